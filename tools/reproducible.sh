#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/reproducible.sh [FOLDER]: builds the Debian packages in two folders of different length and compares them
# byte for byte; with FOLDER, where tools/package.sh left those of this commit, only in the second one. A compiler
# cache gives no object of one folder to the other, since the paths are part of what it looks up; it lets a run that
# was ended go on. OUT=FOLDER: another folder than build/reproducible. Names what differs, and in which file of a
# package, if `diffoscope` is installed.
set -euo pipefail
caller=$PWD
cd "$(dirname "$0")/.."
out=$(realpath -m "${OUT:-build/reproducible}")
one=$out/one two=$out/another/and/longer
export CCACHE_BASEDIR=  # which would take the paths out
if [[ -n ${1:-} ]]; then
  one=$(cd "$caller" && realpath "$1")
else
  OUT=$one tools/package.sh --no-check
fi
OUT=$two tools/package.sh --no-check
failed=0
for package in "$one"/*.deb "$one"/*.spdx.json; do
  other=$two/${package##*/}
  if cmp --silent "$package" "$other"; then
    echo "same bytes: $(sha256sum "$package" | cut -c1-16) ${package##*/}"
  else
    echo "differs: ${package##*/}"
    failed=1
    if command -v diffoscope >/dev/null; then diffoscope --max-report-size 4000 "$package" "$other" || true; fi
  fi
done
exit $failed
