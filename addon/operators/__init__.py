# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: commands of menus and buttons."""
