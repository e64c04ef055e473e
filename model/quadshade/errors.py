# SPDX-License-Identifier: Apache-2.0
"""The one error family of Quadshade: what is wrong, and what to do, in one line."""

from __future__ import annotations


class Terminated(KeyboardInterrupt):
    """In place of Ctrl-C's exception, of signals whose sender does not wait for long."""


def interrupt_of(error: BaseException | None) -> KeyboardInterrupt | None:
    """Ctrl-C's exception, of which amid a call of a compiled loop Numba makes a SystemError."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error


class QuadshadeError(Exception):
    """
    Bad input or a missing tool; the command line prints it as one line and exits with code 2.

    Parameters
    ----------
    message : str
      What is wrong, with the value that was got.
    hint : str
      What the user can do about it; appended to the message.
    """

    def __init__(self, message: str, hint: str = "") -> None:
        text = f"{message}; {hint}" if hint else message
        # What a user gave, as an array, may be shown on several lines.
        super().__init__(" ".join(text.split()) if len(text.splitlines()) > 1 else text)
        self.message = message
        self.hint = hint
