#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/licences.py debian          debian/copyright, in its machine-readable form
tools/licences.py spdx BUILD    list of what the programs and libraries of the build folder are made of (SPDX 2.3, JSON)

Both are made from the SPDX lines of the tracked files and written to stdout. The list also names every Debian package
whose headers were compiled into BUILD, or whose libraries its programs load. It needs `ninja -t deps` and dpkg. With
SOURCE_DATE_EPOCH, the same sources and packages give the same bytes."""
import datetime
import hashlib
import json
import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DEFAULT = "Apache-2.0"  # as LICENSE says of what has no line of its own
COMMON = {"Apache-2.0": "Apache-2.0", "GPL-3.0-or-later": "GPL-3"}  # in /usr/share/common-licenses
OF_DEBIAN = {"GPL-3.0-or-later": "GPL-3+", "AGPL-3.0-only": "AGPL-3"}
TO_SPDX = {  # names in the copyright files of Debian
    "Expat": "MIT", "GPL-3+": "GPL-3.0-or-later", "LGPL-3+": "LGPL-3.0-or-later", "GPL-2+": "GPL-2.0-or-later", "LGPL-2.1+": "LGPL-2.1-or-later",
    "BSD-3-clause": "BSD-3-Clause", "BSD-2-clause": "BSD-2-Clause", "AGPL-3": "AGPL-3.0-only", "AGPL-3+": "AGPL-3.0-or-later", "zlib": "Zlib",
    "Apache-2.0": "Apache-2.0", "MPL-2.0": "MPL-2.0", "BSL-1.0": "BSL-1.0", "Zlib": "Zlib"}


def output(*command: str, **options) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True, **options).stdout


def tracked() -> list:
    return sorted(name for name in output("git", "-C", str(ROOT), "ls-files", "-z").split("\0") if name and (ROOT / name).is_file())


def licence_of(name: str) -> str:
    with (ROOT / name).open("rb") as file:
        start = file.read(400).decode("utf-8", "replace")
    found = re.search(r"SPDX-License-Identifier: ([\w.-]+)", start)
    return found.group(1) if found else DEFAULT


def patterns(licences: dict, wanted: str) -> list:
    """Names of the files under `wanted`, with `folder/*` where everything in the folder is."""
    inside = {}
    for name, licence in licences.items():
        for folder in Path(name).parents:
            inside.setdefault(str(folder), set()).add(licence)
    found = set()
    for name in (name for name, licence in licences.items() if licence == wanted):
        whole = [str(folder) for folder in Path(name).parents if str(folder) != "." and inside[str(folder)] == {wanted}]
        found.add(whole[-1] + "/*" if whole else name)
    return sorted(found)


def write_debian():
    licences = {name: licence_of(name) for name in tracked()}
    print("Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: spheretree\n"
          "Comment: Made by tools/licences.py from the SPDX lines of the files.")
    for licence in [DEFAULT] + sorted(set(licences.values()) - {DEFAULT}):
        files = ["*"] if licence == DEFAULT else patterns(licences, licence)
        print("\nFiles:", "\n ".join(files))
        print("Copyright: 2026 The spheretree authors")
        print("License:", OF_DEBIAN.get(licence, licence))
    for licence in sorted(set(licences.values())):
        print("\nLicense:", OF_DEBIAN.get(licence, licence))
        if licence in COMMON:
            print(f" The text of this licence is in /usr/share/common-licenses/{COMMON[licence]} of Debian systems.")
            continue
        for line in (ROOT / f"LICENSE-{licence.removesuffix('-only')}").read_text(encoding="utf-8").splitlines():
            print(f" {line}" if line.strip() else " .")


def headers_of(build: Path) -> set:
    """Files of the system that were compiled into the build folder."""
    deps = output("ninja", "-C", str(build), "-t", "deps")
    embedded = re.findall(r"^SPHERETREE_THREE_JS:FILEPATH=(.+)$", (build / "CMakeCache.txt").read_text(encoding="utf-8"), re.MULTILINE)
    return {os.path.realpath(line.strip()) for line in deps.splitlines() if line.startswith("    /usr/")} | {os.path.realpath(name) for name in embedded}


def binaries_of(build: Path) -> list:
    """What the build folder installs: programs, libraries, modules of Python."""
    names = ("spheretree", "spheretree-import", "spheretree-tetrahedra", "haptic-player")
    found = [path for path in build.rglob("*") if path.is_file() and (path.name in names or re.match(r"lib.*\.so|_\w+\.cpython.*\.so", path.name))]
    return sorted(path for path in found if not path.is_symlink() and path.read_bytes()[:4] == b"\x7fELF")


def packages_of(files: set) -> dict:
    """Debian packages that hold the files, with their versions."""
    spellings = files | {name.removeprefix("/usr") for name in files if name.startswith("/usr/lib")}
    found = subprocess.run(["dpkg-query", "--search", *sorted(spellings)], capture_output=True, text=True, check=False).stdout
    names = sorted({name.split(":")[0] for line in found.splitlines() if ": /" in line for name in line.split(": /")[0].split(", ")})
    listed = output("dpkg-query", "--show", "--showformat", "${Package} ${Version}\n", *names) if names else ""
    return dict(line.split() for line in listed.splitlines())


def declared(package: str) -> str:
    """Licence of a Debian package, where its copyright file says it by a name that SPDX knows."""
    try:
        text = Path(f"/usr/share/doc/{package}/copyright").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return "NOASSERTION"
    found = re.search(r"^Files: *\*.*?^License: *([^\n]+)$", text, re.MULTILINE | re.DOTALL)
    return TO_SPDX.get(found.group(1).strip(), "NOASSERTION") if found else "NOASSERTION"


def spdx_package(name: str, version: str, licence: str) -> dict:
    return {"SPDXID": "SPDXRef-" + re.sub(r"[^\w.-]", "-", name), "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence, "copyrightText": "NOASSERTION",
            "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": f"pkg:deb/debian/{name}@{version}"}]}


def write_spdx(build: Path):
    version = re.search(r"^project\(spheretree VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE).group(1)
    files, hashes = [], []
    for name in tracked():
        content = (ROOT / name).read_bytes()
        hashes.append(hashlib.sha1(content).hexdigest())
        licence = licence_of(name)
        files.append({"SPDXID": f"SPDXRef-File-{len(files)}", "fileName": f"./{name}", "licenseConcluded": licence, "licenseInfoInFiles": [licence],
                      "copyrightText": "NOASSERTION", "checksums": [{"algorithm": "SHA1", "checksumValue": hashes[-1]},
                                                                    {"algorithm": "SHA256", "checksumValue": hashlib.sha256(content).hexdigest()}]})
    binaries = binaries_of(build)
    loaded = set()
    for binary in binaries:
        for line in output("ldd", str(binary)).splitlines():
            loaded |= {os.path.realpath(path) for path in re.findall(r"=> (/\S+)", line) if not path.startswith(str(build))}
    compiled, linked = packages_of(headers_of(build)), packages_of(loaded)
    used = Counter(file["licenseConcluded"] for file in files)
    own = {"SPDXID": "SPDXRef-spheretree", "name": "spheretree", "versionInfo": version, "downloadLocation": "NOASSERTION", "filesAnalyzed": True,
           "packageVerificationCode": {"packageVerificationCodeValue": hashlib.sha1("".join(sorted(hashes)).encode()).hexdigest()},
           "licenseConcluded": " AND ".join(sorted(used)), "licenseDeclared": " AND ".join(sorted(used)), "licenseInfoFromFiles": sorted(used),
           "copyrightText": "2026 The spheretree authors", "hasFiles": [file["SPDXID"] for file in files]}
    others = [spdx_package(name, number, declared(name)) for name, number in sorted({**compiled, **linked}.items())]
    related = [("SPDXRef-DOCUMENT", "DESCRIBES", own["SPDXID"])]
    for package in others:
        if package["name"] in compiled:
            related.append((package["SPDXID"], "BUILD_DEPENDENCY_OF", own["SPDXID"]))
        if package["name"] in linked:
            related.append((own["SPDXID"], "DYNAMIC_LINK", package["SPDXID"]))
    moment = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH") or output("git", "-C", str(ROOT), "log", "-1", "--format=%ct")),
                                             datetime.timezone.utc)
    verification = own["packageVerificationCode"]["packageVerificationCodeValue"]
    document = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"spheretree-{version}",
                "documentNamespace": f"https://spdx.org/spdxdocs/spheretree-{version}-{verification}",
                "creationInfo": {"created": moment.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: tools/licences.py"]},
                "packages": [own] + others, "files": files,
                "relationships": [{"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b} for a, kind, b in related]}
    json.dump(document, sys.stdout, indent=1)
    print()


if sys.argv[1:] == ["debian"]:
    write_debian()
elif len(sys.argv) == 3 and sys.argv[1] == "spdx":
    write_spdx(Path(sys.argv[2]).resolve())
else:
    sys.exit(__doc__)
