#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/figures.sh [BUILD [STEP...]]: every figure of the documents anew, on this machine. Steps: pictures, tables,
# stability (the table of all scenarios, hours), constants (the effects of half and twice each, longer). Defaults:
# build/release and all steps. Goes on after a step that fails; at the end it lists what failed and, by git, which
# documents differ. Exit code 1 if a step failed. Times are those of this machine, so let it do nothing else.
set -u
cd "$(dirname "$0")/.."
build=${1:-build/release}
steps=("${@:2}")
[[ ${#steps[@]} -gt 0 ]] || steps=(pictures tables stability constants)
for name in "${steps[@]}"; do
  [[ $name =~ ^(pictures|tables|stability|constants)$ ]] || { echo "tools/figures.sh: no step '$name'; there are pictures, tables, stability, constants" >&2; exit 2; }
done
out=build/figures
mkdir -p "$out"

tables() { tools/doc_tables.py "$build" --slow --update; }
pictures() { tools/doc_pictures.sh "$build"; }
stability() {
  # Exit code 5: some figure of the constrained mode is missed, which the table shows.
  "$build/tools/haptic_player/haptic-player" --scenario all --out "$out/stability" --cache "$out/trees"
  [[ $? -eq 0 || $? -eq 5 ]] && tools/stability_table.py "$out/stability/stability.json" docs/stability.md
}
constants() { tools/vary_constants.py --update; }

failed=()
for number in "${!steps[@]}"; do
  name=${steps[number]}
  printf '\n==== %d of %d, %s (%s)\n' $((number + 1)) ${#steps[@]} "$name" "$(date +%H:%M:%S)"
  "$name" || failed+=("$name")
done

printf '\n==== documents that differ (git diff)\n'
git --no-pager diff --stat -- README.md docs
[[ ${#failed[@]} -eq 0 ]] || { echo "tools/figures.sh: failed, at least in part: ${failed[*]}" >&2; exit 1; }
