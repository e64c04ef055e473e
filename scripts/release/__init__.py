# SPDX-License-Identifier: Apache-2.0
"""What others take: the FuseSoC description of the RTL, and the archive of a release."""
