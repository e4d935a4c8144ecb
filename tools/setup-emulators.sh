#!/bin/sh
# Finds or fetches what runs programs of other systems here: Wine for Windows, QEMU for Linux on ARM. Those on PATH are taken; else Debian's
# packages are unpacked into a folder of their own, without root.
# Prints nothing when all is there; on failure one line that says what to do, exit 1.
#
#   tools/setup-emulators.sh                 make sure there are both
#   tools/setup-emulators.sh --where wine    the command that runs a Windows program; exit 1 if there is none
#   tools/setup-emulators.sh --where qemu    the same for Linux on ARM
set -eu

cache=${PETZVAL_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/petzval}
root=$cache/emulators
# A change of the recipe fetches all anew: raise the number.
recipe=1
# ARM programs find their C library there, which zig's linker names by its ordinary place.
packages="libwine wine64 libz-mingw-w64 qemu-user-static libc6-arm64-cross libgcc-s1-arm64-cross"

fail() {
    echo "petzval: $*" >&2
    exit 1
}

ready() { [ "$(cat "$root/.petzval-ready" 2>/dev/null)" = "$recipe" ]; }

where() {
    case $1 in
    wine)
        if ready; then echo "$root/usr/lib/wine/wine64"; else command -v wine64 || command -v wine; fi
        ;;
    qemu)
        if ready; then
            echo "$root/usr/bin/qemu-aarch64-static -L $root/usr/aarch64-linux-gnu"
        else
            [ -e /usr/aarch64-linux-gnu/lib/ld-linux-aarch64.so.1 ] || return 1
            found=$(command -v qemu-aarch64-static || command -v qemu-aarch64) && echo "$found -L /usr/aarch64-linux-gnu"
        fi
        ;;
    *) return 1 ;;
    esac
}

if [ "${1-}" = --where ]; then where "$2" && exit 0 || exit 1; fi
if where wine >/dev/null && where qemu >/dev/null; then exit 0; fi
command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null ||
    fail "emulators: install wine (64 bit), qemu-user and the C library of aarch64 (/usr/aarch64-linux-gnu)"
[ "$(uname -m)" = x86_64 ] || fail "emulators: they are fetched for x86-64 alone: install wine and qemu-user"

mkdir -p "$cache"
exec 9>"$cache/emulators.lock"
flock 9
if ready; then exit 0; fi
partial=$root.partial log=$cache/emulators.log
rm -rf "$partial"
mkdir -p "$partial/packages"
echo "petzval: fetching wine and qemu (once, about a minute; log: $log)" >&2
# The list of packages may be an old one, or there is none yet.
[ "$(id -u)" != 0 ] || apt-get update -q >"$log" 2>&1 || true
# shellcheck disable=SC2086
(cd "$partial/packages" && apt-get download -q $packages) >>"$log" 2>&1 ||
    fail "emulators: Debian's packages $packages cannot be fetched: read $log"
for package in "$partial"/packages/*.deb; do
    dpkg-deb -x "$package" "$partial" >>"$log" 2>&1 || fail "emulators: $package cannot be unpacked: read $log"
done
rm -rf "$partial/packages"
# What Debian has as scripts and links with its own paths.
libraries=$(dirname "$(find "$partial/usr/lib" -path '*/wine/x86_64-windows/kernel32.dll' | head -n 1)")
[ -e "$libraries/kernel32.dll" ] || fail "emulators: Debian's wine is laid out in another way: install wine (64 bit) on PATH"
rm -f "$libraries/zlib1.dll"
cp "$partial/usr/x86_64-w64-mingw32/lib/zlib1.dll" "$libraries/"
[ ! -e "$partial/usr/lib/wine/wineserver64" ] || cp "$partial/usr/lib/wine/wineserver64" "$partial/usr/lib/wine/wineserver"
rm -rf "$root"
echo "$recipe" >"$partial/.petzval-ready"
mv "$partial" "$root"
