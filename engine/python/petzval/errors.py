# SPDX-License-Identifier: GPL-3.0-or-later
"""What a command says when it cannot go on."""

import sys


class CommandError(Exception):
    """The message is one line: what, where, what to do. The command line prints it and exits 1."""


def complain(message: str) -> None:
    """The one line on stderr, whatever line breaks the message had."""
    print("petzval:", " ".join(message.split()), file=sys.stderr)
