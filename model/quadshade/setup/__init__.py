# SPDX-License-Identifier: Apache-2.0
"""Set-up on the host: exact edges, colour words with their error bound, and the set-up packet."""
