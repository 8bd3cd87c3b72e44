#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/site.sh [BUILD [OUT]]: makes one site from the documents: every page, the reference of C, C++ and Python, all
# commands with their options, tutorials, and a gallery with the interactive pages of the sample mouth.
# BUILD, default build/release, has the programs; OUT, default build/site, receives the site: OUT/index.html. Needs no
# network; tools/setup.sh --site installs what it needs. With SOURCE_DATE_EPOCH, as in a Debian package, it lacks the
# pages that show measured times.
set -euo pipefail
caller=$PWD
cd "$(dirname "$0")/.."
build=$(cd "$caller" && realpath "${1:-$OLDPWD/build/release}")
out=$(cd "$caller" && realpath -m "${2:-$OLDPWD/build/site}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
SPHERETREE_VERSION=$(sed -n 's/^project(spheretree VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
export SPHERETREE_VERSION PYTHONPATH=$build/python PYTHONDONTWRITEBYTECODE=1 PYTHONHASHSEED=0

python3 tools/site/stage.py pages "$build" "$work/stage"
tools/site/gallery.sh "$build" "$work/extra/gallery"
for page in mouth robot comparison; do  # a page that is not made has no link
  [[ -e $work/extra/gallery/$page.html ]] || sed -i "s#<a href=\"../gallery/$page.html\">\([^<]*\)</a>#\1#" "$work/stage/docs/gallery.md"
done
# The first page of the reference, which Doxygen would leave empty.
cat >"$work/first.dox" <<'END'
/** \mainpage Interfaces in C and C++
Every header says what it is for at its top. <a href="files.html">All headers</a>, <a href="annotated.html">all
classes and structs</a>, or the search above.

| for | headers |
|---|---|
| contact forces, in C | spheretree/runtime/runtime.h, spheretree/scene/scene.h, spheretree/servo/servo.h |
| contact forces, in C++ | spheretree/runtime/scene.h, spheretree/runtime/step.h |
| building trees | spheretree/builder/build_sphere_tree.h, spheretree/builder/repair_mesh.h |
| files | spheretree/formats/mesh_file.h, spheretree/formats/sphere_tree_file.h, spheretree/formats/scene_file.h |
| devices | spheretree/device/device.h, spheretree/device/open_device.h |
| soft tissue in large motion | spheretree/tissue/tissue_solver.h |

The <a href="../index.html">site</a> has guides with whole programs.
*/
END
(cat <<END
INPUT = $work/first.dox device/include formats/include libruntime/core/include libruntime/runtime/include libruntime/scene/include
INPUT += libruntime/servo/include libruntime/tissue/include libspheretree/include
FILE_PATTERNS = *.h
RECURSIVE = YES
FILTER_PATTERNS = "*.h=python3 tools/site/stage.py filter"
OUTPUT_DIRECTORY = $work/extra
HTML_OUTPUT = cpp
HTML_EXTRA_STYLESHEET = tools/site/cpp.css
HTML_TIMESTAMP = NO
PROJECT_NAME = spheretree
PROJECT_NUMBER = $SPHERETREE_VERSION
PROJECT_BRIEF = "Interfaces in C and C++"
DISABLE_INDEX = NO
SORT_MEMBER_DOCS = NO
SHOW_NAMESPACES = NO
GENERATE_LATEX = NO
HAVE_DOT = NO
QUIET = YES
WARNINGS = NO
WARN_IF_DOC_ERROR = NO
EXTRACT_ALL = YES
STRIP_FROM_PATH = $PWD $work
ENABLE_PREPROCESSING = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = ST_API=
AUTOLINK_SUPPORT = NO
END
) >"$work/Doxyfile"
doxygen "$work/Doxyfile"
python3 tools/site/stage.py directories "$work/extra/cpp"
rm -rf "$out"
# Every warning is an error. In one process, since several order the search index by chance.
/usr/bin/python3 -m sphinx -q -W --keep-going -b html -c tools/site -d "$work/doctrees" "$work/stage" "$out"
cp -r "$work"/extra/. "$out"
rm -rf "$out/.buildinfo" "$out/objects.inv"
echo "$out/index.html"
