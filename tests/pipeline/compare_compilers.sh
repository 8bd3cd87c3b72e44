#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# compare_compilers.sh BUILD_A BUILD_B: two build folders, of different compilers, make the same sample meshes, trees
# and pictures byte for byte, the second on one thread.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

make_all() {  # BUILD FOLDER THREADS
  "$1/samples/make_samples/make_samples" "$2"
  for mesh in molar probe; do
    for builder in cover merge expand; do
      "$1/tools/spheretree/spheretree" build "$2/$mesh.obj" -o "$2/$mesh.$builder.stree" --builder $builder --quality quick \
        --threads "$3" -q >/dev/null
    done
    "$1/tools/spheretree/spheretree" convert "$2/$mesh.cover.stree" "$2/$mesh.png" --mesh "$2/$mesh.obj" --width 300
  done
}
make_all "$1" "$work/a" 0
make_all "$2" "$work/b" 1

count=0
for file in "$work"/a/*; do
  cmp "$file" "$work/b/${file##*/}"
  count=$((count + 1))
done
[[ $count -eq 10 ]] || { echo "only $count files were compared" >&2; exit 1; }
echo "$count files alike"
