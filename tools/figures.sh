#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/figures.sh [BUILD]: every figure of the documents anew, on this machine: tables, pictures, the table of stability
# scenarios, the effects of constants. Takes about a day; what takes least comes first. BUILD: default build/release.
# Goes on after a step that fails. At the end it lists what failed and, by git, which documents differ; exit code 1 if
# a step failed. Times are those of this machine, so let it do nothing else.
set -u
cd "$(dirname "$0")/.."
build=${1:-build/release}
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

steps=(pictures tables stability constants)
failed=()
for number in "${!steps[@]}"; do
  name=${steps[number]}
  printf '\n==== %d of %d, %s (%s)\n' $((number + 1)) ${#steps[@]} "$name" "$(date +%H:%M:%S)"
  "$name" || failed+=("$name")
done

printf '\n==== documents that differ (git diff)\n'
git --no-pager diff --stat -- README.md docs
[[ ${#failed[@]} -eq 0 ]] || { echo "tools/figures.sh: failed, at least in part: ${failed[*]}" >&2; exit 1; }
