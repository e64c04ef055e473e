# SPDX-License-Identifier: Apache-2.0
"""
The serial link between host and board: ``protocol`` is what is on the wire, ``frames`` the codec.

``docs/protocol.md`` is the description; ``rtl/link_pkg.vhd`` is written from ``protocol``.
"""
