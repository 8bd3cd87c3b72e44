#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/setup.sh [--build|--ci|--lanes|--site|--package]: installs the Debian packages that building and testing need;
# with --build only those of the programs, with --ci those of .ci/run as well, with --lanes those of .ci/lane, with
# --site those of tools/site.sh, with --package those of tools/package.sh.
# Only missing packages are installed, so if all are there, it needs neither network nor rights.
set -euo pipefail

packages=(
  g++ cmake ninja-build python3
  libeigen3-dev           # linear algebra
  libcgal-dev             # builder: Delaunay triangulation, exact predicates
  libtbb-dev              # builder: threads
  libopenmesh-dev         # builder: simplification
  libxxhash-dev           # builder: hashes of mesh and settings
  nlohmann-json3-dev      # formats, program: JSON
  libtinygltf-dev         # formats: writes GLB
  libmeshoptimizer-dev libdraco-dev # formats: compressed glTF
  libcli11-dev libpng-dev # program: command line, pictures
  zlib1g-dev libjs-three  # program: pages
  librsvg2-bin            # program: charts as PDF
  libtinyxml2-dev libyaml-cpp-dev # program: robots
  libglfw3-dev libimgui-dev # view: window, panels
  libegl-dev              # view: pictures without a display
  fonts-dejavu-core       # view: text
  libassimp-dev           # program: meshes of robots, spheretree-import: other mesh formats
  libtet1.5-dev           # soft tissue, tests: TetGen, in programs of their own
  pybind11-dev python3-dev python3-numpy # Python package
)
if [[ "${1:-}" != --build ]]; then
  packages+=(
    libgtest-dev
    python3-pytest mypy python3-yaml python3-pip # tests of the Python package
    python3-jsonschema # schemas of JSON
    liburdfdom-dev libmujoco-dev # files of robots as other programs read them
  )
fi
if [[ "${1:-}" == --site || "${1:-}" == --package ]]; then packages+=(python3-sphinx furo python3-myst-parser doxygen); fi
if [[ "${1:-}" == --package ]]; then packages+=(build-essential dpkg-dev debhelper dh-python fakeroot lintian debootstrap autopkgtest git); fi
if [[ "${1:-}" == --lanes ]]; then
  packages+=(
    clang-tidy gcovr
    g++-mingw-w64-x86-64-posix wine wine64     # lane windows
    g++-aarch64-linux-gnu qemu-user-static # lane arm64
  )
fi
if [[ "${1:-}" == --ci || "${1:-}" == --lanes ]]; then
  packages+=(clang clang-format dpkg-dev git chromium chromium-driver xvfb xdotool parallel slurmctld slurmd slurm-client munge python3-scipy)
fi

missing=()
for package in "${packages[@]}"; do
  [[ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

root=()
if [[ $EUID -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "tools/setup.sh: these packages are missing; install them as root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  root=(sudo)
fi
echo "Installing ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${root[@]}" apt-get update && "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } \
  >"$log" 2>&1 </dev/null; then
  cat "$log" >&2
  echo "tools/setup.sh: the packages cannot be installed; apt-get says why above." >&2
  exit 1
fi
