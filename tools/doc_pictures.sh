#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# tools/doc_pictures.sh BUILD [NAME...]: the pictures of docs/images, anew, by the programs of BUILD; all of them, or
# those named. Goes on after one that fails. device.svg is a drawing, which no program makes.
set -u
build=$(realpath "$1"); shift
root=$(realpath "$(dirname "$0")/..")
images=$root/docs/images
spheretree=$build/tools/spheretree/spheretree player=$build/tools/haptic_player/haptic-player make_samples=$build/samples/make_samples/make_samples
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# once FILE COMMAND...: makes a file that several pictures need.
once() { local file=$1; shift; [[ -e $file ]] || "$@" >made.txt; }
samples() { once molar.obj "$make_samples" .; }
mouth() { once mouth "$make_samples" --mouth mouth && once trees "$spheretree" batch mouth/mouth.scene.json -o trees -q; }
levels() { samples && "$spheretree" build "$1.obj" -o tree.stree -q >made.txt && "$spheretree" convert tree.stree "$images/$1.png" --mesh "$1.obj" --width 1200 -q; }

draw_molar() { levels molar; }
draw_probe() { levels probe; }
draw_reduce() {
  samples || return
  local method
  for method in burst expand grid hubbard merge octree spawn; do
    "$spheretree" build molar.obj -o tree.stree --builder $method -q >made.txt &&
      "$spheretree" convert tree.stree "$images/reduce_$method.png" --width 800 -q || return
  done
}
draw_mouth() { mouth && "$spheretree" view trees/scene.json --show spheres --from 0.5,-1,0.35 --size 900x680 --theme light --panels off --picture "$images/mouth.png" -q; }
draw_view() {
  mouth && "$player" trees/scene.json --trajectory mouth/inspection.csv --clock stepped --seconds 7 --record inspection_run.csv -q >made.txt &&
    "$player" trees/scene.json --replay inspection_run.csv --picture "$images/view.png" --at 5250 --follow --within 14 -q
}
draw_tissue() {
  mouth && once soft_trees "$spheretree" batch mouth/soft.scene.json -o soft_trees -q &&
    "$player" soft_trees/scene.json --trajectory mouth/press.csv --clock stepped --record run.csv -q >made.txt &&
    "$player" soft_trees/scene.json --replay run.csv --picture "$images/tissue.png" --at 1500 --size 900x560 -q
}
draw_cavity() {
  once cavity "$make_samples" --cavity cavity && once cavity_trees "$spheretree" batch cavity/cavity.scene.json -o cavity_trees -q &&
    "$player" cavity_trees/scene.json --trajectory cavity/drill.csv --clock stepped --record drilled.csv -q >made.txt &&
    "$player" --replay drilled.csv --picture "$images/cavity.png" --at 40700 --from 0.2,-1.2,2 --within 2.6 --size 900x560 --theme light -q
}
draw_mouth_run() { mouth && "$root/tools/animation.sh" trees/scene.json mouth/inspection.csv "$images/mouth_run.gif"; }
draw_comparison() { samples && "$spheretree" compare molar.obj probe.obj -o comparison --qualities quick,standard -q && cp comparison/comparison.svg "$images"; }
draw_robots() { /usr/bin/python3 "$root/benchmarks/robot_spheres.py" "$build" "$images/robots.svg" >made.txt; }

[[ $# -gt 0 ]] || set -- molar probe reduce mouth view tissue cavity mouth_run comparison robots
failed=()
for name in "$@"; do
  echo "doc_pictures: $name"
  "draw_$name" || failed+=("$name")
done
[[ ${#failed[@]} -eq 0 ]] || { echo "doc_pictures: could not be drawn: ${failed[*]}" >&2; exit 1; }
