#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# batch_threads.sh BUILD: `spheretree batch` on one and on several threads makes the same trees; for ThreadSanitizer, on
# small objects.
set -euo pipefail
build=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$build/samples/make_samples/make_samples" "$work" >/dev/null
cat >"$work/scene.json" <<END
{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2},
 "objects": [{"name": "a", "mesh": "probe.obj"}, {"name": "b", "mesh": "molar.obj"}, {"name": "c", "mesh": "probe.obj", "quality": "standard"}],
 "tool": {"name": "probe", "mesh": "probe.obj"}}
END
for threads in 1 4; do
  "$build/tools/spheretree/spheretree" batch "$work/scene.json" -o "$work/$threads" --threads "$threads" --progress none
done
count=0
for tree in "$work"/1/*.stree; do
  cmp "$tree" "$work/4/${tree##*/}"
  count=$((count + 1))
done
[[ $count -ge 3 ]] || { echo "batch_threads: only $count trees were compared" >&2; exit 1; }
echo "batch_threads: $count trees alike"
