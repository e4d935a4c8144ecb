#!/bin/sh
# Runs everything that must hold, and ends with a summary: what failed, what could not run, the slowest tests.
#
#   tools/test.sh         Rust, Python, bpy 5.2 and 4.5, the real Blender
#   tools/test.sh --all   bpy 5.0 and 4.2 too, the release wheel, all cases, and a small run of every page's recipe
#
# Every step has a log in output/test/. A step that has passed is not run again while nothing that it reads has changed:
# PETZVAL_TEST_AGAIN=1 runs all of them. Two lanes run side by side after the engine is compiled: one compiles and runs the Rust tests,
# and then the Python tests beside the second Blender version; the other runs all other Python tests. The first one has
# what the other leaves of the processor: starts of Blender, windows and single threads leave a part of it.
set -eu
cd "$(dirname "$0")/.."

. tools/processor.sh
logs=output/test
rm -rf "$logs"
passed_steps=.cache/test
mkdir -p "$logs" "$passed_steps"
# What the Rust tests read.
rust="engine lenses tests/reference Cargo.toml Cargo.lock .cargo tools/rust_tests.py"
report=$logs/steps.txt
# There once the Python environments can be used.
prepared_mark=$logs/prepared
PETZVAL_NOT_RUN=$PWD/$logs/not-run.txt
PETZVAL_DURATIONS=$PWD/$logs/durations.txt
export PETZVAL_NOT_RUN PETZVAL_DURATIONS
: >"$report"
: >"$PETZVAL_NOT_RUN"
: >"$PETZVAL_DURATIONS"
start=$(date +%s)

# cpu FILE: seconds of processor time, of the children's line of `times` in it.
cpu() { awk 'NR == 2 { gsub("[ms]", " "); printf "%d\n", 60 * ($1 + $3) + $2 + $4 }' "$1"; }

# step NAME COMMAND...: runs it, keeps what it prints in a log, and shows the log if it fails.
step() {
    name=$1 log=$logs/$(echo "$1" | tr -cs 'A-Za-z0-9.\n' -).log began=$(date +%s) status=0
    shift
    # In a shell of its own: the processes of the other lane would count here when they end.
    (
        "$@" >"$log" 2>&1 || status=$?
        times >"$log.times"
        exit "$status"
    ) || status=$?
    used=$(cpu "$log.times")
    rm -f "$log.times"
    case $status in
    0) word=ok ;;
    124) word="OUT OF TIME" ;;
    *) word=FAILED ;;
    esac
    [ "$word" = ok ] || { cat "$log"; }
    line=$(printf '%-11s %5s s %5s CPU s  %s' "$word" "$(($(date +%s) - began))" "$used" "$name")
    echo "$line" >>"$report"
    echo "$line"
}

# digest PATHS...: of the files under them that git tracks or would track, of the programs that read them, and of scenes by others.
# Nothing where there is no git.
digest() {
    git rev-parse --git-dir >/dev/null 2>&1 || return 0
    {
        git ls-files -coz --exclude-standard -- "$@" | sort -zu | xargs -0 sha256sum 2>/dev/null
        cat .venv-*/.petzval-ready 2>/dev/null
        rustc -vV
        uname -srm
        echo "$all ${PETZVAL_SCENES-}"
        [ -z "${PETZVAL_SCENES-}" ] || find "$PETZVAL_SCENES" -type f -printf '%p %s %T@\n' | sort
    } | sha256sum | cut -c 1-64
}

# step_of PATHS NAME COMMAND...: the step, unless it has passed with the same files under these paths.
step_of() {
    # shellcheck disable=SC2086
    now=$(digest $1) passed=$passed_steps/$(echo "$2" | tr -cs 'A-Za-z0-9.\n' -)
    shift
    if [ -n "$now" ] && [ -z "${PETZVAL_TEST_AGAIN-}" ] && [ "$(cat "$passed" 2>/dev/null)" = "$now" ]; then
        line=$(printf '%-11s %5s s %5s CPU s  %s (passed before, nothing has changed)' ok 0 0 "$1")
        echo "$line" >>"$report"
        echo "$line"
        return
    fi
    rm -f "$passed"
    step "$@"
    [ "$word" != ok ] || [ -z "$now" ] || echo "$now" >"$passed"
}

not_run() { echo "$*" >>"$PETZVAL_NOT_RUN"; }

has() { [ -e ".venv-$1/.petzval-ready" ]; }

# Priority of the Python tests in this lane, as `nice` counts, and that of a lane that leaves the processor to the other.
niceness=0
low=10

# pytest_on ENVIRONMENT SECONDS ARGUMENTS...: two processes, as a test waits for Blender's start or its one thread half of the time.
pytest_on() {
    environment=$1 seconds=$2
    shift 2
    nice -n "$niceness" timeout --kill-after=20 "$seconds" ".venv-$environment/bin/python" -m pytest -q -n 2 --dist loadfile "$@"
}

# prepared ENVIRONMENT...: makes the Python environments, and notes those that could not be made.
prepared() {
    for environment in "$@"; do
        tools/setup-python.sh "$environment" >"$logs/setup-$environment.log" 2>&1 || true
        has "$environment" || not_run "all on $environment: $(tail -n 1 "$logs/setup-$environment.log")"
    done
}

all=
if [ "${1-}" = --all ]; then
    all=yes
    # Rust tests take all lenses and the full number of rays, and check what only a development build checks.
    PETZVAL_TEST_ALL=1 CARGO_PROFILE_DEV_DEBUG_ASSERTIONS=true CARGO_PROFILE_DEV_OVERFLOW_CHECKS=true
    export PETZVAL_TEST_ALL CARGO_PROFILE_DEV_DEBUG_ASSERTIONS CARGO_PROFILE_DEV_OVERFLOW_CHECKS
fi

# Fetching Blender waits for the network and the disk mostly: it runs beside the compiler.
tools/setup-blender.sh >"$logs/setup-blender.log" 2>&1 &
blender_job=$!
cargo fetch --quiet --locked 2>/dev/null &
prepared tools
has tools || { echo "petzval: without its tools nothing can be built: see above" >&2; exit 1; }
# shellcheck disable=SC2046
prepared bpy52 bpy45 docs bench $([ -z "$all" ] || echo bpy50 bpy42) &
python_job=$!
echo "petzval: logs of all steps are in $logs"
step "cargo fmt" cargo fmt --all --check
step "ruff check" .venv-tools/bin/ruff check
step "ruff format" .venv-tools/bin/ruff format --check
step "wheel" tools/build-wheel.sh $([ -z "$all" ] || echo --release)

# In a shell of its own: what it exports is for cargo.
rust_tests() (
    # The settings with which maturin compiles pyo3: with others it would be compiled again here, and for the next wheel.
    PYO3_CONFIG_FILE=$(ls "$PWD"/target/maturin/pyo3-config-*.txt 2>/dev/null | head -n 1)
    PYO3_BUILD_EXTENSION_MODULE=1 PYO3_PYTHON=$PWD/.venv-tools/bin/python
    [ -n "$PYO3_CONFIG_FILE" ] && export PYO3_CONFIG_FILE PYO3_BUILD_EXTENSION_MODULE || export PYO3_PYTHON
    # Benches need criterion, which nothing else does: `make lint` and `make test-all` have them.
    # shellcheck disable=SC2046
    step_of "$rust" "cargo clippy" nice -n "$low" cargo clippy --quiet --all-targets --workspace --locked \
        $([ -n "$all" ] || echo --exclude petzval-benches) -- -D warnings
    step_of "$rust" "cargo test" nice -n "$low" .venv-tools/bin/python tools/rust_tests.py
    step_of "$rust" "cargo test --doc" nice -n "$low" cargo test --quiet --workspace --locked --doc
)

rust_lane() {
    niceness=$low
    rust_tests
    # Until the other lane has made the Python environments, or has ended.
    while [ ! -e "$prepared_mark" ]; do
        kill -0 $$ 2>/dev/null || return 0
        sleep 1
    done
    # If it is the only one, the other lane takes it.
    if has bpy52 && has bpy45; then
        step_of . "pytest, bpy45" pytest_on bpy45 2700 -m "not once and not real_blender and not window"
    fi
}

python_lane() {
    wait "$python_job" || true
    # Makes the checkout the package `petzval` of environments that were made after the wheel.
    tools/build-wheel.sh
    wait "$blender_job" || true
    step "extension" make --no-print-directory extension
    if has docs; then step "book" make --no-print-directory docs; fi
    touch "$prepared_mark"
    main=
    for environment in bpy52 bpy45; do if has $environment; then main=$environment && break; fi; done
    if [ -z "$main" ]; then
        not_run "pytest: no environment with bpy could be made"
        echo "FAILED          0 s  pytest: no environment with bpy" >>"$report"
        return 0
    fi
    step_of . "pytest, $main" pytest_on "$main" 3600 -m "not real_blender and not window and not recipe"
    if tools/setup-blender.sh --where >/dev/null; then
        step_of . "pytest, real Blender" pytest_on "$main" 1200 -m "real_blender or window"
    else
        not_run "all in the real Blender: $(tail -n 1 "$logs/setup-blender.log")"
    fi
    [ -n "$all" ] || return 0
    for environment in bpy50 bpy42; do
        has "$environment" || continue
        step_of . "pytest, $environment" pytest_on "$environment" 1800 -m "not once and not real_blender and not window"
    done
    step_of . "pytest, every recipe" pytest_on "$main" 7200 -m recipe
}

trap 'kill 0' INT TERM
rust_lane &
rust_job=$!
python_lane
wait "$rust_job" || true

printf '\n== summary, %s s in all\n' "$(($(date +%s) - start))"
cat "$report"
printf '\nThe twenty slowest tests, in seconds:\n'
sort -rn "$PETZVAL_DURATIONS" | head -n 20
printf '\n'
sort -u "$PETZVAL_NOT_RUN" | sed 's/^/not run: /'
! grep -qv '^ok ' "$report"
