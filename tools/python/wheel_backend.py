# SPDX-License-Identifier: Apache-2.0
"""What `pip install .` calls: builds the package by CMake and packs it as a wheel (PEP 517, PEP 427).

It stands on the standard library alone. pip builds in an environment of its own, where packages of Debian are not seen,
and would fetch whatever a ready-made backend is from the network.

Settings (pip install . --config-settings NAME=VALUE):
  build-dir  folder of the build; default build/python. One that is configured already is used as it is.
  jobs       compilers at a time; default: as many as the machine has
"""
import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
LICENCES = ("LICENSE", "LICENSE-APACHE-2.0", "LICENSE-GPL-3.0")
METADATA = """Metadata-Version: 2.1
Name: spheretree
Version: {version}
Summary: Certified sphere-trees of triangle meshes, spheres for robots, and a haptic runtime
License: GPL-3.0-or-later
License-File: LICENSE
License-File: LICENSE-APACHE-2.0
License-File: LICENSE-GPL-3.0
Requires-Python: >=3.9
Requires-Dist: numpy

{readme}"""


def version():
    return re.search(r"project\(spheretree VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)


def run(*command):
    print("+", *command, flush=True)
    subprocess.run([str(word) for word in command], check=True)


def install_package(settings, folder):
    """Builds, and installs the folder `spheretree` of the package into `folder`."""
    build = Path(settings.get("build-dir", SOURCE / "build/python"))
    jobs = settings.get("jobs", str(os.cpu_count() or 1))
    if not (build / "CMakeCache.txt").exists() or "build-dir" not in settings:
        run("cmake", "-S", SOURCE, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DSPHERETREE_TESTS=OFF", f"-DSPHERETREE_PYTHON_EXECUTABLE={sys.executable}")
    run("cmake", "--build", build, "--parallel", jobs, "--target", "python_package")
    run("cmake", "--install", build, "--component", "python", "--prefix", folder, "--strip")
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    if not (folder / f"spheretree/_core{suffix}").exists():
        sys.exit(f"{build} builds the package for another interpreter than {sys.executable}. Leave build-dir out, or configure that folder with "
                 f"-DSPHERETREE_PYTHON_EXECUTABLE={sys.executable}.")


def metadata():
    return METADATA.format(version=version(), readme="Documentation: docs/python.md\n")


def wheel_text(tag):
    return f"Wheel-Version: 1.0\nGenerator: spheretree wheel_backend\nRoot-Is-Purelib: false\nTag: {tag}\n"


def pack(path, files):
    """A wheel of (name, bytes), with the list of hashes that it must end with."""
    record = next(name for name, _ in files if name.endswith("/WHEEL")).replace("WHEEL", "RECORD")
    lines = []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, content in sorted(files):
            wheel.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            lines.append(f"{name},sha256={digest},{len(content)}\n")
        wheel.writestr(zipfile.ZipInfo(record), "".join(lines) + f"{record},,\n", zipfile.ZIP_DEFLATED)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub(r'[-.]', '_', sysconfig.get_platform())}"
    info = f"spheretree-{version()}.dist-info"
    files = [(f"{info}/METADATA", metadata().encode()), (f"{info}/WHEEL", wheel_text(tag).encode())]
    files += [(f"{info}/{name}", (SOURCE / name).read_bytes()) for name in LICENCES]
    with tempfile.TemporaryDirectory() as folder:
        install_package(config_settings or {}, Path(folder))
        files += [(str(p.relative_to(folder)), p.read_bytes()) for p in Path(folder).rglob("*") if p.is_file()]
    name = f"spheretree-{version()}-{tag}.whl"
    pack(Path(wheel_directory, name), files)
    return name


def build_sdist(sdist_directory, config_settings=None):
    """What Git holds, as it was committed last."""
    name = f"spheretree-{version()}"
    run("git", "-C", SOURCE, "archive", "--format=tar.gz", f"--prefix={name}/", "-o", Path(sdist_directory).resolve() / f"{name}.tar.gz", "HEAD")
    return f"{name}.tar.gz"
