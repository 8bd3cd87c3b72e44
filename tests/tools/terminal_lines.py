#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""terminal_lines.py SPHERETREE HAPTIC_PLAYER: what a terminal shows in the end is results and messages, each from the
start of a line.

Runs the programs on pseudo-terminals of several widths and draws what they write as a terminal does: \\r, \\n, and a
new line where one is full. No line may hold progress beside anything else, and no line of progress may stay behind. """
import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import tempfile
import termios
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from torus import write_torus  # noqa: E402

spheretree, player = (str(Path(p).resolve()) for p in sys.argv[1:3])
failures = []


def on_terminal(words, columns, term, cwd):
    """The bytes that a program writes to a terminal, and its exit code."""
    pid, fd = pty.fork()
    if pid == 0:
        os.chdir(cwd)
        os.environ["TERM"] = term
        os.read(0, 1)  # until the size is set
        os.execvp(words[0], words)
    settings = termios.tcgetattr(fd)
    settings[3] &= ~termios.ECHO
    termios.tcsetattr(fd, termios.TCSANOW, settings)
    fcntl.ioctl(fd, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    os.write(fd, b"\n")
    out = b""
    while True:
        try:
            part = os.read(fd, 65536)
        except OSError:
            break
        if not part:
            break
        out += part
    return out, os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def screen(text, columns):
    """Lines as they stand in the end; how often a line was begun because the one before was full."""
    lines, column, wraps = [""], 0, 0
    for c in text.replace("\r\n", "\n"):
        if c == "\n":
            lines.append("")
            column = 0
        elif c == "\r":
            column = 0
        else:
            if column == columns:
                lines.append("")
                column = 0
                wraps += 1
            lines[-1] = lines[-1][:column].ljust(column) + c + lines[-1][column + 1:]
            column += 1
    return [line.rstrip() for line in lines], wraps


PROGRESS = re.compile(r"\d %  \d|^ *[0-9.]+ s  (force|late)|\[#|^ *(read|check|distances|balls|cover|certify|hierarchy|medial axis)  +[0-9.]+ s")


def trial(words, columns, term, cwd):
    """Returns what was written."""
    written, code = on_terminal(words, columns, term, cwd)
    text = written.decode(errors="replace")
    what = f"{' '.join(words[1:])} at {columns} columns, TERM={term}"
    if code != 0:
        failures.append(f"{what}: exit code {code}: {text!r}")
        return written
    if term == "dumb":
        if "\r" in text.replace("\r\n", "\n"):
            failures.append(f"{what}: goes back in a line")
        return written
    if "\x1b" in text:
        failures.append(f"{what}: an escape sequence")
    drawn = [part for part in text.replace("\r\n", "\n").split("\r") if part.strip()]
    for part in drawn[:-1]:
        if len(part.rstrip("\n")) >= columns and "\n" not in part:
            failures.append(f"{what}: progress is as wide as the terminal: {part!r}")
    for line in screen(text, columns)[0]:
        if PROGRESS.search(line):
            failures.append(f"{what}: progress in a line that stays: {line!r}")
    return written


def prepare(folder):
    subprocess.run([spheretree, "--version"], check=True, capture_output=True)
    write_torus(folder / "torus.obj", 10, 60)
    (folder / "torus.scene.json").write_text(
        '{"schema": "spheretree.scene/1", "defaults": {"quality": "quick"}, "tool": {"name": "tool", "mesh": "torus.obj", "levels": 3},'
        ' "objects": [{"name": "a", "mesh": "torus.obj"}, {"name": "b", "mesh": "torus.obj", "levels": 3}]}')


def main():
    with tempfile.TemporaryDirectory() as base:
        folder = Path(base)
        prepare(folder)
        for columns, term in ((40, "xterm"), (200, "xterm"), (80, "dumb"), (80, "xterm")):
            shown = trial([spheretree, "build", "torus.obj", "-o", "a.stree", "--quality", "quick"], columns, term, folder)
        if b"\r" not in shown.replace(b"\r\n", b"\n"):
            failures.append("no progress was shown at all: this test cannot fail")
        for words in (["evaluate", "torus.obj", "a.stree"], ["batch", "torus.scene.json", "-o", "out"],
                      ["compare", "torus.obj", "-o", "cmp", "--builders", "cover,octree", "--qualities", "quick", "--levels", "3"]):
            trial([spheretree, *words], 60, "xterm", folder)
        result = subprocess.run([spheretree, "build", "torus.obj", "-o", "a.stree", "--quality", "quick"], cwd=folder, capture_output=True, text=True)
        if result.stderr:
            failures.append(f"progress although stderr is no terminal: {result.stderr!r}")
        for columns in (10, 40, 80):
            trial([player, "out/scene.json", "--seconds", "1.2", "--json"], columns, "xterm", folder)
        written = on_terminal([player, "out/scene.json", "--seconds", "1.2", "-q"], 80, "xterm", folder)[0]
        if b"force" in written.split(b"step time")[0]:
            failures.append("-q shows the status line")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


sys.exit(main())
