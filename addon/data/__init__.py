# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain facts and files: the part of the add-on that needs no scene."""
