#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""doc_links.py SOURCE: every relative link of README.md, CHANGELOG.md and docs/ leads to a file, and to one of its
headings if it names one; docs/README.md lists every page, or a folder that it is in; and the sources that
architecture.md and glossary.md name exist."""
import re
import sys
from pathlib import Path

root = Path(sys.argv[1]).resolve()
docs = root / "docs"
pages = [root / "README.md", root / "CHANGELOG.md", root / "CONTRIBUTING.md", root / "SECURITY.md", *sorted(docs.rglob("*.md"))]
faults, links, listed = [], 0, set()


def anchors(page):
    """The names that headings of a page have in links, as web sites of repositories make them."""
    names = {}
    for heading in re.findall(r"^#+ +(.+?) *$", re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL), re.MULTILINE):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        names[name] = names.get(name, -1) + 1
    return {f"{name}-{n}" if n else name for name, last in names.items() for n in range(last + 1)}


for page in pages:
    text = re.sub(r"```.*?```|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)[^)]*\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        links += 1
        found = (page.parent / target).resolve() if target else page
        if not found.exists():
            faults.append(f"{page.relative_to(root)}: the link to {target} leads nowhere")
        elif anchor and found.suffix == ".md" and anchor not in anchors(found):
            faults.append(f"{page.relative_to(root)}: {found.relative_to(root)} has no heading #{anchor}")
        if page == docs / "README.md":
            listed.add(found)
for page in docs.rglob("*.md"):
    if page != docs / "README.md" and not listed & {page.resolve(), *page.resolve().parents}:
        faults.append(f"docs/README.md does not list {page.relative_to(docs)}")
# Sources that the tables of where to find what name; a name in capitals stands for several.
files = {str(p.relative_to(root)) for p in root.rglob("*") if p.suffix in (".cpp", ".h") and "build" not in p.relative_to(root).parts}
for page in (docs / "architecture.md", docs / "glossary.md"):
    for named in re.findall(r"`([\w/]+\.(?:cpp|h))`", page.read_text(encoding="utf-8")):
        if not re.search(r"[A-Z]{3}", named) and not any(f"/{name}".endswith(f"/{named}") for name in files):
            faults.append(f"{page.relative_to(root)}: there is no {named}")
if links < 10:
    faults.append(f"only {links} links found: the test looks in the wrong place")
print("\n".join(faults) if faults else f"{links} links, {len(pages)} pages: nothing to complain about")
sys.exit(1 if faults else 0)
