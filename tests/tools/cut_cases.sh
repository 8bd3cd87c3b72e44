# SPDX-License-Identifier: GPL-3.0-or-later
# Cases of program_test.sh: grading of a recorded cut, and the mesh of what is left. Argument: make_samples.

# Turns a path of the hand into the recording of a tool that follows it exactly.
recording_of() { # drill.csv scene
  awk -F, -v scene="$2" 'NR == 1 { print "tick,t_s,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,scene,spin"; next }
    { printf "%d,%s,%s,%s,%s,%s,%s,%s,%s,%s,%s\n", NR - 2, $1, $2, $3, $4, $5, $6, $7, $8, NR == 2 ? scene : "", $9 }' "$1"
}

case_grade() {
  "$1" --cavity cavity >out 2>err || fail "make_samples"
  recording_of cavity/drill.csv cavity/cavity.scene.json >run.csv
  expect 0 grade run.csv -o page.html --json --volume-tolerance 1
  cp out first.json
  says '"schema": "spheretree.grade/1"' out
  says '"tolerance_met": true' out
  says '"layer": "lesion"' out
  says 'tooth_36' page.html
  says 'between which the true value lies' page.html
  says 'What is left' page.html
  says 'data-eye="3"' page.html
  expect 0 grade run.csv --json -j 1 --volume-tolerance 1
  cmp -s out first.json || fail "the number of threads changes the figures"
  expect 0 grade run.csv --volume-tolerance 2
  says '^tooth_36: removed [0-9.]* to [0-9.]* mm3' out
  says '^  pulp  *removed .* mm from the cut' out
  expect 0 grade run.csv --volume-tolerance 2 --lesion dentine --json
  says '"layer": "dentine"' out
  expect 0 grade run.csv --at 100 --json
  says '"steps": 101' out
  expect 4 grade run.csv --at 99999999
  says 'before tick' err
  expect 2 grade run.csv --volume-tolerance 0
  expect 2 grade run.csv -o page.txt
  expect 4 grade cavity/drill.csv
  says 'no column' err
  sed 7d run.csv >lost.csv
  expect 4 grade lost.csv
  says 'the row before is tick 4' err
  rm cavity/pulp.obj
  expect 3 grade run.csv
  says 'pulp.obj' err
}

case_remaining() {
  "$1" --cavity cavity >out 2>err || fail "make_samples"
  recording_of cavity/drill.csv cavity/cavity.scene.json >run.csv
  expect 0 convert run.csv left.ply
  says '^left.ply: tooth_36, [0-9]* triangles, within 0.01[0-9]* mm of what is left$' out
  expect 0 check left.ply
  says 'no defects' out
  expect 0 build left.ply --quality quick --leaves 64 -o left.stree
  expect 0 convert run.csv first.obj --object tooth_36 --at 4000 --tolerance 0.05
  expect 0 check first.obj
  expect 0 convert run.csv again.obj --object tooth_36 --at 4000 --tolerance 0.05
  cmp -s first.obj again.obj || fail "the mesh differs from run to run"
  expect 2 convert run.csv left.stl
  expect 2 convert run.csv left.ply --level 2
  expect 2 convert run.csv left.ply --object tooth_37
  says 'tooth_36' err
  expect 2 convert left.stree left.json --tolerance 0.1
  says 'are for recordings' err
  expect 4 convert cavity/drill.csv left.ply
  says 'no column' err
}
