# SPDX-License-Identifier: Apache-2.0
# Cases of compare and report, for program_test.sh, whose functions they use.

case_compare() {
  write_torus a.obj 12
  write_tetrahedron b.obj
  expect 0 compare a.obj b.obj -o work/c --builders cover,octree --qualities quick,standard --levels 2
  says '^cover            quick ' out
  for file in compare.csv compare.json comparison.svg comparison.pdf a.svg a.pdf b.svg index.html trees/a.cover.quick.stree runs/b.octree.standard.json; do
    [ -s work/c/$file ] || fail "no $file"
  done
  [ "$(ls work/c/trees | wc -l)" -eq 6 ] || fail "not 2 meshes x (2 qualities of cover + the octree)"
  [ "$(wc -l <work/c/compare.csv)" -eq 13 ] || fail "not a line for each level of each run"
  says '^a,cover,quick,[0-9.e-]*,[0-9.e-]*,1,8,' work/c/compare.csv
  says '"schema": "spheretree.comparison/1"' work/c/compare.json
  # Text from outside is text on the pages, not markup.
  cp b.obj '<b>&.obj'
  expect 0 compare '<b>&.obj' -o work/d --builders octree --levels 2
  grep -q '<b>&' work/d/index.html && fail "a file's name became markup"
  expect 3 compare no.obj -o work/e
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
  expect 4 compare a.obj flat.obj -o work/e
  expect 2 compare a.obj -o work/e --builders none
  expect 2 compare a.obj
  [ ! -e work/e/compare.json ] || fail "a refused comparison left a result"
  : >file
  expect 3 compare a.obj -o file
  # An input named twice runs once and has its mean.
  expect 0 compare b.obj -o work/t --builders cover,cover --qualities quick,quick --levels 2
  [ "$(grep -c '^cover            quick ' out)" -eq 1 ] || fail "not one mean for a builder that is named twice"
  # The table of stability, which is continued like the runs.
  expect 0 compare b.obj -o work/s --builders octree --levels 2
  grep -q 'Stability' work/s/index.html && fail "a table that was not asked for"
  expect 0 compare b.obj -o work/s --builders cover,octree --qualities quick --levels 2 --stability 2
  says '"change": "rotation"' work/s/compare.json
  says '"cases": 2' work/s/compare.json
  says 'Largest change over all meshes' work/s/index.html
  says 'same spheres' work/s/index.html
  [ -s work/s/runs/b.cover.quick.stability.json ] || fail "no file of the stability of a run"
  sed -i 's/"largest_change": [0-9.e+-]*/"largest_change": 7/' work/s/runs/b.cover.quick.stability.json
  expect 0 compare b.obj -o work/s --builders cover,octree --qualities quick --levels 2 --stability 2
  says '"largest_change": 7' work/s/compare.json
  expect 0 compare b.obj -o work/s --builders cover,octree --qualities quick --levels 2 --stability 3
  grep -q '"largest_change": 7' work/s/compare.json && fail "other rotations, the old table"
  expect 2 compare b.obj -o work/s --stability -1
}

# Spheres of other programs: a ball around everything, one that contains nothing, one without volume.
case_compare_spheres() {
  write_torus a.obj 12
  write_tetrahedron b.obj
  printf '{"a": {"centers": [[0,0,0]], "radii": [0.5]}, "b": {"centers": [[0,0,0],[1,0,0]], "radii": [1e-6,0]}}' >both.json
  printf '[{"center": [0,0,0], "radius": 500}]' >'only.json'
  expect 0 compare a.obj b.obj -o work/o --builders octree --qualities quick --levels 2 --spheres both.json
  says 'both.json: 1 sphere with a radius of 0 or below left out' err
  says '^a,both,,,,[0-9]*,1,[0-9.e+-]*,[0-9.e+-]*,[0-9.e+-]*,[0-9.e+-]*,0.0,' work/o/compare.csv
  says '^b,both,,,,[0-9]*,1,[0-9.e+-]*,[0-9.e+-]*,[0-9.e+-]*,[0-9.e+-]*,1.0,' work/o/compare.csv
  says 'Spheres against accuracy' work/o/a.svg
  says 'Spheres of other programs' work/o/index.html
  cp work/o/index.html before.html
  expect 0 report work/o -o work/again.html
  cmp -s before.html work/again.html || fail "the page that report makes again is another one"
  expect 0 compare a.obj -o work/o --builders octree --qualities quick --levels 2 --spheres only.json --spheres-unit mm
  says '^a,only,,,' work/o/compare.csv
  # From a file with many links, those with the mesh's name; without such a name, the message lists the names.
  cp b.obj c.obj
  expect 4 compare c.obj -o work/p --builders octree --levels 2 --spheres both.json
  says 'has spheres for a, b, and no mesh has this name' err
  expect 3 compare c.obj -o work/p --builders octree --levels 2 --spheres none.json
  expect 2 compare c.obj -o work/p --builders octree --levels 2 --spheres both.json --spheres-unit yard
  [ ! -e work/p/compare.json ] || fail "a refused comparison left a result"
}

# Other programs in the chart of speed: a list with their times.
case_compare_against() {
  write_torus a.obj 12
  expect 0 build a.obj -o other.stree --builder octree --levels 2 -q
  expect 0 convert other.stree other.sph -q
  printf 'name,mesh,seconds,file\ntheirs,a,74.4,other.sph\nothers,a,0.5,other.stree\n' >list.csv
  expect 0 compare a.obj -o work/a --builders octree,octree+search --qualities quick --levels 2 --against list.csv
  says '^a,theirs,,,74.4,' work/a/compare.csv
  says '^a,octree+search,quick,' work/a/compare.csv
  says 'theirs: 74.4 s' work/a/a.svg
  says '<rect class="c' work/a/a.svg
  expect 0 report work/a -o work/again.html
  cmp -s work/a/index.html work/again.html || fail "the page that report makes again is another one"
  printf 'name,mesh,seconds,file\ntheirs,b,74.4,other.sph\n' >list.csv
  expect 4 compare a.obj -o work/b --builders octree --levels 2 --against list.csv
  says 'list.csv, line 2: column 2 (mesh) is "b": not the name of a mesh' err
  printf 'name,mesh,file\n' >list.csv
  expect 4 compare a.obj -o work/b --builders octree --levels 2 --against list.csv
  says 'name,mesh,seconds,file' err
}

# An interrupted run continues where it was, and changed inputs are run again.
case_compare_goes_on() {
  write_torus a.obj 12
  write_tetrahedron b.obj
  expect 0 compare a.obj b.obj -o work/c --builders octree,grid --qualities quick --levels 2
  rm work/c/runs/a.grid.quick.json work/c/compare.json work/c/trees/b.octree.quick.stree
  printf '{"half' >work/c/runs/b.grid.quick.json
  touch -d '2001-01-01' work/c/trees/*
  expect 2 compare a.obj b.obj -o work/c --builders octree,grid --qualities quick --levels 2
  says "work/c/runs/b.grid.quick.json" err  # a file that was edited
  expect 0 compare a.obj b.obj -o work/c --builders octree,grid --qualities quick --levels 2 --force
  new=$(find work/c/trees -name '*.stree' -newermt '2002-01-01' | sort | tr '\n' ' ')
  [ "$new" = "work/c/trees/a.grid.quick.stree work/c/trees/b.grid.quick.stree work/c/trees/b.octree.quick.stree " ] || fail "done again: $new"
  touch -d '2001-01-01' work/c/trees/*
  write_torus a.obj 13
  expect 0 compare a.obj b.obj -o work/c --builders octree,grid --qualities quick --levels 2
  new=$(find work/c/trees -name '*.stree' -newermt '2002-01-01' | sort | tr '\n' ' ')
  [ "$new" = "work/c/trees/a.grid.quick.stree work/c/trees/a.octree.quick.stree " ] || fail "after a change done again: $new"
  # Ctrl-C: finished runs are kept, and no incomplete file is there.
  write_torus large.obj 60
  "$program" compare large.obj -o work/k --builders octree,cover --qualities best >out 2>err &
  job=$!
  for i in $(seq 3000); do [ -e work/k/runs/large.octree.best.json ] && break; sleep 0.1; done
  kill -TERM $job
  wait $job
  [ $? -eq 130 ] || fail "exit code of an interrupted comparison"
  [ -e work/k/runs/large.octree.best.json ] || fail "the finished run is gone"
  [ ! -e work/k/runs/large.cover.best.json ] || fail "an unfinished run passes for a whole one"
  [ ! -e work/k/compare.json ] || fail "an interrupted comparison left a result"
}

# A recording of 50 steps: a force of 1 N along z, the hand moving along x.
write_recording() {
  awk 'BEGIN {
    print "tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,pairs,rows,active,qp_iterations,faults,find_us,rows_us,qp_us,total_us"
    for (i = 0; i < 50; ++i)
      printf "%d,%.3f,%.2f,0,0,1,0,0,0,%.2f,0,0.5,1,0,0,0,0,0,%d,0,0,0,4,2,1,1,0,1,1,1,3\n", i, i / 1000, i / 10, i / 10, i % 2
  }' >"$1"
}

case_report() {
  write_torus a.obj 12
  write_tetrahedron b.obj
  expect 0 compare a.obj b.obj -o work/c --builders octree --levels 2
  expect 0 report work/c -o comparison.html --json
  says '"schema": "spheretree.comparison/1"' out
  cmp -s comparison.html work/c/index.html || fail "the page of a comparison is not that of compare"
  rm b.obj  # the page still opens, without that mesh
  expect 0 report work/c -o comparison.html
  says 'could not be read any more: b' comparison.html

  printf '{"schema": "spheretree.scene/1", "defaults": {"levels": 2}, "tool": {"name": "tip", "mesh": "a.obj"}, "objects": [{"name": "ring", "mesh": "a.obj"}, {"name": "bad", "mesh": "no.obj"}]}' >s.scene.json
  expect 6 batch s.scene.json -o work/b
  write_recording r.csv
  expect 0 report work/b -o batch.html --recording r.csv
  says '1 object of 3 failed' batch.html
  says 'Show its worst spot">ring' batch.html
  expect 0 report r.csv --scene work/b/scene.json -o run.html --json
  says '"largest_force_n": 1.0' out
  expect 0 report r.csv -o run.html
  says '1 N</b>' run.html

  expect 3 report work -o x.html
  expect 3 report no.csv -o x.html
  expect 2 report r.csv -o x.html --recording r.csv
  expect 2 report work/b -o x.html --scene work/b/scene.json
  expect 4 report s.scene.json -o x.html
  mkdir work/s
  printf '{"schema": "spheretree.stability/2"}' >work/s/stability.json
  expect 4 report work/s -o x.html
  printf '{"schema": "spheretree.stability/1", "scenarios": [{"id": "F1"}]}' >work/s/stability.json
  expect 4 report work/s -o x.html
  says 'is missing or of another type' err
  printf '{"schema": "spheretree.comparison/1", "meshes": 3, "runs": {}}' >work/c/compare.json
  expect 4 report work/c -o x.html
  [ ! -e x.html ] || fail "a refused report left a page"
}

# The pages in a browser: no error, no request, and the view responds.
case_page_in_browser() {
  write_torus a.obj 16
  write_torus b.obj 12
  expect 0 compare a.obj b.obj -o work/c --builders cover,octree --qualities quick --levels 3
  "$@" work/c/index.html --max-bytes 2000000 >out 2>&1
  code=$?
  [ $code -eq 77 ] && exit 77
  [ $code -eq 0 ] || fail "$(cat out)"
  printf '{"schema": "spheretree.scene/1", "defaults": {"levels": 3, "quality": "quick"}, "tool": {"name": "tip", "mesh": "b.obj"}, "objects": [{"name": "coarse", "mesh": "b.obj", "quality": "quick", "levels": 2, "position_mm": [60, 0, 0]}, {"name": "ring", "mesh": "a.obj", "position_mm": [30, 0, 0]}, {"name": "other", "mesh": "a.obj"}]}' >s.scene.json
  expect 0 batch s.scene.json -o work/b
  write_recording r.csv
  expect 0 report work/b -o batch.html --recording r.csv
  "$@" batch.html >out 2>&1 || fail "$(cat out)"
  expect 0 report r.csv -o run.html
  "$@" run.html >out 2>&1 || fail "$(cat out)"
}
