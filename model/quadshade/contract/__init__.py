# SPDX-License-Identifier: Apache-2.0
"""
What host and hardware agree on: formats, packed format, protocol, shade state, triangles.

It imports nothing else of the project but the errors.
"""
