# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of rendering as one number of a scene grows, Petzval beside Cycles: the page docs/growth.md."""
