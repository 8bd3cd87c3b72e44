#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the program like a user: exit codes, messages, and no incomplete files.
# Usage: program_test.sh PROGRAM CASE [ARGUMENTS OF THE CASE]
program=$1
case=$2
shift 2
folder=$(mktemp -d) || exit 1
trap 'chmod -R u+rwx "$folder"; rm -rf "$folder"' EXIT
cd "$folder" || exit 1
mkdir work

fail() {
  echo "FAILED: $*" >&2
  [ -f err ] && sed 's/^/  stderr: /' err >&2
  exit 1
}

# expect CODE ARGUMENTS...: runs the program; stdout in `out`, stderr in `err`.
expect() {
  wanted=$1
  shift
  "$program" "$@" >out 2>err
  code=$?
  [ $code -eq "$wanted" ] || fail "exit code $code, not $wanted: spheretree $*"
}

says() { grep -q -e "$1" "$2" || fail "$2 does not say: $1"; }
is_empty() { [ -z "$(ls -A "$1")" ] || fail "left behind in $1: $(ls -A "$1")"; }

# Two levels: a root and two leaves.
write_sph() {
  printf '2 2\n0 0 0 2 1\n0.5 0 0 1.25 1\n-0.5 0.1 0 1.125 1\n' >"$1"
}

write_tetrahedron() {
  printf 'v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >"$1"
}

# A torus of 2 N^2 triangles.
write_torus() {
  awk -v n="$2" 'BEGIN {
    pi = atan2(0, -1)
    for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) {
      u = 2 * pi * i / n; v = 2 * pi * j / n; r = 10 + 3 * cos(v)
      printf "v %.9f %.9f %.9f\n", r * cos(u), r * sin(u), 3 * sin(v)
    }
    for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) {
      a = i * n + j + 1; b = (i + 1) % n * n + j + 1; c = (i + 1) % n * n + (j + 1) % n + 1; d = i * n + (j + 1) % n + 1
      printf "f %d %d %d\nf %d %d %d\n", a, b, c, a, c, d
    }
  }' >"$1"
}

case_help() {
  expect 0 --help
  fits_80 out
  for verb in batch build check compare convert evaluate grade inspect repair report robot scene soften split view; do
    says "^  $verb" out
    "$program" $verb --help >help || fail "no help of $verb"
    says "Example:" help
    says "default" help
    fits_80 help
  done
  expect 0 --version
  says "^spheretree [0-9]" out
}

# Lines of a help are as wide as a terminal, apart from examples, and name no checks of CLI11.
fits_80() {
  awk 'length($0) > 80 && !/^  (spheretree|haptic-player)/ { print; found = 1 } END { exit found }' "$1" || fail "a line of more than 80 characters"
  grep -e "REQUIRED" -e "INT in" -e "{false}" "$1" && fail "checks of CLI11 in a help"
  return 0
}

case_usage() {
  expect 2
  expect 2 biuld
  says "unknown verb 'biuld'; the nearest is 'build'" err
  expect 2 build
  expect 2 build mesh.obj
  expect 2 inspect
  expect 2 inspect a.stree --no-such-option
  expect 2 build mesh.obj --qualty quick
  says "unknown option '--qualty' of build; the nearest is '--quality'" err
  write_tetrahedron mesh.obj
  for bad in "--levels 1" "--levels 7" "--levels x" "--branching 9" "--builder best" "--quality good" "--unit km" "--tolerance 0" \
    "--tolerance -1" "--tolerance nan" "--tolerance inf" "--tolerance 1mm" "--seed -1" "--seed 18446744073709551616" "--threads -1" "--repair maybe" \
    "--combine merge" "--builder combined --combine cover" "--progress loud"; do
    # shellcheck disable=SC2086
    expect 2 build mesh.obj -o work/a.stree $bad
    [ -s err ] || fail "no message for $bad"
    is_empty work
  done
  expect 2 build mesh.obj -o work/a.sph
  says "convert" err
  for verb in "check mesh.obj" "evaluate mesh.obj a.stree" "compare mesh.obj -o work/comparison"; do
    # shellcheck disable=SC2086
    expect 2 $verb --unit km
    says "km.*mm, *cm.*m.*in" err
    is_empty work
  done
  for verb in "evaluate mesh.obj a.stree" "compare mesh.obj -o work/comparison"; do
    # shellcheck disable=SC2086
    expect 2 $verb --seed -1
    says "not a whole number from 0" err
  done
  write_sph a.sph
  expect 2 convert a.sph work/a.txt
  expect 2 convert mesh.obj work/a.stree
  expect 2 convert a.sph work/a.stree --spheres bound
  expect 2 convert a.sph work/b.sph --spheres all
  is_empty work
}

case_inspect() {
  write_sph a.sph
  expect 0 convert a.sph a.stree
  expect 0 inspect a.stree
  says "sound" out
  says "3, 1 of them inner, branching 2" out
  expect 0 inspect a.stree --json
  says '"valid": true' out
  says '"nodes": 3' out
}

case_convert() {
  write_sph a.sph
  expect 0 convert a.sph a.stree
  for ending in stree sph json glb; do
    expect 0 convert a.stree "work/a.$ending"
    [ -s "work/a.$ending" ] || fail "no $ending"
    [ ! -s out ] && [ ! -s err ] || fail "convert is silent if all is well"
  done
  cmp a.stree work/a.stree || fail ".stree to .stree changes bytes"
  expect 0 convert work/a.json b.stree
  cmp a.stree b.stree || fail ".json is not lossless"
  expect 0 convert work/a.sph c.stree
  cmp a.stree c.stree || fail ".sph lost something of a tree that came from .sph"
  printf '2 2\n0 0 0 2 1\n1.5 0 0 1.25 1\n-0.5 0.1 0 1.125 1\n' >reaching.sph  # a leaf reaches out of its parent's cover sphere
  expect 0 convert reaching.sph reaching.stree
  expect 0 convert reaching.stree bound.sph --spheres bound
  cmp -s bound.sph reaching.sph && fail "--spheres bound changes nothing"
  expect 0 convert a.stree COVER.SPH --spheres cover
  cmp COVER.SPH work/a.sph || fail "cover is the default"
  expect 2 convert a.stree a.stree
  cmp a.stree b.stree || fail "a file converted onto itself"
  # Through pipes: the content tells the kind of the input, --to that of the output.
  for form in stree sph json; do
    "$program" convert - - --to $form <a.stree >piped || fail "no $form through a pipe"
    "$program" convert - piped.stree <piped || fail "$form from a pipe is not read"
    cmp a.stree piped.stree || fail "$form changes on its way through pipes"
  done
  expect 2 convert a.stree -
  says "standard output" err
  "$program" inspect - <a.stree >out || fail "no tree from a pipe"
  says "standard input: sound" out
}

case_picture() {
  write_sph a.sph
  write_tetrahedron mesh.obj
  expect 0 convert a.sph work/a.png --mesh mesh.obj --view -1,2,0.5 --width 300
  # PNG: signature, then the width as the first field of the first chunk.
  [ "$(od -An -tx1 -N4 work/a.png | tr -d ' ')" = 89504e47 ] || fail "no PNG"
  [ "$(od -An -tu1 -j16 -N4 work/a.png | tr -s ' ')" = " 0 0 1 44" ] || fail "not 300 pixels wide"
  expect 0 convert a.sph work/b.png --mesh mesh.obj --view -1,2,0.5 --width 300
  cmp work/a.png work/b.png || fail "the same picture in other bytes"
  expect 0 convert a.sph work/b.png --view 1,2,0.5 --width 300
  cmp -s work/a.png work/b.png && fail "mesh and view change nothing"
  rm work/*
  for bad in "--width 99" "--width 3001" "--view 1,2" "--view 0,0,0" "--view 1,2,x" "--view nan,0,1" "--view inf,0,1"; do
    # shellcheck disable=SC2086
    expect 2 convert a.sph work/a.png $bad
  done
  expect 2 convert a.sph work/a.glb --mesh mesh.obj
  expect 3 convert a.sph work/a.png --mesh missing.obj
  is_empty work
}

# No output replaces an input.
case_own_input() {
  write_tetrahedron mesh.obj
  grep -v 'f 2 3 4' mesh.obj >open.obj
  expect 4 check open.obj -o open.glb
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2}, "tool": {"name": "tool", "mesh": "mesh.obj"},
    "objects": [{"name": "object", "mesh": "mesh.obj"}]}' >scene.json
  mkdir before
  cp mesh.obj open.glb scene.json before
  ln -s open.glb link.glb
  expect 2 check open.glb -o open.glb
  expect 2 check open.glb -o ./link.glb
  says "open.glb" err
  expect 2 build mesh.obj -o work/a.stree --report mesh.obj
  expect 2 batch scene.json -o .
  expect 2 batch "$PWD/scene.json" -o work/..
  for file in mesh.obj open.glb scene.json; do cmp $file before/$file || fail "$file was written over"; done
  expect 2 report run.csv --scene scene.json -o scene.json
  is_empty work
}

# Names with blanks, in any script, and of bytes that are not text.
case_names() {
  no_text=$(printf 'no\377text')
  for name in "a tooth" "зуб 歯" "$no_text"; do
    write_tetrahedron "$name.obj"
    mkdir "work/$name"
    expect 0 build "$name.obj" -o "work/$name/a.stree" --levels 2 --quality quick --report "work/$name/built.json" --progress json
    says '"schema": "spheretree.build/1"' "work/$name/built.json"
    expect 0 check "$name.obj" --json
    expect 4 inspect "$name.obj" --json
    says '"valid": false' out
    printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2}, "tool": {"name": "tool", "mesh": "%s/a tooth.obj"},
      "objects": [{"name": "object", "mesh": "../a tooth.obj"}]}' "$PWD" >"work/$name.json"
    expect 0 batch "work/$name.json" -o "work/$name" --progress json
    expect 0 report "work/$name" -o "work/$name.html"
    expect 0 compare "$name.obj" -o "work/$name/compared" --builders cover --qualities quick --levels 2 --progress json
    expect 0 report "work/$name/compared" -o "work/$name.html"
    expect 0 compare "$name.obj" -o "work/$name/compared" --builders cover --qualities quick --levels 2
  done
}

case_evaluate() {
  write_tetrahedron mesh.obj
  printf '2 2\n2.5 2.5 2.5 10 1\n2 2 2 8.9 1\n5 5 5 7.5 1\n' >tree.sph
  expect 0 evaluate mesh.obj tree.sph
  says "^level  spheres" out
  says "h_fin = " out
  expect 0 evaluate mesh.obj tree.sph --json --no-limits --threads 1
  cp out one
  says '"schema": "spheretree.evaluation/1"' out
  for key in diagonal_mm level spheres overhang_mm max bound p99 mean uncovered_fraction max_gap_mm excess_volume_fraction \
    missing_volume_fraction leaves_outside_ancestor; do
    says "\"$key\": " out
  done
  grep -q limit_mm out && fail "--no-limits leaves the limits in"
  expect 0 evaluate mesh.obj tree.sph --json --no-limits --threads 2
  cmp -s out one || fail "the result depends on the threads"
  expect 0 evaluate mesh.obj tree.sph --json
  says '"h_low": ' out
  # A tree of another mesh is measured, with a warning; none for the right one or an imported tree.
  expect 0 build mesh.obj -o tree.stree --levels 2 --quality quick -q
  expect 0 evaluate mesh.obj tree.stree --no-limits
  is_quiet
  expect 0 evaluate mesh.obj tree.stree --no-limits --unit cm
  says "another mesh" err
  expect 2 evaluate mesh.obj tree.sph --link x
  says "--link is for a file of spheres with links" err
  expect 2 evaluate mesh.obj mesh.obj
  expect 2 evaluate mesh.obj tree.sph --unit yard
  expect 3 evaluate missing.obj tree.sph
  expect 3 evaluate mesh.obj missing.stree
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
  expect 4 evaluate flat.obj tree.sph
}

is_quiet() { [ ! -s err ] || fail "stderr is not empty"; }

case_damaged_input() {
  expect 3 inspect missing.stree
  says "missing.stree" err
  expect 3 inspect work
  write_sph a.sph
  expect 0 convert a.sph a.stree
  head -c 300 a.stree >cut.stree
  expect 4 inspect cut.stree
  says "cut.stree" err
  expect 4 inspect cut.stree --json
  says '"valid": false' out
  printf 'x' | cat a.stree - >long.stree
  expect 4 inspect long.stree
  expect 4 convert cut.stree work/a.sph
  printf '2 2\n0 0 0 2 1\n' >short.sph
  expect 4 convert short.sph work/a.stree
  says "ends after 1 of 3 nodes" err
  printf '{"schema": "spheretree.tree/2"}' >a.json
  expect 4 convert a.json work/a.stree
  : >empty.stree
  expect 4 inspect empty.stree
  expect 3 build missing.obj -o work/a.stree
  : >empty.obj
  expect 4 build empty.obj -o work/a.stree
  is_empty work
}

case_unwritable_output() {
  write_sph a.sph
  write_tetrahedron mesh.obj
  mkdir work/folder.stree
  expect 3 convert a.sph work/folder.stree
  expect 3 build mesh.obj -o work/folder.stree
  rmdir work/folder.stree
  expect 3 convert a.sph work/missing/a.stree
  says "folder" err
  expect 3 build mesh.obj -o work/missing/a.stree
  expect 3 build mesh.obj -o work/a.stree --report work/missing/report.json
  is_empty work
  if [ -c /dev/full ]; then
    ln -s /dev/full full.stree
    expect 3 convert a.sph full.stree
    says "space" err
    [ -c /dev/full ] || fail "the device was replaced"
    expect 3 build mesh.obj -o full.stree
  fi
}

case_read_only_folder() {
  write_sph a.sph
  runner=
  if [ "$(id -u)" -eq 0 ]; then
    command -v setpriv >/dev/null || exit 77
    chmod 755 "$folder"
    runner="setpriv --reuid=65534 --regid=65534 --clear-groups"
    $runner "$program" --version >/dev/null 2>&1 || exit 77
  fi
  chmod 555 work
  $runner "$program" convert "$folder/a.sph" "$folder/work/a.stree" >out 2>err
  code=$?
  chmod 755 work
  [ $code -eq 3 ] || fail "exit code $code, not 3"
  says "cannot be written" err
  is_empty work
}

case_standard_output_full() {
  [ -c /dev/full ] || exit 77
  write_sph a.sph
  expect 0 convert a.sph a.stree
  for arguments in "inspect a.stree" "inspect a.stree --json" "--help"; do
    # shellcheck disable=SC2086
    "$program" $arguments >/dev/full 2>err
    code=$?
    [ $code -eq 3 ] || fail "exit code $code, not 3: $arguments"
  done
}

case_build() {
  write_tetrahedron mesh.obj
  expect 0 build mesh.obj -o work/a.stree --levels 3 --quality quick
  says "work/a.stree" out
  [ ! -s err ] || fail "talk although stderr is no terminal"
  expect 0 inspect work/a.stree
  expect 0 build mesh.obj -o work/inch.stree --levels 2 --unit in --quality quick
  expect 0 inspect work/inch.stree --json
  says '"unit_mm": 25.4' out
  expect 0 build mesh.obj -o work/least.stree --tolerance 0.5 --lower-bound --quality quick --report work/least.json
  says "needs at least [1-9][0-9]* spheres; this tree has [1-9]" out
  grep -q '"least_spheres": [1-9]' work/least.json || fail "no least_spheres in the report"
  expect 2 build mesh.obj -o work/least.stree --lower-bound
  says "Add one, without --shape hulls" err
  expect 5 build mesh.obj -o work/missed.stree --levels 2 --tolerance 1e-9 --quality quick
  says "tolerance" err
  expect 0 inspect work/missed.stree
}

case_build_is_deterministic() {
  write_torus mesh.obj 24
  expect 0 build mesh.obj -o work/a.stree --levels 3 --quality quick --threads 1
  for threads in 2 3 8; do
    expect 0 build mesh.obj -o work/b.stree --levels 3 --quality quick --threads $threads
    cmp work/a.stree work/b.stree || fail "$threads threads give other bytes"
  done
}

case_build_report() {
  write_tetrahedron mesh.obj
  expect 0 build mesh.obj -o work/a.stree --levels 2 --quality quick --report work/report.json
  for words in '"schema": "spheretree.build/1"' '"settings_hash": "[0-9a-f]\{32\}"' '"overhang_bound_mm"' '"stages"'; do says "$words" work/report.json; done
  expect 0 inspect work/a.stree --json
  hash=$(sed -n 's/.*"settings_hash": "\([0-9a-f]*\)".*/\1/p' out)
  says "\"settings_hash\": \"$hash\"" work/report.json
}

case_build_refuses_defects() {
  write_tetrahedron whole.obj
  grep -v 'f 2 3 4' whole.obj >open.obj
  expect 4 build open.obj -o work/a.stree --repair off
  says "open.obj" err
  says "border" err
  is_empty work
  sed 's/^f \(.\) \(.\) \(.\)/f \3 \2 \1/' whole.obj >turned.obj
  expect 4 build turned.obj -o work/a.stree --repair off
  is_empty work
  expect 0 build turned.obj -o work/a.stree --levels 2 --quality quick
  says "inside out" err
  expect 0 build turned.obj -o work/b.stree --levels 2 --quality quick -q
  [ ! -s err ] || fail "-q is not quiet"
  expect 0 build turned.obj -o work/b.stree --levels 2 --quality quick --report work/report.json
  says "inside out" work/report.json
  expect 0 inspect work/b.stree
}

case_build_repairs() {
  write_tetrahedron whole.obj
  grep -v 'f 2 3 4' whole.obj >open.obj
  expect 0 build open.obj -o work/a.stree --levels 2 --quality quick --report work/report.json
  says "1 opening closed" err
  for words in '"step": "cap_openings"' '"change_mm"' '"removed_triangles": \[\]' '"input_triangles": 3'; do says "$words" work/report.json; done
  expect 0 evaluate open.obj work/a.stree --no-limits
  says "1 opening closed" err
  if grep -q "another mesh" err; then fail "evaluate repairs otherwise than build"; fi
  # A triangle beside the solid is not part of it, but every tree of the file covers it, and evaluate finds it uncovered
  # by the tree of another file.
  { cat whole.obj; printf 'v 12 1 1\nv 12.1 1 1\nv 12 1.1 1\nf 5 6 7\n'; } >crumb.obj
  expect 0 build whole.obj -o work/b.stree --levels 2 --quality quick
  expect 0 build crumb.obj -o work/c.stree --levels 2 --quality quick
  says "1 triangle with nothing solid on either side, covered all the same" err
  expect 0 evaluate crumb.obj work/c.stree --no-limits --json
  [ "$(grep -c '"max_gap_mm": 0.0,' out)" = 2 ] || fail "a level does not cover the triangle beside the solid"
  expect 0 evaluate crumb.obj work/b.stree --no-limits --json
  if grep -q '"max_gap_mm": 0.0,' out; then fail "evaluate does not see the triangle beside the solid"; fi
  expect 0 build whole.obj -o work/b.stree --levels 2 --quality quick --repair wrap
  says "wrapped" err
  expect 0 evaluate whole.obj work/b.stree --no-limits --repair wrap
  if grep -q "another mesh" err; then fail "evaluate wraps otherwise than build"; fi
  expect 0 evaluate whole.obj work/b.stree --no-limits
  says "another mesh" err
}

case_check() {
  write_tetrahedron whole.obj
  expect 0 check whole.obj
  says "no defects" out
  expect 0 check whole.obj --json --unit cm
  says '"clean": true' out
  says '"build": "accept"' out
  says '"unit_mm": 10.0' out
  says '"volume_mm3": 166666.6' out
  says '"leaf_estimates"' out
  expect 0 check whole.obj
  says "leaves for an overhang of" out
  grep -v 'f 2 3 4' whole.obj >open.obj
  expect 4 check open.obj -o work/marked.glb
  says "border: 3 edges round 1 hole" out
  says "a build repairs this mesh" out
  says "1 opening closed" out
  says "border of 3 edges, .* a loop, .* roundness 0.60" out
  expect 4 check work/marked.glb --json
  says '"border"' out
  rm work/marked.glb
  expect 2 check open.obj -o work/marked.obj
  is_empty work
  expect 4 check open.obj --json
  says '"kind": "border"' out
  says '"build": "fix"' out
  says '"step": "cap_openings"' out
  sed 's/^f \(.\) \(.\) \(.\)/f \3 \2 \1/' whole.obj >turned.obj
  expect 4 check turned.obj --json
  says '"kind": "inside_out"' out
  says '"build": "fix"' out
  { echo 'o large'; cat whole.obj; printf 'o small\nv 1 1 1\nv 2 1 1\nv 1 2 1\nv 1 1 2\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n'; } >both.obj
  expect 0 check both.obj --list-parts
  says "sound       small (#1)" out
  says "0.166667         1.5        1.5        1.5          1         1         1  sound       small" out
  [ "$(grep -c 'sound ' out)" = 2 ] || fail "a component that is a part is listed twice: $(cat out)"
  expect 0 check both.obj --list-parts --json
  says '"centre_mm": \[' out
  says '"component": 1,' out
  expect 0 check both.obj --parts '#1' --json
  says '"triangles": 4,' out
  expect 4 check both.obj --parts '#2'
  says "has no component #2; it has 2" err
  expect 0 build both.obj -o work/part.stree --parts '#1' --quality quick --levels 2
  rm work/part.stree
  expect 0 check both.obj
  says 'part "small") lies wholly within solid matter' out
  expect 0 check both.obj --json
  says '"build": "fix"' out
  expect 0 check both.obj --parts large
  says "4 triangles" out
  expect 4 check both.obj --parts none
  says '"large", "small"' err
  printf 'v 0 0 0\nf 1 2 3\n' >bad.obj
  expect 4 check bad.obj
  says "bad.obj: line 2" err
  expect 3 check missing.obj
  expect 2 check whole.obj --unit km
}

case_build_interrupted() {
  write_torus mesh.obj 120
  for signal in INT TERM; do
    rm -f err  # of the round before: what it says must not be taken for this one's
    "$program" build mesh.obj -o work/a.stree --quality best --levels 5 --progress json >out 2>err &
    pid=$!
    for _ in $(seq 600); do
      grep -q -s '"stage"' err && grep -v -q '"stage":"\(read\|check\|distances\)"' err && break
      kill -0 $pid 2>/dev/null || fail "ended before it could be interrupted"
      sleep 0.1
    done
    kill -$signal $pid
    wait $pid
    code=$?
    [ $code -eq 130 ] || fail "exit code $code, not 130, after $signal"
    says "interrupted" err
    is_empty work
  done
}

case_progress() {
  write_torus mesh.obj 40
  expect 0 build mesh.obj -o work/a.stree --levels 3 --quality quick --progress json
  says '^{"stage":"read","fraction":0' err
  expect 0 build mesh.obj -o work/a.stree --levels 3 --quality quick --progress json -q
  [ ! -s err ] || fail "-q is not quiet"
  expect 0 build mesh.obj -o work/a.stree --levels 3 --quality quick --progress none
  [ ! -s err ] || fail "none is not none"
  write_sph a.sph
  expect 0 convert a.sph a.stree --progress bar
  [ ! -s err ] || fail "a bar for work of a few milliseconds"
}

# The whole of a batch: progress never decreases; each built object is reported once; the end lists the times of the
# stages.
case_batch_progress() {
  write_torus big.obj 32
  write_torus small.obj 16
  printf '{"schema": "spheretree.scene/1", "tool": {"name": "tool", "mesh": "small.obj", "levels": 2},
    "objects": [{"name": "a", "mesh": "big.obj", "levels": 4, "quality": "quick"}, {"name": "b", "mesh": "small.obj", "levels": 3},
                {"name": "copy", "mesh": "small.obj", "levels": 3}]}' >s.json
  expect 0 batch s.json -o work/out --progress json
  sed -n 's/.*"overall":\([0-9.e-]*\).*/\1/p' err >overall
  [ "$(wc -l <overall)" -ge 4 ] || fail "the overall fraction is told less than once a stage"
  awk '$1 + 0 < last || $1 + 0 > 1 { bad = 1 } { last = $1 + 0 } END { exit bad || last < 0.9 }' overall || fail "overall: $(tr '\n' ' ' <overall)"
  says '"stage":"read"' err
  says '"stage":"write"' err
  says '"done":3,"of":3,"running":\[\]' err
  for name in tool a b; do
    [ "$(grep -c "^{\"object\":\"$name\",\"built\":true,\"seconds\":[0-9.e-]*,\"leaves\":[0-9]*,\"overhang_bound_mm\":[0-9]" err)" -eq 1 ] ||
      fail "$name is not told once"
  done
  grep -q '"object":"copy"' err && fail "a copy is told to have been built"
  expect 0 batch s.json -o work/other --cache work/none --progress plain
  if grep -q '^object' err; then # after half a second
    says '^object  *leaves  *bound \[mm\]  *time \[s\]$' err
    says '^a  *[0-9]* *[0-9.e-]* *[0-9.]*$' err
  fi
  if grep -q '^time:' out; then # after a second
    says '^time: read [0-9.]* s, build [0-9.]* s, write [0-9.]* s; the longest: a [0-9.]* s, ' out
  fi
  expect 0 batch s.json -o work/other --cache work/none --progress json
  grep -q '"object"' err && fail "a tree from the cache is told to have been built"
  :
}

case_file_format() {
  expect_python() { "$@" >out 2>err || fail "the reader of the documentation refuses: $*"; }
  write_sph a.sph
  printf '3 3\n1 2 3 9.5 1\n1 0 0 1 1\n2 0 0 2 1\n3 0 0 3 1\n0 0 0 -1 0\n0 0 0 -1 0\n0 0 0 -1 0\n' >b.sph
  printf '0.1 0 0 1 1\n0.2 0 0 1 1\n0.3 0 0 1 1\n0 0 0 -1 0\n0.4 0 0 1 1\n0 0 0 -1 0\n' >>b.sph
  printf '1 2\n1e6 0 0 1 1\n' >c.sph
  for name in a b c; do
    expect 0 convert $name.sph $name.stree
    expect 0 convert $name.stree $name.json
    expect_python "$@" $name.stree $name.json
  done
  printf 'x' | dd of=b.stree bs=1 seek=330 conv=notrunc 2>/dev/null
  "$@" b.stree 2>/dev/null && fail "the reader misses damage"
  return 0
}

. "${0%/*}/batch_cases.sh"
. "${0%/*}/tissue_cases.sh"
. "${0%/*}/cut_cases.sh"
. "${0%/*}/page_cases.sh"
. "${0%/*}/player_cases.sh"
. "${0%/*}/message_cases.sh"
. "${0%/*}/view_cases.sh"

"case_$case" "$@"
