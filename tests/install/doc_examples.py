#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""doc_examples.py PAGE.md FOLDER: writes the examples of a page into the folder. An example is a fenced block after a
line `<!-- example: NAME -->`."""
import re
import sys
from pathlib import Path

page, folder = Path(sys.argv[1]), Path(sys.argv[2])
examples = re.findall(r"<!-- example: ([\w.]+) -->\n```\w*\n(.*?)\n```", page.read_text(encoding="utf-8"), re.DOTALL)
if not examples:
    sys.exit(f"{page}: no example; a line `<!-- example: NAME -->` begins one")
folder.mkdir(parents=True, exist_ok=True)
for name, text in examples:
    (folder / name).write_text(text + "\n", encoding="utf-8")
