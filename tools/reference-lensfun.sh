#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Writes tests/reference/lensfun/lensfun.json: what lensfun itself makes of the lenses in tests/reference/lensfun/lenses.xml.
#
# tools/reference-lensfun.sh LENSFUN, a checkout of github.com/lensfun/lensfun (the table is of 1c8b8f07, 2026-08-14). Its library is
# compiled here with double in place of float: with float its numbers are good to 1e-6, which would hide a wrong formula's small terms.
# Needs g++, pkg-config and the headers of glib 2.
set -eu
source="$1"
here="$(cd "$(dirname "$0")/.." && pwd)/tests/reference/lensfun"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cp "$source"/libs/lensfun/*.cpp "$source"/libs/lensfun/*.h "$work"
rm "$work"/mod-*-sse*.cpp
mkdir -p "$work/windows"
cp "$source"/libs/lensfun/windows/mathconstants.h "$work/windows"
sed 's/@[A-Z_]*@/0/g' "$source"/include/lensfun/lensfun.h.in > "$work/lensfun.h"
cp "$here/driver.cpp" "$work"
cat > "$work/config.h" <<'CONFIG'
#define CONF_PACKAGE "lensfun"
#define CONF_COMPILER_GCC 1
#define PLATFORM_LINUX
#define SYSTEM_DB_PATH "/nonexistent"
#define SYSTEM_DB_UPDATE_PATH "/nonexistent"
#define DATABASE_SUBDIR "version_2"
CONFIG
sed -i -E 's/\bfloat\b/double/g; s/FLT_MAX/DBL_MAX/g; s/\bsqrtf\b/sqrt/g' "$work"/*.cpp "$work"/*.h
# shellcheck disable=SC2046
g++ -O0 -w -std=c++14 -I"$work" $(pkg-config --cflags glib-2.0) "$work"/*.cpp -o "$work/driver" $(pkg-config --libs glib-2.0)
ask() { "$work/driver" "$here/lenses.xml" "$@"; }
{
    echo '['
    first=1
    for model in "Nikkor Z 24-70mm f/4 S" "Nikon AF-S VR Zoom-Nikkor 70-300mm f/4.5-5.6G IF-ED" "Canon PowerShot G12 & compatibles (Standard)" \
        "Nikon AF-S DX Nikkor 35mm f/1.8G" "Sigma 8mm f/3.5 EX DG Circular" "Made-up 20-60mm of Adobe's models"; do
        case "$model" in
            *24-70*) crop=1.0 settings="24:4:1000 30:5:3 47.5:8:10 70:22:1000 90:4:10" ;;
            *70-300*) crop=1.523 settings="70:4.5:10 110:5:20 280:9:1000" ;;
            *G12*) crop=4.63 settings="6.1:2.8:10 9:4:10 30.5:8:10" ;;
            *35mm*) crop=1.528 settings="35:1.8:10 35:3.3:100" ;;
            *8mm*) crop=1.523 settings="8:3.5:10" ;;
            *) crop=1.2 settings="20:4:10 31:5:6 60:8:1000" ;;
        esac
        for setting in $settings; do
            [ "$first" ] || echo ','
            first=
            # shellcheck disable=SC2046
            ask "$model" "$crop" $(echo "$setting" | tr ':' ' ')
        done
    done
    echo ']'
} > "$here/lensfun.json"
