# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of generated pages: each with its make target and the sources that it measures or shows, as pathspecs of git."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Page:
    """A page that a make target writes, in full or in part."""

    file: str
    target: str
    #: The sources that the page measures: a commit that touches none of them leaves the page as true as it was.
    measures: tuple[str, ...]
    #: Variables of make for a run that measures everything anew.
    options: tuple[str, ...] = ()
    #: The generated part, of a page that is otherwise written by hand.
    part: str = ""
    #: The time of a run on two cores, if known.
    minutes: float | None = None


#: Unit tests inside of crates measure nothing.
_WITHOUT_TESTS = (":(exclude,glob)engine/*/src/**/tests.rs", ":(exclude,glob)engine/*/src/**/tests/**")
_BUILD = ("Cargo.toml", "Cargo.lock", ".cargo")
_OPTICS = ("engine/fourier/src", "engine/optics/src")
_ENGINE = (*_OPTICS, "engine/nodes/data", "engine/nodes/src", "engine/render/src", "engine/python/src")
#: The sources from a .blend to the engine.
_SCENE = ("addon/export", "engine/python/petzval/description.py",
          "addon/engine.py", "addon/render/loop.py", "addon/render/photograph.py", "addon/render/staging.py", "addon/settings")  # fmt: skip
#: The sources from a .blend to a picture by the command line.
_RENDER = (*_ENGINE, *_SCENE, "engine/python/petzval/render_in_blender.py")
#: The time of a render, and not its picture alone: the shipped build counts too.
_TIMED = (*_BUILD, "tools/build-wheel.sh")


def _page(name: str, target: str, *measures: str, **more) -> Page:
    if any(path.startswith("engine/") for path in measures):
        measures += _WITHOUT_TESTS
    return Page(f"docs/{name}.md", target, measures, **more)


#: The pages in the order in which they are remade: those of one build stand together, so that it is built once.
_ALL = (
    _page("lens-speed", "speed", *_BUILD, "engine/optics/src", "engine/benches/lens.rs", "tools/lens-speed.py"),
    _page(
        "numerics",
        "numerics",
        "engine/optics/src/single_surface*",
        "engine/optics/src/surface",
        "engine/optics/src/interface.rs",
        "engine/optics/src/lane.rs",
        "engine/optics/src/vector.rs",
        "engine/optics/examples/numerics*",
        "engine/optics/tests/all/numerics",
        "engine/testkit/src",
    ),
    _page(
        "camera-price",
        "price",
        *_TIMED,
        *_RENDER,
        "tests/scenes/demo.blend",
        "lenses/wide-angle-smith-f3.4.lens",
        "tools/camera-price.py",
    ),
    _page(
        "accuracy-cost",
        "accuracy-cost",
        *_TIMED,
        *_RENDER,
        "engine/python/petzval/cost",
        "tests/scenes/demo.blend",
        "tests/scenes/plan_scenes",
        "lenses/wide-angle-smith-f3.4.lens",
        "lenses/double-gauss-f2-tronnier.lens",
        "lenses/cellphone-5.6mm-f3.5.lens",
        "tools/accuracy_cost.py",
        minutes=13,
    ),
    _page("performance", "bench", *_TIMED, *_RENDER, "engine/benches", "tools/bench", "tools/requirements"),
    _page(
        "viewport",
        "viewport-price",
        *_TIMED,
        *_ENGINE,
        *_SCENE,
        "addon/viewport",
        "tests/scenes/demo.blend",
        "tools/viewport-price.py",
        part="The table",
    ),
    _page(
        "ghosts",
        "ghosts",
        *_TIMED,
        *_RENDER,
        "lenses/*.lens",
        "tests/scenes/stray_scenes.py",
        "tools/ghosts.py",
        part="Tables and pictures",
    ),
    _page(
        "lenses",
        "lens-index",
        "lenses/*.lens",
        "engine/optics/src",
        "engine/python/petzval/lens_library.py",
        "engine/python/petzval/lens_list.py",
        "engine/python/petzval/lens_drawing.py",
        "engine/python/petzval/plotting",
        "tools/lens_index.py",
    ),
    _page(
        "other-programs",
        "other-programs",
        *_OPTICS,
        "engine/render/src/reports",
        "tests/reference/foreign",
        "tools/other_programs.py",
        part="Tables",
    ),
    _page(
        "proofs",
        "proofs",
        "lenses",
        "engine/optics/src",
        "engine/proof/src",
        "engine/python/petzval/proof_check",
        "tools/proofs.py",
        part="Every shipped lens",
    ),
    _page(
        "reality",
        "reality",
        "lenses",
        *_OPTICS,
        "engine/render/src/reports",
        "tools/reality.py",
        part="Tables",
    ),
    _page(
        "coatings",
        "coatings",
        "lenses/*.lens",
        *_OPTICS,
        "engine/optics/examples/coatings.rs",
        "tools/coatings.py",
        part="Tables",
    ),
    _page(
        "diffraction",
        "diffraction",
        *_OPTICS,
        "engine/render/src/stray",
        "engine/render/src/camera",
        "engine/render/examples/starburst.rs",
        "engine/render/examples/glare.rs",
        "lenses/double-gauss-f2-tronnier.lens",
        "lenses/cassegrain-f12.lens",
        "lenses/cooke-triplet-50mm.lens",
        "lenses/newtonian-f5.lens",
        "lenses/plano-hyperbolic-50mm.lens",
        "lenses/questar-3.5.lens",
        "tools/diffraction.py",
        part="Tables and pictures",
    ),
    _page(
        "glare",
        "diffraction",
        *_OPTICS,
        "engine/render/src/stray",
        "engine/render/src/camera",
        "engine/render/examples/glare.rs",
        "lenses/double-gauss-f2-tronnier.lens",
        "tools/diffraction.py",
        part="The table and the picture",
    ),
    _page("figures", "figures", *_RENDER, "tests/scenes/gallery", "lenses/*.lens", "tools/figures"),
    _page(
        "parity",
        "parity",
        *_ENGINE,
        *_SCENE,
        "tests/scenes/parity_scenes",
        "tools/parity",
        # Scenes that were rendered with the same numbers are not rendered again without it.
        options=("PARITY_OPTIONS=--again",),
    ),
    _page("growth", "growth", *_TIMED, *_RENDER, "tools/growth"),
    _page("settings", "settings", *_ENGINE, *_SCENE, "tools/settings_walk", "tests/scenes/parity_scenes/studio.py"),
    _page("other-scenes", "other-scenes", *_TIMED, *_RENDER, "tools/other_scenes"),
    _page(
        "denoising",
        "denoising",
        *_TIMED,
        *_RENDER,
        "engine/denoise/src",
        "addon/data/denoiser.py",
        "tests/scenes/demo.blend",
        "tests/scenes/gallery",
        "lenses/*.lens",
        "tools/denoising",
    ),
    _page("design/profile", "profile", *_BUILD, *_RENDER, "tools/cpu_profile.py"),
    _page(
        "panel",
        "panel-pictures",
        "addon/ui",
        ":(glob)addon/*.py",
        "tests/scenes/demo.blend",
        "tools/panels",
        part="Pictures",
    ),
    _page(
        "ui/README",
        "ui-pictures",
        "addon",
        "engine/python/src",
        "tests/support/window*.py",
        "tools/ui-pictures.py",
    ),
)
PAGES = {page.file: page for page in _ALL}
