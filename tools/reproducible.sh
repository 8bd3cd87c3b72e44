#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/reproducible.sh: builds the Debian packages in two folders of different length, without a compiler cache, and
# compares them byte for byte. OUT=FOLDER: another folder than build/reproducible. Names what differs, and in which file
# of a package, if `diffoscope` is installed.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${OUT:-build/reproducible}")
for folder in "$out/one" "$out/another/and/longer"; do
  rm -rf "$folder"
  CMAKE_CXX_COMPILER_LAUNCHER='' OUT=$folder tools/package.sh --no-check
done
failed=0
for package in "$out"/one/*.deb "$out"/one/*.spdx.json; do
  other=$out/another/and/longer/${package##*/}
  if cmp --silent "$package" "$other"; then
    echo "same bytes: $(sha256sum "$package" | cut -c1-16) ${package##*/}"
  else
    echo "differs: ${package##*/}"
    failed=1
    if command -v diffoscope >/dev/null; then diffoscope --max-report-size 4000 "$package" "$other" || true; fi
  fi
done
exit $failed
