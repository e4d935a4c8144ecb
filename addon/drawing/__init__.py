# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a lens in panels, in the viewport and as images."""
