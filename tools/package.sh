#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/package.sh [--no-check]: builds the Debian packages of the tracked files into build/package, checks them with
# lintian, lists what they are made of, and runs every test of debian/tests in a clean Debian that has the packages of
# that test and no other; --no-check leaves this last part out, which needs root and debootstrap.
# With a compiler cache: CMAKE_CXX_COMPILER_LAUNCHER=ccache tools/package.sh
# OUT=FOLDER: another folder than build/package.
# DEBIAN_MIRROR=ADDRESS: where the clean Debian comes from.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${OUT:-build/package}")
source=$out/spheretree
version=$(sed -n 's/^project(spheretree VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export CCACHE_DIR=${CCACHE_DIR:-$(ccache --get-config cache_dir 2>/dev/null || true)}  # debhelper gives the build another home

# The tracked files, and the two files of debian/ that are made: the version stands in CMakeLists.txt alone, and the
# licences in the files.
export_to() {
  git ls-files -z | tar --create --null --files-from - | tar --extract --directory "$1"
  python3 tools/licences.py debian >"$1/debian/copyright"
  cat >"$1/debian/changelog" <<END
spheretree ($version) unstable; urgency=medium

  * Release $version. CHANGELOG.md lists what changed.

 -- $(sed -n 's/^Maintainer: //p' debian/control)  $(date --utc --rfc-email --date "@$SOURCE_DATE_EPOCH")
END
}

rm -rf "$source"  # also what was compiled: of a file that was edited meanwhile, it would be taken as up to date
mkdir -p "$source"
export_to "$source"
rm -f "$out"/*.deb "$out"/*.buildinfo "$out"/*.changes
(cd "$source" && dpkg-buildpackage --build=binary --no-sign --no-pre-clean)
lintian --allow-root --fail-on error,warning --display-info --tag-display-limit 0 "$out"/*.changes
python3 tools/licences.py spdx "$source"/obj-* >"$out/spheretree-$version.spdx.json"
[[ "${1:-}" != --no-check ]] || exit 0

if [[ $EUID -ne 0 ]] || ! command -v debootstrap autopkgtest >/dev/null; then
  echo "tools/package.sh: the packages are made, in $out. To try them in a clean Debian, run this as root, with the packages" \
    "debootstrap and autopkgtest." >&2
  exit 1
fi
clean=$out/debian-12
if [[ ! -e $clean/complete ]]; then
  rm -rf "$clean"
  debootstrap --variant=minbase bookworm "$clean" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" >"$out/debootstrap.log"
  touch "$clean/complete"
fi
unset CMAKE_CXX_COMPILER_LAUNCHER  # the clean Debian has no compiler cache
for test in $(sed -n 's/^Tests: //p' debian/tests/control); do
  place=$out/test
  rm -rf "$place"
  mkdir -p "$place"/{upper,work,root,source}
  export_to "$place/source"
  # In a name space of its own, so that nothing stays mounted.
  unshare --mount bash -euc 'mount -t overlay overlay -o "lowerdir=$1,upperdir=$2/upper,workdir=$2/work" "$2/root"
    autopkgtest --quiet --test-name "$3" "$4"/*.deb "$2/source/" -- chroot "$2/root"' _ "$clean" "$place" "$test" "$out" ||
    { echo "tools/package.sh: the test $test of debian/tests failed" >&2; exit 1; }
  rm -rf "$place"
done
echo "$out: every package is right"
