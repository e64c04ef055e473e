# SPDX-License-Identifier: Apache-2.0
"""Files: triangles and shade state on disk, and writing that leaves no half file."""
