#!/usr/bin/env bash
# Builds modules and their tests with AddressSanitizer and UndefinedBehaviorSanitizer (asan) or ThreadSanitizer (tsan) and
# runs them, one after another, as far as the time allows.
#   scripts/sanitizers.sh [--minutes M] [PRESET:MODULE ...]      e.g. asan:fuzz tsan:core
#     --minutes M    no module is begun, built or run beyond that; default: 240
# Without PRESET:MODULE: those first that read what strangers wrote, then those with threads, then every other module. One line
# each: passed, failed, or not reached. Ends with 1 where one failed; what was not reached is no failure.
# Environment: JOBS (of the compiler, default 2).
set -euo pipefail

fail() { echo "sanitizers: $*" >&2; exit 2; }
minutes=240
modules=()
while [ $# -gt 0 ]; do
  case "$1" in
    --minutes)
      [[ "${2:-}" =~ ^[1-9][0-9]*$ ]] || fail "--minutes needs a whole number"
      minutes="$2"
      shift
      ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
    asan:* | tsan:*) modules+=("$1") ;;
    *) fail "unknown word '$1'; known: --minutes M, asan:MODULE, tsan:MODULE" ;;
  esac
  shift
done
cd "$(dirname "$0")/.."
if [ ${#modules[@]} -eq 0 ]; then
  # asan:fuzz replays the corpora of all parsers.
  modules=(tsan:core asan:fuzz tsan:dataset tsan:layouts asan:dataset asan:layouts asan:convert asan:artifact asan:gltf
    tsan:alignment tsan:tracking tsan:associate tsan:registration tsan:select tsan:fuse tsan:observe tsan:propose tsan:render tsan:shape
    tsan:report tsan:stages tsan:batch)
  for tests in tests/*/CMakeLists.txt; do
    module="$(basename "$(dirname "$tests")")"
    [ -d "src/deepslam/$module" ] || continue
    [[ " ${modules[*]} " = *" asan:$module "* ]] || modules+=("asan:$module")
  done
fi
for module in "${modules[@]}"; do
  [ -f "tests/${module#*:}/CMakeLists.txt" ] || fail "$module: no folder tests/${module#*:}"
done

ends=$((SECONDS + 60 * minutes))
export ASAN_OPTIONS="${ASAN_OPTIONS:-}" LSAN_OPTIONS="suppressions=$PWD/tests/leaks.txt:print_suppressions=0:${LSAN_OPTIONS:-}"
export TSAN_OPTIONS="suppressions=$PWD/tests/races.txt:ignore_noninstrumented_modules=1:history_size=4:${TSAN_OPTIONS:-}"
if command -v ccache >/dev/null && [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ]; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache
fi
# What was compiled in one checkout serves every other one.
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}"

# Runs a command within what is left of the time, its output in a file: 124 where that was not enough.
in_time() {
  local log="$1" left=$((ends - SECONDS))
  shift
  [ "$left" -gt 5 ] || return 124
  timeout --kill-after=20 "$left" "$@" >"$log" 2>&1
}

check() {
  local preset="${1%%:*}" module="${1#*:}" status=0
  local build="build/$preset" target="deepslam_${1#*:}_test"
  local log="$build/$module.log"
  mkdir -p "$build"
  [ -f "$build/build.ninja" ] || in_time "$log" cmake --preset "$preset" -DDEEPSLAM_TESTS=ON || status=$?
  [ $status -ne 0 ] || in_time "$log" cmake --build "$build" -j "${JOBS:-2}" --target "$target" || status=$?
  [ $status -ne 0 ] || in_time "$log" "$build/tests/$module/$target" --gtest_brief=1 || status=$?
  case $status in
    0) echo "sanitizers: $1: passed, $(sed -n 's/.*\] \([0-9]* tests\) from.*/\1/p' "$log" | head -1)" ;;
    124) echo "sanitizers: $1: not reached in $minutes minutes" ;;
    *) tail -60 "$log"; echo "sanitizers: $1: FAILED, its output is in $log" ;;
  esac
  [ $status -eq 124 ] || return $status
}

failed=0
for module in "${modules[@]}"; do
  check "$module" || failed=1
done
exit $failed
