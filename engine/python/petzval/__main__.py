# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m petzval` is the command `petzval`."""

import sys

from .cli import main

sys.exit(main())
