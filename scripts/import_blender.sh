#!/usr/bin/env bash
# Opens a GLB in Blender without a window and prints its objects with their labels as JSON.
#   scripts/import_blender.sh SCENE.glb
# Needs `blender` (apt). Debian bookworm's Blender 3.4 comes without a Draco decoder: give it scene.uncompressed.glb, or
# take Blender from its own site, which reads both.
set -euo pipefail
if [[ $# -ne 1 ]]; then
  echo "usage: $0 SCENE.glb" >&2
  exit 2
fi
blender="${BLENDER:-$(command -v blender || true)}"
if [[ -z "$blender" ]]; then
  echo "no Blender found: apt install blender, or set BLENDER=PATH" >&2
  exit 1
fi
script="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/import_blender.py"
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
if ! "$blender" --background --python-exit-code 1 --python "$script" -- "$1" >"$log" 2>&1; then
  tail -n 5 "$log" >&2
  exit 1
fi
sed -n 's/^SCENE //p' "$log"
