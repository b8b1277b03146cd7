#!/usr/bin/env bash
# Builds the fuzzers (clang, libFuzzer, AddressSanitizer, UndefinedBehaviorSanitizer) and runs them one after another.
#   scripts/fuzz.sh [--executions N] [--seconds S] [--built] [--list] [PARSER ...] [-- libFuzzer's own options]
#     --executions N  per parser; default: 2,000,000 for texts, 200,000 for containers
#     --seconds S     at most so long per parser
#     --built         builds nothing, runs what is there
#     --list          names all parsers, whether each is a text or a container, and its longest input in bytes
# Without PARSER all run. One line per parser: executions, seconds, findings; ends with 1 where something was found.
# What a fuzzer keeps goes to build/fuzz/corpus/PARSER, what it finds to build/fuzz/findings/PARSER: mend the parser and
# copy the case to tests/fuzz/corpus/PARSER/found_WHAT, where every test run replays it.
set -euo pipefail

fail() { echo "fuzz: $*" >&2; exit 2; }
executions=""
seconds=0
build=yes
list=no
parsers=()
while [ $# -gt 0 ]; do
  case "$1" in
    --executions | --seconds)
      [[ "${2:-}" =~ ^[1-9][0-9]*$ ]] || fail "$1 needs a number"
      if [ "$1" = --executions ]; then executions="$2"; else seconds="$2"; fi
      shift
      ;;
    --built) build=no ;;
    --list) list=yes ;;
    -h | --help) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 0 ;;
    --) shift; break ;;
    -*) fail "unknown option '$1'; known: --executions N, --seconds S, --built, --list" ;;
    *) parsers+=("$1") ;;
  esac
  shift
done

cd "$(dirname "$0")/.."
if [ "$build" = yes ]; then
  scripts/setup.sh --fuzz
  mkdir -p build/fuzz
fi
if command -v ccache >/dev/null && [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ]; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache
fi
# What was compiled in one checkout serves every other one.
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}"
[ "$build" = no ] || cmake --preset fuzz >build/fuzz/configure.log 2>&1 || { cat build/fuzz/configure.log >&2; exit 1; }
table=build/fuzz/tests/fuzz/parsers.txt
[ -f "$table" ] || fail "nothing is built: leave --built out"
if [ "$list" = yes ]; then
  cat "$table"
  exit 0
fi
[ ${#parsers[@]} -gt 0 ] || mapfile -t parsers < <(cut -d' ' -f1 "$table")
targets=()
for parser in "${parsers[@]}"; do
  grep -q "^$parser " "$table" || fail "no parser '$parser'; --list names them"
  targets+=("deepslam_fuzz_$parser")
done
[ "$build" = no ] || cmake --build build/fuzz -j "${FUZZ_JOBS:-$(nproc)}" --target "${targets[@]}" >&2

any=0
for parser in "${parsers[@]}"; do
  corpus="build/fuzz/corpus/$parser"
  findings="build/fuzz/findings/$parser"
  log="build/fuzz/$parser.log"
  rm -rf "$findings"
  mkdir -p "$corpus" "$findings"
  runs="$executions"
  read -r _ kind longest < <(grep "^$parser " "$table")
  [ "$kind" = text ] || runs="${runs:-200000}"
  options=(-runs="${runs:-2000000}" -max_len="$longest" -max_total_time="$seconds" -timeout=20
    -report_slow_units=20 -reload=0 -detect_leaks=0 -rss_limit_mb=2048 -malloc_limit_mb=256 -print_final_stats=1
    -verbosity=1 -artifact_prefix="$findings/")
  [ ! -f "tests/fuzz/dictionaries/$parser.dict" ] || options+=(-dict="tests/fuzz/dictionaries/$parser.dict")
  # Leaks are looked for once, at the end: a search costs as much as thousands of executions. Freed memory is kept as
  # long as the processor's cache holds it, and where it was taken is one line; ASAN_OPTIONS overrules both.
  leaks=1
  # ONNX Runtime keeps some bytes for itself, and its allocator asks for chunks.
  case "$parser" in onnx | shape_prior) leaks=0 ;; esac
  begin="$SECONDS"
  code=0
  ASAN_OPTIONS="detect_leaks=$leaks:allocator_may_return_null=1:quarantine_size_mb=1:malloc_context_size=1:${ASAN_OPTIONS:-}" \
    UBSAN_OPTIONS="print_stacktrace=1:${UBSAN_OPTIONS:-}" \
    "build/fuzz/tests/fuzz/deepslam_fuzz_$parser" "${options[@]}" "$@" "$corpus" "tests/fuzz/corpus/$parser" >"$log" 2>&1 || code=$?
  done="$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)"
  found="$(find "$findings" -type f | wc -l)"
  [ "$code" -eq 0 ] || [ "$found" -gt 0 ] || found=1
  printf '%-16s %9s executions %6s s   %s findings\n' "$parser" "${done:-?}" "$((SECONDS - begin))" "$found"
  if [ "$found" -gt 0 ]; then
    any=1
    grep -aE "^deepslam: bug|ERROR: |runtime error|SUMMARY" "$log" | head -4 | sed 's/^/  /'
    echo "  $log; $(find "$findings" -type f | head -3 | tr '\n' ' ')"
  fi
done
exit "$any"
