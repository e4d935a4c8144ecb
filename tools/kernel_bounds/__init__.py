# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of the rounding errors of the lens kernels, proved by Gappa: the scripts of engine/proof/gappa, and the table of docs/proofs.md.

A script holds the operations of a kernel with their roundings (lower case, `rnd=`), the same formula in real numbers (capitals), the domain,
and in its head the goals and the claimed bounds of each case. `make proofs` runs `python -m kernel_bounds`, tools/ on the path; `--print CASE` is
for `gappa` by hand.

A script is also evaluated here (`evaluation`), its roundings by numpy, its real numbers to 100 digits, at random inputs (`draws`): so the largest
error stands beside the bound, and tests compare the script with the compiled kernel.
"""
