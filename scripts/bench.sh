#!/usr/bin/env bash
# Builds the benchmarks and runs them all: whole runs of a capture against what no run can do without, the hot parts alone,
# and tracking and fusion beside those of Open3D and OpenCV on the same frames.
#   scripts/bench.sh [--capture DIR] [--runs N] [--frames N] [--quick] [--before FILE] [OUT]
#     --capture DIR   default: redkitchen in the folder that DEEPSLAM_TEST_DATA names
#     --runs N        whole runs, of which the medians are told (3)
#     --frames N      first frames of the capture that the libraries are compared on (60)
#     --quick         one repetition of everything: does it run at all?
#     --before FILE   bench.json of an older build, for columns of before and after
#     OUT             folder of the results (out/bench): bench.json and bench.md
# Leave the machine alone meanwhile: times are wall times on two threads.
set -euo pipefail

capture="${DEEPSLAM_TEST_DATA:+$DEEPSLAM_TEST_DATA/data/redkitchen}"
runs=3
frames=60
repetitions=5
peer_repetitions=3
before=
out=out/bench
while [ $# -gt 0 ]; do
  case "$1" in
    --capture | --runs | --frames | --before)
      [ $# -ge 2 ] || { echo "bench: $1 needs a value" >&2; exit 2; }
      case "$1" in
        --capture) capture="$2" ;;
        --runs) runs="$2" ;;
        --frames) frames="$2" ;;
        --before) before="$(realpath "$2")" ;;
      esac
      shift 2
      ;;
    --quick) runs=1; repetitions=1; peer_repetitions=1; shift ;;
    -h | --help) sed -n '2,12s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "bench: unknown option '$1'; known: --capture, --runs, --frames, --quick, --before" >&2; exit 2 ;;
    *) out="$1"; shift ;;
  esac
done
[ -n "$capture" ] || { echo "bench: no capture; name one by --capture, or set DEEPSLAM_TEST_DATA" >&2; exit 2; }
[ -d "$capture" ] || { echo "bench: $capture: no such folder" >&2; exit 2; }
capture="$(realpath "$capture")"
mkdir -p "$out"
out="$(realpath "$out")"
cd "$(dirname "$0")/.."

scripts/build.sh release -DDEEPSLAM_BENCHMARKS=ON
scripts/furniture.sh build/release/tools/deepslam

export DEEPSLAM_BENCH_CAPTURE="$capture" DEEPSLAM_BENCH_FRAMES="$frames"
bench() {  # bench NAME REPETITIONS [options ...]
  local name="$1" times="$2"
  shift 2
  echo "bench: $name" >&2
  "build/release/tests/bench/deepslam_${name}_bench" --benchmark_repetitions="$times" --benchmark_out_format=json \
    --benchmark_out="$out/$name.json" "$@" >"$out/$name.log" 2>&1 || { tail -n 20 "$out/$name.log" >&2; exit 1; }
}
in_turn=--benchmark_enable_random_interleaving=true  # a slower minute of the machine is one of everything that is compared
bench floor "$repetitions" "$in_turn"
more=()
[ -z "$before" ] || more=(--before "$before")
tests/bench/whole_run.py build/release/tools/deepslam "$capture" --runs "$runs" --threads 2 --floor "$out/floor.json" \
  --json "$out/whole_run.json" --page "$out/whole_run.md" "${more[@]}"
bench tracking "$repetitions" "$in_turn"
bench alignment "$peer_repetitions"
bench packing "$peer_repetitions" "$in_turn"
bench peers "$peer_repetitions"
bench graph 1  # minutes each
bench loop "$peer_repetitions"
bench selection "$peer_repetitions"
bench kernels "$peer_repetitions"
bench refine "$peer_repetitions"
bench mesh_export "$peer_repetitions"
bench synth "$peer_repetitions"
tests/bench/collect.py "$out"
echo "bench: $out/bench.json, $out/bench.md" >&2
