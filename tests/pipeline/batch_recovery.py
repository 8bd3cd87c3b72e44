# SPDX-License-Identifier: Apache-2.0
"""spheretree batch, killed at 20 random moments: no finished object is built again, and the end is the same bytes as
that of an undisturbed run. Then the same scene in 4 shards at the same time: the same bytes again.

A few small objects; with SPHERETREE_LONG=1 the whole sample mouth (about ten minutes with two processors). Usage:
batch_recovery.py PROGRAM MAKE_SAMPLES FOLDER"""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "support"))
from torus import write_torus  # noqa: E402

KILLS, SHARDS, SEED, RINGS = 20, 4, 1, 8
program, make_samples, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])


def make_scene():
    if os.environ.get("SPHERETREE_LONG"):
        subprocess.run([make_samples, "--mouth", folder / "mouth"], check=True, stdout=subprocess.DEVNULL)
        return folder / "mouth" / "mouth.scene.json"
    for i in range(RINGS):
        write_torus(folder / f"ring{i}.obj", 10 + i)
    scene = {"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 3}, "tool": {"name": "ring0", "mesh": "ring0.obj"},
             "objects": [{"name": f"ring{i}", "mesh": f"ring{i}.obj"} for i in range(1, RINGS)]}
    (folder / "rings.scene.json").write_text(json.dumps(scene))
    return folder / "rings.scene.json"


def command(scene, out, *more):
    return [program, "batch", str(scene), "-o", str(out), "--progress", "none", *more]


def run(scene, out):
    begun = time.monotonic()
    subprocess.run(command(scene, out), check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - begun


def finished(out):
    """The entries of the cache: what it takes for an object to be finished, and what would change if it were built
    again."""
    entries = {}
    for record in (out / "cache").glob("*.json"):
        tree = record.with_suffix(".stree")
        if tree.exists():
            entries[record.stem] = [(f.stat().st_ino, f.stat().st_mtime_ns) for f in (tree, record)]
    return entries


def results(out):
    """All bytes but times, and but whether a tree was built or found."""
    def without(value):
        if isinstance(value, dict):
            return {k: without(v) for k, v in value.items() if k not in ("seconds", "status", "built", "cached")}
        return [without(v) for v in value] if isinstance(value, list) else value

    files = {f.name: f.read_bytes() for f in out.glob("*.stree")}
    files["scene.json"] = (out / "scene.json").read_bytes()
    files["report.json"] = json.dumps(without(json.loads((out / "report.json").read_text())))
    return files


def kill_and_go_on(scene, out, whole_seconds):
    """Kills that hit a running batch, over as many batches as that takes. Gives how many finished objects lay there at
    the kills, all in all, and how many half-written files. Ends with a batch that is not finished."""
    moments = random.Random(SEED)
    kills = kept = half = 0
    while kills < KILLS or not finished(out):
        before = finished(out)
        process = subprocess.Popen(command(scene, out), stdout=subprocess.DEVNULL)
        try:
            process.wait(moments.uniform(0, 0.3 * whole_seconds))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            kills += 1
            kept += len(finished(out))
            half += len(list((out / "cache").glob("*"))) - 2 * len(finished(out)) if (out / "cache").exists() else 0
        else:
            assert process.returncode == 0, process.returncode
        check_untouched(before, finished(out))
        if process.returncode == 0:  # all is done: from the beginning, until there were enough kills
            shutil.rmtree(out)
    return kills, kept, half


def check_untouched(before, after):
    again = [key for key in before if after.get(key) != before[key]]
    assert not again, f"built again though they were finished: {again}"


def main():
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    scene = make_scene()
    seconds = run(scene, folder / "whole")
    whole = results(folder / "whole")
    print(f"undisturbed: {len(whole) - 2} trees in {seconds:.1f} s")

    kills, kept, half = kill_and_go_on(scene, folder / "killed", seconds)
    before = finished(folder / "killed")
    last = run(scene, folder / "killed")
    check_untouched(before, finished(folder / "killed"))
    assert results(folder / "killed") == whole, "after the kills other bytes"
    print(f"killed {kills} times, with {kept} finished objects in the cache and {half} half-written files beside them in all: no finished one "
          f"was built again; the last run found {len(before)} and took {last:.1f} s; the same bytes")

    shards = [subprocess.Popen(command(scene, folder / "shards", "--threads", "1", "--shard", f"{i + 1}/{SHARDS}"), stdout=subprocess.DEVNULL)
              for i in range(SHARDS)]
    assert [shard.wait() for shard in shards] == [0] * SHARDS
    before = finished(folder / "shards")
    run(scene, folder / "shards")
    assert len(before) == len(finished(folder / "shards")), "the shards left something to build"
    check_untouched(before, finished(folder / "shards"))
    assert results(folder / "shards") == whole, "the shards give other bytes"
    print(f"{SHARDS} shards at the same time: the same bytes")
    shutil.rmtree(folder)


main()
