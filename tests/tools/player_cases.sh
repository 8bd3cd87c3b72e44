# SPDX-License-Identifier: Apache-2.0
# Cases of program_test.sh for `haptic-player`, which is the program; program_test.sh sources this file. Argument:
# spheretree.

# Two balls as tool, two larger ones below it as object: scene.json. They touch where the tool is at z = 0.1.
write_touch() {
  write_sph tool.sph
  printf '2 2\n0 0 -6.5 6 1\n0.5 0 -6.5 5.5 1\n-0.5 0 -6.5 5.5 1\n' >object.sph
  for name in tool object; do "$1" convert $name.sph $name.stree || fail "no tree of $name"; done
  printf '{"schema": "spheretree.scene/1", "tool": {"name": "tool", "tree": "tool.stree"},
    "objects": [{"name": "object", "tree": "object.stree"}]}' >scene.json
}

# From 5 mm above down to 1 mm below, in 100 ms.
write_path() {
  awk 'BEGIN { print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
    for (i = 0; i < 100; ++i) printf "%.3f,0,0,%.3f,1,0,0,0\n", i / 1000, 5 - 0.06 * i }' >"$1"
}

case_player_run() {
  write_touch "$1"
  write_path path.csv
  expect 0 scene.json --trajectory path.csv --clock stepped --record work/run.csv --json
  for words in '"steps": 100' '"end": "complete"' '"device": "replay"' '"mode": "constrained"' '"missed_deadlines"' '"largest_penetration_mm"' \
    '"wrench_step"' '"energy_mj"' '"faults"' '"p99_9"'; do says "$words" out; done
  is_quiet
  head -n 1 work/run.csv >header
  says '^tick,t_s,hx_mm,hy_mm,hz_mm,hqw,hqx,hqy,hqz,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,pairs,rows,active,qp_iterations,faults,find_us,rows_us,qp_us,total_us,penetration_mm,scene,settings,touched,friction_n,slip_mm_s,hinges_deg$' header
  [ "$(wc -l <work/run.csv)" -eq 101 ] || fail "not a row for each step"
  # Pressed in at the end: pushed up; in free space at the beginning there is no force.
  sed -n 2p work/run.csv | awk -F, '{ exit !($17 == 0 && $18 == 0 && $19 == 0) }' || fail "a force in free space"
  sed -n '$p' work/run.csv | awk -F, '{ exit !($19 > 0.1) }' || fail "no force in contact"
  # A recording is replayed to the same bytes, except for its times; paths may be absolute.
  expect 0 "$PWD/scene.json" --trajectory work/run.csv --clock stepped --record again.csv
  cut -d, -f1-27 work/run.csv >first
  cut -d, -f1-27 again.csv >second
  cmp first second || fail "a replay differs"
  expect 0 scene.json --trajectory path.csv --clock stepped --mode paper --seconds 0.05 --json
  says '"steps": 50' out
  says '"mode": "paper"' out
  expect 0 scene.json --seconds 0.05 --clock real --json  # the simulated hand, in real time
  says '"clock": "real"' out
  # Real time is held, or not: figures, verdict and exit code agree, whatever the machine did.
  "$program" scene.json --check-realtime --seconds 0.3 --json >out 2>err
  python3 - $? out <<'END' || fail "figures, verdict and exit code of --check-realtime disagree"
import json, sys
run = json.load(open(sys.argv[2]))
held = run["missed_deadlines"] == 0 and run["steps_over_ms"]["clock"] == 0
longest = run["longest_step"]
sys.exit(not (run["steps"] == 300 and run["clock"] == "real" and run["real_time"]["held"] is held and int(sys.argv[1]) == (0 if held else 5)
              and abs(longest["clock_us"] - run["time_us"]["total"]["max"]) < 1e-3 and 0 <= longest["t_s"] < 0.3
              and (longest["kind"] == "first") == (longest["t_s"] == 0)))
END
  "$program" scene.json --check-realtime --seconds 0.01 >out 2>err
  says '^longest step       at 0.0' out
  says '^real time          ' out
}

case_player_usage() {
  write_touch "$1"
  write_path path.csv
  expect 0 --help
  says "Examples:" out
  fits_80 out
  expect 0 --list
  says "^F1 " out
  expect 2 scene.json --trajctory path.csv
  says "the nearest is '--trajectory'" err
  for bad in "--device replay" "--device hand" "--device phantom --trajectory path.csv" "--device phantom --clock stepped" "--mode best" \
    "--clock fast" "--seconds 0" "--seconds -1" "--hand big" "--trajectory path.csv --hand firm" "--hd-calibrate" "--share 0.1" \
    "--out stability" "--cache trees" "--quality quick" "--threads 2" "--scenario F17" "again.json"; do
    # shellcheck disable=SC2086
    expect 2 scene.json $bad
    [ -s err ] || fail "no message for $bad"
  done
  for bad in "--clock stepped" "--picture a.png"; do
    # shellcheck disable=SC2086
    expect 2 scene.json --check-realtime $bad
    says "^haptic-player: --check-realtime is not for" err
  done
  for bad in "--check-realtime" "--record run.csv" "--trajectory path.csv" "--device replay" "--device phantom" "--hand firm" "--passivity-control"; do
    # shellcheck disable=SC2086
    expect 2 --scenario F17 $bad
  done
  # What would do nothing is refused.
  for bad in "--seconds 3" "--mode paper" "--clock stepped" "--theme light" "--hand-from mouse"; do
    # shellcheck disable=SC2086
    expect 2 --scenario F17 --turned 0 $bad
    says "^haptic-player: .*${bad%% *}" err
  done
  for bad in "--hand-from gamepad" "--theme dark" "--size 320x200" "--show spheres" "--from 1,2,3" "--within 5" "--follow" "--panels on" \
    "--scale 1"; do
    # shellcheck disable=SC2086
    expect 2 --seconds 0.01 --clock stepped $bad
    says "${bad%% *} is for --view" err
  done
  for bad in "--contact leaves" "--tissue small"; do
    # shellcheck disable=SC2086
    expect 2 --seconds 0.01 --clock stepped --mode paper $bad
    says "${bad%% *} is for --mode constrained" err
  done
  for bad in "--seconds 3" "--mode paper" "--clock stepped" "--device simulated" "--trajectory path.csv" "--record run.csv" "--json" \
    "--tissue small" "--contact leaves" "--hand firm" "--passivity-control" "--hand-from mouse" "--check-realtime"; do
    # shellcheck disable=SC2086
    expect 2 --replay run.csv --picture work/a.png $bad
    says "${bad%% *} is for a run, and --replay" err
  done
  expect 2 --picture work/a.png --clock real
  says "--clock real is not for --picture" err
  expect 2 --seconds 0.01 --clock stepped --force
  says "--force is for --out and --picture" err
  expect 2 --picture work/a.png --from 1,2
  says "--from needs 3 values, and got 2" err
  expect 0 --version
  says "^haptic-player [0-9]" out
  expect 0 --scenario F17 --turned 0 --device simulated --json
  expect 2 --scenario F99
  says "F22 (leaves)" err
  cp path.csv before
  expect 2 scene.json --trajectory path.csv --clock stepped --record path.csv
  expect 2 scene.json --trajectory path.csv --clock stepped --passivity-control
  says "no hand takes up" err
  cmp before path.csv || fail "the trajectory was written over"
}

case_player_refuses() {
  write_touch "$1"
  expect 3 missing.json --seconds 0.01
  expect 3 scene.json --trajectory missing.csv
  expect 3 scene.json --seconds 0.01 --clock stepped --record work/missing/run.csv
  expect 3 scene.json --seconds 0.01 --clock stepped --record work
  expect 3 scene.json --device phantom --hd-library "$PWD/missing.so"
  says "missing.so" err
  expect 3 --scenario F17 --quality quick --out scene.json/stability
  write_path path.csv
  sed 's/^0.050,/0.051,/' path.csv >late.csv
  expect 4 scene.json --trajectory late.csv --clock stepped
  says "late.csv, line 53: t_s is 0.051, not after" err
  sed 's/object.stree/gone.stree/' scene.json >gone.json
  expect 3 gone.json --seconds 0.01
  says "gone.stree" err
  sed 's/"tree": "object.stree"/"mesh": "object.obj"/' scene.json >mesh.json
  expect 4 mesh.json --seconds 0.01
  says "spheretree batch" err
  printf 'x' | dd of=object.stree bs=1 seek=330 conv=notrunc 2>/dev/null
  expect 4 scene.json --seconds 0.01
  says "object.stree" err
  is_empty work
}

# Ctrl-C: zero wrench, then the complete recording under its name.
case_player_interrupted() {
  write_touch "$1"
  "$program" scene.json --seconds 60 --record work/run.csv --json >out 2>err &
  pid=$!
  for _ in $(seq 100); do  # until there are rows after the header: then the device runs
    [ -n "$(find work -name '*.tmp' -size +2)" ] && break
    sleep 0.1
  done
  kill -INT $pid
  wait $pid
  code=$?
  [ $code -eq 130 ] || fail "exit code $code, not 130"
  says '"end": "interrupted"' out
  [ "$(ls -A work)" = run.csv ] || fail "in the folder: $(ls -A work)"
  steps=$(sed -n 's/^ "steps": \([0-9]*\),/\1/p' out)
  [ "$(wc -l <work/run.csv)" -eq $((steps + 1)) ] || fail "not a row for each of $steps steps"
}

# A simulated hand in one program, the scene in another.
case_player_devices() {
  write_touch "$1"
  # 3 s above the object, while guard and ramp pass; then it presses into it.
  awk 'BEGIN { print "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz"
    for (i = 0; i < 6000; ++i) printf "%.3f,0,0,%.4f,1,0,0,0\n", i / 1000, i < 3500 ? 3 : (i < 4500 ? 3 - 0.006 * (i - 3500) : -3) }' >hand.csv
  "$program" --device simulated --trajectory hand.csv --serve 0 --seconds 30 >served 2>served_err &
  pid=$!
  for _ in $(seq 100); do
    grep -q net: served && break
    sleep 0.05
  done
  address=$(sed -n 's/.*\(net:.*\)/\1/p' served)
  expect 0 scene.json --device "$address" --seconds 7 --json --record run.csv
  kill -INT $pid
  wait $pid || fail "the server's exit code"
  for words in "\"device\": \"$address\"" '"renders_torque": true' '"rate_hz": 1000'; do says "$words" out; done
  python3 - out <<'END' || fail "the hand was not felt"
import json, sys
run = json.load(open(sys.argv[1]))
sys.exit(not (run["largest_force_n"] > 0.2 and run["steps"] > 3000 and run["end"] == "complete"))
END
  # Nobody serves there now; and what would do nothing or harm is refused.
  expect 3 scene.json --device "$address"
  says "does not answer: start the program" err
  expect 3 scene.json --device net:10.0.0.1:47000
  says "is another machine" err
  expect 3 scene.json --device haply --haply-host 127.0.0.1:1
  says "Start the Haply Inverse Service" err
  expect 3 scene.json --device dhd --dhd-library /nowhere/libdhd.so
  says "/nowhere/libdhd.so" err
  for bad in "--haply-host 127.0.0.1:1" "--dhd-library a.so" "--allow-remote" "--clutch-button 1" "--spindle-button 1" "--carried-weight 1" "--device dhd --haply-device 1" \
    "--device haply --trajectory hand.csv" "--device dhd --clock stepped" "--serve 0" "--rate 100" "--rate 9000" "--rate 2000 --picture a.png" \
    "--device dhd --carried-weight 9" "--device dhd --clutch-button 0"; do
    # shellcheck disable=SC2086
    expect 2 scene.json $bad
    [ -s err ] || fail "no message for $bad"
  done
  expect 2 --scenario F1 --rate 2000
  says "S1 and S3" err
  # A trajectory has the same length at each rate, and a recording its own times.
  write_path path.csv
  for rate in 500 1000 4000; do
    expect 0 scene.json --trajectory path.csv --clock stepped --rate $rate --record r$rate.csv --json
    says "\"rate_hz\": $rate" out
    [ "$(wc -l <r$rate.csv)" -ge $((rate * 99 / 1000)) ] || fail "rows at $rate Hz"
    sed -n '$p' r$rate.csv | awk -F, '{ exit !($19 > 0.1 && $2 > 0.097 && $2 < 0.1) }' || fail "the end of the path at $rate Hz"
  done
  # A view has a step for each millisecond; as a trajectory the recording is of any rate.
  expect 4 --replay r4000.csv --picture a.png
  says "was recorded at 4000 Hz" err
  expect 0 scene.json --trajectory r4000.csv --clock stepped --json
  says '"steps": 100' out
}

case_player_measure() {
  expect 0 --measure -o device.json
  says "^latency" out
  says "^proposed" out
  python3 - device.json <<'END' || fail "the measures: $(cat device.json)"
import json, sys
m = json.load(open(sys.argv[1]))
ok = m["schema"] == "spheretree.device_measures/1" and m["encoder_count_mm"] == 0.02 and abs(m["rate_hz"] - 1000) < 1e-6
ok = ok and all(abs(f - 0.2) < 0.02 for f in m["friction_n"]) and abs(m["latency_ms"]) < 0.08 and m["fastest_mm_s"] < 20
sys.exit(not (ok and 0 < m["proposed"]["stiffness_n_per_mm"] < 10))
END
  expect 2 scene.json --measure
  says "SCENE is not for --measure" err
  expect 2 -o device.json
  expect 2 --measure --device replay
}

case_player_scenario() {
  expect 0 --scenario F17 --quality quick --out stability
  says "^F17 " out
  says "1 scenario, 0 fall short" out
  says '"schema": "spheretree.stability/1"' stability/stability.json
  expect 0 --scenario inside --turned 0 --quality quick --json
  says '"schema": "spheretree.stability/1"' out
  says '"verdict": "holds"' out
  if grep -q "^F17" out; then fail "the table among the JSON"; fi
  expect 0 --scenario F7 --share 0.01 --quality quick --turned 0 --modes constrained,points,volume,continuous
  says "constrained *points *volume *continuous" out
  expect 0 --scenario F17 --turned 0 --quality quick --modes continuous
  says "only for paper and constrained" out
}

# What it prints and draws: contract.schemas.
case_player_compare_tools() {
  expect 2 --compare-tools spoon
  says "They are: ball, bur, edge" err
  expect 2 --compare-tools ball --seconds 1
  says "seconds is not for --compare-tools" err
  expect 2 --depth-mm 1
}

case_player_compare_cutting() {
  expect 0 --compare-cutting --chart page.html
  says "^plunge at 0.5 mm/s  *constrained " out
  says "^side cut at 2 mm/s  *voxels " out
  says "plunge at 2 mm/s: force on the hand" page.html
  expect 2 --compare-cutting --seconds 1
  says "seconds is not for --compare-cutting" err
  write_touch "$1"
  write_path path.csv
  expect 4 scene.json --trajectory path.csv --compare-cutting
  says "no burr, or no object that can be cut" err
}

# Runs with good figures that may not be the intended ones.
case_player_notes() {
  write_touch "$1"
  write_path path.csv
  sed 's/{"name": "object", "tree": "object.stree"}/{"name": "a", "tree": "object.stree"}, {"name": "b", "tree": "object.stree", "position_mm": [50, 0, 0]}/' scene.json >two.json
  expect 0 two.json --seconds 0.1 --clock stepped
  says "The hand visited 1 of 2 objects; --seconds 10 visits all." out
  says "The tool touched nothing." out
  expect 0 two.json --seconds 0.1 --clock stepped --json
  says '"The hand visited 1 of 2 objects' out
  expect 0 scene.json --trajectory path.csv --clock stepped --seconds 5
  says "The trajectory ended after 0.1 s of the 5 s asked for." out
  expect 0 scene.json --trajectory path.csv --clock stepped
  if grep -q "^note" out; then fail "a note on a run that did what was meant"; fi
  sed 's/"tree": "tool.stree"/"tree": "tool.stree", "reference_point_mm": [0, 0, 105]/' scene.json >far.json
  expect 0 far.json --trajectory path.csv --clock stepped
  says "Its reference point is 10[0-9.]* mm away from its nearest sphere" out
  expect 0 scene.json --seconds 0.001 --clock stepped
  says "^1 step on" out
  for bad in "--seconds nan" "--seconds -nan" "--seconds inf"; do
    # shellcheck disable=SC2086
    expect 2 scene.json $bad
    says_in_a_line "is not a number from 0.001 to 86400"
  done
  expect 2 --scenario F6 --share nan
  says_in_a_line "is not a number from 0.001 to 1"
  expect 4 object.stree
  says_in_a_line "object.stree: is a sphere-tree (.stree), not a scene"
  expect 2 scene.json --device replay
  says_in_a_line '\.$'
  # A recording belongs to a scene, and is not shown in another one.
  cp scene.json same.json
  expect 0 scene.json --trajectory path.csv --clock stepped --record run.csv
  "$1" report run.csv --scene scene.json -o work/a.html >out 2>err || fail "refused in its own scene"
  "$1" report run.csv --scene same.json -o work/b.html >out 2>err || fail "refused in a copy of its scene"
  "$1" report run.csv --scene two.json -o work/c.html >out 2>err
  [ $? -eq 4 ] || fail "a recording in another scene is taken"
  says_in_a_line "run.csv: was recorded in the scene .*scene.json, not in two.json"
  [ ! -e work/c.html ] || fail "a page of a recording in another scene"
  mkdir moved
  mv run.csv moved
  "$1" report moved/run.csv --scene two.json -o work/c.html >out 2>err || fail "refused although its scene is not there"
  says "It names the scene scene.json, which was not found" work/c.html
}
