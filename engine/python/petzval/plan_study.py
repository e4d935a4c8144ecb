# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans a picture, and forecasts its time, instead of rendering it. Runs where Blender is."""

from __future__ import annotations

import json
from typing import Any


class PlanStudy:
    """The study that is called by the engine instead of a render; `found` is the plan, if there is one."""

    is_long = False

    def __init__(self) -> None:
        self.found: dict[str, Any] | None = None

    def __call__(self, subject: Any) -> None:
        if self.found is not None:  # a further view layer
            return
        from petzval import _native

        plan = _native.Plan(
            subject.scene,
            subject.camera,
            subject.settings,
            subject.over_the_shutter,
            shutter=subject.shutter,
            **subject.wishes,
        )
        self.found = json.loads(plan.forecast(subject.scene, subject.camera, subject.settings))
