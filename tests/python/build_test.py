# SPDX-License-Identifier: Apache-2.0
"""Builds: the same bytes as the program, progress out, Ctrl-C in."""
import os
import signal
import subprocess
import threading
import time
import warnings

import numpy as np
import pytest
from conftest import ellipsoid, surface_points

import spheretree


@pytest.mark.parametrize("options, settings", [
    ([], {}),
    (["--tolerance", "0.7", "--levels", "3"], {"tolerance": 0.7, "levels": 3}),
    (["--builder", "grid", "--levels", "3", "--branching", "4", "--skin", "off"], {"builder": "grid", "levels": 3, "branching": 4, "skin": None}),
    (["--leaves", "20", "--seed", "7", "--skin", "0.05", "--crease-angle", "30"], {"leaves": 20, "seed": 7, "skin": 0.05, "crease_angle": 30}),
])
def test_the_same_bytes_as_the_program(options, settings, molar, program, tmp_path):
    out = tmp_path / "molar.stree"
    subprocess.run([program, "build", molar, "-o", out, "--quality", "quick", "-q", *options], check=True, capture_output=True)
    mesh = spheretree.read(molar)
    expected = out.read_bytes()
    assert spheretree.build(mesh, quality="quick", **settings).to_bytes() == expected
    # From arrays, with any number of repeated vertices, and for any number of threads.
    soup = mesh.vertices[mesh.triangles].reshape(-1, 3)
    for threads in (1, 2):
        assert spheretree.build(mesh.vertices, mesh.triangles, quality="quick", threads=threads, **settings).to_bytes() == expected
    assert len(spheretree.Mesh(soup, np.arange(len(soup)).reshape(-1, 3)).vertices) == len(mesh.vertices)


def test_the_unit_of_the_file_is_recorded(molar, program, tmp_path):
    out = tmp_path / "molar.stree"
    subprocess.run([program, "build", molar, "-o", out, "--quality", "quick", "--unit", "cm", "--levels", "2", "-q"], check=True, capture_output=True)
    assert spheretree.build(spheretree.read(molar, unit="cm"), quality="quick", levels=2).to_bytes() == out.read_bytes()


def test_every_level_covers_the_surface():
    vertices, triangles = ellipsoid()
    tree = spheretree.build(vertices, triangles, levels=3)
    points = surface_points(vertices, triangles, 10**5)
    for level in range(tree.level_count):
        centres, radii = tree.level(level)
        gap = np.min([np.linalg.norm(points - (c + tree.origin), axis=1) - r for c, r in zip(centres.astype(float), radii.astype(float))], axis=0)
        assert gap.max() <= 0
    assert 0 < tree.overhang_bound == tree.overhang_bounds[-1]
    statistics = tree.statistics
    assert [level["spheres"] for level in statistics["levels"]] == [len(tree.level(k)[1]) for k in range(3)]
    assert statistics["tolerance_met"] is None and statistics["repair"] == [] and statistics["seconds"] > 0


def test_progress_is_told_from_the_calling_thread():
    told = []
    spheretree.build(*ellipsoid(), quality="quick", progress=lambda stage, fraction: told.append((stage, fraction, threading.get_ident())))
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages[0] == "check" and len(stages) > 2
    assert all(0 <= fraction <= 1 for _, fraction, _ in told)
    assert {ident for _, _, ident in told} == {threading.get_ident()}


def test_what_the_callback_raises_ends_the_build():
    class Enough(Exception):
        pass

    def progress(stage, fraction):
        raise Enough(stage)

    with pytest.raises(Enough, match="check"):
        spheretree.build(*ellipsoid(), quality="best", progress=progress)


def test_ctrl_c_cancels(molar):
    mesh = spheretree.read(molar)
    started = threading.Event()

    def interrupt():
        started.wait()
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        spheretree.build(mesh, quality="best", levels=5, progress=lambda stage, fraction: started.set())
    assert spheretree.build(mesh, quality="quick", levels=2).level_count == 2  # and nothing is left over


def test_ctrl_c_cancels_without_a_callback(molar):
    mesh = spheretree.read(molar)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        spheretree.build(mesh, quality="best", levels=5)


def test_other_threads_of_python_run_meanwhile(molar):
    mesh, times, end = spheretree.read(molar), [], threading.Event()

    def count():
        while not end.is_set():
            times.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.perf_counter()
    spheretree.build(mesh, levels=3)
    built = time.perf_counter()
    end.set()
    thread.join()
    # With the GIL held there would be at most one between begin and end.
    assert sum(begin < t < built for t in times) > 5


def test_repairs_and_missed_tolerances_are_warnings():
    vertices, triangles = ellipsoid()
    with pytest.warns(spheretree.MeshWarning, match="hole|border"):
        tree = spheretree.build(vertices, triangles[1:], quality="quick", levels=2)
    assert tree.statistics["repair"]
    with pytest.warns(spheretree.MeshWarning, match="tolerance is not met"):
        tree = spheretree.build(vertices, triangles, quality="quick", levels=2, tolerance=1e-3)
    assert tree.statistics["tolerance_met"] is False
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert spheretree.build(vertices, triangles, quality="quick", levels=3, tolerance=2).statistics["tolerance_met"] is True
        with pytest.raises(spheretree.MeshWarning):
            spheretree.build(vertices, triangles[1:], quality="quick", levels=2)


@pytest.mark.parametrize("settings, error, says", [
    ({"levels": 7}, ValueError, "levels"),
    ({"branching": 1}, ValueError, "branching"),
    ({"tolerance": 0}, ValueError, "tolerance"),
    ({"tolerance": float("nan")}, ValueError, "tolerance"),
    ({"leaves": 0}, ValueError, "leaves"),
    ({"quality": "fast"}, ValueError, "quick, standard, best"),
    ({"builder": "octrees"}, ValueError, "octree"),
    ({"skin": -1}, ValueError, "skin"),
    ({"skin": "of"}, TypeError, "skin"),
    ({"repair": "on"}, ValueError, "auto, off or wrap"),
    ({"threads": -1}, ValueError, "threads"),
    ({"tolerence": 1}, TypeError, "incompatible"),
])
def test_settings_out_of_range_are_refused(settings, error, says):
    with pytest.raises(error) as refusal:
        spheretree.build(*ellipsoid(), **settings)
    assert says in str(refusal.value)


def test_a_mesh_that_no_build_takes_is_refused():
    vertices, triangles = ellipsoid()
    with pytest.raises(spheretree.BuildError, match="border"):
        spheretree.build(vertices, triangles[1:], repair="off")
    vertices[0, 0] = np.nan
    with pytest.raises(spheretree.BuildError, match="finite"):
        spheretree.build(vertices, triangles)
    for mesh, more in [("molar.obj", None), (ellipsoid()[0], None), (spheretree.Mesh(*ellipsoid()), ellipsoid()[1])]:
        with pytest.raises(TypeError):
            spheretree.build(mesh, more)


def test_checks_and_repairs():
    vertices, triangles = ellipsoid()
    report = spheretree.check(vertices, triangles)
    assert report and report.clean and report.summary().startswith("no defects") and len(report.components) == 1
    assert report.volume == pytest.approx(4 / 3 * np.pi * 9 * 6 * 4, rel=0.02)
    assert report.low == pytest.approx([-9, -6, -4], rel=0.01) and report.high == pytest.approx([9, 6, 4], rel=0.01)
    open_mesh = spheretree.Mesh(vertices, triangles[1:])
    report = spheretree.check(open_mesh)
    assert not report and [(d.kind, d.count) for d in report.defects] == [("border", 3)]
    assert len(report.defects[0].first) == 3 and len(report.defects[0].first[0].vertices) == 2
    repaired = spheretree.repair(open_mesh)
    assert repaired.is_sound and repaired.steps[0].kind == "fill holes" and spheretree.check(repaired.mesh).clean
    assert not spheretree.repair(open_mesh, repair="off").is_sound
