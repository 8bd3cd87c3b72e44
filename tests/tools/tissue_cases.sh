# SPDX-License-Identifier: Apache-2.0
# Cases of program_test.sh: soft tissue.

case_soften() {
  write_torus torus.obj 24
  expect 0 build torus.obj -o torus.stree --quality quick --levels 3 -q
  expect 0 soften torus.obj torus.stree -o work/torus.soft --young 15 --fix box:-20,-20,-20,20,20,-2 --tets 1500 -q
  says "tetrahedra" out
  expect 0 inspect work/torus.soft
  says "sound" out
  expect 0 convert work/torus.soft again.stree
  cmp torus.stree again.stree || fail "the tree at rest is not the tree"
  expect 0 soften torus.obj torus.stree -o again.soft --young 15 --fix box:-20,-20,-20,20,20,-2 --tets 1500 --json
  says '"schema": "spheretree.softening/1"' out
  cmp work/torus.soft again.soft || fail "the same input gives other bytes"
  expect 4 soften torus.obj torus.stree -o inside.soft --young 15 --fix box:-99,-99,-99,99,99,99 --tets 500
  says "nothing can move" err
  [ ! -e inside.soft ] || fail "a refused tree was written"
  # In the window: the surface of the tetrahedra, and the spheres.
  "$program" view again.soft --picture tetrahedra.png --size 500x400 >out 2>err
  if ! grep -q "built without its view" err; then
    for show in meshes spheres; do expect 0 view again.soft --picture $show.png --size 500x400 --show $show; done
    cmp tetrahedra.png meshes.png || fail "it does not open on the tetrahedra"
    if cmp -s meshes.png spheres.png; then fail "spheres look like tetrahedra"; fi
    expect 0 view torus.obj again.soft --overhang --picture overhang.png --size 500x400
  fi
}

case_soften_refuses() {
  write_torus torus.obj 24
  write_tetrahedron other.obj
  expect 0 build torus.obj -o torus.stree --quality quick --levels 2 -q
  fix="--fix box:-20,-20,-20,20,20,-2"
  expect 2 soften torus.obj torus.stree -o work/a.soft --young 0.015 $fix
  says "MPa" err
  expect 2 soften torus.obj torus.stree -o work/a.soft --young 15 --poisson 0.5 $fix
  expect 2 soften torus.obj torus.stree -o work/a.soft --young 15
  says "is not held" err
  expect 2 soften torus.obj torus.stree -o work/a.soft --young 15 --fix box:1,2
  expect 2 soften torus.obj torus.stree -o work/a.stree --young 15 $fix
  expect 4 soften other.obj torus.stree -o work/a.soft --young 15 $fix
  says "not built from" err
  expect 4 soften torus.obj torus.stree -o work/a.soft --young 15 --fix sphere:0,0,0,1
  says "float away" err
  SPHERETREE_TETRAHEDRA=/nowhere/spheretree-tetrahedra expect 4 soften torus.obj torus.stree -o work/a.soft --young 15 $fix
  says "libtet1.5-dev" err
  is_empty work
}

case_soften_batch() {
  write_torus torus.obj 24
  write_tetrahedron tool.obj
  cat >scene.json <<'S'
{"schema": "spheretree.scene/1", "tool": {"name": "probe", "mesh": "tool.obj", "levels": 2},
 "defaults": {"quality": "quick", "levels": 3},
 "objects": [{"name": "bone", "mesh": "tool.obj", "position_mm": [0, 0, -6], "levels": 2},
             {"name": "ring", "mesh": "torus.obj", "levels": 4,
              "soft": {"young_kpa": 15, "tetrahedra": 800, "fixed": [{"inside": "bone"}, {"box": {"low_mm": [-20, -20, -9], "high_mm": [20, 20, -1]}}]}}]}
S
  expect 0 batch scene.json -o made -q
  expect 0 evaluate torus.obj made/ring.soft --states 5 --samples 1000
  says "squeeze" out
  grep -q '"tree": "ring.soft"' made/scene.json || fail "the scene does not name the soft tree"
  [ ! -e made/ring.stree ] || fail "two trees of one object"
  cp made/ring.soft first.soft
  expect 0 batch scene.json -o made -q
  cmp first.soft made/ring.soft || fail "from the cache it has other bytes"
  for f in made/cache/*.soft; do head -c 1000 "$f" >cut && mv cut "$f"; done
  expect 0 batch scene.json -o made -q
  cmp first.soft made/ring.soft || fail "a damaged cache gives other bytes"
  grep -q "soft: .* tetrahedra" made/report.json || fail "the report does not mention the tissue"
  expect 0 report made -o page.html
  grep -q "tetrahedra" page.html || fail "the page does not mention the tissue"
  # Pressed in by 2 mm from above it pushes back, but less than a rigid ring; every play gives the same result.
  awk 'BEGIN { print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
    for (i = 0; i < 300; ++i) printf "%.3f,10,0,%.3f,1,0,0,0\n", i / 1000, i < 200 ? 5 - 0.02 * i : 1 }' >press.csv
  player=$1
  for run in soft again rigid; do
    [ $run = rigid ] && "$program" convert made/ring.soft made/ring.stree >/dev/null && sed -i 's/ring.soft/ring.stree/' made/scene.json
    "$player" made/scene.json --trajectory press.csv --clock stepped --record $run.csv >/dev/null || fail "the player stops"
    cut -d, -f1-27 $run.csv >$run.steps
  done
  cmp soft.steps again.steps || fail "the same path gives another force"
  force() { tail -n 1 "$1" | awk -F, '{ print $19 }'; }
  awk -v soft="$(force soft.csv)" -v rigid="$(force rigid.csv)" 'BEGIN { exit !(soft > 0.05 && soft < 0.9 * rigid) }' ||
    fail "soft: $(force soft.csv) N, rigid: $(force rigid.csv) N"
  sed 's/"low_mm": \[-20, -20, -9\]/"low_mm": [19, 19, -9]/; s/{"inside": "bone"}, //' scene.json >loose.json
  expect 6 batch loose.json -o loose -q
  grep -q "float away" loose/report.json || fail "the report does not say why"
  sed 's/"young_kpa": 15/"young_kpa": 0.015/' scene.json >wrong.json
  expect 4 batch wrong.json -o wrong -q
  says "MPa" err
}
