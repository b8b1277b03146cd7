#!/usr/bin/env bash
# From nothing to a scene: installs, builds, renders a sample capture of a small room and reconstructs it.
#   scripts/demo.sh [--downloads DIR]      result: out/demo
set -euo pipefail
if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then sed -n '2,3s/^# \{0,1\}//p' "$0"; exit 0; fi
downloads=()
if [ $# -gt 0 ]; then
  [ $# -eq 2 ] && [ "$1" = --downloads ] || { echo "demo: known: --downloads DIR" >&2; exit 2; }
  downloads=(--downloads "$(realpath -m "$2")")
fi
cd "$(dirname "$0")/.."

scripts/setup.sh "${downloads[@]}"
scripts/build.sh release -DDEEPSLAM_TESTS=OFF
scripts/sample.sh "${downloads[@]}" --program build/release/tools/deepslam out/demo
