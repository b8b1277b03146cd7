#!/usr/bin/env bash
# Configures and builds a preset of CMakePresets.json, with ccache where it is installed.
#   scripts/build.sh [PRESET] [cmake options ...]          PRESET: release (default), dev, asan, tsan; result: build/PRESET
set -euo pipefail
if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then sed -n '2,3s/^# \{0,1\}//p' "$0"; exit 0; fi
cd "$(dirname "$0")/.."

preset="${1:-release}"
[ $# -eq 0 ] || shift
if command -v ccache >/dev/null && [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ]; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache
fi
# What was compiled in one checkout serves every other one.
export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}"
# Headers that are compiled once (DEEPSLAM_PCH) are told apart by what is in them.
export CCACHE_SLOPPINESS="${CCACHE_SLOPPINESS:-pch_defines,time_macros}"

# The largest files take 2 GB each to compile, 4 GB with sanitizers: more jobs than memory would not be faster.
gib_per_job=2
case "$preset" in asan | tsan) gib_per_job=4 ;; esac
jobs="$(nproc)"
gib="$(awk '/^MemAvailable:/ {print int($2 / 1048576)}' /proc/meminfo)"
[ "$((gib / gib_per_job))" -ge "$jobs" ] || jobs=$((gib / gib_per_job > 1 ? gib / gib_per_job : 1))

# Quiet unless it fails.
mkdir -p "build/$preset"
log="build/$preset/configure.log"
cmake --preset "$preset" "$@" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
cmake --build "build/$preset" -j "$jobs" >&2
