# To be sourced: replaces the flags of .cargo/config.toml on a processor without AVX2.
if [ "$(uname -m)" = x86_64 ] && [ -r /proc/cpuinfo ] && ! grep -qw avx2 /proc/cpuinfo; then
    RUSTFLAGS="-C target-cpu=x86-64-v2 --cfg disable_dispatch_avx512 -C llvm-args=-inline-threshold=300"
    export RUSTFLAGS
fi
