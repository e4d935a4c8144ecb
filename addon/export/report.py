# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings of an export."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Report:
    """The warnings of an export, told to the user once each."""

    warnings: list[str] = field(default_factory=list)

    def warn(self, text: str) -> None:
        if text not in self.warnings:
            self.warnings.append(text)
