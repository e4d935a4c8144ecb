#!/bin/sh
# Finds or makes a real Blender of at least 4.2, for the tests that need the program and not only the bpy module:
# its own on PATH if that is new enough, else Debian trixie's in a folder of its own (root only, once, 1.8 GB).
# Prints nothing when all is there; on failure one line that says what to do, exit 1. Run it again after a break: it goes on.
#
#   tools/setup-blender.sh          make sure there is one
#   tools/setup-blender.sh --where  print "path" or "chroot FOLDER"; exit 1 if there is none yet
set -eu

cache=${PETZVAL_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/petzval}
suite=trixie
root=$cache/blender-$suite
# A change of the recipe builds the folder anew: raise the number.
recipe=2
packages="blender xvfb xauth libgl1-mesa-dri imagemagick xdotool python3-numpy"

fail() {
    echo "petzval: $*" >&2
    exit 1
}

# True for "Blender 4.2.0" and newer.
new_enough() {
    "$1" --version 2>/dev/null | awk '
        /^Blender [0-9]/ { split($2, v, "."); found = v[1] > 4 || (v[1] == 4 && v[2] >= 2) }
        END { exit !found }'
}

on_path() {
    command -v blender >/dev/null 2>&1 && command -v xvfb-run >/dev/null 2>&1 && new_enough blender
}

ready() {
    [ "$(cat "$root/.petzval-ready" 2>/dev/null)" = "$recipe" ]
}

if [ "${1-}" = --where ]; then
    if ready; then echo "chroot $root"; elif on_path; then echo path; else exit 1; fi
    exit 0
fi

if ready || on_path; then exit 0; fi
[ "$(id -u)" = 0 ] || fail "real blender: none of 4.2 or newer with xvfb-run on PATH: install both, or run as root once to make one"
command -v apt-get >/dev/null || fail "real blender: no blender of 4.2 or newer on PATH: install one, and xvfb"

mkdir -p "$cache"
exec 9>"$cache/blender-$suite.lock"
flock 9
if ready; then exit 0; fi

partial=$root.partial
log=$cache/blender-$suite.log
step() {
    # The lock is not handed down: a daemon left behind must not keep it.
    "$@" >>"$log" 2>&1 9>&- || fail "real blender: '$1 ${2-}' failed: read $log, then run again"
}
: >"$log"

if ! command -v debootstrap >/dev/null; then
    step apt-get update -q
    step apt-get install -yq --no-install-recommends debootstrap
fi
if [ ! -e "$partial/.petzval-base" ]; then
    echo "real blender: fetching Debian $suite (once, about four minutes)" >&2
    rm -rf "$partial"
    step debootstrap --variant=minbase "$suite" "$partial"
    printf '#!/bin/sh\nexit 101\n' >"$partial/usr/sbin/policy-rc.d"
    chmod +x "$partial/usr/sbin/policy-rc.d"
    : >"$partial/.petzval-base"
fi
if [ ! -e "$partial/.petzval-packages" ]; then
    cp /etc/resolv.conf "$partial/etc/resolv.conf"
    # A private mount namespace: whatever happens, nothing stays mounted.
    step unshare --mount sh -euc '
        mount -t proc proc "$1/proc"
        mount --rbind /dev "$1/dev"
        run() { chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive sh -euc "$2"; }
        run "$1" "dpkg --configure -a; apt-get update -q; apt-get install -yq --no-install-recommends $2; apt-get clean"
    ' sh "$partial" "$packages"
    # Blender asks it for the disks.
    ln -sf /proc/self/mounts "$partial/etc/mtab"
    : >"$partial/.petzval-packages"
fi
rm -rf "$root"
echo "$recipe" >"$partial/.petzval-ready"
mv "$partial" "$root"
