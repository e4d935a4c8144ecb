# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval beside Cycles on scenes by others: the agreement of the pictures, and the cost of the same noise. The program of `make
other-scenes`."""
