#!/bin/sh
# Builds dist/petzval-VERSION-PLATFORM.zip, the Blender extension, for each wheel in dist/: the add-on, and the engine's wheel in
# wheels/. `make extension` builds the wheel of this machine; those of others are built there and copied into dist/ (docs/packaging.md).
# A real Blender validates and builds them; without one they are only packed, and that is said.
set -eu
cd "$(dirname "$0")/.."

ls dist/petzval-*.whl >/dev/null 2>&1 || { echo "petzval: no wheel in dist/: run make extension" >&2; exit 1; }

# stage WHEEL: lays the extension out in dist/extension, and says its zip's name.
stage() {
    rm -rf dist/extension
    cp -R addon dist/extension
    find dist/extension -name __pycache__ -prune -exec rm -rf {} +
    mkdir dist/extension/wheels
    cp "$1" dist/extension/wheels/
    .venv-tools/bin/python - <<'PY'
import pathlib, tomllib
stage = pathlib.Path("dist/extension")
manifest = stage / "blender_manifest.toml"
wheel, = (stage / "wheels").iterdir()
tag = wheel.stem.rsplit("-", 1)[1]
system = "linux" if "linux" in tag else "macos" if "macosx" in tag else "windows"
machine = "arm64" if tag.endswith(("aarch64", "arm64")) else "x64"
text = manifest.read_text()
# Keys of the top table must stand before the first section.
head, section, rest = text.partition("\n[permissions]")
head += f'\nplatforms = ["{system}-{machine}"]\nwheels = ["./wheels/{wheel.name}"]\n'
manifest.write_text(head + section + rest)
print(f"dist/petzval-{tomllib.loads(text)['version']}-{system}-{machine}.zip")
PY
}

fresh() {
    [ -e dist/.petzval-extension ] || return 1
    [ "$(find dist -name 'petzval-*.zip' | wc -l)" = "$(find dist -name 'petzval-*.whl' | wc -l)" ] || return 1
    [ -z "$(find addon tools/build-extension.sh dist/petzval-*.whl -name __pycache__ -prune -o -newer dist/.petzval-extension -print |
        head -n 1)" ]
}
if fresh; then exit 0; fi

rm -f dist/petzval-*.zip dist/.petzval-extension
touch dist/.petzval-extension.begun
for wheel in dist/petzval-*.whl; do
    zip=$(stage "$wheel")
    if tools/setup-blender.sh --where >/dev/null; then
        tools/blender --command extension validate dist/extension
        tools/blender --command extension build --source-dir dist/extension --output-filepath "$zip"
        tools/blender --command extension validate "$zip"
    else
        .venv-tools/bin/python -m zipfile -c "$zip" dist/extension/*
        echo "petzval: $zip is packed, not validated: there is no real Blender (tools/setup-blender.sh)" >&2
    fi
    echo "$zip"
done
rm -rf dist/extension
mv dist/.petzval-extension.begun dist/.petzval-extension
