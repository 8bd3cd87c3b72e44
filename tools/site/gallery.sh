#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/site/gallery.sh BUILD FOLDER: makes the interactive pages of the gallery: the sample mouth with a run in it, a
# robot, and a comparison; with SOURCE_DATE_EPOCH the robot alone. About a minute with two processors.
set -euo pipefail
build=$1
mkdir -p "$2"
out=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
samples=$build/samples/make_samples/make_samples
spheretree="$build/tools/spheretree/spheretree --quiet"
cd "$work"
"$samples" . >/dev/null
"$samples" --mouth mouth >/dev/null
"$samples" --robots robots >/dev/null

$spheretree robot robots/sample_arm7/sample_arm7.urdf -o arm7 --budget 90 >/dev/null
$spheretree report arm7 -o "$out/robot.html"
# The other pages show measured times. With SOURCE_DATE_EPOCH every build has to give the same bytes.
[[ -z ${SOURCE_DATE_EPOCH:-} ]] || exit 0

sed '0,/{/s//{"defaults": {"quality": "quick"}, /' mouth/mouth.scene.json >mouth/quick.scene.json
code=0
$spheretree batch mouth/quick.scene.json -o trees >/dev/null || code=$?
[[ $code == 0 || $code == 5 ]]  # 5: a tolerance was not met
"$build/tools/haptic_player/haptic-player" trees/scene.json --trajectory mouth/inspection.csv --clock stepped --seconds 6 --record run.csv -q >/dev/null
$spheretree report trees -o "$out/mouth.html" --recording run.csv
$spheretree compare molar.obj -o comparison --qualities quick >/dev/null
cp comparison/*.html "$out/comparison.html"
