"""Instructions that compute: registers in, registers out. Each has one function in device/arithmetic.h."""

from operands import C_TYPES, FLOATS
from parse import PtxError

# Opcode: (function, types of the operands after the first where they are not the instruction's own, type of the result).
SIMPLE = {
    "add": ("add", {}, None), "sub": ("subtract", {}, None), "neg": ("negate", {}, None), "abs": ("absolute", {}, None),
    "rem": ("remainder", {}, None), "div": ("divide", {}, None), "min": ("minimum", {}, None), "max": ("maximum", {}, None),
    "fma": ("fused", {}, None), "sqrt": ("square_root", {}, None), "rcp": ("reciprocal", {}, None),
    "copysign": ("copy_sign", {}, None),
    "shl": ("shift_left", {2: "u32"}, None), "shr": ("shift_right", {2: "u32"}, None),
    "clz": ("leading_zeros", {}, "u32"), "popc": ("population", {}, "u32"), "brev": ("reverse", {}, None),
    "bfi": ("insert", {3: "u32", 4: "u32"}, None), "bfe": ("extract", {2: "u32", 3: "u32"}, None),
}  # fmt: skip
# What says how to round, and changes nothing: to nearest is how the host rounds. Everything else is refused.
ROUNDED = ("add", "sub", "mul", "div", "fma", "sqrt", "rcp")
COMPARISONS = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">="}
COMPARISONS |= {"lo": "<", "ls": "<=", "hi": ">", "hs": ">="}  # of unsigned numbers
JOINS = {"and": "&", "or": "|", "xor": "^"}


def without(opcode, *allowed):
    """The opcode's last part, its type, when it has no other parts than those allowed."""
    rest = [part for part in opcode[1:-1] if part not in allowed]
    if rest:
        raise PtxError(f"'.{rest[0]}' is refused or not understood")
    return opcode[-1]


def simple(i, o):
    function, kinds, result = SIMPLE[i.opcode[0]]
    kind = without(i.opcode, *(("rn",) if i.opcode[0] in ROUNDED and i.opcode[-1] in FLOATS else ()))
    if i.opcode[0] in ("sqrt", "rcp", "fma") and "rn" not in i.opcode:
        raise PtxError("is refused: it is approximate")
    if i.opcode[0] == "div" and kind in FLOATS and "rn" not in i.opcode:
        raise PtxError("is refused: it is approximate")
    arguments = [o.read(text, kinds.get(n, kind)) for n, text in enumerate(i.operands) if n > 0]
    return o.write(i.operands[0], result or kind, f"{function}<{C_TYPES[kind]}>({', '.join(arguments)})")


def multiply(i, o):
    """mul and mad, of one width, the high half, or twice as wide."""
    kind = without(i.opcode, "lo", "hi", "wide", "rn")
    a, b = o.read(i.operands[1], kind), o.read(i.operands[2], kind)
    result = kind
    if "wide" in i.opcode:
        result = kind[0] + str(2 * int(kind[1:]))
        product = f"multiply_wide<{C_TYPES[result]}>({a}, {b})"
    else:
        product = f"{'multiply_high' if 'hi' in i.opcode else 'multiply'}<{C_TYPES[kind]}>({a}, {b})"
    if i.opcode[0] == "mad":
        if kind in FLOATS:
            raise PtxError("is refused: mad of floating point")
        product = f"add<{C_TYPES[result]}>({product}, {o.read(i.operands[3], result)})"
    return o.write(i.operands[0], result, product)


def logic(i, o):
    kind = without(i.opcode)
    if kind == "pred":
        values = [o.predicate(text) for text in i.operands[1:]]
        value = f"!{values[0]}" if i.opcode[0] == "not" else f"({values[0]} {JOINS[i.opcode[0]]} {values[1]}) != 0"
        return o.write(i.operands[0], kind, value)
    values = [o.read(text, kind) for text in i.operands[1:]]
    value = f"~{values[0]}" if i.opcode[0] == "not" else f"{values[0]} {JOINS[i.opcode[0]]} {values[1]}"
    return o.write(i.operands[0], kind, f"static_cast<{C_TYPES[kind]}>({value})")


def compare(i, o):
    """setp, perhaps joined with a further predicate, perhaps with the opposite as a second result."""
    kind, comparison = i.opcode[-1], i.opcode[1]
    join = next((part for part in i.opcode[2:-1] if part in JOINS), None)
    if [part for part in i.opcode[2:-1] if part not in JOINS]:
        raise PtxError("is refused or not understood")
    if kind == "pred":
        raise PtxError("compares predicates")
    a, b = o.read(i.operands[1], kind), o.read(i.operands[2], kind)
    value = compare_floats(comparison, a, b) if kind in FLOATS else f"{a} {COMPARISONS[comparison]} {b}"
    targets = i.operands[0].split("|")
    lines = [f"const bool holds = {value};"]
    for target, holds in zip(targets, ("holds", "!holds"), strict=False):
        if target != "_":
            joined = f"({holds} {JOINS[join]} {o.predicate(i.operands[3])}) != 0" if join else holds
            lines.append(o.write(target, "pred", joined))
    return " ".join(lines)


def compare_floats(comparison, a, b):
    if comparison in ("num", "nan"):
        return f"{'!' if comparison == 'num' else ''}unordered({a}, {b})"
    if comparison.endswith("u"):  # true of NaN
        return f"unordered({a}, {b}) || {a} {COMPARISONS[comparison[:-1]]} {b}"
    if comparison == "ne":
        return f"!unordered({a}, {b}) && {a} != {b}"
    return f"{a} {COMPARISONS[comparison]} {b}"


def select(i, o):
    kind = without(i.opcode)
    return o.write(i.operands[0], kind,
                   f"{o.predicate(i.operands[3])} ? {o.read(i.operands[1], kind)} : {o.read(i.operands[2], kind)}")


def move(i, o):
    kind = without(i.opcode)
    to, source = i.operands
    if kind == "pred":
        return o.write(to, kind, o.predicate(source))
    half = "b" + str(int(kind[1:]) // 2) if to.startswith("{") or source.startswith("{") else kind
    if source.startswith("{"):
        low, high = (o.read(part.strip(), half) for part in source[1:-1].split(","))
        return o.write(to, kind, f"static_cast<{C_TYPES[kind]}>(std::uint64_t{{{high}}} << {half[1:]} | {low})")
    if to.startswith("{"):
        low, high = (part.strip() for part in to[1:-1].split(","))
        return (f"const {C_TYPES[kind]} whole = {o.read(source, kind)}; "
                + o.write(low, half, f"static_cast<{C_TYPES[half]}>(whole)")
                + o.write(high, half, f"static_cast<{C_TYPES[half]}>(whole >> {half[1:]})"))  # fmt: skip
    return o.write(to, kind, o.read(source, kind))


ROUNDS = {"rni": "std::nearbyint", "rzi": "std::trunc", "rmi": "std::floor", "rpi": "std::ceil"}


def convert(i, o):
    to, source = i.opcode[-2:]
    how = i.opcode[1:-2]
    if to not in C_TYPES or source not in C_TYPES:
        raise PtxError(f"converts {source} to {to}")
    value = o.read(i.operands[1], source)
    rounds = [part for part in how if part in ROUNDS]
    allowed = [*rounds, "rn"] if to in FLOATS else [*rounds, "sat"] if source not in FLOATS else rounds
    if [part for part in how if part not in allowed] or (source in FLOATS and to not in FLOATS and not rounds):
        raise PtxError("is refused or not understood")
    if source in FLOATS and rounds:
        value = f"{ROUNDS[rounds[0]]}({value})"
    if to in FLOATS:
        return o.write(i.operands[0], to, f"to_float<{C_TYPES[to]}>({value})")
    if source in FLOATS:
        return o.write(i.operands[0], to, f"saturate<{C_TYPES[to]}>({value})")
    return o.write(i.operands[0], to, f"{'clamp_to' if 'sat' in how else 'static_cast'}<{C_TYPES[to]}>({value})")


def find_leading(i, o):
    kind = without(i.opcode, "shiftamt")
    function = "find_leading_shift" if "shiftamt" in i.opcode else "find_leading"
    return o.write(i.operands[0], "u32", f"{function}<{C_TYPES[kind]}>({o.read(i.operands[1], kind)})")


def three_words(function):
    """Of 32-bit words alone: prmt, lop3."""
    def translate(i, o):
        without(i.opcode)
        values = ", ".join(o.read(text, "u32") for text in i.operands[1:])
        return o.write(i.operands[0], "u32", f"{function}({values})")
    return translate


def funnel(i, o):
    """shf: the shift counts modulo 32 (wrap) or up to 32 (clamp)."""
    without(i.opcode, "l", "r", "wrap", "clamp")
    low, high, n = (o.read(text, "u32") for text in i.operands[1:])
    n = f"({n} & 31u)" if "wrap" in i.opcode else f"minimum<std::uint32_t>({n}, 32u)"
    return o.write(i.operands[0], "u32", f"funnel_{'left' if 'l' in i.opcode else 'right'}({low}, {high}, {n})")


TRANSLATIONS = dict.fromkeys(SIMPLE, simple) | {
    "mul": multiply, "mad": multiply, "and": logic, "or": logic, "xor": logic, "not": logic, "setp": compare, "selp": select,
    "mov": move, "cvt": convert, "bfind": find_leading, "prmt": three_words("permute"), "lop3": three_words("any_of_three"),
    "shf": funnel,
}  # fmt: skip
