# SPDX-License-Identifier: Apache-2.0
"""
The serial link between host and board.

``frames`` is the codec of what is on the wire (``quadshade.contract.protocol``); ``transport`` is the line,
``session`` what keeps order on it, ``planes`` the way back, ``faults`` a bad line.
``docs/reference/protocol.md`` is the description, ``docs/reference/link.md`` the use;
``rtl/generated/link_pkg.vhd`` is written from ``protocol``.
"""
