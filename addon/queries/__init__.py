# SPDX-License-Identifier: GPL-3.0-or-later
"""Questions that panels, overlays and operators ask of a camera and its lens, remembered while nothing changes."""
