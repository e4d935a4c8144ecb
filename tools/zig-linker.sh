#!/bin/sh
# Links for another system, with the C libraries that zig brings: a linker for Cargo. PETZVAL_ZIG_TARGET names the system as zig does
# (tools/platforms).
set -eu
tools=$(cd "$(dirname "$0")/../.venv-wheels/bin" && pwd)
PATH=$tools:$PATH

# A Mac's libraries are linked by Rust's own LLD: zig's linker knows no list of what they hand out, and a module that hands out everything
# asks for every function of Python that any crate knows.
link_for_mac() {
    host=$(rustc -vV | sed -n 's/^host: //p')
    linker=$(rustc --print sysroot)/lib/rustlib/$host/bin/rust-lld
    system=$(python -c 'import pathlib, ziglang; print(pathlib.Path(ziglang.__file__).parent / "lib/libc/darwin/libSystem.tbd")')
    # Zig's name is aarch64-macos.11.0-none.
    version=${PETZVAL_ZIG_TARGET#*-macos.} version=${version%-*}
    # What is meant for a C compiler, in the linker's own words; the arguments are turned round once.
    count=$#
    while [ "$count" -gt 0 ]; do
        argument=$1
        shift
        count=$((count - 1))
        case $argument in
        -Wl,*)
            rest=${argument#-Wl,}
            while [ "$rest" != "${rest#*,}" ]; do
                set -- "$@" "${rest%%,*}"
                rest=${rest#*,}
            done
            set -- "$@" "$rest"
            ;;
        -dynamiclib) set -- "$@" -dylib ;;
        # All of them are libSystem, but for the one of character sets, which nothing here calls.
        -mmacosx-version-min=* | -nodefaultlibs | -lSystem | -lc | -lm | -liconv) ;;
        *) set -- "$@" "$argument" ;;
        esac
    done
    exec "$linker" -flavor darwin -platform_version macos "$version" "$version" "$@" "$system"
}

# Zig takes no notice of Rust's list of what a Windows library hands out, and hands out everything: in an object it does.
list='' is_library='' is_mac=''
for argument in "$@"; do
    case $argument in
    -Wl,*.def) list=${argument#-Wl,} ;;
    -shared) is_library=yes ;;
    -dynamiclib) is_mac=yes ;;
    esac
done
[ -z "$is_mac" ] || link_for_mac "$@"
if [ -n "$list" ] && [ -n "$is_library" ]; then
    awk 'BEGIN { print ".section .drectve,\"yni\"" } { gsub("\"", "") } NR > 1 && NF { printf ".ascii \" -export:%s\"\n", $1 }' "$list" >"$list.s"
    python -m ziglang cc -target "$PETZVAL_ZIG_TARGET" -c "$list.s" -o "$list.o"
    set -- "$@" "$list.o"
fi
exec maturin zig cc -- -target "$PETZVAL_ZIG_TARGET" "$@"
