# SPDX-License-Identifier: GPL-3.0-or-later
"""`make denoising`: pictures of few samples, denoised, beside converged ones: through lenses, and beside Cycles on scenes by others."""
