# SPDX-License-Identifier: Apache-2.0
# Messages of the program and their streams: cases of program_test.sh, whose functions they use.

# says_in_a_line PATTERN: stderr is one line with PATTERN.
says_in_a_line() {
  says "$1" err
  [ "$(wc -l <err)" -eq 1 ] || fail "not one line"
}

# Suggestions only if one is close; a prefix has priority.
case_mistyped() {
  write_tetrahedron mesh.obj
  for pair in "--tol --tolerance" "--tol=3 --tolerance" "--out --output" "--qualty --quality" "--thread --threads"; do
    expect 2 build mesh.obj -o work/a.stree "${pair% *}"
    says_in_a_line "the nearest is '${pair#* }'"
  done
  for option in --scale --dry-run --version -x; do
    expect 2 build mesh.obj -o work/a.stree $option
    says_in_a_line "unknown option '$option' of build. See"
  done
  expect 2 biuld
  says_in_a_line "the nearest is 'build'"
  expect 2 paint
  says_in_a_line "unknown verb 'paint'. See"
  expect 2 --verbose build
  says_in_a_line "unknown option '--verbose'"
  expect 2 xyz build
  says_in_a_line "unknown verb 'xyz'"
  expect 2 help nothing
  says_in_a_line "unknown verb 'nothing'"
  expect 0 help
  says "^  build" out
  expect 0 help build
  says "^  --tolerance" out
  expect 0 help scene
  says "spheretree.scene/1" out
  says "^  -o, --output" out
  expect 2 build mesh.obj -o work/a.stree --quality quick --quality best
  says_in_a_line "quality is given more than once"
  expect 2 build mesh.obj -o work/a.stree --tolerance
  says_in_a_line "tolerance needs a value"
  expect 2 build mesh.obj more.obj -o work/a.stree
  says_in_a_line "several meshes need a folder"
  expect 2 evaluate mesh.obj a.stree more.obj
  says_in_a_line "unexpected argument 'more.obj' of evaluate"
  is_empty work
  # After -- every argument is a file name.
  cp mesh.obj ./-dash.obj
  expect 0 -q build -o work/a.stree --quality quick --levels 2 -- -dash.obj
  [ ! -s err ] || fail "-q before the verb is not quiet"
  expect 2 build -- -dash.obj -o work/b.stree
  says_in_a_line "output is required"
  expect 2 repair -- -dash.obj -o work/b.ply
  says_in_a_line "unexpected argument '-o' of repair: after --"
}

# Messages are our own, not a library's, and state where a text stops being JSON.
case_no_json() {
  write_tetrahedron mesh.obj
  cp mesh.obj mesh.json
  expect 4 batch mesh.json -o work/a
  says_in_a_line "mesh.json: is a mesh (OBJ), not a scene"
  expect 0 build mesh.obj -o tree.stree --levels 2 --quality quick
  cp tree.stree tree.json
  expect 4 batch tree.json -o work/a
  says_in_a_line "tree.json: is a sphere-tree (.stree), not a scene"
  expect 4 check tree.stree
  says_in_a_line "tree.stree: is a sphere-tree (.stree), not a mesh"
  while IFS='|' read -r text place advice; do
    printf '%b' "$text" >bad.json
    expect 4 batch bad.json -o work/a
    says_in_a_line "bad.json: $place: is not JSON: $advice"
    if grep -q 'json.exception' err; then fail "the words of a library"; fi
  done <<'END'
{"schema": NaN}|line 1, column 12|JSON has no NaN
// mine\n{}|line 1, column 1|JSON has no comments
{"a": 1,\n }|line 2, column 2|a comma before a closing bracket
{"a": 1|line 1, column 8|it ends too early
{'a': 1}|line 1, column 2|texts stand in double
{"a": tru}|line 1, column 7|something else is expected at "tru}"
END
  printf '{"a": 1e999}' >bad.json
  expect 4 batch bad.json -o work/a
  says_in_a_line "is too large"
  printf '{"schema": "spheretree.scene/1", "unit": "mm", "unit": "cm"}' >bad.json
  expect 4 batch bad.json -o work/a
  says_in_a_line 'the key "unit" stands twice in one object'
}

# Names from outside can neither break a line nor send commands to the terminal.
case_control_characters() {
  name=$(printf 'a\nb.obj')
  expect 3 check "$name"
  says_in_a_line '^spheretree: a\\nb.obj: cannot be read'
  write_tetrahedron "$name"
  expect 0 check "$name"
  says '^a\\nb.obj: OBJ' out
  { printf 'g red\033[31m\007\n'; cat "$name"; } >colours.obj
  expect 0 check colours.obj --list-parts
  says 'red\\x1b\[31m\\x07' out
  if grep -q "$(printf '\033')" out; then fail "an escape sequence went out"; fi
}

# The message names the option that limits the result.
case_advice() {
  write_tetrahedron mesh.obj
  expect 5 build mesh.obj -o work/a.stree --quality quick --tolerance 0.001 --leaves 20
  says_in_a_line "Allow more --leaves or a larger --tolerance"
  expect 5 build mesh.obj -o work/a.stree --quality quick --tolerance 0.001 --levels 2
  says_in_a_line "Allow more --levels or a larger --tolerance"
}

# --unit is the unit of the numbers in the file, for every verb and every format.
case_units() {
  write_tetrahedron mesh.obj
  expect 0 build mesh.obj -o tree.stree --quality quick --levels 2 --unit cm
  expect 0 convert tree.stree tree.glb  # a GLB, in metres
  expect 4 check tree.glb --json
  metres=$(grep -A 4 '"high"' out | sed -n '2s/[ ,]//gp')
  for unit in mm cm in; do
    expect 4 check tree.glb --json --unit $unit
    if grep -q 'unit given' out; then fail "a note where the unit is used"; fi
    own=$(grep -A 4 '"high"' out | sed -n '2s/[ ,]//gp')
    case $unit in mm) factor=1000 ;; cm) factor=100 ;; in) factor=39.370078740157 ;; esac
    awk -v a="$metres" -v b="$own" -v f=$factor 'BEGIN { exit !(a / b / f > 0.999999 && a / b / f < 1.000001) }' || fail "$unit: $own of $metres"
  done
  # An object and the tool may have different units.
  printf '{"schema": "spheretree.scene/1", "unit": "cm", "defaults": {"quality": "quick", "levels": 2},
    "tool": {"name": "tool", "mesh": "mesh.obj", "unit": "mm"}, "objects": [{"name": "a", "mesh": "mesh.obj"}]}' >a.scene.json
  expect 0 batch a.scene.json -o work/b
  expect 0 inspect work/b/tool.stree
  says "unit 1 mm" out
  expect 0 inspect work/b/a.stree
  says "unit 10 mm" out
}

# A part may be a component, as counted by check --list-parts.
case_components() {
  write_tetrahedron one.obj
  { cat one.obj; printf 'v 40 0 0\nv 53 0 0\nv 40 11 0\nv 40 0 9\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n'; } >both.obj
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2}, "tool": {"name": "tool", "mesh": "one.obj"},
    "objects": [{"name": "left", "mesh": "both.obj", "part": "#0"}, {"name": "right", "mesh": "both.obj", "part": "#1"}%s]}' "" >a.scene.json
  expect 0 batch a.scene.json -o work/a
  expect 0 build both.obj --parts '#1' -o right.stree --quality quick --levels 2
  cmp right.stree work/a/right.stree || fail "another component than of build"
  expect 0 report work/a -o work/a.html
  # With --components each of them becomes an object; names keep letters of every script.
  expect 0 scene both.obj -o work/one.scene.json
  [ "$(grep -c '"part"' work/one.scene.json)" = 0 ] || fail "parts of a file without parts"
  cp both.obj 上颌.obj
  expect 0 scene 上颌.obj --components -o work/c.scene.json
  says '"name": "上颌_1"' work/c.scene.json
  says '"part": "#1"' work/c.scene.json
  expect 0 batch work/c.scene.json -o work/c --dry-run
  says "3 to build" out
  sed 's/#1/#2/' a.scene.json >b.scene.json
  expect 6 batch b.scene.json -o work/b
  says "right: the mesh has no component #2; it has 2" err
}

# The batch and its page report repairs, the largest change first.
case_repairs_are_said() {
  write_tetrahedron whole.obj
  grep -v 'f 2 3 4' whole.obj >open.obj
  sed 's/^f \(.\) \(.\) \(.\)/f \3 \2 \1/' whole.obj >turned.obj
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2}, "tool": {"name": "tool", "mesh": "whole.obj"},
    "objects": [{"name": "turned", "mesh": "turned.obj"}, {"name": "open", "mesh": "open.obj"}, {"name": "whole", "mesh": "whole.obj"}]}' >a.scene.json
  for run in first again; do
    expect 0 batch a.scene.json -o work/a
    says "^2 meshes repaired, 1 by more than the tolerance, a hundredth of the object or a tenth of its triangles" out
    says "^! open: 1 opening closed" out
    says "^  turned: " out
    [ "$(grep -n '^! open' out | cut -d: -f1)" -lt "$(grep -n '^  turned' out | cut -d: -f1)" ] || fail "$run: not the largest first"
  done
  says '"repair_large": true' work/a/report.json
  says '"change_mm"' work/a/report.json
  expect 0 report work/a -o work/a.html
  says "1 opening closed" work/a.html
  if grep -q 'class="good">All 4 trees' work/a.html; then fail "all is good on the page of a batch with a large repair"; fi
  # A reference point that is not near the tool.
  sed 's/"mesh": "whole.obj"}, "objects"/"mesh": "whole.obj", "reference_point_mm": [0, 0, 90]}, "objects"/; s/}$/}/' a.scene.json |
    sed 's/"mesh": "whole.obj"},$/"mesh": "whole.obj", "reference_point_mm": [0, 0, 90]},/' >far.scene.json
  expect 0 batch far.scene.json -o work/far
  says "the reference point of the tool is 80 mm away from it" err
  sed 's/"reference_point_mm": \[0, 0, 90\]/"reference_point": "centre"/' far.scene.json >centre.scene.json
  expect 0 batch centre.scene.json -o work/centre
  [ "$(tr -d ' \n' <work/centre/scene.json | sed 's/.*"reference_point_mm":\[\([^]]*\)\].*/\1/')" = "5.0,5.0,5.0" ] || fail "not the centre of the box"
}

# The mesh that a build uses, as a file.
case_repair() {
  write_tetrahedron whole.obj
  grep -v 'f 2 3 4' whole.obj >open.obj
  expect 0 repair open.obj -o work/a.ply
  says "work/a.ply: 4 triangles, sound" out
  says "1 opening closed" out
  expect 0 check work/a.ply
  # The tree of the repaired mesh is that of the input, except for names.
  expect 0 build open.obj -o a.stree --levels 2 --quality quick -q
  expect 0 build work/a.ply -o b.stree --levels 2 --quality quick -q
  for name in a b; do "$program" convert $name.stree - --to csv >$name.csv || fail "no list of $name"; done
  cmp a.csv b.csv || fail "the repaired mesh gives another tree"
  expect 0 repair whole.obj -o work/a.obj --json
  says '"schema": "spheretree.repair/1"' out
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
  expect 4 repair flat.obj -o work/b.ply
  [ ! -e work/b.ply ] || fail "a mesh that cannot be repaired was written"
  expect 2 repair whole.obj -o work/b.stl
  # The exit code of check, for use in scripts.
  expect 4 check open.obj
  expect 0 check open.obj --fail-on unfixable
  expect 4 check flat.obj --fail-on unfixable
  expect 0 check flat.obj --fail-on nothing
}

# Spheres in the formats of robot programs, in any unit; a GLB of one level.
case_lists() {
  write_sph a.sph
  expect 0 convert a.sph work/a.csv
  [ "$(cat work/a.csv)" = "$(printf 'x_mm,y_mm,z_mm,radius_mm\n0.5,0,0,1.25\n-0.5,0.10000000149011612,0,1.125')" ] || fail "$(cat work/a.csv)"
  expect 0 convert a.sph -o work/a.yaml --unit m --level 0
  [ "$(cat work/a.yaml)" = "$(printf '# unit: m\ncollision_spheres:\n  - center: [0, 0, 0]\n    radius: 0.002')" ] || fail "$(cat work/a.yaml)"
  expect 0 convert a.sph work/a.json --level 1 --unit m
  tr -d ' \n' <work/a.json >flat
  says '^{"unit":"m","a":\[{"origin":\[0.0005,0.0,0.0\],"radius":0.00125},{"origin":\[-0.0005,0.0001' flat
  # Every list is read in its own unit: the same figures.
  write_tetrahedron mesh.obj
  for list in "b.csv" "b.csv --unit m" "b.yaml --unit cm" "b.json --level 1 --unit in" "b.json --level 1 --unit mm"; do
    rm -f work/b.*
    expect 0 convert a.sph work/$list
    expect 0 evaluate mesh.obj work/${list%% *} --no-limits
    sed -n '/^ *[0-9] /p' out >figures
    [ -s first ] || cp figures first
    cmp -s figures first || fail "$list has other figures: $(cat out)"
  done
  printf 'x,y,z,radius\n5,5,0,8\n' >work/bare.csv
  expect 0 evaluate mesh.obj work/bare.csv --no-limits --spheres-unit m
  says "times as large as the mesh: --spheres-unit mm makes them fit" err
  printf 'x,y,z\n1,2,3\n' >work/bad.csv
  expect 4 evaluate mesh.obj work/bad.csv
  says "radius" err
  expect 2 convert a.sph work/b.csv --level 2
  says_in_a_line "the tree has the levels 0 to 1"
  expect 0 convert a.sph work/all.glb
  expect 0 convert a.sph work/one.glb --level 1
  [ "$(wc -c <work/one.glb)" -lt "$(wc -c <work/all.glb)" ] || fail "--level leaves nothing out"
  # A viewer shows the leaves first: the root's sphere would hide them.
  expect 4 check work/all.glb --json
  says '"sphere_1"' out
  if grep -q '"sphere_0"' out; then fail "the root is shown with its leaves"; fi
}

# Several files at once, the folder of a batch, and a quick look at a scene.
case_several() {
  write_tetrahedron a.obj
  sed 's/10/12/' a.obj >b.obj
  expect 0 check a.obj b.obj
  [ "$(grep -c 'no defects' out)" -eq 2 ] || fail "not both were checked"
  expect 0 check a.obj b.obj --json
  says '"file": "b.obj"' out
  expect 0 build a.obj b.obj -o trees --levels 2 --quality quick
  expect 0 inspect trees/a.stree trees/b.stree
  [ "$(grep -c ': sound' out)" -eq 2 ] || fail "not both were inspected"
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
  expect 6 build flat.obj a.obj -o work/more --levels 2 --quality quick
  says_in_a_line "flat.obj: the mesh is refused"
  [ "$(ls work/more)" = a.stree ] || fail "in the folder: $(ls work/more)"
  mkdir other
  cp b.obj other/a.obj
  expect 2 build a.obj other/a.obj -o work/twins --levels 2
  says_in_a_line "named for two outputs"
  cp trees/a.stree cut.stree
  head -c 300 trees/b.stree >bad.stree
  expect 4 inspect bad.stree cut.stree --json
  says '"valid": false' out
  says '"valid": true' out
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "best", "levels": 2, "builder": "octree"}, "tool": {"name": "tool", "mesh": "a.obj"},
    "objects": [{"name": "a", "mesh": "a.obj", "tolerance_mm": 0.1}]}' >a.scene.json
  expect 0 batch a.scene.json -o work/quick --quality quick --builder cover --tolerance 5 -j 1
  expect 0 inspect work/quick/a.stree
  says "builder cover, quality quick" out
  says "tolerance   5 mm" out
  # Only lists the trees that would be built.
  expect 0 batch a.scene.json -o work/none --dry-run
  says "work/none: 2 to build, 0 unchanged, 0 cannot be read; nothing was written" out
  [ ! -e work/none ] || fail "a dry run made a folder"
  expect 0 batch a.scene.json -o work/quick --dry-run --quality quick --builder cover --tolerance 5
  says "work/quick: 0 to build, 2 unchanged" out
  expect 2 batch a.scene.json -o work/none --dry-run --budget 100
}
