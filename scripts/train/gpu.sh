#!/usr/bin/env bash
# Trains the networks of one class for some minutes by the clock on one large GPU, on a machine that has neither the catalogues nor
# our programs nor a network: first packed here, then run there, on a copy of the working tree with out/gpu in it.
#   scripts/train/gpu.sh pack CLASS [--meshes FOLDER] [--limit-mib N]       writes out/gpu/CLASS.tar.xz
#   scripts/train/gpu.sh CLASS [--minutes M] [--out FOLDER] [--seed N] [--start-from FOLDER] [--credit TEXT] [--cpu]
# Run again it goes on from the last checkpoint in --out (out/gpu/CLASS); --minutes counts all runs together. results.tar there has
# networks, card, scores and curves; no file is larger than 16 MiB. --cpu tries everything without a GPU.
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
rest=()
while [ $# -gt 0 ]; do
  case "$1" in
    --out) out="$2"; shift 2 ;;
    --cpu) cpu=(--cpu); shift ;;
    --no-scores) rest+=("$1"); shift ;;
    --minutes|--seed|--start-from|--credit|--threads|--save-every) rest+=("$1" "$2"); shift 2 ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
done
"$python" "$here/gpu_kit.py" check "${cpu[@]}"
mkdir -p "$work"
archive="$root/out/gpu/$class.tar.xz"
[ "$work/kit" -nt "$archive" ] || "$python" "$here/gpu_kit.py" unpack "$archive" --class "$class" --out "$work/kit"
exec "$python" "$here/gpu_train.py" "$here/classes/$class.yaml" --kit "$work/kit" --work "$work" --out "$out" "${cpu[@]}" "${rest[@]}"
