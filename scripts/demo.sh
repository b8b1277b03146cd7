#!/usr/bin/env bash
# From nothing to a scene: installs, builds, renders a sample capture of a small room and reconstructs it.
#   scripts/demo.sh [--downloads DIR]      result: out/demo
set -euo pipefail
if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then sed -n '2,3s/^# \{0,1\}//p' "$0"; exit 0; fi
cd "$(dirname "$0")/.."

scripts/setup.sh "$@"
scripts/build.sh release -DDEEPSLAM_TESTS=OFF
scripts/sample.sh "$@" --program build/release/tools/deepslam out/demo
