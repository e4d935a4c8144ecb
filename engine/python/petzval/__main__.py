# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m petzval` is the command `petzval`."""

import sys

from . import interrupts


def main() -> int:
    """The command's entry; returns its exit status."""
    # Before anything else is imported: Python drops a KeyboardInterrupt that reaches one of its clean-up callbacks.
    interrupts.end_at_ctrl_c()
    from .cli import main

    return main()


if __name__ == "__main__":
    sys.exit(main())
