# SPDX-License-Identifier: GPL-3.0-or-later
"""What rendering costs as one number of a scene grows, Petzval beside Cycles: the page docs/growth.md."""
