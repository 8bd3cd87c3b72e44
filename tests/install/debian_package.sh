#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# debian_package.sh BUILD WORK: the Debian packages hold programs, library, manual pages and completion, and the Python
# package, and say what they need.
set -eu
build=$1
work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$build"
cpack -G DEB -B "$work" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
package=$(ls "$work"/spheretree_*.deb)
dpkg-deb -c "$package" >"$work/files"
for file in usr/bin/spheretree usr/bin/haptic-player usr/share/man/man1/spheretree.1 usr/share/man/man1/haptic-player.1 \
  usr/share/bash-completion/completions/spheretree usr/share/fish/vendor_completions.d/haptic-player.fish libspheretree_runtime.so \
  libspheretree_scene.so libspheretree_servo.so spheretree-runtime.pc spheretree-scene.pc spheretree-servo.pc \
  spheretree/runtime/runtime.h spheretree/servo/servo.h LICENSE-APACHE-2.0; do
  grep -q "$file" "$work/files" || { echo "FAILED: the package lacks $file" >&2; exit 1; }
done
if grep -q spheretree-tetrahedra "$work/files" && ! grep -q LICENSE-AGPL-3.0 "$work/files"; then
  echo "FAILED: the package holds spheretree-tetrahedra without its licence" >&2
  exit 1
fi
dpkg-deb -f "$package" Depends | grep -q libtbb || { echo "FAILED: the package does not say that it needs oneTBB" >&2; exit 1; }
if grep -qE '/(voronoi_oracle|make_samples|.*_test)$' "$work/files"; then echo "FAILED: the package holds what is for tests" >&2; exit 1; fi
dpkg-deb -x "$package" "$work/root"
"$work/root/usr/bin/spheretree" --version | grep -q "^spheretree " || { echo "FAILED: the packaged program does not run" >&2; exit 1; }

python=$(ls "$work"/python3-spheretree_*.deb 2>/dev/null) || exit 0  # built without Python
dpkg-deb -f "$python" Depends | grep -q python3-numpy || { echo "FAILED: the Python package does not say that it needs numpy" >&2; exit 1; }
dpkg-deb -f "$python" Depends | grep -q libtbb || { echo "FAILED: the Python package does not say that it needs oneTBB" >&2; exit 1; }
for licence in LICENSE-APACHE-2.0 LICENSE-GPL-3.0; do
  dpkg-deb -c "$python" | grep -q "doc/python3-spheretree/$licence" || { echo "FAILED: the Python package lacks $licence" >&2; exit 1; }
done
dpkg-deb -x "$python" "$work/python_root"
grep -q dist-packages "$work/files" && { echo "FAILED: the package of the programs holds the one of Python" >&2; exit 1; }
cd "$work"
PYTHONPATH="$work/python_root/usr/lib/python3/dist-packages" /usr/bin/python3 -c '
import numpy, spheretree
corners = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
mesh = spheretree.Mesh(corners, numpy.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
tree = spheretree.build(mesh, levels=2, quality="quick")
assert spheretree.evaluate(mesh, tree).levels[-1].coverage.uncovered_fraction == 0' ||
  { echo "FAILED: the packaged Python package does not build a tree" >&2; exit 1; }
