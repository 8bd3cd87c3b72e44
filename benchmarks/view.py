#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""view.py BUILD [SECONDS]: what the window costs the servo loop, and what a frame costs. Prints a table.

The sample mouth on trees of 512 leaves, the probe along `inspection.csv` on the real clock, SECONDS (default 60)
without a window and with one on a virtual display, drawn by the processor (Mesa llvmpipe), at two sizes. Needs Xvfb.
Run it on an otherwise idle machine; compare the columns, which are of one run, not the runs of two machines."""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

build = Path(sys.argv[1]).resolve()
seconds = sys.argv[2] if len(sys.argv) > 2 else "60"
SPHERETREE, PLAYER = build / "tools/spheretree/spheretree", build / "tools/haptic_player/haptic-player"
CASES = [("no window", []), ("window of 640 x 480, 64 spheres an object", ["--size", "640x480", "--show", "spheres"]),
         ("window of 1280 x 720, meshes", ["--size", "1280x720"])]


def output(*command, **more):
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE, text=True, **more).stdout


def display():
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x900x24", "-noreset"], pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as told:
        return server, ":" + told.readline().strip()


def there_and_back(folder):
    """The path of the mouth, forth and back until it lasts long enough."""
    head, *rows = (folder / "mouth/inspection.csv").read_text().splitlines()
    poses = [row.split(",", 1)[1] for row in rows]
    poses += poses[::-1]
    wanted = int(1000 * float(seconds)) + 1
    lines = [f"{n / 1000:.3f},{poses[n % len(poses)]}" for n in range(wanted)]
    (folder / "path.csv").write_text("\n".join([head, *lines]) + "\n")


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    output(build / "samples/make_samples/make_samples", "--mouth", folder / "mouth")
    output(SPHERETREE, "batch", folder / "mouth/mouth.scene.json", "-o", folder / "trees", "--quality", "quick", "-q")
    there_and_back(folder)
    server, name = display()
    try:
        print("| | step: median / p99 / p99.9 | late | frame: median / p99 | first frame | not shown |\n|---|---|---|---|---|---|")
        for title, options in CASES:
            view = ["--view", "--hand-from", "file", *options] if options else []
            environment = os.environ | {"DISPLAY": name, "LIBGL_ALWAYS_SOFTWARE": "1"}
            run = json.loads(output(PLAYER, folder / "trees/scene.json", "--device", "simulated", "--trajectory", folder / "path.csv", "--clock", "real",
                                    "--seconds", seconds, "--json", "--progress", "none", *view, env=environment))
            step, shown = run["time_us"]["total"], run.get("view")
            row = [title, f"{step['median']:.1f} / {step['p99']:.0f} / {step['p99_9']:.0f} us", f"{run['missed_deadlines']} steps"]
            row += [f"{shown['frame_us']['median'] / 1000:.0f} / {shown['frame_us']['p99'] / 1000:.0f} ms", f"{shown['first_frame_s']:.2f} s",
                    f"{shown['steps_not_shown']} steps"] if shown else ["", "", ""]
            print("| " + " | ".join(row) + " |", flush=True)
    finally:
        server.terminate()
