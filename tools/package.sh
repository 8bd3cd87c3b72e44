#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/package.sh [--no-check]: builds the Debian packages of the tracked files into build/package, checks them with
# lintian, installs them into a clean root beside the packages that they need, and runs there what
# tests/install/from_packages.sh runs.
# With a compiler cache: CMAKE_CXX_COMPILER_LAUNCHER=ccache tools/package.sh
# OUT=FOLDER: another folder than build/package. What was compiled before is kept there.
set -euo pipefail
cd "$(dirname "$0")/.."
checkout=$PWD
out=$(realpath -m "${OUT:-build/package}")
source=$out/spheretree
version=$(sed -n 's/^project(spheretree VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}

# The sources, without what a checkout has beside them. Times are kept, so that only what changed is compiled again.
mkdir -p "$source"
find "$source" -mindepth 1 -maxdepth 1 ! -name 'obj-*' -exec rm -rf {} +
git ls-files -z | tar --create --null --files-from - | tar --extract --directory "$source"
python3 tools/licences.py debian >"$source/debian/copyright"
cat >"$source/debian/changelog" <<END
spheretree ($version) unstable; urgency=medium

  * Release $version. CHANGELOG.md lists what changed.

 -- $(sed -n 's/^Maintainer: //p' debian/control)  $(date --utc --rfc-email --date "@$SOURCE_DATE_EPOCH")
END

rm -f "$out"/*.deb "$out"/*.buildinfo "$out"/*.changes
(cd "$source" && dpkg-buildpackage --build=binary --no-sign --no-pre-clean)
lintian --fail-on error,warning --info --display-info --tag-display-limit 0 "$out"/*.changes
python3 "$source/tools/licences.py" spdx "$source"/obj-* >"$out/spheretree-$version.spdx.json"
ls -l "$out"/*.deb "$out"/*.spdx.json
[[ "${1:-}" != --no-check ]] || exit 0

# A clean Debian 12, made once; every test of debian/tests installs into a copy of it only what it says that it needs.
if [[ $EUID -ne 0 ]] || ! command -v debootstrap autopkgtest >/dev/null; then
  echo "tools/package.sh: the packages are made, but to try them in a clean Debian this has to run as root, with the packages debootstrap" \
    "and autopkgtest." >&2
  exit 1
fi
clean=$out/debian-12
if [[ ! -e $clean/complete ]]; then
  rm -rf "$clean"
  debootstrap --variant=minbase bookworm "$clean" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" >"$out/debootstrap.log"
  touch "$clean/complete"
fi
for test in $(sed -n 's/^Tests: //p' debian/tests/control); do
  place=$out/test/$test
  rm -rf "$place"
  mkdir -p "$place"/{upper,work,root}
  # In a name space of its own, so that nothing stays mounted.
  unshare --mount bash -euc 'mount -t overlay overlay -o "lowerdir=$1,upperdir=$2/upper,workdir=$2/work" "$2/root"
    autopkgtest --quiet --no-built-binaries --test-name "$3" "$4"/*.deb "$4/spheretree/" -- chroot "$2/root"' \
    _ "$clean" "$place" "$test" "$out" || { echo "tools/package.sh: the test $test of debian/tests failed" >&2; exit 1; }
  rm -rf "$place"
done
echo "$out: every package is right"
