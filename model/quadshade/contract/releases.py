# SPDX-License-Identifier: Apache-2.0
"""
Which release a board is of: HELLO's ``definition`` tells, so no byte of the line is spent on it.

A board carries the hash of formats, packet layout and protocol and not the version's text: a release that
changes none of these works with the bitstreams of the one before it.
"""

from __future__ import annotations

from quadshade.contract.protocol import definition_hash

RELEASES = {
    "0.2.0": 0xF1DCD3EE,
}
"""Version of each release, oldest first, and its :func:`quadshade.contract.protocol.definition_hash`."""

UNRELEASED: int | None = 0x12BA1E01
"""The definition of this checkout, where it is no more that of the last release."""


def release_of(definition: int) -> str:
    """
    Name the release that a board or a file is of.

    Parameters
    ----------
    definition : int
      HELLO's ``definition``, 32 bits.

    Returns
    -------
    str
      ``release 0.2.0``, ``release 0.2.0 or 0.2.1`` where several share the definition, ``this checkout`` for
      the definition of the running package where no release had it, or ``no known release``.
    """
    versions = [version for version, known in RELEASES.items() if known == definition]
    if versions:
        return f"release {' or '.join(versions)}"
    return "this checkout" if definition == definition_hash() else "no known release"


def other_release(what: str, definition: int) -> str:
    """
    Say that a board or a file is of another release than the running package.

    Parameters
    ----------
    what : str
      The subject, ``the board`` for example.
    definition : int
      Its hash.

    Returns
    -------
    str
      One clause with both releases and both hashes.
    """
    own = definition_hash()
    return f"{what} is of {release_of(definition)} ({definition:08x}), this is {release_of(own)} ({own:08x})"
