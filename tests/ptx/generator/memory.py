"""Instructions that touch memory: loads, stores, atomics, fences, and addresses of one space as those of another."""

from operands import BYTES, C_TYPES
from parse import PtxError, split_operands

SPACES = {"global": "global", "shared": "shared", "local": "local", "param": "parameter", "const": "global"}
HINTS = ("weak", "nc", "ca", "cg", "cs", "lu", "cv", "wb", "wt", "cta", "cluster", "gpu", "sys")
STRONG = ("volatile", "relaxed", "acquire", "release", "mmio")
WINDOWS = {"shared": "kSharedWindow", "local": "kLocalWindow", "param": "kParameterWindow"}
OPERATIONS = {
    "add": "add", "min": "minimum", "max": "maximum", "exch": "exchange", "inc": "increase", "dec": "decrease",
    "and": "bit_and", "or": "bit_or", "xor": "bit_xor",
}  # fmt: skip


def space_of(opcode):
    return next((SPACES[part.split("::")[0]] for part in opcode[1:] if part.split("::")[0] in SPACES), "generic")


def load_or_store(i, o):
    loads = i.opcode[0] == "ld"
    kind = i.opcode[-1]
    count = {"v2": 2, "v4": 4}.get(i.opcode[-2], 1)
    known = (*SPACES, *HINTS, *STRONG, "v2", "v4")
    unknown = [p for p in i.opcode[1:-1] if p.split("::")[0] not in known and not p.startswith(("L1::", "L2::"))]
    if unknown or kind not in C_TYPES:
        raise PtxError("is not understood")
    address, space = o.address(i.operands[1 if loads else 0], space_of(i.opcode))
    text = i.operands[0 if loads else 1]
    registers = split_operands(text[1:-1]) if text.startswith("{") else [text]
    strong = "strong_" if any(part in STRONG for part in i.opcode) else ""
    c_type, size = C_TYPES[kind], BYTES[kind]
    lines = [f"char* at = reach(thread, Space::{space}, {address}, {size * count}, "
             f"Access::{strong}{'read' if loads else 'write'});"]  # fmt: skip
    for n, register in enumerate(registers):
        place = f"at + {n * size}" if n else "at"
        if loads:
            lines.append(o.write(register, kind, f"take<{c_type}>({place})"))
        else:
            lines.append(f"put<{c_type}>({place}, {o.read(register, kind)});")
    if "release" in i.opcode:
        lines.insert(0, "fence(thread);")
    if "acquire" in i.opcode:
        lines.append("fence(thread);")
    return " ".join(lines)


def atomic(i, o):
    """atom, and red, which returns nothing."""
    kind = i.opcode[-1]
    name = next((part for part in i.opcode[1:-1] if part in (*OPERATIONS, "cas")), None)
    rest = [p for p in i.opcode[1:-1] if p != name and p.split("::")[0] not in (*SPACES, *HINTS, "relaxed", *FENCED)]
    if name is None or rest or kind not in C_TYPES:
        raise PtxError("is not understood")
    operands = i.operands if i.opcode[0] == "atom" else ["_", *i.operands]
    address, space = o.address(operands[1], space_of(i.opcode))
    c_type = C_TYPES[kind]
    values = ", ".join(o.read(text, kind) for text in operands[2:])
    if name == "cas":
        call = f"compare_and_swap<{c_type}>(thread, Space::{space}, {address}, {values})"
    else:
        function = "add_flushed" if (name, kind, space) == ("add", "f32", "global") else f"{OPERATIONS[name]}<{c_type}>"
        call = f"update<{c_type}>(thread, Space::{space}, {address}, {function}, {values})"
    before = "fence(thread); " if any(part in ("release", "acq_rel") for part in i.opcode) else ""
    after = " fence(thread);" if any(part in ("acquire", "acq_rel") for part in i.opcode) else ""
    return before + o.write(operands[0], kind, call) + after


FENCED = ("acquire", "release", "acq_rel")


def fence(i, o):
    """A fence of the block alone orders nothing that the race detector would count: only barriers do, within a block."""
    if any(part not in ("sc", "acq_rel", "cta", "cluster", "gpu", "gl", "sys") for part in i.opcode[1:]):
        raise PtxError("is not understood")
    return ";" if "cta" in i.opcode else "fence(thread);"


def change_space(i, o):
    """cvta: to the generic space, or from it to one space."""
    space, kind = i.opcode[-2], i.opcode[-1]
    window = WINDOWS.get(space.split("::")[0])
    value = o.read(i.operands[1], kind)
    if window:
        value = f"{value} - {window}" if "to" in i.opcode else f"{value} + {window}"
    return o.write(i.operands[0], kind, value)


def fences(instruction):
    """Whether it can order the memory of one block for another."""
    return (instruction.opcode[0] in ("membar", "fence") and "cta" not in instruction.opcode) or (
        instruction.opcode[0] in ("ld", "st", "atom", "red") and any(part in FENCED for part in instruction.opcode))


def may_wait(instruction):
    """Whether a loop around it may wait for another thread."""
    return instruction.opcode[0] == "nanosleep" or (
        instruction.opcode[0] in ("ld", "atom") and any(part in (*STRONG, "cas", "exch") for part in instruction.opcode))


TRANSLATIONS = {"ld": load_or_store, "st": load_or_store, "atom": atomic, "red": atomic, "membar": fence, "fence": fence,
                "cvta": change_space, "prefetch": lambda i, o: ";", "nanosleep": lambda i, o: ";"}  # fmt: skip
