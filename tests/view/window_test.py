#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""window_test.py HAPTIC_PLAYER SPHERETREE: the window on a virtual display, driven as by a user. Exit code 77 where
Xvfb or xdotool are missing.

A drag moves the tool and presses it on the object, keys begin and end recordings, closing the window ends the run like
an emergency stop, and a signal at any time leaves a whole recording. """
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PLAYER, SPHERETREE = sys.argv[1:3]
if not shutil.which("Xvfb") or not shutil.which("xdotool"):
    sys.exit(77)


def start_display():
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1000x700x24", "-noreset"], pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as told:
        display = ":" + told.readline().strip()  # the whole line: the server gives up if nobody reads its end
    for _ in range(50):  # until it answers
        asked = subprocess.run(["xdotool", "getdisplaygeometry"], env=os.environ | {"DISPLAY": display}, capture_output=True, check=False)
        if asked.returncode == 0:
            return server, display
        time.sleep(0.1)
    server.terminate()
    sys.exit(f"FAILED: the virtual display {display} does not answer")


def write_scene(folder):
    for name, text in (("tool", "2 2\n0 0 0 2 1\n0.5 0 0 1.25 1\n-0.5 0.1 0 1.125 1\n"),
                       ("object", "2 2\n0 0 -6.5 6 1\n0.5 0 -6.5 5.5 1\n-0.5 0 -6.5 5.5 1\n")):
        (folder / f"{name}.sph").write_text(text)
        subprocess.run([SPHERETREE, "convert", folder / f"{name}.sph", folder / f"{name}.stree"], check=True)
    (folder / "scene.json").write_text('{"schema": "spheretree.scene/1", "tool": {"name": "tool", "tree": "tool.stree"},'
                                       ' "objects": [{"name": "object", "tree": "object.stree"}]}')
    rows = "\n".join(f"{n / 1000:.3f},0,0,4,1,0,0,0" for n in range(10))
    (folder / "start.csv").write_text("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + rows + "\n")


def xdo(*words):
    subprocess.run(["xdotool", *map(str, words)], check=True)


def open_player(folder, *more):
    player = subprocess.Popen([PLAYER, "scene.json", "--view", "--trajectory", "start.csv", "--from", "0,-1,0", "--within", "20", "--size", "900x600",
                               *more],
                              cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(200):
        if player.poll() is not None:
            sys.exit(f"the player ended: {player.communicate()}")
        if subprocess.run(["xdotool", "search", "--name", "haptic-player"], capture_output=True, check=False).stdout:
            break
        time.sleep(0.1)
    time.sleep(1.5)  # the first frames
    return player


def column(path, name):
    lines = path.read_text().splitlines()
    at = lines[0].split(",").index(name)
    return [float(line.split(",")[at]) for line in lines[1:]]


def drag(steps, down):
    xdo("mousemove", 300, 150)
    time.sleep(0.2)
    xdo("mousedown", 1)
    for _ in range(steps):
        xdo("mousemove_relative", "--", 0, down)
        time.sleep(0.03)
    xdo("mouseup", 1)
    time.sleep(1)


def check(condition, message):
    if not condition:
        sys.exit(f"FAILED: {message}")


def check_drag_and_close(folder):
    player = open_player(folder, "--record", "run.csv", "--json")
    drag(40, 2)
    xdo("key", "r")  # ends the recording that --record began
    time.sleep(0.6)
    xdo("key", "r")  # begins another one
    time.sleep(1)
    xdo("key", "r")
    time.sleep(0.6)
    xdo("key", "ctrl+q")
    out, err = player.communicate(timeout=30)
    check(player.returncode == 0, f"closing the window gave exit code {player.returncode}: {err}")
    check('"end": "complete"' in out, f"the run does not say how it ended: {out}")
    z = column(folder / "run.csv", "hz_mm")
    check(z[0] > 3.5 and min(z) < 2.5, f"the drag moved the tool from {z[0]} to {min(z)} mm")
    check(max(column(folder / "run.csv", "fz_n")) > 0.05, "nothing was felt")
    ticks = column(folder / "run.csv", "tick")
    check(ticks == list(range(len(ticks))), "the recording has gaps")
    later = column(folder / "run-1.csv", "tick")
    check(len(later) > 300 and later[0] > ticks[-1], "the second recording is not one of its own")


def check_press(folder):
    """The way of the pointer before a press, as of a pen that is put down elsewhere, moves no hand."""
    player = open_player(folder, "--record", "press.csv", "--seconds", "4")
    xdo("mousemove", 200, 150)
    time.sleep(0.3)
    for place in (400, 200, 400, 200):
        xdo("mousemove", place, 150, "mousedown", 1)
        time.sleep(0.1)
        xdo("mouseup", 1)
        time.sleep(0.1)
    player.communicate(timeout=30)
    x = column(folder / "press.csv", "hx_mm")
    check(max(x) - min(x) < 0.2, f"pressing moved the hand by {max(x) - min(x)} mm")


def check_keyboard(folder):
    player = open_player(folder, "--hand-from", "keyboard", "--record", "keys.csv", "--seconds", "6")
    xdo("mousemove", 300, 150)
    xdo("keydown", "Right")
    time.sleep(0.5)
    xdo("keyup", "Right")
    player.communicate(timeout=30)
    check(player.returncode == 0, "a run with an end fails")
    x = column(folder / "keys.csv", "hx_mm")
    check(2 < x[-1] < 25, f"half a second at 20 mm/s led to {x[-1]} mm")
    rows = len(x)
    check(rows == 6000, f"{rows} rows of 6 s")


def box(low, high):
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = "134 142 568 587 126 165 378 384 157 173 248 286"
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces.split())


def check_burr(folder):
    """A key starts and stops the burr, which rests at first."""
    (folder / "block.obj").write_text(box((-4, -4, -4), (4, 4, 0)))
    (folder / "stick.obj").write_text(box((-0.2, -0.2, -0.2), (0.2, 0.2, 4)))
    (folder / "cut.scene.json").write_text(json.dumps({
        "schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2},
        "tool": {"name": "stick", "mesh": "stick.obj", "burr": [{"centre_mm": [0, 0, 0], "radius_mm": 0.5}]},
        "objects": [{"name": "block", "mesh": "block.obj",
                     "cut": {"layers": [{"name": "block", "mesh": "block.obj"}], "removal_mm_per_n_s": {"block": 5}}}]}))
    subprocess.run([SPHERETREE, "batch", "cut.scene.json", "-o", "cut", "-q"], cwd=folder, check=True)
    (folder / "cut" / "start.csv").write_text((folder / "start.csv").read_text())
    player = open_player(folder / "cut", "--hand-from", "keyboard", "--record", "burr.csv")
    for _ in range(2):
        xdo("key", "b")
        time.sleep(1)
    xdo("key", "ctrl+q")
    _, err = player.communicate(timeout=30)
    check(player.returncode == 0, f"a run with a burr fails: {err}")
    spins = column(folder / "cut" / "burr.csv", "spin")
    changes = [n for n in range(1, len(spins)) if spins[n] != spins[n - 1]]
    check(spins[0] == 0 and spins[-1] == 0 and len(changes) == 2, f"the key turned the burr at the steps {changes}")


def check_course(folder):
    """Pause, single steps, slow motion, reset, screenshot and film of a live run, by keys."""
    def run_of(action, text):
        """The keys of `action`, then what the run says of itself at its end."""
        player = open_player(folder, "--record", text + ".csv", "--json")
        action()
        xdo("key", "ctrl+q")
        out, err = player.communicate(timeout=60)
        check(player.returncode == 0, f"{text}: exit code {player.returncode}: {err}")
        return json.loads(out), column(folder / f"{text}.csv", "tick"), err

    def pause():
        xdo("key", "space")
        time.sleep(1)
        xdo("key", "c")  # the frame after it shows the pause
        time.sleep(3)
        xdo("key", "n", "key", "n", "key", "n")
        time.sleep(1)

    run, ticks, err = run_of(pause, "paused")
    check(run["end"] == "complete", "a paused run does not end")
    check(ticks == list(range(len(ticks))), "the recording of a paused run has gaps")
    check("paused-1.png" in err and (folder / "paused-1.png").read_bytes()[:4] == b"\x89PNG", f"no screenshot: {err}")

    def reset():
        drag(30, 2)
        xdo("key", "BackSpace")
        time.sleep(1.5)
        xdo("key", "r")
        time.sleep(1.5)
        xdo("key", "v")
        time.sleep(2)
        xdo("key", "v")
        time.sleep(1)

    _, ticks, err = run_of(reset, "again")
    check(ticks == list(range(len(ticks))), "a recording goes beyond a reset")
    after = column(folder / "again-1.csv", "hz_mm")
    check(max(after) - min(after) < 0.5 and min(after) > 3.5, f"the tool is not back at its start: {min(after)} to {max(after)}")
    check(column(folder / "again-1.csv", "tick")[0] > 0, "the time goes on from the reset")
    check("ffmpeg -framerate" in err and (folder / "again-1-film" / "00001.png").exists(), f"no film: {err}")


def check_killed(folder, times):
    dice = random.Random(1)
    for n in range(times):
        player = open_player(folder, "--record", f"killed{n}.csv")
        time.sleep(dice.uniform(0, 1))
        player.send_signal(dice.choice([signal.SIGTERM, signal.SIGINT, signal.SIGHUP]))
        player.communicate(timeout=30)
        check(player.returncode == 130, f"a signal gave exit code {player.returncode}")
        ticks = column(folder / f"killed{n}.csv", "tick")
        check(len(ticks) > 500 and ticks == list(range(len(ticks))), "the recording of a run that was stopped is not whole")


def main():
    server, display = start_display()
    os.environ.update(DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")
    os.environ.pop("WAYLAND_DISPLAY", None)
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_scene(folder)
            check_drag_and_close(folder)
            check_press(folder)
            check_keyboard(folder)
            check_burr(folder)
            check_course(folder)
            check_killed(folder, 3)
    finally:
        server.terminate()
        server.wait()


main()
