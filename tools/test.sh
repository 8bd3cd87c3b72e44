#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tools/test.sh [CTEST OPTION...]: builds everything and runs all tests; CTest's summary comes last.
# PRESET=sanitize tests with AddressSanitizer and UndefinedBehaviorSanitizer, PRESET=clang what Clang makes, where it is
# installed (tools/setup.sh --ci); default release, with GCC.
# SPHERETREE_JOBS=N builds with N jobs and tests with one more; default: as many as the machine has processors.
# SPHERETREE_TEST_TIMEOUT=SECONDS ends a test after this time; default 900. Presets of slow builds have 3600.
# SPHERETREE_TARGETS="A B" builds only those, for a run that --label-regex restricts to them; default: everything.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${PRESET:-release}
jobs=${SPHERETREE_JOBS:-$(nproc)}

tools/setup.sh
cmake --preset "$preset" -DSPHERETREE_TESTS=ON >/dev/null
cmake --build --preset "$preset" --parallel "$jobs" ${SPHERETREE_TARGETS:+--target $SPHERETREE_TARGETS}
results=build/$preset/tests.xml
rm -f "$results"
# A program that writes a file waits until the disk has it. Where there is room for the files of the tests in memory,
# they write them there.
room=$(df --output=avail /dev/shm 2>/dev/null | tail -1)
if [[ -z ${TMPDIR:-} && ${room:-0} -gt 4000000 ]]; then export TMPDIR=/dev/shm; fi
failed=0
# One test more than there are jobs, since some wait for a window or a clock.
ctest --preset "$preset" --timeout "${SPHERETREE_TEST_TIMEOUT:-900}" --parallel $((jobs + 1)) --output-junit tests.xml "$@" || failed=1
# A test that is skipped shows nothing: only those of tests/allowed_skips.txt may be.
[[ ! -f "$results" ]] || python3 tests/skips.py "$results" >&2 || failed=1
exit $failed
