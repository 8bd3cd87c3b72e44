#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""reference.py SPHERETREE HAPTIC_PLAYER: shell completion and manual pages know every verb and option that --help
shows."""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def output(*command, code=0):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != code:
        sys.exit(f"FAILED: {' '.join(map(str, command))}: exit code {done.returncode}, not {code}: {done.stderr}")
    return done.stdout


def check(condition, message):
    if not condition:
        sys.exit(f"FAILED: {message}")


def completed(program, script, *words):
    """What bash offers for the last of the words."""
    name = Path(program).name
    function = "_" + name.replace("-", "_")
    line = " ".join(f"'{word}'" for word in (name, *words))
    text = f"source '{script}'; COMP_WORDS=({line}); COMP_CWORD={len(words)}; {function}; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    return set(output("bash", "-c", text).split())


def options_of(program, *verb):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", "\n".join(re.findall(r"^ {2}(-\S.*?)(?: {2}|$)", output(program, *verb, "--help"), re.M))))


def check_program(program, folder):
    script = folder / "completion.bash"
    script.write_text(output(program, "--completion", "bash"))
    page = output(program, "--manual")
    verbs = re.findall(r"^  ([a-z]+) {2,}\S", output(program, "--help").partition("\nVerbs:\n")[2], re.M)
    for verb in verbs:
        check(verb in completed(program, script, verb[:-1]), f"'{verb[:-1]}' is not completed to '{verb}'")
        check(f".SS {verb}" in page, f"the manual lacks {verb}")
    for words in [["--help"], *([verb, "--help"] for verb in verbs), *([["help", "scene"]] if verbs else [])]:
        wide = [line for line in output(program, *words).split("\n") if len(line) > 80]
        check(not wide, f"{words}: wider than 80 columns: {wide}")
    for verb in [[], *([v] for v in verbs)]:
        known = options_of(program, *verb)
        check(len(known) >= 3, f"{program} {verb}: only the options {known}")
        offered = completed(program, script, *verb, "--")
        check(known <= offered, f"{' '.join(verb)}: not completed: {sorted(known - offered)}")
        for option in known:
            check(option.replace("-", "\\-") in page, f"the manual lacks {option}")
    for line in page.split("\n"):
        check(not line.startswith(".") or re.match(r"\.(TH|SH|SS|TP|B|I|PP|nf|fi)\b", line), f"no request of troff: {line}")
    output("bash", "-n", script)
    for shell in ("fish", "zsh"):
        check(Path(program).name in output(program, "--completion", shell), f"nothing for {shell}")
        if shutil.which(shell):
            (folder / shell).write_text(output(program, "--completion", shell))
            output(shell, "-n", folder / shell)
    if shutil.which("groff"):
        (folder / "page.1").write_text(page)
        told = subprocess.run(["groff", "-man", "-Tascii", "-ww", folder / "page.1"], capture_output=True, text=True)
        check(told.returncode == 0 and not told.stderr, f"groff: {told.stderr[:500]}")
    output(program, "--completion", "tcsh", code=2)
    output(program, "--completion", code=2)


def main():
    with tempfile.TemporaryDirectory() as name:
        for program in sys.argv[1:]:
            check_program(program, Path(name))
        script = Path(name) / "spheretree.bash"
        script.write_text(output(sys.argv[1], "--completion", "bash"))
        check(completed(sys.argv[1], script, "build", "--quality", "") == {"quick", "standard", "best"}, "values of --quality")
        check(completed(sys.argv[1], script, "build", str(script)[:-3]) == {str(script)}, "names of files")


main()
