# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images straight from their files: those that Blender itself has of them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

WIDTH, HEIGHT = 5, 3


@pytest.fixture
def given(parts, blender):
    """The modules, and the images that the engine was given."""
    import imbuf

    if not hasattr(imbuf.types.ImBuf, "with_buffer"):
        pytest.skip("this Blender does not give the bytes of a file")
    sent, warned = [], []
    builder = SimpleNamespace(add_image=lambda name, pixels, srgb: sent.append(pixels) or len(sent) - 1)
    report = SimpleNamespace(warn=warned.append)
    images = parts.part("export.image").Images(parts.part("export.kept").Kept(builder), report, 1)
    return SimpleNamespace(files=parts.part("export.image_file"), images=images, sent=sent, warned=warned)


def saved(bpy, tmp_path, kind: str, *, has_alpha: bool = False, is_deep: bool = False):
    """An image of random colours, loaded from a file."""
    random = np.random.default_rng(5).uniform(size=(HEIGHT, WIDTH, 4)).astype(np.float32)
    if not has_alpha:
        random[..., 3] = 1.0
    made = bpy.data.images.new("made", WIDTH, HEIGHT, alpha=True, float_buffer=is_deep)
    made.pixels.foreach_set(random.ravel())
    settings = bpy.context.scene.render.image_settings
    settings.file_format = kind
    settings.color_mode = "RGBA" if kind == "PNG" else "RGB"
    if kind == "PNG":
        settings.color_depth = "16" if is_deep else "8"
    path = tmp_path / f"image.{kind.lower()}"
    made.save_render(str(path))
    return bpy.data.images.load(str(path))


def by_blender(image, module) -> np.ndarray:
    return module.Pixels.of_blender(image).sent()


@pytest.mark.parametrize("is_packed", [False, True])
@pytest.mark.parametrize(("kind", "has_alpha"), [("PNG", False), ("PNG", True), ("JPEG", False)])
@pytest.mark.parametrize("alpha_mode", ["STRAIGHT", "CHANNEL_PACKED", "PREMUL", "NONE"])
def test_bytes_are_those_that_blender_has(parts, blender, given, tmp_path, kind, has_alpha, is_packed, alpha_mode):
    image = saved(blender, tmp_path, kind, has_alpha=has_alpha)
    image.alpha_mode = alpha_mode
    if is_packed:
        image.pack()
        image.buffers_free()
    given.images.index(image)
    # Blender had not to read what its file gives.
    assert image.has_data == (has_alpha and alpha_mode in ("PREMUL", "NONE"))
    expected = by_blender(image, parts.part("export.image_pixels"))
    assert given.sent[0].dtype == np.uint8 and np.array_equal(given.sent[0], expected)
    assert not given.warned


def test_an_image_is_sent_once(parts, blender, given, tmp_path):
    image = saved(blender, tmp_path, "PNG", has_alpha=True)
    assert [given.images.index(image) for _ in range(2)] == [0, 0] and not image.has_data
    (sent,) = given.sent
    assert np.array_equal(sent, by_blender(image, parts.part("export.image_pixels")))


def test_what_blender_holds_differently_is_read_from_blender(parts, blender, given, tmp_path):
    deep = saved(blender, tmp_path, "PNG", is_deep=True)
    assert given.files.pixels(deep) is None
    painted = saved(blender, tmp_path, "JPEG")
    painted.pixels[0] = 0.25
    assert painted.is_dirty and given.files.pixels(painted) is None
    given.images.index(painted)
    assert given.sent[0][0, 0, 0] == 64
    generated = blender.data.images.new("generated", 4, 4)
    assert given.files.pixels(generated) is None


def test_files_that_cannot_be_read_are_magenta_and_named(blender, given, tmp_path):
    image = saved(blender, tmp_path, "PNG")
    for name, content in (("broken.png", b"\x89PNG\r\n\x1a\n"), ("empty.jpg", b""), ("text.png", b"no picture")):
        path = tmp_path / name
        path.write_bytes(content)
        image.filepath = str(path)
        image.buffers_free()
        given.images.index(image.copy())
    assert len(given.warned) == 3 and all("cannot be read" in line for line in given.warned)
    assert all(pixels.shape == (1, 1, 4) for pixels in given.sent)
