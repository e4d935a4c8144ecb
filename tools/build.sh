#!/bin/sh
# Compiles the engine while Blender is fetched, and makes the checkout the Petzval of the Python environments: what `make build` runs.
set -eu
cd "$(dirname "$0")/.."

{ tools/setup-python.sh bpy52 || tools/setup-python.sh bpy45; } &
environment=$!
# Downloads, while the environment of the build is made. Without a connection the build itself says so.
cargo fetch --quiet --locked 2>/dev/null &
fetched=$!
tools/setup-python.sh tools
wait "$fetched" || true
built=0
tools/build-wheel.sh || built=$?
wait "$environment"
[ "$built" = 0 ] || exit "$built"
# The environment may have been made after the wheel.
tools/build-wheel.sh
