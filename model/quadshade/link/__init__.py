# SPDX-License-Identifier: Apache-2.0
"""
The serial link between host and board.

``protocol`` is what is on the wire and ``frames`` its codec; ``transport`` is the line, ``session`` what
keeps order on it, ``picture`` the way back; ``board_model`` is a board in this process, ``faults`` a bad
line.
``docs/protocol.md`` is the description, ``docs/link.md`` the use; ``rtl/link_pkg.vhd`` is written from
``protocol``.
"""
