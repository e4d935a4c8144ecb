#!/bin/sh
# Everything that must hold, one step after another; at the end what failed and what could not run.
#
#   tools/test.sh         Rust, Python, bpy 5.2 and 4.5, the real Blender
#   tools/test.sh --all   bpy 5.0 and 4.2 too
set -eu
cd "$(dirname "$0")/.."

mkdir -p output
report=$PWD/output/test-report.txt
PETZVAL_NOT_RUN=$PWD/output/not-run.txt
export PETZVAL_NOT_RUN
: >"$report"
: >"$PETZVAL_NOT_RUN"
failed=0

# step NAME COMMAND...: runs it, keeps how it ended.
step() {
    name=$1 began=$(date +%s)
    shift
    printf '\n== %s\n' "$name"
    status=0
    "$@" || status=$?
    # pytest says 5 when a selection is empty.
    [ "$status" = 124 ] && name="$name (out of time)"
    if [ "$status" = 0 ]; then word=ok; else word=FAILED failed=1; fi
    printf '%-7s %5s s  %s\n' "$word" "$(($(date +%s) - began))" "$name" >>"$report"
    return 0
}

not_run() { echo "$*" >>"$PETZVAL_NOT_RUN"; }

has() { [ -e ".venv-$1/.petzval-ready" ]; }

# pytest_on ENVIRONMENT SECONDS ARGUMENTS...
pytest_on() {
    environment=$1 seconds=$2
    shift 2
    timeout --kill-after=20 "$seconds" ".venv-$environment/bin/python" -m pytest -q "$@"
}

# kept LOG COMMAND...: keeps what a command says and, in LOG.status, how it ended.
kept() {
    log=$1 ended=0 started=$(date +%s)
    shift
    rm -f "$log.status"
    "$@" >"$log" 2>&1 || ended=$?
    echo "petzval: $(($(date +%s) - started)) s" >>"$log"
    echo "$ended" >"$log.status"
}

# told LOG: says what `kept` has kept, and ends like it.
told() {
    cat "$1"
    return "$(cat "$1.status" 2>/dev/null || echo 1)"
}

# Fetching the real Blender waits for the network and the disk mostly: it runs beside the Rust steps.
blender_log=output/setup-blender.log
tools/setup-blender.sh >"$blender_log" 2>&1 &
blender_job=$!

more=
[ "${1-}" != --all ] || more="bpy50 bpy42"
for environment in tools bpy52 bpy45 docs $more; do
    tools/setup-python.sh "$environment" 2>&1 | tee output/setup.log
    has "$environment" || not_run "all on $environment: $(tail -n 1 output/setup.log)"
done
has tools || { echo "petzval: without its tools nothing can be built: see above" >&2; exit 1; }
# The crate of the Python module asks an interpreter for its version.
PYO3_PYTHON=$PWD/.venv-tools/bin/python
export PYO3_PYTHON

step "cargo fmt" cargo fmt --all --check
step "cargo clippy" cargo clippy --quiet --all-targets --workspace --locked -- -D warnings
# Examples, which clippy has compiled, are left out: the tracer's kernels are long to make for each program.
step "cargo test" cargo test --quiet --locked --lib --tests
step "cargo test --doc" cargo test --quiet --locked --doc
step "ruff check" .venv-tools/bin/ruff check
step "ruff format" .venv-tools/bin/ruff format --check
if has docs; then step "book" make --no-print-directory docs; fi
step "wheel" tools/build-wheel.sh

wait "$blender_job" || true
cat "$blender_log"
step "extension" tools/build-extension.sh
if tools/setup-blender.sh --where >/dev/null; then
    real=yes
else
    not_run "all in the real Blender: $(tail -n 1 "$blender_log")"
    real=
fi

main=
for environment in bpy52 bpy45; do if has $environment; then main=$environment && break; fi; done
if [ -n "$main" ]; then
    # In two rows of about the same length, side by side: each waits for programs to start and for Blender's one thread about
    # half of its time. One holds pictures beside Cycles and the figures, the other is the second Blender and then all else.
    second=
    if [ "$main" != bpy45 ] && has bpy45; then second=output/pytest-bpy45.log; fi
    others=output/pytest-others.log
    beside="tests/test_*against_cycles.py tests/test_parity.py tests/test_light_groups.py tests/test_figures.py"
    {
        [ -z "$second" ] || kept "$second" pytest_on bpy45 2700 -m "not once and not real_blender and not window"
        kept "$others" pytest_on "$main" 2700 -m "not real_blender and not window" \
            --ignore-glob="*against_cycles.py" --ignore=tests/test_parity.py --ignore=tests/test_light_groups.py \
            --ignore=tests/test_figures.py
    } &
    row=$!
    # shellcheck disable=SC2086
    step "pytest, $main, beside Cycles, and figures" pytest_on "$main" 2700 -m "not real_blender and not window" $beside
    step "pytest, the rest of the other row" wait "$row"
    [ -z "$second" ] || step "pytest, bpy45: see $second" told "$second"
    step "pytest, $main, all else: see $others" told "$others"
    for environment in $more; do
        has "$environment" || continue
        step "pytest, $environment" pytest_on "$environment" 900 -m "not once and not real_blender and not window"
    done
    [ -z "$real" ] || step "pytest, real Blender" pytest_on "$main" 1200 -m "real_blender or window"
else
    not_run "pytest: no environment with bpy could be made"
    failed=1
fi

printf '\n== summary\n'
cat "$report"
sort -u "$PETZVAL_NOT_RUN" | sed 's/^/not run: /'
exit $failed
