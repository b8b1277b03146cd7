#!/usr/bin/env bash
# From nothing to a scene: installs, builds, renders a sample capture of a small room and reconstructs it.
#   scripts/demo.sh [--downloads DIR]      result: out/demo
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh "$@"
scripts/build.sh release -DDEEPSLAM_TESTS=OFF
deepslam=build/release/tools/deepslam
scripts/furniture.sh "$deepslam"

scene=configs/scenes/demo_room.yaml
if [ ! out/demo_capture/capture.yaml -nt "$scene" ]; then
  rm -rf out/demo_capture
  "$deepslam" synth "$scene" -o out/demo_capture
fi
"$deepslam" run out/demo_capture -o out/demo --progress auto

echo
echo "scene   $PWD/out/demo/export/scene.glb"
echo "report  $PWD/out/demo/report/index.html"
