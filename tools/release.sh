#!/bin/sh
# Makes dist/release of the extensions and wheels in dist/: what is handed out with a release. The folder is a static extensions
# repository too: Blender reads it from a folder or from any server of files, and finds updates there.
#
#   tools/release.sh [FOLDER]
set -eu
cd "$(dirname "$0")/.."

out=${1:-dist/release}
ls dist/petzval-*.zip >/dev/null 2>&1 || { echo "petzval: no extension in dist/: run make extensions-all" >&2; exit 1; }
tools/setup-blender.sh --where >/dev/null ||
    { echo "petzval: the repository's index is made by Blender: run tools/setup-blender.sh, or put a blender of 4.2 or later on PATH" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"
cp dist/petzval-*.zip dist/petzval-*.whl LICENSE CHANGELOG.md "$out/"
# Bills and notices of this machine's engine; those of the others lie in their wheels.
PYTHONPATH=tools .venv-tools/bin/python -m supply notices "$out/THIRD-PARTY-NOTICES.txt"
PYTHONPATH=tools .venv-tools/bin/python -m supply sbom "$out/SBOM.cdx.json"
tools/blender --command extension server-generate --repo-dir "$(cd "$out" && pwd)" --html
(cd "$out" && sha256sum petzval-* >SHA256SUMS)
ls "$out"
