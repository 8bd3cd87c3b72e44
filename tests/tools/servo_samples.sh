#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the samples of the servo loop with the simulated device.
# Usage: servo_samples.sh CASE SPHERETREE SAMPLES SECOND_DEVICE FOLDER...   FOLDER: of the shared libraries
case=$1
spheretree=$2
samples=$3
second_device=$4
shift 4
libraries=$(IFS=:; echo "$*")
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# Two leaves of 20 mm.
printf '2 2\n0 0 0 22 1\n1 0 0 20 1\n-1 0 0 20 1\n' >tool.sph
"$spheretree" convert tool.sph tool.stree || fail "no tree"

case $case in
  engine_in_csharp)
    command -v mcs >/dev/null && command -v mono >/dev/null || exit 77
    mcs -out:Touch.exe "$samples/05_engine/Touch.cs" || fail "it does not compile"
    LD_LIBRARY_PATH=$libraries mono Touch.exe tool.stree tool.stree >out || fail "exit code $?: $(cat out)"
    grep -q "contact True, force [0-9]*\.[0-9]* N" out || fail "$(cat out)"
    LD_LIBRARY_PATH=$libraries mono Touch.exe tool.stree tool.stree mouse 2>err && fail "a mouse is no device"
    grep -q "there is no device 'mouse'" err || fail "$(cat err)"
    ;;
  second_device)
    "$second_device" tool.stree >out || fail "exit code $?: $(cat out)"
    grep -q "they touch: -[0-9.]* N on the left hand, [0-9.]* N on the right one" out || fail "$(cat out)"
    ;;
esac
