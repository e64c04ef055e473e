# SPDX-License-Identifier: Apache-2.0
"""Files: triangles and shade state on disk, and writing that leaves no half file."""

from quadshade.files.atomic import check_writable, write_atomically, write_json, write_text
from quadshade.files.markdown import markdown_table
from quadshade.files.pixel_file import write_arrays, write_pixels
from quadshade.files.triangle_file import open_triangles, read_triangles, write_triangles

__all__ = [
    "check_writable",
    "markdown_table",
    "open_triangles",
    "read_triangles",
    "write_arrays",
    "write_atomically",
    "write_json",
    "write_pixels",
    "write_text",
    "write_triangles",
]
