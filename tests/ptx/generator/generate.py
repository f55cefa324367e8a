#!/usr/bin/env python3
"""Writes C++ from nvcc's PTX, for the executor of docs/ptx.md.

usage: generate.py module NAME FILE.ptx OUT.cpp [MUTATION]     a kernel's faults are put in by name (mutations.py)
       generate.py table OUT.cpp NAME...                       the table of the modules of one program
"""

import pathlib
import sys

import mutations
import write
from parse import PtxError, parse


def main(arguments):
    if len(arguments) >= 2 and arguments[0] == "table":
        pathlib.Path(arguments[1]).write_text(write.write_table(arguments[2:]), encoding="utf-8")
        return 0
    if len(arguments) not in (4, 5) or arguments[0] != "module":
        print(__doc__, file=sys.stderr)
        return 2
    name, source, target = arguments[1], pathlib.Path(arguments[2]), pathlib.Path(arguments[3])
    try:
        module = parse(source.read_text(encoding="utf-8"), source.name)
        if len(arguments) == 5:
            mutations.apply(arguments[4], module)
        target.write_text(write.write_module(module, name), encoding="utf-8")
    except PtxError as error:
        print(f"{source.name}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
