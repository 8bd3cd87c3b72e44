#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# tools/vary_constant.sh FILE NAME [BUILD OPTION...]: what half and twice a constant do to the trees of the sample meshes.
# Works in a copy of the checkout (build/vary); prints, for half, once and twice its value, the bound of the overhang of the leaves of
# molar and probe [mm] and the processor time [s] of both builds on one thread. Figures for docs/constants.md
set -euo pipefail
[[ $# -ge 2 ]] || { sed -n '3,5s/^# //p' "$0" >&2; exit 2; }
file=$1 name=$2
shift 2
cd "$(dirname "$0")/.."
root=$PWD copy=$PWD/build/vary
grep -qE "constexpr[^;=]*\b$name\b" "$file" || { echo "vary_constant: $file defines no constant $name" >&2; exit 2; }
mkdir -p "$copy/source"
git ls-files -z | xargs -0 cp --parents --update -t "$copy/source"
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake -S "$copy/source" -B "$copy/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSPHERETREE_TESTS=OFF "${launcher[@]}" >/dev/null
trap 'cp "$root/$file" "$copy/source/$file"' EXIT
for factor in 0.5 1 2; do
  # `kName = VALUE` becomes `kName = decltype(VALUE)((VALUE) * FACTOR)`.
  sed -E "s/(constexpr[^;=]*\b$name) = ([^,;]+)/\1 = static_cast<decltype(\2)>((\2) * $factor)/" "$root/$file" >"$copy/source/$file"
  cmake --build "$copy/build" --target spheretree make_samples >"$copy/build.log" || { tail -20 "$copy/build.log" >&2; exit 1; }
  "$copy/build/samples/make_samples/make_samples" "$copy" >/dev/null
  printf '%s x %s:' "$name" "$factor"
  before=$(awk '{print $16}' /proc/$$/stat)
  for mesh in molar probe; do
    "$copy/build/tools/spheretree/spheretree" build "$copy/$mesh.obj" -o "$copy/$mesh.stree" -q --threads 1 --report "$copy/report.json" "$@" >/dev/null
    python3 -c 'import json, sys; print("", sys.argv[2], json.load(open(sys.argv[1]))["levels"][-1]["overhang_bound_mm"], end=";")' "$copy/report.json" "$mesh"
  done
  after=$(awk '{print $16}' /proc/$$/stat)
  python3 -c "import os, sys; print(f' {($after - $before) / os.sysconf(\"SC_CLK_TCK\"):.2f} s')"
done
