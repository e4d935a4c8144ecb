#!/bin/sh
# Builds the wheel into dist/ when something it holds has changed, and lends the checkout to the test environments:
# the compiled modules are put into their Python package, and each .venv-* gets the package and the command `petzval`
# from the checkout, so that a change of a Python file needs no build.
set -eu
cd "$(dirname "$0")/.."

package=engine/python/petzval
stamp=dist/.petzval-wheel
# The name of this machine's wheel.
own=dist/.petzval-own-wheel
mkdir -p dist

# The levels of processors that the wheel has an engine for, lowest first; petzval/processors.py picks one at import.
# Where there are none, the one engine is for every processor of the machine's kind.
case $(uname -sm) in
"Linux x86_64") levels="x86-64-v2 x86-64-v3" ;;
*) levels= ;;
esac

# The compiled modules' places in the package.
modules() {
    [ -n "$levels" ] || echo _native.abi3.so
    for level in $levels; do echo "_engines/$level/_native.abi3.so"; done
}

fresh() {
    [ -e "$stamp" ] && [ -e "$own" ] && [ -e "$(cat "$own")" ] || return 1
    lent=$(cd "$package" && find . -name '_native.abi3.so' | sed 's,^\./,,' | sort)
    [ "$lent" = "$(modules | sort)" ] || return 1
    # Folders count too: theirs is the time of the last file added or taken away. The package's own is left out: the
    # build itself adds to it.
    changed=$(find engine addon lenses Cargo.toml Cargo.lock pyproject.toml LICENSE tools/build-wheel.sh tools/join-wheels.py \
        \( -name __pycache__ -o -name _bundled -o -name _engines -o -name '*.so' \) -prune -o \
        ! -path "$package" -newer "$stamp" -print | head -n 1)
    [ -z "$changed" ]
}

build() {
    rm -rf "$package/_bundled" dist/new
    find "$package" -name '*.so.new' -exec rm {} +
    mkdir -p "$package/_bundled"
    cp -R addon lenses "$package/_bundled/"
    find "$package/_bundled" -name __pycache__ -prune -exec rm -rf {} +
    # Zig links against an old C library, so that the wheel runs wherever Blender 4.2 does (glibc 2.28).
    # A Linux without it, and every other system, gets a wheel for itself.
    flags=
    if .venv-tools/bin/python -c 'import ziglang' 2>/dev/null; then flags="--zig --compatibility manylinux_2_28"; fi
    flags="build --quiet --release $flags"
    # Side by side, each in a folder of its own: for most of its time a build compiles one crate, on one core.
    # shellcheck disable=SC2016,SC2086
    if [ -n "$levels" ]; then
        printf '%s\n' $levels | FLAGS=$flags PATH="$PWD/.venv-tools/bin:$PATH" xargs -P 0 -I LEVEL sh -c '
            RUSTFLAGS="${RUSTFLAGS-} -C target-cpu=$1" exec maturin $FLAGS \
                --target-dir "${CARGO_TARGET_DIR:-target}/$1" --out "dist/new/$1"' sh LEVEL
        .venv-tools/bin/python tools/join-wheels.py dist/new $levels
    else
        PATH="$PWD/.venv-tools/bin:$PATH" maturin $flags --out dist/new
    fi
    # shellcheck disable=SC2046
    .venv-tools/bin/python - "$package" $(modules) <<'PY'
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
# What an earlier build lent and this one does not; one beside the package would go before all others.
for left in package.rglob("_native.abi3.so"):
    if left.relative_to(package).as_posix() not in modules:
        left.unlink()
PY
    rm -rf "$package/_bundled"
    # Those of other machines, copied here for their extensions, stay; this machine's of another version or C library goes.
    [ ! -e "$own" ] || rm -f "$(cat "$own")"
    echo "dist/$(basename dist/new/petzval-*.whl)" >"$own"
    mv dist/new/petzval-*.whl dist/
    rm -rf dist/new
}

lend() {
    for python in .venv-bpy*/bin/python; do
        [ -x "$python" ] || continue
        folder=${python%/bin/python}
        [ "$(cat "$folder/.petzval-lent" 2>/dev/null)" = "$PWD" ] && continue
        site=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
        echo "$PWD/engine/python" >"$site/petzval-checkout.pth"
        printf '#!%s\nimport sys\nfrom petzval.cli import main\nsys.exit(main())\n' "$PWD/$python" >"$folder/bin/petzval"
        chmod +x "$folder/bin/petzval"
        echo "$PWD" >"$folder/.petzval-lent"
    done
}

# One build at a time, whoever asks.
if command -v flock >/dev/null; then exec 9>dist/.lock && flock 9; fi
# A build may begin before a change and end after it: then the change is newer than the beginning, not than the end.
if ! fresh; then
    touch "$stamp.begun"
    build
    mv "$stamp.begun" "$stamp"
fi
lend
