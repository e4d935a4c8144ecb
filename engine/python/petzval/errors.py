# SPDX-License-Identifier: GPL-3.0-or-later
"""The message of a command that cannot go on."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

#: Characters of a word, as of a name or of a word from a file, and of a whole message.
_LONGEST_WORD, _LONGEST_MESSAGE = 200, 2000


#: Exit status of a command that may succeed when it is tried again: the disk is full, the time is over.
AGAIN = 75


class TryAgain(Exception):
    """A render that failed for a reason which may be gone at another try. The message is one line."""


class CommandError(Exception):
    """An error of a command. The message is one line: the fault, its place, the remedy. The command line prints it and exits with
    `status`."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status


@contextmanager
def writing(file: Path) -> Iterator[None]:
    """A block that writes a file: its `OSError` becomes a `CommandError` that names the file."""
    try:
        yield
    except OSError as error:
        raise CommandError(f"cannot write {file}: {error.strerror or error}: choose another place") from None


def complain(message: str) -> None:
    """Prints one line on stderr, whatever line breaks the message had; words without end are cut."""
    print("petzval:", one_line(message), file=sys.stderr)


def one_line(message: str) -> str:
    """A message in one line of bounded length."""
    return _cut(" ".join(_cut(word, _LONGEST_WORD) for word in message.split()), _LONGEST_MESSAGE)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else text[:most] + "…"
