# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves a .blend in which no setting of Petzval has its default, and the values as JSON, for tests/addon/test_saved_before.py of later versions. Each
release adds its own:

    .venv-bpy45/bin/python tools/saved_settings.py tests/addon/saved_by_VERSION
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import bpy

import petzval

#: Text that no list of choices gives.
_TEXT = {"lens_file": "//a lens.lens"}
#: The settings that the add-on writes itself.
_OWN = {"settings_version", "version", "blender_camera", "blender_sensor_fit"}


def _other(setting: bpy.types.Property, name: str):
    """A value of a setting that is not its default, and can be told from it in 32 bits; None where a user cannot set it."""
    kind = setting.type
    if kind == "BOOLEAN":
        return not setting.default
    if kind == "ENUM":
        if setting.is_enum_flag:
            return None
        return next((item.identifier for item in setting.enum_items_static if item.identifier != setting.default), None)
    if kind == "STRING":
        return _TEXT.get(name, f"some {name}")
    if kind == "INT":
        return setting.default + 1 if setting.default < setting.hard_max else setting.default - 1
    if kind == "FLOAT":
        bounds = (max(setting.soft_min, -100.0), min(setting.soft_max, 100.0))
        if setting.is_array:
            return [_between(default, *bounds) for default in setting.default_array]
        return _between(setting.default, *bounds)
    return None


def _between(default: float, low: float, high: float) -> float:
    return default + 0.125 * ((high if default < high else low) - default)


def _set(holder: bpy.types.PropertyGroup) -> dict[str, object]:
    """Sets every setting, and returns their values afterwards: some round, some change others."""
    names = []
    for setting in holder.bl_rna.properties:
        name = setting.identifier
        if setting.is_readonly or name in _OWN or name in ("name", "rna_type"):
            continue
        value = _other(setting, name)
        if value is None:
            continue
        try:
            setattr(holder, name, value)
        except (TypeError, ValueError) as why:
            print(f"petzval: {name} is left as it is: {why}", file=sys.stderr)
            continue
        names.append(name)
    found = {}
    for name in sorted(names):
        value = getattr(holder, name)
        default = holder.bl_rna.properties[name]
        plain = list(value) if getattr(default, "is_array", False) else value
        found[name] = plain
    return found


def main() -> None:
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon = petzval.load_addon()
    addon.register()
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    saved = {"camera": _set(camera.data.petzval), "scene": _set(scene.petzval)}
    bpy.ops.wm.save_as_mainfile(filepath=str(folder.resolve() / "settings.blend"), compress=True)
    (folder / "settings.json").write_text(json.dumps(saved, indent=1) + "\n")
    addon.unregister()


if __name__ == "__main__":
    main()
