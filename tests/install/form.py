#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""form.py SOURCE: fails if a function has more than 60 lines, a line of prose more than 120 characters, or if a script
that names its interpreter cannot be executed.

Prose: comments that have a line to themselves, in any language, docstrings of Python, and Markdown outside of code and
tables; a list within a list is prose. A line that holds one word too long to break (an address, a path) may be longer, and so may a line that ends with `// long: WHY`."""
import ast
import os
import re
import subprocess
import sys
from pathlib import Path

MOST_LINES, MOST_CHARACTERS = 60, 120
CODE = {".cpp", ".h", ".c"}
SCRIPTS = {".py", ".sh", ".cmake", ".yml", ".js", ".css"}


def blanked(text):
    """C++ without comments and the contents of literals, line by line as before."""
    pattern = re.compile(r'R"(\w*)\((?:.|\n)*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![\w])\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*(?:.|\n)*?\*/')
    return pattern.sub(lambda found: ('""' if found.group(0)[0] in "R\"'" else "") + "\n" * found.group(0).count("\n"), text)


def functions(text):
    """First and last line of each function that is in no other; a class or namespace is none."""
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda found: "\n" * found.group(0).count("\n"), blanked(text), flags=re.MULTILINE)
    stack, head, line, head_line = [], "", 1, 1
    for character in text:
        if character == "{":
            inside = next((kind for kind, _ in stack if kind != "scope"), None)
            is_member = re.search(r"\)[\w\s]*:[^:]", head) and re.search(r"[\w>]$", head.rstrip()) and not head.rstrip().endswith("noexcept")
            if inside or is_member:
                stack.append(("block", None))
            elif re.search(r"\b(namespace|class|struct|union|enum|extern)\b", head) and not re.search(r"\)\s*(const|noexcept|->.*)?\s*$", head):
                stack.append(("scope", None))
                head = ""
            else:
                stack.append(("function" if "(" in head else "block", head_line))
        elif character == "}":
            if stack:
                kind, start = stack.pop()
                if kind == "function":
                    yield start, line
                if kind != "block" or not stack or stack[-1][0] == "scope":
                    head = head if kind == "block" and "(" in head else ""
        elif character == ";" and all(kind == "scope" for kind, _ in stack):
            head = ""
        elif all(kind == "scope" for kind, _ in stack):
            if not head.strip() and not character.isspace():
                head, head_line = "", line
            head += character
        line += character == "\n"


def docstring_lines(text):
    """Numbers of the lines of docstrings."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node) is not None:
            yield from range(node.body[0].lineno, node.body[0].end_lineno + 1)


def prose(path, text):
    """Numbers of lines and their text."""
    fenced, in_list, docstrings = False, False, set(docstring_lines(text)) if path.suffix == ".py" else set()
    for number, line in enumerate(text.splitlines(), 1):
        if path.suffix == ".md":
            fenced ^= line.startswith("```")
            if line.strip() and not line.startswith(" "):
                in_list = re.match(r"[-*] |\d+\. ", line) is not None
            if not fenced and not line.lstrip().startswith(("|", "```", "![")) and (in_list or not line.startswith("    ")):
                yield number, line
        elif number in docstrings:
            yield number, line
        elif path.suffix in CODE and line.lstrip().startswith(("//", "/*", "* ")) or path.suffix not in CODE and line.lstrip().startswith(("# ", "// ")):
            yield number, line


def faults_of(root, name):
    path = root / name
    text = path.read_text(encoding="utf-8", errors="replace")
    if text.startswith("#!") and not os.access(path, os.X_OK):
        yield f"{name}: starts with #! but is not executable; chmod +x"
    for number, line in prose(path, text):
        words = line.strip().lstrip("/#*->! ").split()
        if len(line) > MOST_CHARACTERS and max(map(len, words), default=0) < MOST_CHARACTERS - 20 and "// long: " not in line:
            yield f"{name}:{number}: a line of prose with {len(line)} characters; at most {MOST_CHARACTERS}"
    if path.suffix in CODE:
        for first, last in functions(text):
            if last - first + 1 > MOST_LINES:
                yield f"{name}:{first}: a function of {last - first + 1} lines; at most {MOST_LINES}"


def main():
    root = Path(sys.argv[1])
    run = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True)
    names = run.stdout.splitlines() if run.returncode == 0 else [str(p.relative_to(root)) for p in root.rglob("*") if "build" not in p.parts]
    wanted = [n for n in names if (Path(n).suffix in CODE | SCRIPTS | {".md"} or Path(n).name == "CMakeLists.txt") and (root / n).is_file()]
    faults = [fault for name in sorted(wanted) for fault in faults_of(root, name)]
    print("\n".join(faults) if faults else f"form: {len(wanted)} files, nothing to complain about")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
