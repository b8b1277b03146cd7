#!/usr/bin/env bash
# Trains the networks of one class for some minutes by the clock on one large GPU, on a machine that has neither the catalogues nor
# our programs nor a network: first packed here, then run there, on a copy of the working tree with out/gpu in it.
#   scripts/train/gpu.sh pack CLASS [--meshes FOLDER] [--limit-mib N]       writes out/gpu/CLASS.tar.xz
#   scripts/train/gpu.sh CLASS [--minutes M] [--out FOLDER] [--seed N] [--start-from FOLDER] [--credit TEXT] [--cpu]
#   scripts/train/gpu.sh CLASS --score [--out FOLDER]                       networks and scores of what was trained, without a GPU
# Run again it goes on from the last checkpoint in --out (out/gpu/CLASS); --minutes counts all runs together. results.tar there has
# weights and curves as soon as training ends, and networks, card, scores and curves once those are made, for which it takes
# --score-minutes; no file is larger than 16 MiB. --cpu tries everything without a GPU.
# Environment: DEEPSLAM_PROGRAM (the built program, to pack), DEEPSLAM_TRAIN (folder of views), PYTHON (one with PyTorch).
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
case "${1:-}" in
  -h|--help|"") sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0"; exit 0 ;;
esac
python="${PYTHON:-python3}"
known() {
  [ -f "$here/classes/$1.yaml" ] || { echo "no such class: $1 ($here/classes/$1.yaml is missing)" >&2; exit 2; }
}
if [ "$1" = pack ]; then
  class="${2:?class, as in scripts/train/classes}"
  known "$class"
  shift 2
  exec "$python" "$here/gpu_kit.py" pack "$class" --program "${DEEPSLAM_PROGRAM:-$root/build/release/tools/deepslam}" \
    --out "$root/out/gpu/$class.tar.xz" "$@"
fi
class="$1"
known "$class"
shift
work="${DEEPSLAM_TRAIN:-${TMPDIR:-/tmp}/deepslam-train}/$class"
out="$root/out/gpu/$class"
cpu=()
without_gpu=()
rest=()
while [ $# -gt 0 ]; do
  case "$1" in
    --out) out="$2"; shift 2 ;;
    --cpu) cpu=(--cpu); without_gpu=(--cpu); shift ;;
    --score) rest+=("$1"); without_gpu=(--cpu); shift ;;
    --no-scores) rest+=("$1"); shift ;;
    --minutes|--score-minutes|--seed|--start-from|--credit|--threads|--save-every) rest+=("$1" "$2"); shift 2 ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
done
"$python" "$here/gpu_kit.py" check "${without_gpu[@]}"
mkdir -p "$work"
archive="$root/out/gpu/$class.tar.xz"
[ "$work/kit" -nt "$archive" ] || "$python" "$here/gpu_kit.py" unpack "$archive" --class "$class" --out "$work/kit"
exec "$python" "$here/gpu_train.py" "$here/classes/$class.yaml" --kit "$work/kit" --work "$work" --out "$out" "${cpu[@]}" "${rest[@]}"
