# SPDX-License-Identifier: GPL-3.0-or-later
"""The checker of lens proofs. It shares no code with the prover: another language, other formulas, and no part of the engine."""
