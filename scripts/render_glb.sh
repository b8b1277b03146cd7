#!/usr/bin/env bash
# Draws a GLB by three.js in headless Chromium, Draco decoded: what a browser user will see.
#   scripts/render_glb.sh IN.glb OUT.png [YAW_DEG PITCH_DEG]      default 35 30; yaw about the vertical, pitch downwards
# Prints the nodes found, with their extras, as JSON. Packages come once from npm into ${XDG_CACHE_HOME:-~/.cache}/deepslam/node;
# Chromium from apt (`chromium`) or by CHROMIUM=PATH. DEEPSLAM_HIDE=room,trajectory leaves nodes out of the picture.
set -euo pipefail
if [[ $# -ne 2 && $# -ne 4 ]]; then
  echo "usage: $0 IN.glb OUT.png [YAW_DEG PITCH_DEG]" >&2
  exit 2
fi
three=0.187.0
playwright=1.65.1
cache="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/node/render-$three-$playwright"
if [[ ! -f "$cache/node_modules/three/package.json" || ! -f "$cache/node_modules/playwright-core/package.json" ]]; then
  mkdir -p "$cache"
  npm install --no-save --no-audit --no-fund --loglevel=error --prefix "$cache" "three@$three" "playwright-core@$playwright" >&2
fi
browser="${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}"
if [[ -z "$browser" ]]; then
  echo "no Chromium found: apt install chromium, or set CHROMIUM=PATH" >&2
  exit 1
fi
script="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/render_glb.cjs"
DEEPSLAM_NODE_MODULES="$cache/node_modules" DEEPSLAM_BROWSER="$browser" exec node "$script" "$@"
