# SPDX-License-Identifier: GPL-3.0-or-later
# Cases of program_test.sh for pictures without a display, and for the messages without one; program_test.sh sources
# this file. Argument of the player's cases: spheretree.
unset DISPLAY WAYLAND_DISPLAY  # no case opens a window: tests/view/window_test.py does
export LIBGL_ALWAYS_SOFTWARE=1

# is_png FILE WIDTH HEIGHT
is_png() {
  [ "$(od -An -tu1 -N4 "$1" | tr -s ' ')" = " 137 80 78 71" ] || fail "$1 is no PNG"
  set -- "$1" "$2" "$3" $(od -An -tu1 -j16 -N8 "$1")
  [ $(($6 * 256 + $7)) -eq "$2" ] && [ $((${10} * 256 + ${11})) -eq "$3" ] || fail "$1 is not $2 x $3 pixels"
}

has_view() { "$program" "$@" >out 2>err; ! grep -q "built without its view" err; }

case_player_picture() {
  write_touch "$1"
  write_path path.csv
  has_view scene.json --trajectory path.csv --picture first.png --at 90 --size 320x200 || exit 77
  expect 0 scene.json --trajectory path.csv --picture work/again.png --at 90 --size 320x200
  cmp first.png work/again.png || fail "the same picture twice differs"
  is_png first.png 320 200
  expect 0 scene.json --trajectory path.csv --picture light.png --at 90 --size 320x200 --theme light --show spheres --panels off
  if cmp -s first.png light.png; then fail "another theme gives the same picture"; fi
  # Several, numbered.
  expect 0 scene.json --trajectory path.csv --picture frame.png --at 10:90:40 --size 128x96
  for name in frame.00000 frame.00001 frame.00002; do is_png $name.png 128 96; done
  [ ! -e frame.00003.png ] || fail "one picture too many"
  # A recording shows the same as its run, except for the clock.
  expect 0 scene.json --trajectory path.csv --clock stepped --record run.csv
  expect 0 --replay run.csv --picture replay.png --at 90 --size 400x300
  is_png replay.png 400 300
  expect 0 --replay run.csv --compare run.csv --picture both.png --at 50 --size 640x300
  expect 2 --replay run.csv --picture late.png --at 100
  says "100 steps" err
  expect 2 scene.json --trajectory path.csv --picture late.png --at 5000
  expect 2 scene.json --trajectory path.csv --picture out.jpg
  expect 2 scene.json --picture path.png --at soon
  expect 2 scene.json --picture path.png --size 10x10
  expect 2 --replay run.csv
  expect 2 --compare run.csv
  expect 3 scene.json --trajectory path.csv --picture work/missing/out.png --at 10
  # A recording that is cut off or belongs to another program.
  head -n 5 run.csv | cut -d, -f1-12 >cut.csv
  expect 4 --replay cut.csv --picture out.png
  says "column" err
  sed '4s/^[^,]*,[^,]*/3,soon/' run.csv >soon.csv
  expect 4 --replay soon.csv --picture out.png
  says "line 4" err
}

# write_box FILE LOW_X LOW_Y LOW_Z HIGH_X HIGH_Y HIGH_Z
write_box() {
  for z in "$4" "$7"; do for y in "$3" "$6"; do for x in "$2" "$5"; do echo "v $x $y $z"; done; done; done >"$1"
  printf 'f %s\n' "1 3 4" "1 4 2" "5 6 8" "5 8 7" "1 2 6" "1 6 5" "3 7 8" "3 8 4" "1 5 7" "1 7 3" "2 4 8" "2 8 6" >>"$1"
}

# A cavity in a block of two layers, in pictures of a run and of its recording.
case_player_cavity() {
  write_box block.obj -4 -4 -4 4 4 0
  write_box core.obj -3 -3 -3 3 3 -0.5
  write_box stick.obj -0.2 -0.2 -0.2 0.2 0.2 4
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2},
    "tool": {"name": "stick", "mesh": "stick.obj", "burr": [{"centre_mm": [0, 0, 0], "radius_mm": 0.5}]},
    "objects": [{"name": "block", "mesh": "block.obj", "cut": {"layers": [{"name": "shell", "mesh": "block.obj"},
    {"name": "core", "mesh": "core.obj"}], "removal_mm_per_n_s": {"shell": 5, "core": 5}}}]}' >cut.scene.json
  "$1" batch cut.scene.json -o trees -q >out 2>err || fail "batch: $(cat err)"
  awk 'BEGIN { print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin"
    for (n = 0; n < 800; ++n) printf "%.3f,0,0,%.4f,1,0,0,0,1\n", n / 1000, n < 500 ? 0.8 - 0.004 * n : -2.4 + 0.008 * (n - 300) }' >drill.csv
  seen="--size 320x240 --panels off --from 1,-1,2 --within 2"
  # shellcheck disable=SC2086
  has_view trees/scene.json --trajectory drill.csv --picture run.png --at 700 $seen || exit 77
  expect 0 trees/scene.json --trajectory drill.csv --clock stepped --record run.csv
  # shellcheck disable=SC2086
  expect 0 --replay run.csv --picture replay.png --at 700 $seen
  cmp run.png replay.png || fail "a recording shows another cavity than its run"
  awk -F, -v OFS=, 'NR == 1 { for (k = 1; k <= NF; ++k) if ($k == "spin") at = k } NR > 1 { $at = 0 } { print }' run.csv >rest.csv
  # shellcheck disable=SC2086
  expect 0 --replay rest.csv --picture rest.png --at 700 $seen
  if cmp -s rest.png replay.png; then fail "a burr that rests leaves a cavity"; fi
  expect 2 trees/scene.json --spindle-button 1
  says "devices that a hand holds" err
}

case_player_no_display() {
  write_touch "$1"
  has_view scene.json --view --seconds 0.1 || exit 77
  expect 3 scene.json --view --seconds 0.1
  says "DISPLAY" err
  says "picture" err
  DISPLAY=:7654 expect 3 scene.json --view --seconds 0.1
  # Without arguments it plays the built-in scene and states in one line why there is no window.
  "$program" >out 2>err &
  pid=$!
  for _ in $(seq 150); do
    grep -q "no window" err && break
    sleep 0.1
  done
  sleep 3
  kill -INT $pid
  wait $pid
  [ "$(grep -c "no window" err)" -eq 1 ] || fail "it does not say why there is no window"
  expect 2 scene.json --view --hand-from nose
  expect 2 scene.json --view --hand-from file
}

# Two links: a box, and a mesh with a capsule, which hang on a joint above it. Files arm.urdf, link.obj.
write_arm() {
  sed 's/10/0.1/g' <<END >link.obj
v 0 0 0
v 10 0 0
v 0 10 0
v 0 0 10
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
END
  cat >arm.urdf <<END
<robot name="arm">
<link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="tool"><collision><geometry><mesh filename="link.obj"/></geometry></collision>
<collision><origin xyz="0 0 0.2"/><geometry><capsule radius="0.02" length="0.2"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="tool"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/></joint>
</robot>
END
}

case_view_robot() {
  write_arm
  expect 0 robot arm.urdf -o work/arm --budget 20 --quality quick
  says '"schema": "spheretree.robot/1"' work/arm/robot.json
  says '"urdf": "../../arm.urdf"' work/arm/robot.json
  # The page: every link with its figures, and the robot in 3D.
  expect 0 report work/arm -o arm.html --json
  says '"schema": "spheretree.robot_report/1"' out
  [ "$(grep -c '"uncovered_fraction": 0.0' out)" -eq 2 ] || fail "not two links that are covered"
  says 'Every surface is covered' arm.html
  says 'data-object="1"' arm.html
  expect 2 report work/arm -o arm.html --pages
  says "for a cohort" err
  "$program" view arm.urdf --picture meshes.png --size 400x300 --panels off >out 2>err
  if grep -q "built without its view" err; then exit 77; fi
  is_png meshes.png 400 300
  # The folder opens on the spheres; those of any format, named after the robot, are the same.
  expect 0 view work/arm --picture folder.png --size 400x300 --panels off
  if cmp -s meshes.png folder.png; then fail "the folder does not open on the spheres"; fi
  expect 0 view arm.urdf work/arm/arm.xrdf --picture named.png --size 400x300 --panels off
  cmp folder.png named.png || fail "the folder shows other spheres than its XRDF"
  expect 0 view work/arm --show meshes --picture same.png --size 400x300 --panels off
  cmp meshes.png same.png || fail "the folder shows another robot"
  expect 0 view work/arm --overhang --picture overhang.png --size 400x300 --panels off
  if cmp -s overhang.png folder.png; then fail "no colours of overhang"; fi
  # The folder moves together with the robot, and the unit of the meshes is remembered.
  mkdir moved && cp -r work moved && cp arm.urdf link.obj moved
  expect 0 view moved/work/arm/robot.json --picture moved.png --size 400x300 --panels off
  cmp folder.png moved.png || fail "a moved folder looks different"
  expect 0 robot arm.urdf -o work/small --budget 20 --quality quick --unit 'tool=cm'
  says '"tool=cm"' work/small/robot.json
  expect 0 view work/small --picture small.png --size 400x300
  # What does not belong together, or is missing.
  printf '{"other": {"centers": [[0,0,0]], "radii": [0.5]}}' >other.json
  expect 4 view arm.urdf other.json --picture out.png
  says "has no spheres of a link of arm.urdf" err
  sed -i '/"spheres": "/d' work/small/robot.json
  expect 4 view work/small --picture out.png
  says "is missing or of another type" err
  rm arm.urdf
  expect 3 view work/arm --picture out.png
  expect 3 report work/arm -o out.html
  [ ! -e out.png ] && [ ! -e out.html ] || fail "a refused robot left something"
}

case_view() {
  write_tetrahedron mesh.obj
  write_sph tree.sph
  "$program" view mesh.obj --picture mesh.png --size 200x150 >out 2>err
  if grep -q "built without its view" err; then exit 77; fi
  is_png mesh.png 200 150
  expect 0 view mesh.obj tree.sph --overhang --picture over.png --size 500x300
  expect 0 view mesh.obj tree.sph --overhang --picture again.png --size 500x300
  cmp over.png again.png || fail "the same picture twice differs"
  expect 0 view tree.sph --level 0 --picture root.png --size 200x150 --panels off
  expect 0 view tree.sph --level 1 --picture leaves.png --size 200x150 --panels off
  if cmp -s root.png leaves.png; then fail "two levels look the same"; fi
  expect 0 convert tree.sph object.stree
  printf '{"schema": "spheretree.scene/1", "tool": {"name": "t", "tree": "object.stree"},
    "objects": [{"name": "o", "tree": "object.stree", "mesh": "mesh.obj"}]}' >a.scene.json
  expect 0 view a.scene.json --picture scene.png --size 200x150
  expect 2 view tree.sph tree.sph tree.sph tree.sph tree.sph tree.sph tree.sph --picture many.png
  says "room for 6" err
  # What is not there is not shown in another way.
  expect 2 view tree.sph --level 5 --picture out.png
  says "the deepest tree has the levels 0 to 1" err
  for words in "mesh.obj --overhang" "tree.sph --overhang" "tree.sph mesh.obj --overhang" "mesh.obj --level 0" "mesh.obj --show spheres"; do
    # shellcheck disable=SC2086
    expect 2 view $words --picture out.png
  done
  mkdir -p patient
  expect 3 view patient --picture out.png
  says "patient: neither compare.json nor scene.json nor mouth.scene.json" err
  cp a.scene.json patient/mouth.scene.json
  cp object.stree mesh.obj patient
  expect 0 view patient --picture split.png --size 200x150
  # The colours of a marked mesh, and the pictures of inputs of very different sizes.
  sed '$d' mesh.obj >open.obj
  expect 4 check open.obj -o marked.glb
  expect 0 view open.obj --picture plain.png --size 200x150 --panels off
  expect 0 view marked.glb --picture marked.png --size 200x150 --panels off
  if cmp -s plain.png marked.png; then fail "the marks have no colours"; fi
  sed 's/10/0.1/' mesh.obj >tiny.obj
  expect 0 view mesh.obj tiny.obj --picture scale.png --size 400x200
  expect 0 view mesh.obj tiny.obj --picture fill.png --size 400x200 --fill
  if cmp -s scale.png fill.png; then fail "--fill does nothing"; fi
  # A comparison opens on the spheres, coloured by overhang.
  expect 0 compare mesh.obj -o comparison --builders cover,octree --qualities quick --levels 2 -q
  expect 0 view comparison --picture opens.png --size 400x200
  expect 0 view comparison --overhang --picture overhang.png --size 400x200
  cmp opens.png overhang.png || fail "a comparison does not open on overhangs"
  expect 0 view comparison --show meshes --picture meshes.png --size 400x200
  if cmp -s opens.png meshes.png; then fail "a comparison opens on its meshes"; fi
  # Measured against another mesh than its own: a warning.
  expect 0 build mesh.obj -o own.stree --quality quick --levels 2
  expect 0 view mesh.obj own.stree --overhang --picture own.png --size 200x150
  if grep -q "another mesh" err; then fail "a warning for the right mesh"; fi
  sed 's/10/11/' mesh.obj >other.obj
  expect 0 view other.obj own.stree --overhang --picture other.png --size 200x150
  says "own.stree was built from another mesh than other.obj" err
  expect 0 convert own.stree own.png --mesh mesh.obj --width 200
  if grep -q "another mesh" err; then fail "a warning for the right mesh"; fi
  expect 0 convert own.stree own.png --mesh other.obj --width 200
  says "own.stree was built from another mesh than other.obj" err
  for words in "1,2" "1,2,3,4"; do
    expect 2 view mesh.obj --picture out.png --from $words
    says "--from needs 3 values" err
    expect 2 convert tree.sph out.png --view $words
    says "--view needs 3 values" err
  done
  expect 2 view mesh.obj --picture mesh.gif
  expect 2 view mesh.obj --picture out.png --from 0,0,0
  expect 3 view gone.obj --picture out.png
  expect 3 view mesh.obj
  says "DISPLAY" err
}
