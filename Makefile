# `make help` lists what there is. What takes more than a line lies in tools/.

DEMO_SCENE = tests/scenes/demo.blend
DEMO_LENS = lenses/wide-angle-smith-f3.4.lens
DEMO_OPTIONS =
# The build that is timed: the shipped one. ENGINE=build takes the fast build, to try a recipe.
ENGINE = wheels
# A folder; tests of these recipes have one of their own.
OUTPUT = output
BENCH_OPTIONS =
PRICE_OPTIONS =
ACCURACY_COST_OPTIONS =
VIEWPORT_PRICE_OPTIONS =
DIFFRACTION_OPTIONS =
SPEED_OPTIONS =
PARITY_OPTIONS =
# Scenes by others are found by the tests in the same way.
SCENES = $(PETZVAL_SCENES)
OTHER_SCENES_OPTIONS =
SETTINGS_OPTIONS =
DENOISING_OPTIONS =
INSTRUCTIONS_OPTIONS =
GPU_OPTIONS =
# Of each target; FUZZ_OPTIONS names some of them, and --keep keeps what they find new.
FUZZ_SECONDS = 60
FUZZ_OPTIONS =
# Of a 3D view in the pictures of Blender's window, which is denoised there.
UI_SAMPLES = 16
GHOSTS_OPTIONS =
# --only windows-x64 macos-arm64 ...; --fast compiles in a third of the time, to try.
WHEELS_ALL_OPTIONS =
TEST_PLATFORMS_OPTIONS =
FIGURES_OPTIONS =
PROOFS_OPTIONS =
SOAK_OPTIONS =

.PHONY: help demo test test-all test-long test-platforms lint setup build wheels wheels-all extension extensions-all release speed price accuracy-cost bench parity other-scenes growth settings denoising profile viewport-price newcomer ui-pictures panel-pictures lens-index reality other-programs coatings diffraction ghosts figures fuzz gpu instructions numerics proofs soak pages pages-again docs clean

help: ## what there is to make
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' Makefile | expand -t 12

demo: build ## render the demo scene through a real lens, into output/demo.png
	@mkdir -p $(OUTPUT)
	@echo "petzval: rendering $(DEMO_SCENE) (about a minute on 2 cores)" >&2
	@$(PETZVAL) render $(DEMO_SCENE) --lens $(DEMO_LENS) --samples 24 --denoise high -o $(OUTPUT)/demo.png --stats $(OUTPUT)/demo.json $(DEMO_OPTIONS)
	@.venv-tools/bin/python tools/demo_report.py $(OUTPUT)/demo.png $(OUTPUT)/demo.json

test: ## everything: Rust, Python, bpy 5.2 and 4.5, the real Blender; sets up what it needs
	@tools/test.sh

test-all: ## the same, and bpy 5.0 and 4.2 too
	@tools/test.sh --all

test-long: ## hours of it, with other random numbers each time: all cases of the Rust tests, fuzzing, and the soak
	@tools/test-long.sh

test-platforms: .venv-tools ## the engine's Rust tests for Windows by Wine, for Linux on ARM by QEMU
	@tools/setup-python.sh wheels
	@PYTHONPATH=tools .venv-tools/bin/python -m platforms test $(TEST_PLATFORMS_OPTIONS)

lint: .venv-tools setup build ## formatting and lints of Rust and Python, and types
	cargo fmt --all --check
	PYO3_PYTHON=$(CURDIR)/.venv-tools/bin/python cargo clippy --all-targets --workspace --locked -- -D warnings
	.venv-tools/bin/ruff check
	.venv-tools/bin/ruff format --check
	$(dir $(PETZVAL))python -m pytest -q tests/project/test_types.py

wheels: setup ## the wheel that is shipped, dist/petzval-*.whl, with every optimisation; docs/packaging.md has other machines
	@tools/build-wheel.sh --release

wheels-all: wheels ## the wheels of every system that has a Blender, made here; docs/packaging.md
	@tools/setup-python.sh wheels
	@PYTHONPATH=tools .venv-tools/bin/python -m platforms wheels $(WHEELS_ALL_OPTIONS)

extensions-all: wheels-all ## the Blender extension of every system, checked: dist/petzval-VERSION-PLATFORM.zip
	@tools/setup-blender.sh || true
	@tools/build-extension.sh
	@PYTHONPATH=tools .venv-tools/bin/python -m platforms check --all

release: extensions-all ## an extensions repository for Blender, and all that a release has, in dist/release; docs/packaging.md
	@tools/release.sh

extension: build ## the Blender extension of each wheel in dist/, dist/petzval-VERSION-PLATFORM.zip; `make wheels` first to ship it
	@tools/setup-blender.sh || true
	@tools/build-extension.sh

build: ## the engine, compiled fast, and the command petzval in the environments
	@tools/build.sh

setup: .venv-tools ## the Python environments: bpy 5.2, or 4.5 where Python 3.13 is missing
	@tools/setup-python.sh bpy52 || tools/setup-python.sh bpy45

.PHONY: .venv-tools
.venv-tools:
	@tools/setup-python.sh tools

speed: ## time the lens tracer, and write docs/lens-speed.md
	@python3 tools/lens-speed.py $(SPEED_OPTIONS)

price: $(ENGINE) ## what each camera and pipeline costs, into docs/camera-price.md
	@$(dir $(PETZVAL))python tools/camera-price.py $(PRICE_OPTIONS)

accuracy-cost: $(ENGINE) ## what each step from the pinhole to the full lens costs and mends, into docs/accuracy-cost.md
	@tools/setup-python.sh bench
	@.venv-bench/bin/python tools/accuracy_cost.py $(ACCURACY_COST_OPTIONS)

bench: $(ENGINE) ## Petzval beside Cycles and Mitsuba, into docs/performance.md; BENCH_OPTIONS=--quick to try
	@tools/setup-python.sh bench
	@PYTHONPATH=tools .venv-bench/bin/python -m bench $(BENCH_OPTIONS)

parity: build ## Petzval beside Cycles, scene by scene, into docs/parity.md; PARITY_OPTIONS="--only sun" to try
	@tools/setup-python.sh bench
	@PYTHONPATH=tools .venv-bench/bin/python -m parity $(PARITY_OPTIONS)

other-scenes: $(ENGINE) ## Petzval beside Cycles on the .blend files under SCENES=FOLDER, by others, into docs/other-scenes.md
	@[ -d "$(SCENES)" ] || { echo "petzval: make other-scenes SCENES=FOLDER: give a folder of .blend files" >&2; exit 1; }
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m other_scenes "$(SCENES)" $(OTHER_SCENES_OPTIONS)

growth: $(ENGINE) ## what rendering costs as a scene grows, beside Cycles, into docs/growth.md
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m growth $(GROWTH_OPTIONS)

settings: $(ENGINE) ## every setting changed in Petzval and in Cycles, into docs/settings.md; SETTINGS_OPTIONS="--only 'camera.*'" to try
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m settings_walk $(SETTINGS_OPTIONS)

denoising: $(ENGINE) ## denoised pictures beside converged ones, and beside Cycles on the .blend files under SCENES=FOLDER, into docs/denoising.md
	@tools/setup-python.sh bench
	@PYTHONPATH=tools .venv-bench/bin/python -m denoising $(if $(SCENES),--scenes "$(SCENES)") $(DENOISING_OPTIONS)

profile: build ## where the time of a sample goes on the .blend files under SCENES=FOLDER, by perf, into docs/design/profile.md
	@[ -d "$(SCENES)" ] || { echo "petzval: make profile SCENES=FOLDER: give a folder of .blend files" >&2; exit 1; }
	@PYO3_PYTHON=$(dir $(PETZVAL))python cargo build --quiet --release --locked -p petzval-python
	@PYTHONPATH=tools $(dir $(PETZVAL))python tools/cpu_profile.py --engine "$${CARGO_TARGET_DIR:-target}/release/lib_native.so" "$(SCENES)" $(PROFILE_OPTIONS)

viewport-price: $(ENGINE) ## how soon a 3D view shows an edit, into docs/viewport.md
	@$(dir $(PETZVAL))python tools/viewport-price.py $(VIEWPORT_PRICE_OPTIONS)

newcomer: $(ENGINE) extension ## time a newcomer's path: install the extension, choose a lens, render
	@export PETZVAL_BEGAN=$$(date +%s.%N) BLENDER_USER_RESOURCES=$$(mktemp -d) && \
	tools/blender --command extension install-file -r user_default --enable $$(ls dist/petzval-*-linux-x64.zip) >/dev/null && \
	tools/blender --in-window --addons bl_ext.user_default.petzval --python tools/newcomer.py

ui-pictures: extension ## what the tests of Blender's window see, into docs/ui
	@tools/setup-python.sh bench
	@mkdir -p output/packages && ln -sfn $$(.venv-bench/bin/python -c 'import importlib.util; print(importlib.util.find_spec("pyoidn").submodule_search_locations[0])') output/packages/pyoidn
	@PETZVAL_PICTURE_SAMPLES=$(UI_SAMPLES) PETZVAL_PICTURE_PACKAGES=$(CURDIR)/output/packages $(dir $(PETZVAL))python -m pytest -q -m window
	@.venv-bench/bin/python tools/ui-pictures.py

panel-pictures: extension ## the pictures of panels in docs/panel.md and README.md, in Blender's window
	@tools/setup-python.sh bench
	@PYTHONPATH=tools .venv-bench/bin/python -m panels

lens-index: build ## the lens library's page with a drawing of each lens, docs/lenses.md
	@$(dir $(PETZVAL))python tools/lens_index.py

reality: build ## shipped lenses beside measurements of their products, into docs/reality.md; LENSFUN=FOLDER of lensfun's database
	@$(dir $(PETZVAL))python tools/reality.py $(or $(LENSFUN),$(error LENSFUN=FOLDER, lensfun's data/db or an installed version_1)) $(REALITY_OPTIONS)

other-programs: build ## lenses by rayoptics and optiland beside the same by Petzval, into docs/other-programs.md
	@$(dir $(PETZVAL))python tools/other_programs.py

coatings: build ## what coatings reflect, and what lenses let through, into docs/coatings.md
	@cargo build --quiet --locked -p petzval-optics --example coatings
	@$(dir $(PETZVAL))python tools/coatings.py $(or $(CARGO_TARGET_DIR),target)/debug/examples/coatings

diffraction: build ## what diffraction and glare do, into docs/diffraction.md and docs/glare.md
	@tools/setup-python.sh bench
	@cargo build --quiet --release --locked -p petzval-render --example starburst --example glare
	@PYTHONPATH=$(CURDIR)/engine/python .venv-bench/bin/python tools/diffraction.py $(or $(CARGO_TARGET_DIR),target)/release/examples $(DIFFRACTION_OPTIONS)

ghosts: $(ENGINE) ## ghosts beside brute force, their price, and pictures full of light that strays, into docs/ghosts.md
	@$(dir $(PETZVAL))python tools/ghosts.py $(GHOSTS_OPTIONS)

gpu: ## the lens on a graphics processor: lints, tests, rays a second (docs/gpu.md); GPU_OPTIONS="--device NAME"
	@cargo fmt --manifest-path engine/gpu/Cargo.toml --check
	@cd engine/gpu && cargo clippy $(GPU_BUILD) --all-targets -- -D warnings && cargo test $(GPU_BUILD) && \
	cargo run $(GPU_BUILD) --example lens_bench -- --if-any $(GPU_OPTIONS)

fuzz: ## break the readers of files and the lens tracer, FUZZ_SECONDS=60 for each target; needs nightly Rust and cargo-fuzz (docs/robustness.md)
	@FUZZ_SECONDS=$(FUZZ_SECONDS) python3 tools/fuzz.py $(FUZZ_OPTIONS)

instructions: ## count the instructions of a sample, beside those kept; INSTRUCTIONS_OPTIONS=--keep keeps them
	@cargo build --quiet --release --locked -p petzval-render --example path_kernel
	@python3 tools/instructions.py $(INSTRUCTIONS_OPTIONS)

numerics: ## hold the lens tracer against exact numbers, and write docs/numerics.md
	@began=$$(date +%s) && cargo run --quiet --locked -p petzval-optics --example numerics && \
	PYTHONPATH=tools python3 -m pages stamp docs/numerics.md --began $$began

proofs: build ## prove the kernels' rounding errors, and of every shipped lens which rays pass, into docs/proofs.md; PROOFS_OPTIONS="--only NAME"
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m kernel_bounds --if-there
	@$(dir $(PETZVAL))python tools/proofs.py $(PROOFS_OPTIONS)

soak: $(ENGINE) ## what thousands of edits, renders, frames and kills leave behind; SOAK_OPTIONS="--only edits" to try
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m soak $(SOAK_OPTIONS)

figures: $(ENGINE) ## the paper's figures and three more, measured, into docs/figures.md; FIGURES_OPTIONS="--only fig-10" to try
	@PYTHONPATH=tools $(dir $(PETZVAL))python -m figures $(FIGURES_OPTIONS)

pages: ## the generated pages of docs/, and the commits since each was made that touch what it shows
	@PYTHONPATH=tools python3 -m pages

pages-again: ## remake the pages that are stale, one after the other, unattended: for an idle machine
	@PYTHONPATH=tools python3 -m pages again

docs: ## docs/ as a book, output/book/index.html; a link that leads nowhere fails
	@tools/setup-python.sh docs
	@NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs build --quiet
	@echo "output/book/index.html"

clean: ## what was built; the environments and the real Blender stay
	cargo clean
	rm -rf dist output $(addprefix engine/python/petzval/,_bundled _engines *.so)

# A workspace of its own, built beside the others.
GPU_BUILD = --quiet --release --locked --target-dir $(abspath $(or $(CARGO_TARGET_DIR),target))/gpu

# Found when the recipe runs: the environments may just have been made.
PETZVAL = $(firstword $(wildcard .venv-bpy52/bin/petzval .venv-bpy45/bin/petzval) .venv-bpy52/bin/petzval)
