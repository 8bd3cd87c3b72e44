#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# debian_package.sh BUILD WORK: the Debian package holds programs, library, manual pages and completion, and says what
# it needs.
set -eu
build=$1
work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$build"
cpack -G DEB -B "$work" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
package=$(ls "$work"/*.deb)
dpkg-deb -c "$package" >"$work/files"
for file in usr/bin/spheretree usr/bin/haptic-player usr/share/man/man1/spheretree.1 usr/share/man/man1/haptic-player.1 \
  usr/share/bash-completion/completions/spheretree usr/share/fish/vendor_completions.d/haptic-player.fish libspheretree_runtime.so \
  spheretree/runtime/runtime.h LICENSE-APACHE-2.0; do
  grep -q "$file" "$work/files" || { echo "FAILED: the package lacks $file" >&2; exit 1; }
done
dpkg-deb -f "$package" Depends | grep -q libtbb || { echo "FAILED: the package does not say that it needs oneTBB" >&2; exit 1; }
if grep -qE '/(voronoi_oracle|make_samples|.*_test)$' "$work/files"; then echo "FAILED: the package holds what is for tests" >&2; exit 1; fi
dpkg-deb -x "$package" "$work/root"
"$work/root/usr/bin/spheretree" --version | grep -q "^spheretree " || { echo "FAILED: the packaged program does not run" >&2; exit 1; }
