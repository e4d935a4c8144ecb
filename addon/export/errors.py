# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors of scenes that cannot be handed over."""


class ExportError(Exception):
    """An error with one line for the user: the fault, its place, the remedy."""
