#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""settings.py SOURCE: fails if a document states another default of a setting than the header that defines it."""
import re
import sys
from pathlib import Path

SAFETY = "device/include/spheretree/device/safety.h", "SafetySettings"
LIMITS = "libruntime/runtime/include/spheretree/runtime/scene.h", "WrenchLimits"
COUNTS = "libruntime/runtime/include/spheretree/runtime/scene.h", "StepLimits"
COUPLING = "libruntime/runtime/include/spheretree/runtime/scene.h", "Coupling"
# Document, struct, and what the document says; `x_ms`: x in milliseconds.
SENTENCES = [
    ("docs/device.md", SAFETY, "a jump of {pose_jump} mm in 1 ms"),
    ("docs/device.md", SAFETY, "the last good wrench for {hold_ms} ms, then a fade of {stale_fade_ms} ms; after {off_after_ms} ms off"),
    ("docs/device.md", SAFETY, "contacts or a pose older than {stale_after_ms} ms, or a servo pause | fade of {stale_fade_ms} ms; older than {off_after_ms} ms: off"),
    ("docs/device.md", SAFETY, "was below {guard_force} N and {guard_torque} N mm for more than 3 ms"),
    ("docs/device.md", SAFETY, "gain from 0 to 1 in {ramp} s; rises by at most {ramp_force_slew} N and {ramp_torque_slew} N mm in 1 ms"),
    ("docs/device.md", SAFETY, "with more than {fade_force} N | fades in {fade_time_ms} ms"),
    ("docs/device.md", SAFETY, "rises by at most {force_slew} N and {torque_slew} N mm in 1 ms, except in the first {contact_start_ms} ms of a contact"),
    ("docs/device.md", SAFETY, "motor temperature above {warm} (of 0 to 1)"),
    ("docs/device.md", SAFETY, "to the continuous ones ({continuous_force} N), until it is below {cool}"),
    ("docs/device.md", SAFETY, "force vector to {max_force} N; torque vector until no component in handle axes exceeds {max_torque} N mm"),
    ("docs/device.md", SAFETY, "`passivity_damping`, {passivity_damping} N s/mm"),
    ("docs/runtime.md", LIMITS, "shortened to {force} N"),
    ("docs/runtime.md", LIMITS, "until no component exceeds {torque} N mm (defaults)"),
    ("docs/runtime.md", COUNTS, "| `max_pairs` | {max_pairs} |"),
    ("docs/runtime.md", COUNTS, "| `max_work` | {max_work} |"),
    ("libruntime/runtime/include/spheretree/runtime/runtime.h", COUNTS, "default {max_pairs}. max_work"),
    ("libruntime/runtime/include/spheretree/runtime/runtime.h", COUNTS, "default {max_work}."),
    ("libruntime/runtime/include/spheretree/runtime/runtime.h", LIMITS, "defaults {force} N for the magnitude of the force"),
    ("libruntime/runtime/include/spheretree/runtime/runtime.h", COUPLING, "defaults {translation} N/mm and {rotation} N mm/rad"),
]


def defaults(root, header, name):
    """Members of a struct and the text of their defaults; of a number NAME also NAME_ms, times 1000."""
    text = re.sub(r"//[^\n]*", "", (root / header).read_text(encoding="utf-8"))
    body = re.search(r"struct " + name + r" \{(.*?)\n\};", text, re.DOTALL).group(1)
    found = {}
    for member, list_text, number in re.findall(r"(\w+)(?:\{([^{}]+)\}| = ([\d.e'+-]+))", body):
        if list_text:
            found[member] = list_text
            continue
        value = float(number.replace("'", ""))
        found[member], found[member + "_ms"] = f"{value:.10g}", f"{1000 * value:.10g}"
    return found


def plain(text):
    """One space between words, also across lines of a comment; no blank within a number."""
    return re.sub(r"(?<=\d) (?=000\b)", "", re.sub(r"\s+(\* |/// )?", " ", text))


def main():
    root, faults = Path(sys.argv[1]), []
    for document, (header, name), sentence in SENTENCES:
        wanted = sentence.format(**defaults(root, header, name))
        if plain(wanted) not in plain((root / document).read_text(encoding="utf-8")):
            faults.append(f"{document} does not say '{wanted}', as {name} of {header} has it; correct the document, or the sentence in settings.py")
    print("\n".join(faults) if faults else f"settings: {len(SENTENCES)} sentences, as the headers have it")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
