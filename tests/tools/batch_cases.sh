# SPDX-License-Identifier: Apache-2.0
# Cases of program_test.sh for `spheretree batch`; program_test.sh sources this file.

# write_scene FILE MORE_OBJECTS: a tetrahedron as tool, two parts of one file as objects.
write_scene() {
  write_tetrahedron tool.obj
  printf 'g left\n' >pair.obj
  write_tetrahedron part.obj
  cat part.obj >>pair.obj
  printf 'g right\nv 20 0 0\nv 33 0 0\nv 20 11 0\nv 20 0 9\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n' >>pair.obj
  cat >"$1" <<END
{"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 3},
 "tool": {"name": "tool", "mesh": "tool.obj"},
 "objects": [{"name": "left", "mesh": "pair.obj", "part": "left", "position_mm": [1, 2, 3]},
             {"name": "right", "mesh": "pair.obj", "part": "right", "quaternion_wxyz": [0, 0, 1, 0]}$2]}
END
}

case_scene() {
  write_scene unused.scene.json ""  # its meshes
  mkdir -p sub
  expect 0 scene pair.obj tool.obj -o sub/a.scene.json --tolerance 1.5 --match 'l*=1' --match 'left=2' --reach 0.1
  says "2 objects, tool tool" out
  says '"mesh": "../pair.obj", "part": "left"' sub/a.scene.json
  says '"tolerance_mm": 2.0' sub/a.scene.json
  says '"reach": {"radius_mm": 0.1, "tolerance_mm": 10.0}' sub/a.scene.json
  expect 0 batch sub/a.scene.json -o out_scene --quality quick
  says "3 built, 0 unchanged, 0 failed" out
  # Without a tool: a ball is the tool and is written, too.
  expect 0 scene pair.obj -o b.scene.json
  says "the tool is a ball of 1 mm" err
  [ -s ball.obj ] || fail "no ball"
  # A file in another unit.
  sed 's/^v \([0-9]*\) \([0-9]*\) \([0-9]*\)/v \1e-3 \2e-3 \3e-3/' tool.obj >small.obj
  expect 0 scene small.obj -o c.scene.json
  says "small.obj: the diagonal is 0.0173 mm, very small: --unit m makes it 17.3 mm" err
  expect 0 scene small.obj -o c.scene.json --unit m
  says '"unit": "m"' c.scene.json
  expect 2 scene pair.obj -o d.scene.json --match 'x*=1'
  expect 2 scene pair.obj -o d.scene.json --match 'left=0'
  expect 2 scene pair.obj -o d.scene.json --tool lift
  says "the nearest is left" err
  expect 2 scene tool.obj -o d.scene.json --tool tool
  says "no object" err
  expect 2 scene pair.obj -o pair.obj
  expect 2 scene pair.obj -o d.scene.json --reach 1
  expect 2 scene - -o d.scene.json
  expect 3 scene gone.obj -o d.scene.json
  [ ! -e d.scene.json ] || fail "something was written"
  # An output that would replace an input is refused, and the input is unchanged.
  cp tool.obj ball.obj && cp ball.obj before.obj
  expect 2 scene ball.obj pair.obj -o e.scene.json --tool nothing
  expect 0 scene ball.obj pair.obj -o e.scene.json
  cmp ball.obj before.obj || fail "an input was replaced"
  [ -s ball_2.obj ] || fail "no second ball"
}

# split MAKE_SCANS
case_split() {
  "$1" scans edge=0.9 || fail "make_scans"
  "$program" split scans/upper.obj scans/lower.obj --labels scans/upper.json scans/lower.json --opening 25 -o patient \
    --marked patient/marked.glb >out 2>err
  code=$?
  says "28 teeth, 2 gums; 0 refused" out
  # Exit code 5 and findings occur together.
  if grep -q '"state": "crosses"' patient/split.json; then [ $code = 5 ] && says "finding: " err; else [ $code = 0 ]; fi ||
    fail "exit code $code does not go with the findings"
  for part in tooth_11 tooth_27 tooth_36 tooth_47 gum_upper gum_lower; do
    [ -s patient/$part.ply ] || fail "no $part"
    expect 0 check patient/$part.ply
  done
  says '"schema": "spheretree.split/1"' patient/split.json
  [ -s patient/marked.glb ] || fail "nothing marked in the folder of the parts"
  expect 0 batch patient/mouth.scene.json -o trees --dry-run
  says "31 to build" out
  # The same jaw twice gives the same parts; labels in a PLY are equivalent to those in a JSON file.
  expect 0 split scans/upper.obj --labels scans/upper.json -o one --json
  says '"jaw": "upper"' out
  cmp one/tooth_16.ply patient/tooth_16.ply || fail "a tooth depends on the other jaw"
  # Inputs that do not match are refused, and nothing is written.
  expect 4 split scans/lower.obj --labels scans/upper.json -o x
  says "labels, and the scan has" err
  sed 's/"labels": \[0/"labels": [-1/;s/"labels": \[\([1-9]\)/"labels": [-\1/' scans/upper.json >bad.json
  expect 4 split scans/upper.obj --labels bad.json -o x
  says "labels\[0\]" err
  expect 2 split scans/upper.obj -o x/inner
  expect 2 split scans/upper.obj --labels scans/upper.json --parts -o x
  expect 2 split scans/upper.obj --labels scans/upper.json --opening 20 -o x
  expect 4 split scans/upper.obj scans/upper.obj --labels scans/upper.json scans/upper.json -o x
  says "both scans are of the upper jaw" err
  expect 3 split scans/upper.obj --labels scans/upper.json -o x --marked nowhere/marked.glb
  expect 4 split scans/upper.obj --label-property label -o x/inner
  says "only PLY has properties" err
  [ ! -e x ] || fail "a refused split left a folder"
}

# A small lower scan: a sheet of 61 x 31 vertices with three crowns, 44 to 46, and its labels in every form.
write_scans() {
  cat >scans.py <<'EOF'
import json, math, struct
V, F, L = [], [], []
for j in range(31):
    for i in range(61):
        x, y, z, label = 0.65 * i - 19.5, 0.65 * j - 9.75, 0, 0
        for k, number in enumerate((44, 45, 46)):
            r = math.hypot(x - 11 * (k - 1), y) / 4.6
            if r < 1:
                label, z = number, 6 * (1 - r * r) ** 0.4
        V.append((x, y, z)), L.append(label)
for j in range(30):
    for i in range(60):
        a = 61 * j + i
        F += [(a, a + 1, a + 62), (a, a + 62, a + 61)]
face = [sorted(L[v] for v in f)[1] for f in F]
def labels(name, values, **more):
    json.dump({"jaw": "lower", "labels": values, **more}, open(name, "w"))
def obj(name, more=""):
    open(name, "w").write(more + "".join("v %.9g %.9g %.9g\n" % v for v in V) + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in F))
def ply(name, vertex, face_colours):
    head = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(V) + "".join("property float %s\n" % c for c in "xyz")
    colour = "".join("property uchar %s\n" % c for c in ("red", "green", "blue"))
    head += colour + "element face %d\nproperty list uchar int vertex_indices\n" % len(F) + colour + "end_header\n"
    rgb = lambda n: "%d %d %d" % (n * 5 % 256, 100, n % 7)
    open(name, "w").write(head + "".join("%.9g %.9g %.9g %s\n" % (*v, rgb(n)) for v, n in zip(V, vertex))
                          + "".join("3 %d %d %d %s\n" % (*f, rgb(n)) for f, n in zip(F, face_colours)))
obj("s.obj"), obj("lps.obj", "# SPACE=LPS\n")
obj("ras.obj", "# SPACE=RAS\n")
mixed = [F[k * 7919 % len(F)] for k in range(len(F))]
with open("s.stl", "wb") as f:
    f.write(bytes(80) + struct.pack("<I", len(F)))
    for t in mixed:
        f.write(struct.pack("<12fH", 0, 0, 0, *(c for v in t for c in V[v]), 0))
labels("plain.json", L), labels("faces.json", face), labels("floats.json", [float(n) for n in L], instances=[-1])
json.dump({"jaw": "Mandible", "labels": L}, open("word.json", "w"))
labels("gum18.json", [n or 18 for n in L]), labels("upper.json", [{44: 11, 45: 21, 46: 22}.get(n, 0) for n in L], jaw="upper")
first = list(dict.fromkeys(v for t in mixed for v in t))
labels("first.json", [L[v] for v in first])
ply("faces.ply", [0] * len(V), face), ply("vertices.ply", L, [0] * len(F))
# Closed: a skirt and a base under the sheet.
rim = [*range(61), *(61 * j + 60 for j in range(1, 31)), *(61 * 30 + i for i in range(59, -1, -1)), *(61 * j for j in range(29, 0, -1))]
top, n = len(V), len(rim)
V += [(V[v][0], V[v][1], -8.0) for v in rim] + [(0, 0, -8.0)]
for k in range(n):
    a, b, c, d = rim[k], rim[(k + 1) % n], top + k, top + (k + 1) % n
    F += [(b, a, c), (b, c, d), (d, c, top + n)]
obj("closed.obj"), labels("closed.json", L + [0] * (n + 1))
EOF
  python3 scans.py || fail "scans.py"
}

# Labels of every form give the same teeth.
case_labels() {
  write_scans
  expect 0 split s.obj --labels plain.json -o plain
  says "3 teeth, 1 gum" out
  says "^next: spheretree batch" out
  for labels in floats word; do
    expect 0 split s.obj --labels $labels.json -o $labels
    cmp $labels/tooth_45.ply plain/tooth_45.ply || fail "$labels"
  done
  expect 0 split s.stl --labels plain.json -o sorted
  says "in the order of y, x, z" err
  expect 0 split s.stl --labels first.json -o first
  says "in the order of their first places" err
  for part in tooth_44 tooth_45 tooth_46 gum_lower; do cmp sorted/$part.ply first/$part.ply || fail "$part"; done
  expect 0 split s.obj --labels faces.json -o faces
  says "the labels are taken for the 3600 faces" err
  says "3 teeth, 1 gum" out
  # The colours of one side vary; nothing tells the jaw.
  for side in vertices faces; do
    expect 0 split $side.ply --label-property colour -o $side
    says "the colour of the $side is taken, with 4 different values" err
    says "jaw unknown" err
    [ -s $side/gum.ply ] || fail "no gum.ply"
  done
  expect 4 split faces.ply --label-property colour --label-side vertices -o x
  expect 0 split faces.ply --label-property colour --jaw lower -o lower
  [ -s lower/gum_lower.ply ] || fail "no gum_lower.ply"
  # A gum that is numbered as a tooth.
  expect 4 split s.obj --labels gum18.json -o x
  says "add --gum-label 18" err
  expect 0 split s.obj --labels gum18.json --gum-label 18 -o gum18
  cmp gum18/tooth_45.ply plain/tooth_45.ply || fail "gum-label"
  expect 4 split s.obj --labels plain.json --gum-label 19 -o x
  expect 0 split s.obj --labels plain.json --jaw upper -o other
  says "numbers of the other jaw in a scan of the upper one: 44, 45, 46" err
  expect 0 split s.obj --labels upper.json --jaw upper -o missing
  says "missing teeth: 12" err
  [ ! -e x ] || fail "a refused split left a folder"
}

# What is no open scan, and where scans stand.
case_scans() {
  write_scans
  expect 4 split s.obj s.obj --labels plain.json plain.json -o x
  says "both scans are of the lower jaw" err
  expect 0 split s.obj --labels plain.json -o plain
  # Closed teeth.
  write_tetrahedron one.obj
  { echo 'o tooth_44'; cat one.obj; printf 'o tooth_45\nv 40 0 0\nv 53 0 0\nv 40 11 0\nv 40 0 9\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n'; } >teeth.obj
  expect 4 split teeth.obj --parts -o x
  says "2 of 2 teeth are closed solids already" err
  says "spheretree scene teeth.obj" err
  expect 2 split s.obj --labels plain.json --up 0,0,0 -o x
  expect 0 split s.obj --labels plain.json --up 0,0,2 -o up
  # A cast with its base: up is where the crowns look.
  expect 0 split closed.obj --labels closed.json -o closed
  says "The scan is closed, so up cannot be told" err
  says "3 teeth, 1 gum; 0 refused, 0 cross" out
  expect 0 split closed.obj --labels closed.json --up 0,0,1 -o closed_up
  cmp closed/tooth_45.ply closed_up/tooth_45.ply || fail "another up"
  # Frames.
  expect 0 split lps.obj ras.obj --labels plain.json upper.json -o frames
  says "SPACE=RAS and the other one LPS" err
  expect 0 split lps.obj ras.obj --labels plain.json upper.json --frame LPS -o frames
  if grep -q "opposite ways" err; then fail "both are LPS"; fi
  expect 0 scene lps.obj ras.obj -o s.scene.json
  says "1 file says SPACE=LPS and 1 file says SPACE=RAS" err
  expect 0 scene lps.obj ras.obj --frame RAS -o s.scene.json
  says '"quaternion_wxyz": \[0.0, 0.0, 0.0, 1.0\]' s.scene.json
  [ ! -e x ] || fail "a refused split left a folder"
}

case_cohort() {
  write_scene mouth.scene.json ""
  for i in 1 2 3 4 5; do
    mkdir -p P$i
    sed "s|\"levels\": 3|\"levels\": $((i % 3 + 2)), \"tolerance_mm\": $i|; s|\"\([a-z]*\).obj\"|\"../\1.obj\"|g" mouth.scene.json >P$i/s.scene.json
    echo "{\"patient\": \"P$i\", \"scene\": \"P$i/s.scene.json\"}"
  done >list.jsonl
  expect 0 batch --cohort list.jsonl -o whole
  says "5/5 P" out
  for shard in 2 1 3; do expect 0 batch --cohort list.jsonl -o parts --shard $shard/3 --threads $shard; done
  [ "$(cat parts/cohort.*-of-3.jsonl | wc -l)" -eq 5 ] || fail "not each patient is in one log"
  for i in 1 2 3 4 5; do
    for file in scene.json tool.stree left.stree right.stree; do
      cmp whole/P$i/$file parts/P$i/$file || fail "P$i/$file differs between one run and three"
    done
  done
  # Again: nothing is built.
  expect 0 batch --cohort list.jsonl -o parts --shard 1/3
  says ", 0 built, " out
  # One bad patient does not stop the others, and comes first on the page.
  echo '{"patient": "Q", "scene": "gone.scene.json"}' >>list.jsonl
  expect 6 batch --cohort list.jsonl -o whole
  says "Q: refused" out
  says "6 patients" out
  expect 0 report --cohort whole -o page.html --json
  grep '"patient":' out >order
  says '"patient": "Q"' order
  head -1 order | grep -q '"Q"' || fail "the worst patient is not the first"
  says "1 of 6 patients is not as requested" page.html
  [ "$(grep -c 'class="meter ' page.html)" -eq 5 ] || fail "not a bar for each patient with a tolerance"
  if grep -q '<a href="./whole' page.html; then fail "a link to a page that does not exist"; fi
  # The pages of the patients, and links to them from anywhere; a patient without a result has none.
  mkdir -p "some where"
  expect 0 report --cohort whole --pages -o "some where/page.html"
  for i in 1 2 3 4 5; do
    says "<a href=\"../whole/P$i/report.html\">P$i</a>" "some where/page.html"
    says "<title>Batch P$i</title>" whole/P$i/report.html
  done
  if grep -q 'Q/report.html' "some where/page.html"; then fail "a link to a patient without a page"; fi
  expect 0 report --cohort whole --pages -o page.html
  echo mine >whole/P1/report.html
  expect 2 report --cohort whole --pages -o page.html
  says "whole/P1/report.html" err
  expect 0 report --cohort whole --pages -o page.html --force
  # Options that exclude each other, and invalid lists.
  expect 2 batch --cohort list.jsonl mouth.scene.json -o x
  expect 2 batch --cohort list.jsonl -o x --dry-run
  expect 2 batch --cohort list.jsonl -o x --budget 100
  expect 2 batch --cohort list.jsonl -o x --unit m
  expect 2 batch -o x
  echo '{"patient": "P1", "scene": "s"}' >>list.jsonl
  expect 4 batch --cohort list.jsonl -o x
  says "line 7: the patient \"P1\" is in line 1 already" err
  expect 3 batch --cohort gone.jsonl -o x
  [ ! -e x ] || fail "something was written"
  expect 2 report --cohort whole -o y.html --scene mouth.scene.json
  expect 3 report --cohort P1 -o y.html
}

case_batch_meshes() {
  write_scene a.scene.json ""
  expect 0 batch pair.obj tool.obj -o out_m --quality quick --tolerance 1.5 --match 'left=1.25'
  says "3 built, 0 unchanged, 0 failed" out
  # Equal to the result of a scene file.
  expect 0 scene pair.obj tool.obj -o b.scene.json --tolerance 1.5 --match 'left=1.25'
  expect 0 batch b.scene.json -o out_s --quality quick
  for tree in tool left right; do cmp out_m/$tree.stree out_s/$tree.stree || fail "$tree differs"; done
  # The scene is in the folder, and an edit rebuilds only the changed objects.
  sed 's/1.25/1/' out_m/drafted.scene.json >out_m/edited.scene.json
  expect 0 batch out_m/edited.scene.json -o out_m --quality quick
  says "1 built, 2 unchanged, 0 failed" out
  expect 0 report out_m -o page.html
  # Without a tool.
  expect 0 batch pair.obj -o out_ball --quality quick --tolerance 1.5
  [ -s out_ball/ball.stree ] || fail "no ball"
  expect 0 batch pair.obj -o out_ball --quality quick --tolerance 1.5
  says "0 built, 3 unchanged, 0 failed" out
  expect 2 batch a.scene.json pair.obj -o out_x
  expect 2 batch a.scene.json -o out_x --tool left
  expect 0 batch pair.obj -o out_dry --dry-run
  [ ! -e out_dry ] || fail "a dry run wrote something"
}

case_batch() {
  write_scene a.scene.json ""
  expect 0 batch a.scene.json -o out_a
  says "3 built, 0 unchanged, 0 failed" out
  for tree in tool left right; do
    [ -s out_a/$tree.stree ] || fail "no tree of $tree"
    expect 0 inspect out_a/$tree.stree
  done
  says '"tree": "left.stree"' out_a/scene.json
  says '"schema": "spheretree.batch/1"' out_a/report.json
  says '"mesh": "../pair.obj"' out_a/scene.json  # to be shown
  # A tree of a batch is the tree of build, byte for byte.
  expect 0 build pair.obj --parts left --quality quick --levels 3 -o left.stree
  cmp left.stree out_a/left.stree || fail "batch and build differ"
  # Unchanged: nothing is built, and the trees stay as they are. Changed: only the changed objects are built.
  cp -r out_a before
  expect 0 batch a.scene.json -o out_a --threads 1
  says "0 built, 3 unchanged, 0 failed" out
  for tree in tool left right; do cmp before/$tree.stree out_a/$tree.stree || fail "$tree changed"; done
  sed -i 's/^v 20 0 9$/v 20 0 8/' pair.obj
  expect 0 batch a.scene.json -o out_a
  says "2 built, 1 unchanged, 0 failed" out  # both parts of the file that changed: its bytes count
  # A compiled scene is a scene.
  expect 0 batch out_a/scene.json -o again
  cmp out_a/left.stree again/left.stree || fail "a tree changed on its way through"
  # An entry of the cache that is cut off or altered is not used.
  for entry in out_a/cache/*.stree; do printf x >>"$entry"; done
  expect 0 batch a.scene.json -o out_a
  says "3 built, 0 unchanged, 0 failed" out
}

case_batch_failures() {
  write_scene bad.scene.json ', {"name": "line", "mesh": "line.obj"}, {"name": "gone", "mesh": "gone.obj"},
    {"name": "nopart", "mesh": "pair.obj", "part": "middle"}, {"name": "notree", "tree": "tool.obj"}'
  printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >line.obj
  expect 6 batch bad.scene.json -o out_b
  says "3 built, 0 unchanged, 4 failed" out
  for name in line gone nopart notree; do
    says "spheretree: $name: " err
    says "\"name\": \"$name\"" out_b/report.json
    if grep -q "\"$name\"" out_b/scene.json; then fail "the compiled scene names $name, which has no tree"; fi
  done
  says 'its parts are "left", "right"' err
  # Without any tree there is no scene, not even one of an earlier run.
  sed 's/tool.obj/gone.obj/' bad.scene.json >worse.scene.json
  expect 6 batch worse.scene.json -o out_b
  [ ! -e out_b/scene.json ] || fail "a scene without a tool was left behind"
  sed 's/"levels"/"level"/' bad.scene.json >key.scene.json
  expect 4 batch key.scene.json -o out_c
  says 'the nearest known one is "levels"' err
  expect 3 batch gone.scene.json -o out_c
  expect 2 batch bad.scene.json -o out_c --shard 3/2
  [ ! -e out_c ] || fail "a folder was made for a scene that was refused"
  # A cache that is not writable is detected before anything is built.
  expect 3 batch bad.scene.json -o out_c --cache tool.obj/cache
  says "tool.obj/cache: cannot be made" err
  [ ! -e out_c/report.json ] || fail "results without a cache"
  write_scene tight.scene.json ', {"name": "tight", "mesh": "tool.obj", "tolerance_mm": 1e-6}'
  expect 5 batch tight.scene.json -o out_d
  says "tight: the tolerance of 1e-06 mm is not met" err
  expect 5 batch tight.scene.json -o out_d
}

case_batch_shards() {
  write_scene a.scene.json ', {"name": "twin", "mesh": "pair.obj", "part": "left"}'
  expect 0 batch a.scene.json -o whole
  for shard in 1 2 3; do expect 0 batch a.scene.json -o parts --shard $shard/3; done
  [ ! -e parts/report.json ] || fail "a shard wrote the report"
  expect 0 batch a.scene.json -o parts
  says "0 built, 4 unchanged, 0 failed" out
  for tree in tool left right twin; do cmp whole/$tree.stree parts/$tree.stree || fail "$tree differs"; done
  cmp whole/scene.json parts/scene.json || fail "the scenes differ"
}

# Killed at any moment: the next run continues and produces the same bytes.
case_batch_killed() {
  write_torus torus.obj 24
  objects=""
  for i in 1 2 3 4 5 6; do
    sed "s/^v \([0-9.-]*\)/v \1$i/" torus.obj >torus$i.obj
    objects="$objects, {\"name\": \"torus$i\", \"mesh\": \"torus$i.obj\"}"
  done
  write_scene a.scene.json "$objects"
  expect 0 batch a.scene.json -o whole
  for delay in 0.2 0.5 0.9; do
    "$program" batch a.scene.json -o killed >/dev/null 2>&1 &
    running=$!
    sleep $delay
    kill -9 $running 2>/dev/null
    wait $running 2>/dev/null
  done
  "$program" batch a.scene.json -o killed >/dev/null 2>err &
  running=$!
  sleep 0.3
  kill -INT $running 2>/dev/null
  wait $running
  code=$?
  [ $code -eq 130 ] || [ $code -eq 0 ] || fail "exit code $code after Ctrl-C"
  expect 0 batch a.scene.json -o killed
  for tree in tool left right torus1 torus6; do cmp whole/$tree.stree killed/$tree.stree || fail "$tree differs"; done
  cmp whole/scene.json killed/scene.json || fail "the scenes differ"
}

# Prints the first number FIELD of FILE.
number_of() { sed -n "s/^ *\"$1\": \([0-9.e-]*\),*$/\1/p" "$2" | head -n 1; }

# less A B: compares as numbers.
less() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a < b) }'; }

# A small ring and a large one, with a tetrahedron as tool.
write_rings() {
  write_tetrahedron tool.obj
  write_torus small.obj 12
  sed 's/^v \(\S*\) \(\S*\) \(\S*\)/v \10 \20 \30/; s/\.\([0-9]\)\([0-9]*\)/\1.\2/g' small.obj >large.obj  # ten times the size
  printf '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick"%s},
    "tool": {"name": "tool", "mesh": "tool.obj"},
    "objects": [{"name": "small", "mesh": "small.obj", "position_mm": [300, 0, 0]}, {"name": "large", "mesh": "large.obj"}]%s}' "$2" "$3" >"$1"
}

case_batch_budget() {
  write_rings a.scene.json "" ""
  write_rings even.scene.json ', "levels": 3' ""
  expect 0 batch even.scene.json -o even
  expect 0 batch a.scene.json -o out_a --budget 120
  says '^budget: ' out
  says '"of": "leaves"' out_a/report.json
  leaves=$(number_of spent out_a/report.json)
  [ "${leaves%.*}" -le 120 ] && [ "${leaves%.*}" -ge 100 ] || fail "$leaves leaves of 120"
  # Fewer leaves than 64 for each tree, and a smaller error: the purpose of a budget.
  error=$(number_of overhang_bound_mm out_a/report.json)
  less "$error" "$(number_of overhang_bound_mm even/report.json)" || fail "with $leaves leaves an error of $error"
  expect 0 batch a.scene.json -o again --budget 120 --threads 1
  for file in tool.stree small.stree large.stree scene.json; do cmp out_a/$file again/$file || fail "$file depends on threads"; done
  expect 0 batch a.scene.json -o out_a --budget 120
  says "0 built, 3 unchanged" out
  # A budget of time, by a model: it is met, and the result does not depend on the load of the machine.
  expect 0 batch even.scene.json -o slow --budget 1000us  # all that its levels allow
  some=$(number_of spent slow/report.json | awk '{ print 0.8 * $1 }')
  expect 0 batch even.scene.json -o fast --budget "${some}us"
  less "$(number_of spent fast/report.json)" "$some" || fail "beyond $some us"
  expect 5 batch even.scene.json -o fast --budget 0.1us
  says "the budget is not met" err
  # Tolerances weight the errors: the small ring gets leaves.
  sed 's/"mesh": "small.obj"/"mesh": "small.obj", "tolerance_mm": 0.05/; s/"mesh": "large.obj"/"mesh": "large.obj", "tolerance_mm": 5/' a.scene.json >w.scene.json
  expect 0 batch w.scene.json -o weighed --budget 120
  [ "$("$program" inspect weighed/small.stree --json | number_of nodes -)" -gt "$("$program" inspect again/small.stree --json | number_of nodes -)" ] ||
    fail "the tolerance weighs nothing"
  # A region of work also is a tolerance.
  write_rings site.scene.json ', "tolerance_mm": 8' ', "work": [{"name": "spot", "sphere": {"centre_mm": [130, 0, 0], "radius_mm": 10}, "tolerance_mm": 4}]'
  expect 0 batch site.scene.json -o site --budget 40
  says '"min_tolerance_mm"' site/report.json
  for bad in 0 -3 2.5 x 5ms 1e10; do expect 2 batch a.scene.json -o none --budget=$bad; done
  expect 2 batch a.scene.json -o none --budget 2
  expect 2 batch a.scene.json -o none --budget 100 --shard 1/2
  expect 2 batch a.scene.json -o none --trajectory t.csv
  write_rings b.scene.json ', "builder": "octree"' ""
  expect 2 batch b.scene.json -o none --budget 100
}

case_batch_regions() {
  spot() { write_rings site.scene.json ', "tolerance_mm": 4' ", \"work\": [{\"name\": \"spot\", \"sphere\": {\"centre_mm\": [130, 0, 0], \"radius_mm\": 10}, \"tolerance_mm\": $1}$2]"; }
  write_rings plain.scene.json ', "tolerance_mm": 4' ""
  spot 1 ""
  expect 0 batch plain.scene.json -o plain
  expect 0 batch site.scene.json -o site
  says '"name": "spot"' site/report.json
  # A ring that no region can reach is the same as without regions, and an edited region rebuilds only what it concerns.
  cmp plain/small.stree site/small.stree || fail "a region far away changes a tree"
  cmp plain/large.stree site/large.stree && fail "the region changes nothing"
  spot 2 ""
  expect 0 batch site.scene.json -o site
  says "1 built, 2 unchanged, 0 failed" out
  spot 2 ', {"name": "beside", "box": {"low_mm": [304, -99, -99], "high_mm": [305, 99, 99]}, "tolerance_mm": 0.5}'
  expect 0 batch site.scene.json -o site
  says "1 built, 2 unchanged, 0 failed" out
  # Regions that change nothing are reported, each once, and objects that use none.
  spot 2 ', {"name": "lost", "sphere": {"centre_mm": [0, 0, 900], "radius_mm": 5}, "tolerance_mm": 0.5}'
  expect 0 batch site.scene.json -o site
  says 'work\[1\] (lost) touches no object: the nearest is [a-z]*, [0-9.]* mm away' err
  [ "$(grep -c "touches no object" err)" -eq 1 ] || fail "another region"
  sed 's/"mesh": "large.obj"/"mesh": "large.obj", "builder": "octree"/' site.scene.json >octree.scene.json
  expect 5 batch octree.scene.json -o octree
  says 'work has no effect on large: a published builder' err
  sed 's/, "tolerance_mm": 4}/}/; s/, "tolerance_mm": 4,/,/' site.scene.json >whole.scene.json
  expect 0 batch whole.scene.json -o whole --dry-run
  says 'work has no effect on large: without a tolerance_mm' err
  # What is missed is said with its region.
  spot 0.0001 ""
  expect 5 batch site.scene.json -o site
  says "large: the tolerance is not met in the region spot (.* mm instead of 0.0001 mm)" err
  expect 0 report site -o site.html
  says "1 object of 3 missed the tolerance asked for" site.html
  if grep -q "whole and certified" site.html; then fail "two verdicts"; fi
}

case_batch_chart() {
  write_rings a.scene.json ', "levels": 3' ""
  printf 't_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n' >press.csv
  awk 'BEGIN { for (i = 0; i < 200; ++i) printf "%.3f,0,100,%.2f,1,0,0,0\n", i / 1000, 40 - i / 10 }' >>press.csv
  expect 0 batch a.scene.json -o out_a --chart --trajectory press.csv
  # 8 and 64 leaves and the chosen trees, for the scene, the tool and two objects.
  [ "$(grep -c '"leaves_each": ' out_a/report.json)" -eq 12 ] || fail "not 3 rows of 4"
  [ "$(grep -c '"chosen": true' out_a/report.json)" -eq 4 ] || fail "not one chosen row each"
  # The second run is equal except for times: the whole chart comes from the cache.
  grep -v -e seconds -e step_us -e built -e cached out_a/report.json >first
  expect 0 batch a.scene.json -o out_a --chart --trajectory press.csv --threads 1
  grep -v -e seconds -e step_us -e built -e cached out_a/report.json >second
  cmp first second || fail "two charts differ beyond their times"
  expect 0 report out_a -o page.html
  says 'Leaves against overhang' page.html
  says 'class="cq"' page.html
  # A row for each tolerance of the scene; none for the only one, which the chosen trees have.
  sed -i 's/"quality": "quick"/"quality": "quick", "tolerance_mm": 4/' a.scene.json
  expect 0 batch a.scene.json -o out_t --chart
  grep -c '"chosen": false' out_t/report.json | grep -qx 8 || fail "a row of the only tolerance"
  sed -i 's/"mesh": "small.obj"/"mesh": "small.obj", "tolerance_mm": 0.5/' a.scene.json
  expect 0 batch a.scene.json -o out_t --chart
  grep -c '"chosen": false' out_t/report.json | grep -qx 16 || fail "not a row for each of two tolerances"
}

# Every command of docs/tutorial.md, and the scene of its step 2. Arguments: make_samples, haptic-player, the page,
# make_scans.
case_batch_tutorial() {
  mkdir bin
  ln -s "$program" bin/spheretree
  ln -s "$1" bin/make_samples
  ln -s "$2" bin/haptic-player
  ln -s "$4" bin/make_scans
  PATH=$PWD/bin:$PATH
  sed -n 's/^    //p' "$3" >lines
  commands=0
  while read -r line; do
    case $line in
      "{"*) printf '%s\n' "$line" >mouth/first.scene.json ;;
      '"'*) printf '%s\n' "$line" >>mouth/first.scene.json ;;
      *)
        sh -euc "$line" >"out" 2>err </dev/null || fail "of the tutorial: $line"
        commands=$((commands + 1))
        case $line in haptic-player*) says '"end": "complete"' out ;; esac
        ;;
    esac
  done <lines
  [ $commands -eq 10 ] || fail "the tutorial has $commands commands, not 10"
  says '"tooth_16"' patient/mouth.scene.json
  says '"tooth_46"' mouth/drafted.scene.json
  says '"overhang_mm"' compiled/report.json
  says 'tooth_46' page.html
  sed 's/"tool"/"defaults": {"quality": "quick"}, "tool"/' mouth/first.scene.json >mouth/quick.scene.json
  # Fewer leaves where the tool cannot reach and no work is done; the region has its own figure, and its tolerance is
  # met.
  sed -e 's/"quality": "quick"/"quality": "quick", "tolerance_mm": 0.4/' mouth/quick.scene.json >mouth/even.scene.json
  sed -e '$ s/}$/, "work": [{"name": "cusp", "sphere": {"centre_mm": [-26, 16, 7], "radius_mm": 2}, "tolerance_mm": 0.2}]}/' \
    mouth/even.scene.json >mouth/work.scene.json
  # 5: certification may enlarge a leaf slightly beyond its tolerance.
  "$program" batch mouth/work.scene.json -o work >out 2>err || [ $? -eq 5 ] || fail "exit code $?"
  says '"name": "cusp"' work/report.json
  says '"min_tolerance_mm": 0.2' work/report.json
  "$program" batch mouth/work.scene.json -o work >out 2>err || [ $? -eq 5 ] || fail "exit code $?"
  says "0 built, 2 unchanged" out
}
