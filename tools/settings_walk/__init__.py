# SPDX-License-Identifier: GPL-3.0-or-later
"""Every setting that Cycles or Blender has for a picture, changed in Petzval and in Cycles: the page docs/settings.md."""
