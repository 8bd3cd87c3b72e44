#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# tools/animation.sh SCENE.json TRAJECTORY.csv OUT.gif [FROM TO]: plays the path in the scene, records it, and draws ten
# pictures for each second of the recording from step FROM to TO (default 1500 to 11500) as an animated image. Needs
# ffmpeg and gifsicle (Debian), which nothing else needs, and no display.
set -euo pipefail
if [[ $# -ne 3 && $# -ne 5 ]]; then
  echo "usage: tools/animation.sh SCENE.json TRAJECTORY.csv OUT.gif [FROM TO]" >&2
  exit 2
fi
for program in ffmpeg gifsicle; do
  command -v "$program" >/dev/null || { echo "tools/animation.sh: $program is missing: apt-get install ffmpeg gifsicle" >&2; exit 3; }
done
player=$(dirname "$0")/../build/release/tools/haptic_player/haptic-player
from=${4:-1500} to=${5:-11500}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$player" "$1" --trajectory "$2" --clock stepped --seconds "$(((to + 1000) / 1000))" --record "$work/run.csv" -q >/dev/null
"$player" "$1" --replay "$work/run.csv" --picture "$work/frame.png" --at "$from:$((to - 100)):100" --size 400x266 --panels off --follow \
  --within 14 -q
ffmpeg -loglevel error -framerate 10 -i "$work/frame.%05d.png" \
  -vf 'split[a][b];[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=none:diff_mode=rectangle' "$work/run.gif"
gifsicle -O3 --lossy=60 --no-warnings "$work/run.gif" -o "$3"
echo "$3: $(stat -c %s "$3") bytes"
