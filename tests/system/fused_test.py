#!/usr/bin/env python3
"""No multiplication is fused with an addition unless the source asks for it: else bits would depend on the instruction set
(docs/determinism.md). Read from the machine code of common/ and cpu/.

The objects of a build are told by functions: where the instruction set has no fused operations, as x86-64 before AVX2, those
compiled for better sets hold them and no other does. ARM has them everywhere: there, this says nothing.
Sources that are named are compiled anew, on x86 for Haswell, with the line that each instruction comes from: it must ask.

Usage: fused_test.py <build folder> <objdump> <processor> [SOURCE...]        SOURCE: from the root, as cpu/weight.cpp"""

import functools
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77
FUSED = re.compile(r"\t(vfn?m(?:add|sub)\w*|fn?m(?:add|sub|ad|sb)|fn?ml[as]\w*)\s")
FUNCTION = re.compile(r"^[0-9a-f]+ <(.*)>:$")
LINE = re.compile(r"^(/.*):(\d+)(?: \(discriminator \d+\))?$")
ASKS = re.compile(r"fma|fms|fnma")  # __builtin_fma and the compiler's intrinsics
MASKED = re.compile(r"run_avx512|N_AVX3")  # an operation under a mask has the line of the choice that it serves
WITH_HIGHWAY = "ray_trace.cpp.o"  # the one that may ask by intrinsics: in any other they are not this project's own
OF_BETTER_SETS = re.compile(r"N_AVX|run_avx|\.fma\b")  # Highway's namespaces, cpu/simd.h, target_clones


@functools.cache
def lines_of(file):
    return file.read_text(encoding="utf-8", errors="replace").splitlines() if file.exists() else []


def asks(obj, path, number):
    """Whether that line asks for it. A cache may have kept the path of another copy of this tree."""
    ours = re.search(r"/((?:common|cpu)/.*)$", path)
    if not ours and obj.name != WITH_HIGHWAY:
        return False
    lines = lines_of(ROOT / ours[1] if ours else pathlib.Path(path))
    return 0 < number <= len(lines) and bool(ASKS.search(lines[number - 1]))


def look(objdump, obj, by_line):
    """How many fused instructions there are, and those that nobody asked for."""
    options = ["-d", "--no-show-raw-insn", *(["-l"] if by_line else [])]
    text = subprocess.run([objdump, *options, obj], check=True, capture_output=True, text=True).stdout
    function, place, fused, wrong = "", None, 0, []
    for line in text.splitlines():
        if found := FUNCTION.match(line):
            function, place = found[1], None
        elif found := LINE.match(line):
            place = (found[1], int(found[2]))
        elif found := FUSED.search(line):
            fused += 1
            if by_line and MASKED.search(function):
                continue  # compiled for AVX2 as well, from the same lines
            if not (place and asks(obj, *place) if by_line else OF_BETTER_SETS.search(function)):
                wrong.append(f"{found[1]} in {function}" + (f" ({place[0]}:{place[1]})" if place else ""))
    return fused, wrong


def compiled_anew(command, work, more):
    """The object of a source, by the build's own command and some more options."""
    words = shlex.split(command["command"])
    while words[0].endswith("ccache"):
        words = words[1:]
    obj = pathlib.Path(work) / (pathlib.Path(command["file"]).name + ".o")
    words[words.index("-o") + 1] = str(obj)
    if "clang" not in words[0]:
        more = [*more, "-fdisable-rtl-combine"]  # which gives a fused operation the line of what its result is copied to
    subprocess.run([*words, *more], check=True, cwd=command["directory"], stderr=subprocess.DEVNULL)
    return obj


def main():
    build, objdump, processor, *sources = sys.argv[1:]
    build, on_arm = pathlib.Path(build).resolve(), processor == "aarch64"
    if on_arm and not sources:
        print("skipped: on ARM, functions do not tell")
        return SKIPPED
    with tempfile.TemporaryDirectory() as work:
        if sources:
            commands = {pathlib.Path(c["file"]): c for c in json.loads((build / "compile_commands.json").read_text())}
            options = ["-g1"] if on_arm else ["-g1", "-march=haswell"]
            objects = [compiled_anew(commands[ROOT / source], work, options) for source in sources]
        else:
            folders = [build / "CMakeFiles/parloc.dir" / name for name in ("common", "cpu")]
            objects = sorted(obj for folder in folders for obj in folder.rglob("*.o"))
        total, failed = 0, 0
        for obj in objects:
            fused, wrong = look(objdump, obj, by_line=bool(sources))
            total += fused
            if wrong:
                failed += 1
                print(f"{obj.name}: {len(wrong)} of {fused} fused instructions that nobody asked for, such as {wrong[0]}")
    print(f"{len(objects)} objects, {total} fused instructions, {failed} objects with some that nobody asked for")
    return 1 if failed or not objects else 0


if __name__ == "__main__":
    sys.exit(main())
