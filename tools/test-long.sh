#!/bin/sh
# Runs what takes hours, with other random numbers each time, and ends with a summary: all cases of the Rust tests by the seed of the day
# (statistics: engine/testkit/src/sampling.rs; property tests), a minute of fuzzing for each reader, and the soak.
#
#   tools/test-long.sh                          PETZVAL_TEST_SEED=20261130 tools/test-long.sh repeats a day's run
set -u
cd "$(dirname "$0")/.."

PETZVAL_TEST_SEED=${PETZVAL_TEST_SEED:-$(date +%Y%m%d)} PETZVAL_TEST_ALL=1
export PETZVAL_TEST_SEED PETZVAL_TEST_ALL
logs=output/test-long
rm -rf "$logs"
mkdir -p "$logs"
echo "petzval: PETZVAL_TEST_SEED=$PETZVAL_TEST_SEED; logs of all steps are in $logs"
failed=0

# step NAME COMMAND...: runs it, keeps what it prints in a log, and shows the log if it fails.
step() {
    log=$logs/$(echo "$1" | tr ' ' -).log began=$(date +%s) word=ok name=$1
    shift
    "$@" >"$log" 2>&1 || { word=FAILED failed=1; tail -n 40 "$log"; }
    printf '%-6s %6s s  %s\n' "$word" "$(($(date +%s) - began))" "$name"
}

make --no-print-directory build >"$logs/build.log" 2>&1 || { cat "$logs/build.log"; exit 1; }
PYO3_PYTHON=$PWD/.venv-tools/bin/python
export PYO3_PYTHON
step "Rust tests" .venv-tools/bin/python tools/rust_tests.py
if why=$(PYTHONPATH=tools python3 -c 'import fuzz; print(fuzz.missing() or "")') && [ -z "$why" ]; then
    step "fuzzing" make --no-print-directory fuzz
else
    echo "not run: fuzzing: $why"
fi
step "soak" make --no-print-directory ENGINE=build soak
exit "$failed"
