#!/bin/sh
# Builds the wheel into dist/ when something it holds has changed, and lends the checkout to the test environments:
# the compiled module is put beside its Python package, and each .venv-* gets the package and the command `petzval`
# from the checkout, so that a change of a Python file needs no build.
set -eu
cd "$(dirname "$0")/.."

package=engine/python/petzval
stamp=dist/.petzval-wheel
mkdir -p dist

fresh() {
    [ -e "$stamp" ] && [ -e "$package/_native.abi3.so" ] && ls dist/petzval-*.whl >/dev/null 2>&1 || return 1
    # Folders count too: theirs is the time of the last file added or taken away. The package's own is left out: the
    # build itself adds to it.
    changed=$(find engine addon lenses Cargo.toml Cargo.lock pyproject.toml LICENSE tools/build-wheel.sh \
        \( -name __pycache__ -o -name _bundled -o -name '*.so' \) -prune -o \
        ! -path "$package" -newer "$stamp" -print | head -n 1)
    [ -z "$changed" ]
}

build() {
    rm -rf "$package/_bundled" "$package"/*.so.new dist/new
    mkdir -p "$package/_bundled"
    cp -R addon lenses "$package/_bundled/"
    find "$package/_bundled" -name __pycache__ -prune -exec rm -rf {} +
    # Zig links against an old C library, so that the wheel runs wherever Blender 4.2 does (glibc 2.28).
    # A Linux without it, and every other system, gets a wheel for itself.
    flags=
    if .venv-tools/bin/python -c 'import ziglang' 2>/dev/null; then flags="--zig --compatibility manylinux_2_28"; fi
    # shellcheck disable=SC2086
    PATH="$PWD/.venv-tools/bin:$PATH" maturin build --quiet --release $flags --out dist/new
    # Renamed into place: a Blender that runs keeps the old one.
    .venv-tools/bin/python - "$package/_native.abi3.so" <<'PY'
import glob, os, sys, zipfile
target, = sys.argv[1:]
wheel, = glob.glob("dist/new/petzval-*.whl")
with zipfile.ZipFile(wheel) as archive:
    name, = [name for name in archive.namelist() if name == "petzval/_native.abi3.so"]
    with open(target + ".new", "wb") as out:
        out.write(archive.read(name))
os.replace(target + ".new", target)
PY
    rm -rf "$package/_bundled" dist/petzval-*.whl
    mv dist/new/petzval-*.whl dist/
    rmdir dist/new
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
