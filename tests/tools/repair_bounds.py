#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""repair_bounds.py SPHERETREE: bodies that nearly coincide are repaired within bounds of time, memory and size, and an
interrupt ends every verb at any moment.

Processor time is printed and decides nothing; the answer to an interrupt is measured by the clock. With
SPHERETREE_LONG=1 every kind is tried with every offset, else with one. """
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from coincident_bodies import KINDS, plates, write_obj  # noqa: E402

spheretree = str(Path(sys.argv[1]).resolve())
is_long = os.environ.get("SPHERETREE_LONG") == "1"
FILES, BYTES = 50, 300e6               # memory: 50 times the file and 300 MB beside it
GROWTH, MORE = 4, 200_000              # triangles: 4 times those read and 200,000 beside them
failures = []


def run(*words):
    """The exit code, the processor time [s] and the memory [bytes] of a command, and what it printed."""
    child = subprocess.Popen([spheretree, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    text = child.stdout.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024, text


def within_bounds(folder):
    for number, (kind, make) in enumerate(KINDS.items()):
        for offset in [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3] if is_long else [(1e-6, 1e-3)[number % 2]]:
            path = folder / f"{kind}_{offset}.obj"
            mesh = make(offset)
            write_obj(path, mesh)
            code, seconds, memory, text = run("repair", path, "-o", folder / "out.ply", "--json")
            name = f"{kind}, {offset}"
            if code != 0:
                failures.append(f"{name}: exit code {code}: {text}")
                continue
            found = json.loads(text[text.index("{"):])
            step = found["repair"]["steps"][-1]["step"] if found["repair"]["steps"] else "none"
            print(f"{name}: {len(mesh[1])} triangles become {found['triangles']}, {seconds:.2f} s, {memory / 1e6:.0f} MB, "
                  f"bound {found['repair']['bound_mm']:.2g} mm, last step {step}")
            if memory > FILES * path.stat().st_size + BYTES:
                failures.append(f"{name}: {memory / 1e6:.0f} MB for {path.stat().st_size / 1e6:.2f} MB")
            if found["triangles"] > GROWTH * len(mesh[1]) + MORE:
                failures.append(f"{name}: {found['triangles']} triangles of {len(mesh[1])}")
            if run("check", folder / "out.ply", "--fail-on", "defects")[0] != 0:
                failures.append(f"{name}: the repaired mesh has defects")


def answer(words, delay):
    """Seconds between an interrupt after `delay` and the end of the command; None if it ended before."""
    child = subprocess.Popen([spheretree, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(delay)
    if child.poll() is not None:
        return None
    begun = time.monotonic()
    child.send_signal(signal.SIGINT)
    code = child.wait(timeout=300)
    taken = time.monotonic() - begun
    return taken if code == 130 else None if code in (0, 4, 5) else failures.append(f"{words[0]}: exit code {code}")


def interrupts(folder):
    mesh = folder / "many.obj"
    write_obj(mesh, plates(1e-4, side=40, count=6))
    (folder / "r.urdf").write_text('<robot name="r"><link name="a"><collision><geometry><mesh filename="many.obj" '
                                   'scale="0.001 0.001 0.001"/></geometry></collision></link></robot>')
    verbs = {"check": ["check", mesh], "repair": ["repair", mesh, "-o", folder / "o.ply"],
             "build": ["build", mesh, "-o", folder / "o.stree"], "evaluate": ["evaluate", mesh, folder / "quick.stree"],
             "robot": ["robot", folder / "r.urdf", "-o", folder / "robot"],
             "batch": ["batch", mesh, "-o", folder / "batch"]}
    small = folder / "small.obj"
    write_obj(small, plates(0, side=2, count=1))
    if run("build", small, "-o", folder / "quick.stree", "--quality", "quick", "--levels", "2")[0] != 0:
        failures.append("build of one plate")
    for verb, words in verbs.items():
        worst = 0
        for delay in [0.05, 0.2, 0.5, 1, 2, 4] if is_long else [0.2, 0.8]:
            taken = answer(words, delay)
            if taken is None:
                break
            worst = max(worst, taken)
        print(f"{verb}: ends at most {worst:.2f} s after an interrupt")
        # Half a second on an idle machine; the tests run beside others.
        if worst > 0.5 * max(1, os.getloadavg()[0]):
            failures.append(f"{verb}: {worst:.2f} s after an interrupt")


with tempfile.TemporaryDirectory() as folder:
    within_bounds(Path(folder))
    interrupts(Path(folder))
for failure in failures:
    print("FAILED:", failure)
sys.exit(1 if failures else 0)
