# SPDX-License-Identifier: Apache-2.0
"""pip_install.py SOURCE BUILD: `pip install .` without network gives a package that builds a tree. BUILD spares the
compilation."""
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

CHECK = """
import numpy, spheretree
vertices = numpy.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], float)
triangles = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
print(spheretree.__file__)
assert spheretree.build(vertices, triangles, levels=2).level_count == 2
"""


def main():
    source, build = map(Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, system_site_packages=True, with_pip=False)
        python = Path(folder, "bin/python")
        subprocess.run([sys.executable, "-m", "pip", "--python", python, "install", "--no-index", "--no-cache-dir", "--quiet",
                        "--config-settings", f"build-dir={build}", source], check=True, cwd=folder)
        where = subprocess.run([python, "-c", CHECK], check=True, cwd=folder, capture_output=True, text=True).stdout.strip()
        if not Path(where).is_relative_to(folder):
            sys.exit(f"the package comes from {where}, not from {folder}")
        installed = sorted(p.name for p in Path(where).parent.iterdir() if p.suffix != "" and p.name != "__pycache__")
        wanted = {"__init__.py", "_core.pyi", "_builder.pyi", "py.typed"}
        if not wanted <= set(installed) or sum(name.endswith(".so") for name in installed) != 2:
            sys.exit(f"installed are {installed}")
        listed = subprocess.run([sys.executable, "-m", "pip", "--python", python, "show", "-f", "spheretree"], check=True, capture_output=True, text=True).stdout
        if "GPL-3.0-or-later" not in listed or "LICENSE" not in listed:
            sys.exit(listed)
        subprocess.run([sys.executable, "-m", "pip", "--python", python, "uninstall", "-y", "--quiet", "spheretree"], check=True)
        if Path(where).exists():
            sys.exit(f"{where} is still there")
    print("pip install: a tree was built")


main()
