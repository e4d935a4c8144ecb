# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers that tests share. A test imports from here and never from another test; fixtures stand in conftest.py."""
