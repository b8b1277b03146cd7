#!/usr/bin/env bash
# The sample: fetches what is missing (weights, furniture library), renders a capture of a small room, reconstructs it.
#   deepslam-demo [--downloads DIR] [--program DEEPSLAM] [FOLDER]
#     FOLDER           where the capture (FOLDER_capture) and the workspace (FOLDER) go. Default: deepslam_demo
#     --downloads DIR  see deepslam-fetch-weights --help
#     --program FILE   the deepslam program. Default: the one beside this script, else the one in PATH
set -euo pipefail

self="$(readlink -f "$0")"
scripts="$(dirname "$self")"
configs="$scripts/../configs"
folder=deepslam_demo
program="$scripts/../../../bin/deepslam"
[ -x "$program" ] || program=deepslam
fetch=()
while [ $# -gt 0 ]; do
  case "$1" in
    --downloads | --program)
      [ $# -ge 2 ] || { echo "demo: $1 needs a value" >&2; exit 2; }
      if [ "$1" = --program ]; then program="$2"; else fetch+=(--downloads "$2"); fi
      shift 2
      ;;
    -h | --help) sed -n '2,6s/^# \{0,1\}//p' "$self"; exit 0 ;;
    -*) echo "demo: unknown option '$1'; known: --downloads DIR, --program DEEPSLAM" >&2; exit 2 ;;
    *) folder="$1"; shift ;;
  esac
done

"$scripts/fetch_weights.sh" "${fetch[@]}"
"$scripts/furniture.sh" "$program"
scene="$configs/scenes/demo_room.yaml"
capture="${folder}_capture"
if [ ! "$capture/capture.yaml" -nt "$scene" ]; then
  [ ! -e "$capture/truth/objects.json" ] || rm -rf "$capture"  # rendered, of an older scene
  "$program" synth "$scene" -o "$capture"
fi
"$program" run "$capture" -o "$folder" --progress auto

echo
echo "scene   $(cd "$folder" && pwd)/export/scene.glb"
echo "report  $(cd "$folder" && pwd)/report/index.html"
