#!/usr/bin/env bash
# Makes the furniture library of the CAD proposals out of Debian's sweethome3d-furniture; nothing when it is up to date.
#   scripts/furniture.sh DEEPSLAM      DEEPSLAM: the program that was built
set -euo pipefail
program="${1:?the deepslam program}"
withheld="$(cd "$(dirname "$0")/.." && pwd)/configs/withheld_models.yaml"
"$program" library build --withheld "$withheld"
