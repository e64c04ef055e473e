# SPDX-License-Identifier: Apache-2.0
"""The literature's set-up methods, for comparison with ours."""
