#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# tools/doc_pictures.sh BUILD: the pictures of trees in docs/images, anew, by the programs of BUILD.
set -eu
spheretree=$(realpath "$1/tools/spheretree/spheretree")
make_samples=$(realpath "$1/samples/make_samples/make_samples")
images=$(realpath "$(dirname "$0")/../docs/images")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$make_samples" .
for mesh in molar probe; do
  "$spheretree" build $mesh.obj -o tree.stree -q >tree.txt
  "$spheretree" convert tree.stree "$images/$mesh.png" --mesh $mesh.obj --width 1200 -q
done
for method in burst expand grid hubbard merge octree spawn; do
  "$spheretree" build molar.obj -o tree.stree --builder $method -q >tree.txt
  "$spheretree" convert tree.stree "$images/reduce_$method.png" --width 800 -q
done
