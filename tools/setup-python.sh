#!/bin/sh
# Makes the Python environments .venv-NAME of the checkout from tools/requirements/NAME.txt; costs nothing when they are up to date.
#
#   tools/setup-python.sh NAME...     tools bpy52 bpy45 bpy50 bpy42 bench docs wheels
#
# Exit 1, with one line that says what to do, if one of them cannot be made; the others are made all the same.
set -eu
cd "$(dirname "$0")/.."

say() { echo "petzval: $*" >&2; }

# The Python that the bpy of this name was built for.
version_of() {
    case $1 in
    bpy52) echo 3.13 ;;
    bpy45 | bpy50 | bpy42) echo 3.11 ;;
    tools | docs | wheels) echo 3.11 3.12 3.13 3.14 ;;
    bench) echo 3.13 3.12 3.11 ;;
    *) return 1 ;;
    esac
}

# An interpreter of one of the given versions, on PATH or among pyenv's.
find_python() {
    for version in "$@"; do
        for candidate in "python$version" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python; do
            found=$("$candidate" -c 'import sys, venv; print("%d.%d" % sys.version_info[:2], sys.executable)' 2>/dev/null) || continue
            [ "${found%% *}" = "$version" ] && echo "${found#* }" && return 0
        done
    done
    return 1
}

# What bpy needs of the system, under the names of Debian.
libraries="libx11-6 libxrender1 libxfixes3 libxi6 libxxf86vm1 libxkbcommon0 libsm6 libgl1 libgomp1"
install_libraries() {
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -q && apt-get install -yq --no-install-recommends $libraries
    fi
}

make_one() {
    name=$1 folder=.venv-$1 list=tools/requirements/$1.txt
    versions=$(version_of "$name") && [ -e "$list" ] || { say "$name: no such environment: see tools/requirements"; return 1; }
    # With the hashes of all packages, where they are known: nothing else is installed then.
    what="-r $list" locked=tools/requirements/locked/$1.txt
    [ ! -e "$locked" ] || what="--require-hashes --no-deps -r $locked"
    stamp=$(cat "$list" tools/requirements/tests.txt "$locked" 2>/dev/null | sha256sum)
    if [ "$(cat "$folder/.petzval-ready" 2>/dev/null)" = "$stamp" ] && "$folder/bin/python" -c '' 2>/dev/null; then return 0; fi

    # shellcheck disable=SC2086
    python=$(find_python $versions) || { say "$name: no Python $versions: install it (with venv), on PATH or by pyenv"; return 1; }
    log=$folder.log
    case $name in
    bpy*) long="fetches Blender as a Python module, about a minute" ;;
    *) long="a few seconds" ;;
    esac
    echo "petzval: making $folder ($long; log: $log)" >&2
    # Broken off on the way, or of another Python: from the start. Otherwise only the list changed.
    if [ ! -e "$folder/.petzval-ready" ] || ! "$folder/bin/python" -c '' 2>/dev/null; then
        "$python" -m venv --clear "$folder" >"$log" 2>&1 || { say "$name: cannot make $folder: read $log"; return 1; }
    fi
    # Python compiles what it imports; all of Blender's scripts would take a quarter of the time of the installation.
    # shellcheck disable=SC2086
    "$folder/bin/python" -m pip install --disable-pip-version-check --no-compile $what >>"$log" 2>&1 ||
        { say "$name: cannot install $list: read $log"; return 1; }
    case $name in
    tools | bench | docs | wheels) needs_bpy=no ;;
    *) needs_bpy=yes ;;
    esac
    if [ $needs_bpy = yes ] && ! import_bpy; then
        install_libraries >>"$log" 2>&1 || true
        import_bpy || { say "$name: bpy does not load: install $libraries, or read $log"; return 1; }
    fi
    echo "$stamp" >"$folder/.petzval-ready"
}

import_bpy() {
    "$folder/bin/python" -c 'import bpy, os, sys; sys.stdout.flush(); os._exit(0)' >>"$log" 2>&1
}

failed=0
for name in "$@"; do make_one "$name" || failed=1; done
exit $failed
