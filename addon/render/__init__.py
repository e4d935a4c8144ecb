# SPDX-License-Identifier: GPL-3.0-or-later
"""A render, from the dependency graph to the last pass."""
