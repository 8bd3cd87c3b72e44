#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# tools/demo.sh [FOLDER]: builds the programs, makes the sample meshes, builds and evaluates their sphere-trees, and
# draws them; then builds a whole mouth and names the command that opens it.
# FOLDER, default out/demo in the checkout, receives the results.
set -euo pipefail
out=${1:+$(realpath -m "$1")}  # of the caller's folder
cd "$(dirname "$0")/.."
out=${out:-out/demo}

tools/setup.sh --build
echo "== Building the libraries, and a first tree with them (build/release; a few minutes the first time)"
cmake --preset release -DSPHERETREE_TESTS=OFF >/dev/null
cmake --build --preset release --target make_samples 01_build_a_tree
mkdir -p "$out"
build/release/samples/make_samples/make_samples "$out"
build/release/samples/01_build_a_tree/01_build_a_tree "$out/molar.obj" "$out/molar.stree"

echo "== Building the program"
cmake --build --preset release --target spheretree
spheretree=build/release/tools/spheretree/spheretree
for name in molar probe; do
  echo "== $name: checking, building, evaluating, drawing"
  view=1,1.6,0.9
  [[ $name == probe ]] && view=0.2,-2,0.3
  "$spheretree" check "$out/$name.obj"
  "$spheretree" build "$out/$name.obj" -o "$out/$name.stree" --report "$out/$name.report.json"
  "$spheretree" evaluate "$out/$name.obj" "$out/$name.stree"
  "$spheretree" convert "$out/$name.stree" "$out/$name.glb"
  "$spheretree" convert "$out/$name.stree" "$out/$name.png" --mesh "$out/$name.obj" --view $view --width 1200
done
echo
echo "In $out, for molar and probe:"
echo "  .obj  the mesh             .stree        its sphere-tree"
echo "  .png  mesh and levels      .report.json  settings, figures of every level, seconds"
echo "  .glb  every level as a mesh, for a glTF viewer"

echo
echo "== A mouth of 33 objects, and the program that plays it"
cmake --build --preset release --target haptic-player
mouth=$out/mouth
build/release/samples/make_samples/make_samples --mouth "$mouth"
"$spheretree" batch "$mouth/mouth.scene.json" -o "$mouth/trees"
player=build/release/tools/haptic_player/haptic-player
"$player" "$mouth/trees/scene.json" --trajectory "$mouth/inspection.csv" --picture "$mouth/mouth.png" --at 3000 -q >/dev/null ||
  echo "No picture of it: the player was built without its window (libglfw3-dev, libimgui-dev, libegl-dev)."
echo
echo "Touch it, on a desktop: drag moves the probe, the wheel pushes it, ? shows all keys"
echo "  $player $mouth/trees/scene.json --view --trajectory $mouth/inspection.csv"
