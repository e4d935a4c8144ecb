#!/bin/sh
# Builds this machine's wheel into dist/ when something that it holds has changed, and installs the checkout into the test
# environments: the compiled modules are copied into their Python package, and each .venv-bpy* gets the package and the command
# `petzval` from the checkout, so that a change of a Python file needs no build.
#
#   tools/build-wheel.sh            the development build: one engine, compiled fast; shares its artifacts with `cargo test`
#   tools/build-wheel.sh --release  the wheel that is shipped: link-time optimisation, laid out by a profile, an engine for each level
#                                   of processor, and an old C library (docs/packaging.md)
#
# A release wheel that is up to date serves as a development build too.
set -eu
cd "$(dirname "$0")/.."

. tools/processor.sh
build=development
[ "${1-}" != --release ] || build=release

package=engine/python/petzval
stamp=dist/.petzval-wheel # holds the build, the levels and the wheel's name
log=output/build.log
mkdir -p dist output

# The levels of processors that a release wheel has an engine for, lowest first; petzval/processors.py picks one at import.
# Without levels the one engine is for every processor of the machine's kind.
levels=
[ "$build $(uname -sm)" != "release Linux x86_64" ] || levels="x86-64-v2 x86-64-v3"

# The places of the compiled modules in the package; the arguments are levels.
modules() {
    [ $# -gt 0 ] || echo _native.abi3.so
    for level in "$@"; do echo "_engines/$level/_native.abi3.so"; done
}

fresh() {
    [ -e "$stamp" ] || return 1
    # shellcheck disable=SC2046
    set -- $(cat "$stamp")
    [ "$1" = "$build" ] || [ "$1" = release ] || return 1
    [ -e "dist/$2" ] || return 1
    shift 2
    installed=$(cd "$package" && find . -name '_native.abi3.so' | sed 's,^\./,,' | sort)
    [ "$installed" = "$(modules "$@" | sort)" ] || return 1
    # Folders count too: theirs is the time of the last file added or taken away. The package's own is left out: the
    # build itself adds to it.
    changed=$(find engine addon lenses .cargo Cargo.toml Cargo.lock pyproject.toml LICENSE tools/build-wheel.sh tools/train_engine.py tools/join-wheels.py tools/supply \
        \( -name __pycache__ -o -name _bundled -o -name _engines -o -name '*.so' \) -prune -o \
        ! -path "$package" -newer "$stamp" -print | head -n 1)
    [ -z "$changed" ]
}

# run COMMAND...: keeps what a build says in the log, and shows it when the build fails.
run() {
    "$@" >"$log" 2>&1 || { cat "$log" >&2; echo "petzval: the engine was not built: see above, or $log" >&2; exit 1; }
}

# Counts the branches and calls of an engine at work (tools/train_engine.py), for the compiler to lay the release out by: about a
# tenth of a render's time (docs/design/processors.md). Puts the flags for that into $laid_out; without the tools for it, nothing. The
# arguments are maturin's: counts are found by the names of functions, in which Cargo puts a hash of how a crate is compiled, so the
# counting engine is compiled by the very command of the release.
count_branches() {
    laid_out=
    host=$(rustc -vV | sed -n 's/^host: //p')
    libraries=$(rustc --print sysroot)/lib/rustlib/$host
    merge=$libraries/bin/llvm-profdata
    if ! [ -x "$merge" ] && command -v rustup >/dev/null; then rustup component add llvm-tools >"$log" 2>&1 || true; fi
    bpy=$(for python in .venv-bpy52/bin/python .venv-bpy45/bin/python; do [ ! -x "$python" ] || { echo "$PWD/$python"; break; }; done)
    if ! [ -x "$merge" ] || ! ls "$libraries"/lib/libprofiler_builtins-*.rlib >/dev/null 2>&1 || [ -z "$bpy" ]; then
        echo "petzval: a wheel that renders a tenth slower: its layout by profile needs Rust from rustup (rustup component add llvm-tools) and bpy" >&2
        return
    fi
    # Counted on the best level that this machine runs, for all of them.
    counted=
    for level in $levels; do
        case $level in x86-64-v3) grep -qw avx2 /proc/cpuinfo || continue ;; esac
        counted="-C target-cpu=$level"
    done
    folder=$(mkdir -p "${CARGO_TARGET_DIR:-target}/profile" && cd "${CARGO_TARGET_DIR:-target}/profile" && pwd)
    rm -rf "$folder/wheel" "$folder/stage" "$folder/counts" "$folder/pictures"
    mkdir -p "$folder/pictures"
    # Linked by this machine's own linker: Zig's does not know the option by which the counters come in.
    run env RUSTFLAGS="$RUSTFLAGS $counted -C profile-generate=$folder/counts" \
        "CARGO_TARGET_$(echo "$host" | tr 'a-z-' 'A-Z_')_LINKER=cc" \
        maturin "$@" --auditwheel skip --target-dir "$folder" --out "$folder/wheel"
    run .venv-tools/bin/python -m zipfile -e "$folder"/wheel/*.whl "$folder/stage"
    # Counts of build scripts, which are none of the engine's, lie beside.
    run env LLVM_PROFILE_FILE="$folder/counts/engine-%m-%p.profraw" \
        PYTHONPATH="$folder/stage:$PWD/tools:$PWD/tests:$PWD/tests/scenes" \
        "$bpy" "$PWD/tools/train_engine.py" "$folder/pictures"
    run "$merge" merge -o "$folder/engine.profdata" "$folder"/counts/engine-*.profraw
    rm -rf "$folder/wheel" "$folder/stage" "$folder/counts" "$folder/pictures"
    laid_out="-C profile-use=$folder/engine.profdata -C llvm-args=-pgo-warn-missing-function"
}

# Of the functions that are compiled by counts, a few hundred were never part of the counting engine. More of them are none of ours.
MOST_UNCOUNTED=2000
see_counts() {
    uncounted=$(grep -ac "no profile data available" "$log" || true)
    [ "$uncounted" -le $MOST_UNCOUNTED ] || { echo "petzval: $uncounted functions were not found in the counts of the engine at work: is it compiled by another command than the release?" >&2; exit 1; }
}

compile_release() {
    # Zig links against an old C library, so that the wheel runs wherever Blender 4.2 does (glibc 2.28).
    # A Linux without it, and every other system, gets a wheel for itself.
    tools/setup-python.sh wheels
    PATH="$PWD/.venv-wheels/bin:$PATH"
    # Messages name places in the sources, not in the folders of the machine that builds.
    sources="--remap-path-prefix=$PWD=petzval --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}/registry/src=crates"
    RUSTFLAGS="${RUSTFLAGS-} $sources"
    export RUSTFLAGS
    flags="build --release"
    if .venv-wheels/bin/python -c 'import ziglang' 2>/dev/null; then flags="$flags --zig --compatibility manylinux_2_28"; fi
    # shellcheck disable=SC2086
    count_branches $flags
    RUSTFLAGS="$RUSTFLAGS $laid_out"
    if [ -z "$levels" ]; then
        # shellcheck disable=SC2086
        run maturin $flags --out dist/new
        see_counts
        return
    fi
    # Side by side, each in a folder of its own: for most of its time a build compiles one crate, on one core.
    # shellcheck disable=SC2016,SC2086
    printf '%s\n' $levels | FLAGS=$flags run xargs -P 0 -I LEVEL sh -c '
        RUSTFLAGS="${RUSTFLAGS-} -C target-cpu=$1" exec maturin $FLAGS \
            --target-dir "${CARGO_TARGET_DIR:-target}/$1" --out "dist/new/$1"' sh LEVEL
    see_counts
    # shellcheck disable=SC2086
    .venv-tools/bin/python tools/join-wheels.py dist/new $levels
}

build() {
    case $build in
    development) echo "petzval: compiling the engine (about 3 minutes on 2 cores the first time; log: $log)" >&2 ;;
    release) echo "petzval: compiling the release wheel (about 15 minutes on 2 cores; log: $log)" >&2 ;;
    esac
    rm -rf "$package/_bundled" dist/new
    find "$package" -name '*.so.new' -exec rm {} +
    mkdir -p "$package/_bundled"
    cp -R addon lenses "$package/_bundled/"
    find "$package/_bundled" -name __pycache__ -prune -exec rm -rf {} +
    PYTHONPATH=tools .venv-tools/bin/python -m supply notices "$package/_bundled/THIRD-PARTY-NOTICES.txt"
    PYTHONPATH=tools .venv-tools/bin/python -m supply sbom "$package/_bundled/SBOM.cdx.json"
    PATH="$PWD/.venv-tools/bin:$PATH"
    case $build in
    development) run maturin build --profile dev --out dist/new ;;
    release) compile_release ;;
    esac
    # shellcheck disable=SC2046,SC2086
    .venv-tools/bin/python - "$package" $(modules $levels) <<'PY'
import glob, os, pathlib, sys, zipfile
package, *modules = sys.argv[1:]
package = pathlib.Path(package)
wheel, = glob.glob("dist/new/petzval-*.whl")
# Renamed into place: a Blender that runs keeps the old one.
with zipfile.ZipFile(wheel) as archive:
    for module in modules:
        target = package / module
        new = target.with_name(target.name + ".new")
        new.parent.mkdir(parents=True, exist_ok=True)
        new.write_bytes(archive.read(f"petzval/{module}"))
        os.replace(new, target)
# Those of another build; one beside the package would be loaded before all others.
for left in package.rglob("_native.abi3.so"):
    if left.relative_to(package).as_posix() not in modules:
        left.unlink()
PY
    rm -rf "$package/_bundled"
    # Wheels of other machines, copied here for their extensions, stay; this machine's last one goes.
    [ ! -e "$stamp" ] || rm -f "dist/$(cut -d ' ' -f 2 "$stamp")"
    wheel=$(basename dist/new/petzval-*.whl)
    mv "dist/new/$wheel" dist/
    rm -rf dist/new
}

# Makes the checkout's package and command the environment's own.
install_checkout() {
    for python in .venv-bpy*/bin/python; do
        [ -x "$python" ] || continue
        folder=${python%/bin/python}
        [ "$(cat "$folder/.petzval-installed" 2>/dev/null)" = "$PWD" ] && continue
        site=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
        echo "$PWD/engine/python" >"$site/petzval-checkout.pth"
        printf '#!%s\nimport sys\nfrom petzval.__main__ import main\nsys.exit(main())\n' "$PWD/$python" >"$folder/bin/petzval"
        chmod +x "$folder/bin/petzval"
        echo "$PWD" >"$folder/.petzval-installed"
    done
}

# One build at a time.
if command -v flock >/dev/null; then exec 9>dist/.lock && flock 9; fi
if ! fresh; then
    # The stamp's time is the beginning of the build: what changes during a build is newer than the stamp.
    touch "$stamp.begun"
    build
    # shellcheck disable=SC2086
    echo $build "$wheel" $levels >"$stamp"
    touch -r "$stamp.begun" "$stamp"
    rm -f "$stamp.begun"
fi
install_checkout
