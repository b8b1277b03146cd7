#!/usr/bin/env bash
# Opens a GLB or a USD scene in Blender without a window and prints its objects with their labels as JSON.
#   scripts/import_blender.sh SCENE.glb|SCENE.usdz|SCENE.usda [OUT.png [YAW_DEG PITCH_DEG]]
#     OUT.png: what it looks like (Cycles, on the processor), from where scripts/render_glb.sh looks
# Needs `blender` (apt), or Python with Blender as a module (`pip install bpy`; BLENDER_PYTHON=PATH says which Python).
# Debian bookworm's Blender 3.4 has neither a Draco decoder nor USD: give it scene.uncompressed.glb; what comes from
# Blender's own site, and the module, read all three. DEEPSLAM_HIDE=room,trajectory leaves objects out of the picture.
set -euo pipefail
if [[ $# -ne 1 && $# -ne 2 && $# -ne 4 ]]; then
  echo "usage: $0 SCENE.glb|SCENE.usdz|SCENE.usda [OUT.png [YAW_DEG PITCH_DEG]]" >&2
  exit 2
fi
script="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/import_blender.py"
blender="${BLENDER:-$(command -v blender || true)}"
python="${BLENDER_PYTHON:-python3}"
if [[ -z "${BLENDER_PYTHON:-}" && -n "$blender" ]]; then
  command=("$blender" --background --python-exit-code 1 --python "$script")
elif "$python" -c "import bpy" 2>/dev/null; then
  command=("$python" "$script")
else
  echo "no Blender found: apt install blender, or set BLENDER=PATH; or pip install bpy, and set BLENDER_PYTHON=PATH" >&2
  exit 1
fi
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
if ! "${command[@]}" -- "$@" >"$log" 2>&1; then
  tail -n 5 "$log" >&2
  exit 1
fi
sed -n 's/^SCENE //p' "$log"
