#!/usr/bin/env bash
# From nothing to the networks of one class: data, training, scores, ONNX files and model card. Run again after a stop: what
# is there is kept, training goes on where it was.
#   scripts/train/train.sh CLASS [--minutes M] [--steps N] [--rate R] [--device cpu|cuda] [--threads N] [--meshes FOLDER --credit TEXT] [--start-from FOLDER|weights.pt]
# Environment: DEEPSLAM_PROGRAM (the built program), DEEPSLAM_TRAIN (folder of data and checkpoints), PYTHON.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
case "${1:-}" in
  -h|--help) sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0"; exit 0 ;;
esac
class="${1:?class, as in scripts/train/classes}"
shift
config="$here/classes/$class.yaml"
[ -f "$config" ] || { echo "no such class: $class ($config is missing)" >&2; exit 2; }
program="${DEEPSLAM_PROGRAM:-$root/build/release/tools/deepslam}"
work="${DEEPSLAM_TRAIN:-$root/out/train}/$class"
python="${PYTHON:-}"
meshes=()
credits=()
training=()
while [ $# -gt 0 ]; do
  case "$1" in
    --credit) credits+=(--credit "$2"); shift 2 ;;
    --meshes) meshes+=(--meshes "$2"); shift 2 ;;
    --minutes|--device|--threads|--steps|--rate|--start-from) training+=("$1" "$2"); shift 2 ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
done
if [ -z "$python" ]; then
  python="$work/../venv/bin/python"
  if [ ! -x "$python" ]; then
    python3 -m venv "$work/../venv"
    "$python" -m pip install -q -r "$here/requirements.txt"
  fi
fi
field() { sed -n "s/^$1: *\([^ #]*\).*/\1/p" "$config"; }
cd "$root"
mkdir -p "$work"
[ -d "$work/views" ] || "$program" priors render --class "$class" --designs "$(field designs)" --views "$(field views)" \
  --product-views "$(field product_views)" --variants "$(field variants)" --widened "$(field widened)" \
  --narrowed "$(field narrowed)" --tops "$(field tops)" --seed "$(field seed)" \
  "${meshes[@]}" -o "$work/views"
[ -d "$work/test" ] || "$program" priors render --class "$class" --withheld --product-views "$(field test_views)" \
  --seed "$(field seed)" -o "$work/test"
"$python" "$here/train.py" "$config" --data "$work/views" --out "$work/run" "${training[@]}"
"$python" "$here/mirror.py" --config "$config" --weights "$work/run/weights.pt" --data "$work/views" --out "$work/run/mirror.pt"
"$python" "$here/scores.py" --config "$config" --weights "$work/run/mirror.pt" --train "$work/views" --test "$work/test" --out "$work/run"
"$python" "$here/export.py" --config "$config" --weights "$work/run/mirror.pt" --scores "$work/run/scores.json" \
  --curve "$work/run/curve.json" --data "$work/views" "${credits[@]}" --out "$root/configs/priors/$class"
