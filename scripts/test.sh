#!/usr/bin/env bash
# Installs what the tests need, builds, and runs them all.
#   scripts/test.sh [--preset release|dev|asan|tsan] [--downloads DIR] [ctest options ...]
#     e.g. scripts/test.sh -L unit          unit tests only
#          scripts/test.sh --preset asan    with AddressSanitizer and UndefinedBehaviorSanitizer
#          scripts/test.sh --preset tsan    unit tests with ThreadSanitizer; unless ctest options say which
# Tests on real captures look for them in the folder that DEEPSLAM_TEST_DATA names, and report themselves skipped
# without it.
set -euo pipefail

preset=release
setup=(--tests)
while [ $# -gt 0 ]; do
  case "$1" in
    --preset | --downloads)
      [ $# -ge 2 ] || { echo "test: $1 needs a value" >&2; exit 2; }
      if [ "$1" = --preset ]; then preset="$2"; else setup+=(--downloads "$(realpath -m "$2")"); fi
      shift 2
      ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) break ;;
  esac
done

cd "$(dirname "$0")/.."
scripts/setup.sh "${setup[@]}"
if [ "$preset" = asan ]; then
  export LSAN_OPTIONS="suppressions=$PWD/tests/leaks.txt:print_suppressions=0:${LSAN_OPTIONS:-}"
fi
if [ "$preset" = tsan ]; then
  export TSAN_OPTIONS="suppressions=$PWD/tests/races.txt:ignore_noninstrumented_modules=1:history_size=4:${TSAN_OPTIONS:-}"
  [ $# -gt 0 ] || set -- -L unit
fi
# Test `benchmarks` runs the smallest of them; what sanitizers slow down is not measured.
benchmarks=ON
case "$preset" in asan | tsan) benchmarks=OFF ;; esac
scripts/build.sh "$preset" -DDEEPSLAM_TESTS=ON -DDEEPSLAM_BENCHMARKS="$benchmarks"
scripts/furniture.sh "build/$preset/tools/deepslam"

exec ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)" "$@"
