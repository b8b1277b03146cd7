#!/usr/bin/env bash
# Builds the image of Dockerfile without a registry, on a bare bookworm of debootstrap as its base, and runs the demo's
# capture through it as a plain user. Takes as long as a build, and 8 GB, which it gives back.
#   scripts/test_container.sh [--base DIR] [--ccache DIR] [--downloads DIR] [--workspace DIR]
#     --base DIR       a root that `debootstrap --variant=minbase bookworm DIR` made. Default: one is made for the test
#     --ccache DIR     a cache of ccache that the build may use and fill. Default: none, a build from nothing
#     --downloads DIR  npm archives that hold the weights. Default: ${XDG_CACHE_HOME:-~/.cache}/deepslam/downloads
#     --workspace DIR  where the workspace is left to look at. Default: nowhere
# Needs root, debootstrap, buildah and a network; exit code 77 where one of them is missing. Containers are chroots
# (buildah's --isolation chroot), as machines without namespaces of their own allow no others. Debian's mirror and the
# certificates are those of this machine.
set -euo pipefail

downloads="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/downloads"
given=""
cache=""
workspace=""
while [ $# -gt 0 ]; do
  case "$1" in
    --base | --ccache | --downloads | --workspace)
      [ $# -ge 2 ] || { echo "test_container: $1 needs a folder" >&2; exit 2; }
      case "$1" in
        --base) given="$(realpath "$2")" ;;
        --ccache) cache="$(realpath -m "$2")" ;;
        --downloads) downloads="$2" ;;
        --workspace) workspace="$(realpath -m "$2")" ;;
      esac
      shift 2
      ;;
    -h | --help) sed -n '2,12s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "test_container: unknown option '$1'; known: --base DIR, --ccache DIR, --downloads DIR, --workspace DIR" >&2; exit 2 ;;
  esac
done
cd "$(dirname "$0")/.."

skip() { echo "test_container: skipped: $*" >&2; exit 77; }
say() { echo "test_container: $* ($((SECONDS)) s)" >&2; }
fail() { echo "test_container: $*" >&2; exit 1; }
[ "$(id -u)" -eq 0 ] || skip "needs root for chroot"
for program in debootstrap buildah; do
  command -v "$program" >/dev/null || skip "needs $program (apt-get install $program)"
done
mirror="$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' | head -n 1)"
[ -n "$mirror" ] || skip "this machine's apt has no bookworm archive"

folder="$(mktemp -d)"
chmod 755 "$folder"
images() { command buildah --root "$folder/images" --runroot "$folder/run" --storage-driver overlay "$@"; }
clean_up() {
  images rm -a >/dev/null 2>&1 || true
  images rmi -a -f >/dev/null 2>&1 || true
  # Buildah leaves its store mounted upon itself.
  awk -v folder="$folder/" 'index($2, folder) == 1 {print $2}' /proc/mounts | sort -r | while read -r place; do umount "$place" || true; done
  mount | grep -qF " on $folder/" && { echo "test_container: something is still mounted in $folder; left alone" >&2; return; }
  rm -rf --one-file-system "$folder"
}
trap clean_up EXIT
log="$folder.log"
quietly() { "$@" >>"$log" 2>&1 || { tail -n 40 "$log" >&2; fail "failed: $*; log: $log"; }; }

# The base: as the slim images of Debian, without manuals and translations.
base="$folder/base"
if [ -n "$given" ]; then
  cp -a "$given" "$base"
else
  quietly debootstrap --variant=minbase bookworm "$base" "$mirror"
fi
printf 'path-exclude /usr/share/%s/*\n' man locale info doc >"$base/etc/dpkg/dpkg.cfg.d/slim"
printf 'path-include /usr/share/doc/*/copyright\n' >>"$base/etc/dpkg/dpkg.cfg.d/slim"
find "$base/usr/share/doc" -type f ! -name copyright -delete
rm -rf "$base"/usr/share/{man,locale,info}/* "$base"/var/lib/apt/lists/* "$base"/var/cache/apt/*
cp "${SSL_CERT_FILE:-/etc/ssl/certs/ca-certificates.crt}" "$base/opt/certificates.pem"
container="$(images from scratch)"
images config --env NODE_EXTRA_CA_CERTS=/opt/certificates.pem "$container"
quietly images copy "$container" "$base" /
quietly images commit "$container" localhost/bookworm
quietly images rm "$container"
say "base"

build=(build --isolation chroot --layers --build-arg BASE=localhost/bookworm)
if [ -n "$cache" ]; then
  mkdir -p "$cache"
  build+=(--volume "$cache:/root/.cache/ccache")
fi
quietly images "${build[@]}" --target build -t localhost/deepslam-build .
say "stage build"
quietly images "${build[@]}" -t localhost/deepslam .
say "image"

# What `docker run` would take from the image.
inspect() { images inspect --type image --format "$1" localhost/deepslam; }
[ "$(inspect '{{.OCIv1.Config.User}}')" = deepslam ] || fail "the image's user is not deepslam"
[ "$(inspect '{{.OCIv1.Config.Entrypoint}}')" = "[deepslam]" ] || fail "the image does not start deepslam"
container="$(images from localhost/deepslam)"
in_image() { images run --isolation chroot "$@"; }
[ "$(in_image "$container" -- id -u)" != 0 ] || fail "the image runs as root"
[ -z "$(in_image --user root "$container" -- find / -xdev -name "yolo*")" ] || fail "the image holds the detector's weights"
[ -s "$(images mount "$container")/usr/share/doc/deepslam/copyright" ] || fail "the image has no texts of licences"
images umount "$container" >/dev/null
quietly in_image "$container" -- deepslam --help
# What the image leaves out of Debian's packages is nothing that is linked.
in_image "$container" -- sh -c 'find /usr/bin/deepslam* /usr/lib/deepslam -type f -exec ldd {} +; true' >"$folder/linked" 2>>"$log"
! grep "not found" "$folder/linked" >&2 || fail "the image lacks libraries"
grep -q libavcodec "$folder/linked" || fail "the image cannot read videos"
images images --format '{{.Name}} {{.Size}}' localhost/deepslam

# The demo's capture is rendered where the furniture is, in the stage that built it.
mkdir "$folder/capture" "$folder/workspace" "$folder/data"
builder="$(images from localhost/deepslam-build)"
quietly images run --isolation chroot -v "$folder/capture:/capture" "$builder" -- \
  build/release/tools/deepslam synth configs/scenes/demo_room.yaml -o /capture/demo
quietly images rm "$builder"
scripts/fetch_weights.sh --downloads "$downloads" --data "$folder/data" 2>>"$log" ||
  skip "no npm archives of the weights in $downloads, and npm cannot fetch them"
chown 1234:1234 "$folder/workspace"
say "capture"

run=(in_image --user 1234:1234 -v "$folder/capture/demo:/capture:ro" -v "$folder/workspace:/workspace")
code=0
"${run[@]}" "$container" -- deepslam run /capture -o /workspace >"$folder/told" 2>&1 || code=$?
[ "$code" -eq 3 ] && grep -q "weights" "$folder/told" || { cat "$folder/told" >&2; fail "without weights: exit code $code, not 3"; }
run+=(-v "$folder/data/weights:/data/weights:ro")
"${run[@]}" "$container" -- deepslam run /capture -o /workspace >"$folder/told" 2>&1 ||
  { tail -n 40 "$folder/told" >&2; fail "the run in the container failed"; }
quietly "${run[@]}" "$container" -- deepslam validate /workspace/export/scene.glb
[ "$(stat -c %u "$folder/workspace/export/scene.glb")" = 1234 ] || fail "the workspace's files are not the user's"
[ "$(wc -l <"$folder/workspace/export/objects.csv")" -gt 1 ] || fail "no object was found in the demo's capture"
if [ -n "$workspace" ]; then
  rm -rf "$workspace"
  cp -r "$folder/workspace" "$workspace"
fi
cat "$folder/workspace/export/objects.csv"
rm -f "$log"
say "all well"
