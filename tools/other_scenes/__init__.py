# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval beside Cycles on scenes by others: whether the pictures agree, and what the same noise costs. What `make other-scenes` runs."""
