#!/usr/bin/env bash
# Runs the Khronos glTF validator over GLB files: one JSON line per file with its findings; exit 1 on any error.
#   scripts/validate_gltf.sh FILE.glb...
# The validator cannot look into Draco: give it the uncompressed copy as well. Installed once from npm into
# ${XDG_CACHE_HOME:-~/.cache}/deepslam/node; DEEPSLAM_DOWNLOADS may name a folder with gltf-validator-2.0.0-dev.3.10.tgz.
set -euo pipefail
if [[ $# -eq 0 ]]; then
  echo "usage: $0 FILE.glb..." >&2
  exit 2
fi
version=2.0.0-dev.3.10
cache="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/node/gltf-validator-$version"
if [[ ! -f "$cache/node_modules/gltf-validator/package.json" ]]; then
  package="gltf-validator@$version"
  local_copy="${DEEPSLAM_DOWNLOADS:-}/gltf-validator-$version.tgz"
  [[ -f "$local_copy" ]] && package="$local_copy"
  mkdir -p "$cache"
  npm install --no-save --no-audit --no-fund --loglevel=error --prefix "$cache" "$package" >&2
fi
NODE_PATH="$cache/node_modules" node -e '
const fs = require("fs");
const validator = require("gltf-validator");
(async () => {
  let failed = false;
  for (const file of process.argv.slice(1)) {
    let line = {file};
    try {
      const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {maxIssues: 100});
      const issues = report.issues;
      line = {file, errors: issues.numErrors, warnings: issues.numWarnings, infos: issues.numInfos, hints: issues.numHints,
              messages: issues.messages, info: report.info};
      failed ||= issues.numErrors > 0;
    } catch (e) {
      line = {file, errors: 1, warnings: 0, messages: [{message: String(e)}]};
      failed = true;
    }
    console.log(JSON.stringify(line));
  }
  process.exit(failed ? 1 : 0);
})();
' -- "$@"
