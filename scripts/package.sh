#!/usr/bin/env bash
# Makes the Debian packages deepslam and deepslam-dev for bookworm.
#   scripts/package.sh [FOLDER]        FOLDER: where they go; default: out/packages
# Needs what scripts/setup.sh installs. scripts/test_package.sh tries them on a bare system.
set -euo pipefail
if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 0; fi
folder="$(realpath -m "${1:-$(dirname "$0")/../out/packages}")"
cd "$(dirname "$0")/.."

scripts/build.sh release
mkdir -p "$folder"
log="$folder/.cpack.log"
cpack --config build/release/CPackConfig.cmake -G DEB -B "$folder" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf "$folder/_CPack_Packages" "$log"
ls -l "$folder"/*.deb
