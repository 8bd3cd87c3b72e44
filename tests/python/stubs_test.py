# SPDX-License-Identifier: Apache-2.0
"""The stubs say what is there, and everything that users import is documented."""
import inspect
import subprocess
import sys

import spheretree


def test_stubs_agree_with_the_modules(tmp_path):
    # Classes of pybind11 have a metaclass and an __init__(*args) of its own; their members are compared.
    (tmp_path / "allowed").write_text(r"spheretree\._(core|builder)\.[A-Z]\w*(\.__init__)?" + "\n")
    run = subprocess.run([sys.executable, "-m", "mypy.stubtest", "spheretree._core", "spheretree._builder", "--ignore-missing-stub",
                          "--allowlist", tmp_path / "allowed", "--ignore-unused-allowlist"],
                         cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_typed_code_passes_and_mistakes_do_not(tmp_path):
    good = "import spheretree\ntree = spheretree.build(spheretree.read('a.obj'), tolerance=0.1)\ncentres, radii = tree.level(3)\nx: float = tree.overhang_bound\n"
    (tmp_path / "good.py").write_text(good)
    (tmp_path / "bad.py").write_text(good + "y: str = tree.overhang_bound\ntree.levels\n")
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "good.py", "bad.py"], cwd=tmp_path, capture_output=True, text=True)
    mistakes = [line.split(":")[:2] for line in run.stdout.splitlines() if ": error:" in line]
    assert run.returncode == 1 and mistakes == [["bad.py", "5"], ["bad.py", "6"]], run.stdout + run.stderr


def test_every_name_is_documented():
    for name in spheretree.__all__:
        thing = getattr(spheretree, name)
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and thing.__module__ == "spheretree" and not issubclass(thing, (Exception, int)):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    assert inspect.getdoc(value), f"{name}.{member}"
