#!/bin/sh
# Links for another system by zig, which brings the C libraries of all of them: a linker for Cargo. PETZVAL_ZIG_TARGET names the system
# as zig does (tools/platforms).
set -eu
tools=$(cd "$(dirname "$0")/../.venv-wheels/bin" && pwd)
PATH=$tools:$PATH

# Zig takes no notice of Rust's list of what a Windows library hands out, and hands out everything: in an object it does.
list='' is_library=
for argument in "$@"; do
    case $argument in
    -Wl,*.def) list=${argument#-Wl,} ;;
    -shared) is_library=yes ;;
    esac
done
if [ -n "$list" ] && [ -n "$is_library" ]; then
    awk 'BEGIN { print ".section .drectve,\"yni\"" } { gsub("\"", "") } NR > 1 && NF { printf ".ascii \" -export:%s\"\n", $1 }' "$list" >"$list.s"
    python -m ziglang cc -target "$PETZVAL_ZIG_TARGET" -c "$list.s" -o "$list.o"
    set -- "$@" "$list.o"
fi
exec maturin zig cc -- -target "$PETZVAL_ZIG_TARGET" "$@"
