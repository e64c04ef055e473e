# SPDX-License-Identifier: Apache-2.0
"""A hash of this package's code, for results that are kept between runs."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from quadshade import errors


@cache
def code_digest(unused: tuple[str, ...] = ()) -> str:
    """
    Hash of the package's modules.

    Parameters
    ----------
    unused : tuple of str
      Folders of the package, such as ``trade/page``, on whose code the results do not depend.

    Returns
    -------
    str
    """
    root = Path(errors.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        if not any(path.is_relative_to(root / folder) for folder in unused):
            digest.update(path.read_bytes())
    return digest.hexdigest()
