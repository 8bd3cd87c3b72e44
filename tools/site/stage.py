#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""stage.py pages BUILD FOLDER    the pages of the site, for Sphinx: a copy of the documents, and what is made
stage.py filter HEADER          a header as Doxygen reads it: every comment is one for it
stage.py directories FOLDER     names for the pages of directories that do not depend on the place of the sources

A link to a file that is not a page leads to a page that shows the file."""
import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = {".cpp": "cpp", ".h": "cpp", ".c": "c", ".py": "python", ".sh": "bash", ".cs": "csharp", ".cmake": "cmake", ".json": "json", ".pyi": "python"}
C_HEADERS = ["runtime/include/spheretree/runtime/runtime.h", "scene/include/spheretree/scene/scene.h", "servo/include/spheretree/servo/servo.h"]
TUTORIALS = ["docs/tutorials/first_touch", "docs/tutorial", "docs/tutorials/simulator", "docs/tutorials/robot", "docs/tutorials/chart",
             "docs/tutorials/packaging"]


def filtered(header: Path) -> str:
    lines = header.read_text(encoding="utf-8").splitlines()
    first = next((i for i, line in enumerate(lines) if line.startswith("#")), 0)  # the comment above is that of the file
    out = [""] * first
    for line in lines[first:]:
        line = re.sub(r"^(\s*)//(?!/) ?", r"\1/// ", line)
        line = re.sub(r"^(\s*)/\*(?!\*)", r"\1/**", line)
        line = re.sub(r"(\S\s*)//(?!/) ", r"\1///< ", line) if not line.lstrip().startswith("//") else line
        line = re.sub(r"([;,{\w]\s*)/\*(?![*])", r"\1/**<", line)
        out.append(line)
    return "\n".join(out) + "\n"


def name_directories(folder: Path):
    """The names are hashes of the titles, in place of absolute paths."""
    names = {}
    for page in folder.glob("dir_*.html"):
        title = re.search("<title>(.*?)</title>", page.read_text(encoding="utf-8")).group(1)
        names[page.stem] = "dir_" + hashlib.md5(title.encode()).hexdigest()
    for page in sorted(path for path in folder.rglob("*") if path.suffix in (".html", ".js")):
        text = page.read_text(encoding="utf-8")
        page.write_text(re.sub("dir_[0-9a-f]{32}", lambda match: names.get(match.group(0), match.group(0)), text), encoding="utf-8")
        if page.stem in names:
            page.rename(page.with_stem(names[page.stem]))


def shown_file(source: Path, target: Path):
    """A page that shows a file."""
    target.parent.mkdir(parents=True, exist_ok=True)
    text = source.read_text(encoding="utf-8")
    target.write_text(f"---\norphan: true\n---\n# {source.name}\n\n``````{LANGUAGES.get(source.suffix, 'text')}\n{text}``````\n", encoding="utf-8")


def shown_folder(source: Path, target: Path):
    """A page that lists the pages and files of a folder."""
    target.parent.mkdir(parents=True, exist_ok=True)
    entries = []
    for path in sorted(path for path in source.rglob("*") if path.is_file() and "__pycache__" not in path.parts):
        entries.append(f"- [{path.relative_to(source)}]({path.relative_to(source)})")
    target.write_text(f"---\norphan: true\n---\n# {source.relative_to(ROOT)}\n\n" + "\n".join(entries) + "\n", encoding="utf-8")
    return target


class Stage:
    def __init__(self, folder: Path):
        self.folder, self.done = folder, set()

    def page(self, name: str, orphan=False):
        """Copies a page; its links lead to pages."""
        self.done.add(name)
        source, target = ROOT / name, self.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        text = source.read_text(encoding="utf-8") if source.is_file() else target.read_text(encoding="utf-8")
        text = re.sub(r"<!--.*?-->\n?", "", text, flags=re.DOTALL)
        parts = re.split(r"(^```.*?^```$|`[^`\n]*`)", text, flags=re.DOTALL | re.MULTILINE)
        for i in range(0, len(parts), 2):
            parts[i] = re.sub(r"\]\(([^)#\s]+)(#[^)\s]*)?\)", lambda match: self.link(Path(name).parent, match), parts[i])
        target.write_text(("---\norphan: true\n---\n" if orphan else "") + "".join(parts), encoding="utf-8")

    def link(self, folder: Path, match) -> str:
        address, anchor = match.group(1), match.group(2) or ""
        if re.match(r"[a-z]+:", address):
            return match.group(0)
        name = os.path.normpath(folder / address)
        if name == "README.md":  # is the first page
            return f"]({os.path.relpath('index.md', folder)}{anchor})"
        source = ROOT / name
        if source.suffix in (".md", ".html"):
            return match.group(0)
        if source.suffix in (".png", ".svg", ".gif"):
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, self.folder / name)
            return match.group(0)
        page = f"{name}/files.md" if source.is_dir() else f"{name}.md"
        if source.exists() and page not in self.done:
            self.done.add(page)
            if source.is_dir():
                shown_folder(source, self.folder / page)
                self.page(page)
            else:
                shown_file(source, self.folder / page)
        return f"]({os.path.relpath(page, folder)})"

    def write(self, name: str, text: str):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def titled(title: str) -> str:
    return f"{title}\n{'=' * len(title)}\n\n"


def write_interfaces(stage: Stage):
    text = titled("Interfaces in C and C++") + ("The `reference of all headers <../cpp/index.html>`_ was made by Doxygen from the public headers: functions, types and "
        "members by name, with a search of its own. :doc:`../docs/runtime` explains the runtime with whole programs.\n\n"
        "The headers of the interface in C, as they are installed:\n\n")
    for name in C_HEADERS:
        heading = name.partition("/include/")[2]
        text += f"{heading}\n{'-' * len(heading)}\n\n.. code-block:: c\n\n"
        text += re.sub("^(?=.)", "    ", (ROOT / "libruntime" / name).read_text(encoding="utf-8"), flags=re.MULTILINE) + "\n\n"
    stage.write("reference/c.rst", text)
    stage.write("reference/python.rst", titled("Interface in Python") + ".. automodule:: spheretree\n   :members:\n   :imported-members:\n   :undoc-members:\n")


def help_as_lists(text: str) -> str:
    """A --help as lists, whose lines break where the screen ends."""
    about, usage, groups, ending = re.fullmatch(r"(.*?)\n(Usage: .*?)\n(.*?)((?:^Examples?:).*)?", text, re.DOTALL | re.MULTILINE).groups()
    escaped = lambda words: re.sub(r"([\\*`_|<])", r"\\\1", " ".join(words.split()))
    plain = lambda words: re.sub(r"\\`(.*?)\\`|(?<!\S)(--[a-z][a-z-]*)", lambda match: f"``{match[1] or match[2]}``", escaped(words))
    code = lambda lines: "::\n\n" + re.sub("^(?=.)", "    ", lines, flags=re.MULTILINE) + "\n\n"
    out = plain(about) + "\n\n" + code(usage)
    for heading, rows in re.findall(r"^(\S.*):\n((?: .*\n)+)", groups, re.MULTILINE):
        out += f"**{heading}**\n\n"
        for label, words in re.findall(r"^  (\S.*?)(?:  +|\n +)(\S.*\n(?: {5,}.*\n)*)", rows, re.MULTILINE):
            out += f"``{label}``\n    {plain(words)}\n\n"
    return out + (code(ending) if ending else "")


def write_commands(stage: Stage, build: Path):
    def ran(*command):
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    program = build / "tools/spheretree/spheretree"
    text = titled("Commands and their options")
    for verb in re.findall(r"^  (\w+)  ", ran(program, "--help").partition("Verbs:")[2], re.MULTILINE):
        text += f"spheretree {verb}\n{'-' * (11 + len(verb))}\n\n" + help_as_lists(ran(program, verb, "--help"))
    for name, path in (("haptic-player", "tools/haptic_player/haptic-player"), ("spheretree-import", "tools/mesh_import/spheretree-import")):
        if (build / path).exists():
            text += f"{name}\n{'-' * len(name)}\n\n" + help_as_lists(ran(build / path, "--help"))
    stage.write("reference/commands.rst", text)


def tree(caption: str, names, depth=1) -> str:
    return f"```{{toctree}}\n:caption: {caption}\n:hidden:\n:maxdepth: {depth}\n\n" + "\n".join(names) + "\n```\n\n"


def write_pages(build: Path, folder: Path):
    stage = Stage(folder)
    names = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"] + sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md"))
    for name in names:
        stage.page(name)
    write_interfaces(stage)
    write_commands(stage, build)
    readme = folder / "README.md"
    algorithms = [name[:-3] for name in names if name.startswith("docs/algorithms/")]
    for_developers = ["docs/architecture", "docs/glossary", "docs/constants", "CONTRIBUTING", "SECURITY", "CHANGELOG"]
    listed = set(TUTORIALS + algorithms + for_developers + ["docs/README", "docs/which_command", "docs/gallery", "README"])
    rest = [name[:-3] for name in names if name[:-3] not in listed]
    stage.write("index.md", readme.read_text(encoding="utf-8") + "\n" + tree("Start", ["docs/which_command", "docs/gallery", "docs/README"]) + tree("Tutorials", TUTORIALS) +
                tree("Guides", rest) + tree("Reference", ["reference/commands", "reference/c", "reference/python"]) +
                tree("Algorithms", algorithms) + tree("For developers", for_developers))
    readme.unlink()


if len(sys.argv) == 3 and sys.argv[1] == "filter":
    sys.stdout.write(filtered(Path(sys.argv[2])))
elif len(sys.argv) == 3 and sys.argv[1] == "directories":
    name_directories(Path(sys.argv[2]))
elif len(sys.argv) == 4 and sys.argv[1] == "pages":
    write_pages(Path(sys.argv[2]).resolve(), Path(sys.argv[3]).resolve())
else:
    sys.exit(__doc__)
