#!/usr/bin/env bash
# Builds what README's first command builds and says what that took; the result is build/release, as ever.
#   scripts/build_time.sh            what is built already stays, and a compiler cache is used where there is one
#   scripts/build_time.sh --cold     in a folder of its own, without either; names the files that took longest
set -euo pipefail
if [ "${1:-}" = -h ] || [ "${1:-}" = --help ]; then sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 0; fi
cd "$(dirname "$0")/.."
TIMEFORMAT='%U %S %R'
if [ "${1:-}" = --cold ]; then
  folder="$(mktemp -d)"
  trap 'rm -rf "$folder"' EXIT
  git ls-files -z | xargs -0 cp --parents -t "$folder"
  cd "$folder"
  export CCACHE_DISABLE=1
fi
hits() { ccache --print-stats 2>/dev/null | awk '/^(direct|preprocessed)_cache_hit/ {n += $2} END {print n + 0}'; }
built() { awk -F'\t' '$4 ~ /\.o$/ {seen[$4] = 1} END {print length(seen)}' build/release/.ninja_log 2>/dev/null || echo 0; }
before="$(hits)"
there="$(built)"
took="$({ time scripts/build.sh release -DDEEPSLAM_TESTS=OFF >&2; } 2> >(tail -n 1))"
read -r user system wall <<<"$took"
awk -v user="$user" -v sys="$system" -v wall="$wall" -v files="$(($(built) - there))" -v hits="$(($(hits) - before))" 'BEGIN {
  printf "build: %.0f s of processor time, %.0f s of wall time; %d files, %d of them from a compiler cache\n", user + sys, wall, files, hits }'
if [ "${1:-}" = --cold ]; then
  echo "longest:"
  awk -F'\t' '$4 ~ /\.o$/ {t[$4] = ($2 - $1) / 1000} END {for (f in t) printf "%7.1f s  %s\n", t[f], f}' build/release/.ninja_log | sort -rn | head -12
fi
