#!/bin/sh
# Builds dist/petzval-VERSION.zip, the Blender extension: the add-on, and the wheel of the engine in wheels/.
# A real Blender validates and builds it; without one it is only packed, and that is said.
set -eu
cd "$(dirname "$0")/.."

ls dist/petzval-*.whl >/dev/null 2>&1 || { echo "petzval: no wheel in dist/: run make extension" >&2; exit 1; }

fresh() {
    [ -n "$(find dist -name 'petzval-*.zip' -newer dist/.petzval-wheel)" ] &&
        [ -z "$(find addon tools/build-extension.sh -name __pycache__ -prune -o -newer dist/.petzval-extension -print | head -n 1)" ]
}
if [ -e dist/.petzval-extension ] && fresh; then exit 0; fi

rm -rf dist/extension dist/petzval-*.zip
touch dist/.petzval-extension
cp -R addon dist/extension
find dist/extension -name __pycache__ -prune -exec rm -rf {} +
mkdir dist/extension/wheels
cp dist/petzval-*.whl dist/extension/wheels/

zip=$(.venv-tools/bin/python - <<'PY'
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
print(f"dist/petzval-{tomllib.loads(text)['version']}.zip")
PY
)
if tools/setup-blender.sh --where >/dev/null; then
    tools/blender --command extension validate dist/extension
    tools/blender --command extension build --source-dir dist/extension --output-filepath "$zip"
    tools/blender --command extension validate "$zip"
else
    .venv-tools/bin/python -m zipfile -c "$zip" dist/extension/*
    echo "petzval: $zip is packed, not validated: there is no real Blender (tools/setup-blender.sh)" >&2
fi
rm -rf dist/extension
echo "$zip"
