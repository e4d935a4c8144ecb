# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain facts and files: what the add-on knows without a scene."""
