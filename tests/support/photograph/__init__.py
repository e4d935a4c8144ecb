# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of photographs share: the picture that exact rays predict, charts in Blender, and spots measured."""
