# SPDX-License-Identifier: GPL-3.0-or-later
"""An outside opinion on what is felt: an independent program drags a ball over a mesh with the player and compares the
force and the place of the graphic tool with the mesh, or with the smooth surface that it stands for.

usage: feel_figures.py FEEL.py SPHERETREE PLAYER MESH WORK NAME=LIMIT... [-- OPTION...]

Prints what that program measured and each figure beside its limit; exits with 1 if one is above. NAME: angle_median,
angle_p99 [degree], inside, outside (1st and 99th percentile of the stand-off) [mm], jump_median, jump_max [N]. Options
go to that program. """
import json
import subprocess
import sys

feel, spheretree, player, mesh, work, *rest = sys.argv[1:]
split = rest.index("--") if "--" in rest else len(rest)
# Without its reference of interpolated normals, on which no limit is set: it takes nineteen twentieths of the time.
program = "import sys; exec(open(sys.argv.pop(1)).read().replace('\\nmain()\\n', '\\nphong = lambda *_: [0]\\nmain()\\n'))"
run = subprocess.run([sys.executable, "-c", program, feel, spheretree, player, mesh, work, "--modes", "--mode constrained", *rest[split + 1:]],
                     capture_output=True, text=True)
sys.stderr.write(run.stderr)
if run.returncode:
    sys.exit(run.returncode)
line = json.loads(run.stdout.splitlines()[-1])
print(run.stdout.strip())
figures = {
    "angle_median": line["angle_deg"]["median"],
    "angle_p99": line["angle_deg"]["p99"],
    "inside": -line["stand_off_mm"]["p1"],
    "outside": line["stand_off_mm"]["p99"],
    "jump_median": line["force_jump_N"]["median"],
    "jump_max": line["force_jump_N"]["max"],
}
missed = 0
for limit in rest[:split]:
    name, most = limit.split("=")
    verdict = "holds" if figures[name] <= float(most) else "MISSED"
    missed += verdict == "MISSED"
    print(f"{name:14} {figures[name]:9.4f}  at most {float(most):g}  {verdict}")
sys.exit(missed > 0)
