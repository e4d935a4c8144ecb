#!/bin/sh
# Compiles the engine while Blender is fetched, and makes the checkout the Petzval of the Python environments: what `make build` runs.
set -eu
cd "$(dirname "$0")/.."

{ tools/setup-python.sh bpy52 || tools/setup-python.sh bpy45; } &
environment=$!
built=0
tools/build-wheel.sh || built=$?
wait "$environment"
[ "$built" = 0 ] || exit "$built"
# The environment may have been made after the wheel.
tools/build-wheel.sh
