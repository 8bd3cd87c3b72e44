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
  says "nothing holds" err
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
