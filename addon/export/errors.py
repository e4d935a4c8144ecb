# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors of scenes that cannot be handed over."""


class ExportError(Exception):
    """The message is one line for the user: what, where, what to do."""
