"""Operands of PTX as C++: registers, numbers, addresses, special registers."""

import re

from parse import PtxError

C_TYPES = {
    "pred": "bool", "u8": "std::uint8_t", "s8": "std::int8_t", "b8": "std::uint8_t", "u16": "std::uint16_t",
    "s16": "std::int16_t", "b16": "std::uint16_t", "u32": "std::uint32_t", "s32": "std::int32_t", "b32": "std::uint32_t",
    "u64": "std::uint64_t", "s64": "std::int64_t", "b64": "std::uint64_t", "f32": "float", "f64": "double",
}  # fmt: skip
BYTES = {"pred": 1} | {kind + bits: int(bits) // 8 for kind in "usb" for bits in ("8", "16", "32", "64")} | {"f32": 4, "f64": 8}
FLOATS = ("f32", "f64")

SPECIAL = {
    "%laneid": "thread.lane()", "%warpid": "thread.warp()", "%lanemask_eq": "(1u << thread.lane())",
    "%lanemask_ge": "thread.lanes_at_or_above()", "%lanemask_lt": "thread.lanes_below()",
    "%lanemask_le": "(thread.lanes_below() | 1u << thread.lane())",
    "%lanemask_gt": "(thread.lanes_at_or_above() & ~(1u << thread.lane()))",
    "%dynamic_smem_size": "thread.launch->dynamic_shared", "WARP_SZ": "32u",
} | {f"%{name}.{axis}": f"thread.{member}.{axis}" for axis in "xyz" for name, member in
     (("tid", "id"), ("ctaid", "block_id"), ("ntid", "launch->threads"), ("nctaid", "launch->blocks"))}  # fmt: skip


class Operands:
    """Those of one kernel."""

    def __init__(self, kernel, module):
        self.kernel, self.module = kernel, module

    def register(self, name):
        """(C++ of it, its type), or None where it is no register."""
        found = re.fullmatch(r"%(\w*?)(\d+)", name)
        if not found or found[1] not in self.kernel.registers:
            return None
        kind, count = self.kernel.registers[found[1]]
        return (f"s.{found[1]}[{found[2]}]", kind) if int(found[2]) < count else None

    def variable(self, name):
        """A variable with its space: of the kernel, a parameter, or of the module."""
        return self.kernel.variables.get(name) or self.kernel.parameters.get(name) or self.module.variables.get(name)

    def address_of(self, variable, kind):
        if variable.space in ("global", "const"):
            return f"symbols[{list(self.module.variables).index(variable.name)}].address"
        return f"{C_TYPES[kind]}{{{variable.offset}}}"

    def read(self, operand, kind):
        """The value of an operand, as a C++ expression of that very type."""
        found = self.register(operand)
        if found:
            return read_register(*found, kind)
        if operand in SPECIAL:
            return f"static_cast<{C_TYPES[kind]}>({SPECIAL[operand]})"
        if operand.startswith("%"):
            raise PtxError(f"the special register {operand} is refused or not understood")
        literal = re.fullmatch(r"0([fd])([0-9A-Fa-f]+)", operand)
        if literal and kind in FLOATS:
            bits = "std::uint32_t{0x" if literal[1] == "f" else "std::uint64_t{0x"
            return f"bits<{C_TYPES[kind]}>({bits}{literal[2]}u}})"
        if re.fullmatch(r"-?(\d+|0x[0-9A-Fa-f]+)U?", operand) and kind not in FLOATS:
            return literal_of(int(operand.rstrip("U"), 0), kind)
        offset = re.fullmatch(r"([\w$]+)(?:\+(-?\d+))?", operand)
        variable = self.variable(offset[1]) if offset else None
        if variable:
            return f"static_cast<{C_TYPES[kind]}>({self.address_of(variable, kind)} + {int(offset[2] or 0)})"
        raise PtxError(f"operand '{operand}' is not understood as {kind}")

    def write(self, operand, kind, expression):
        """A statement that puts a value of that type into a register; wider registers are filled by its sign."""
        if operand == "_":
            return f"(void)({expression});"
        found = self.register(operand)
        if not found:
            raise PtxError(f"'{operand}' is not a register")
        name, own = found
        if own == kind or (own == "pred" and kind == "pred"):
            return f"{name} = {expression};"
        if (own in FLOATS) != (kind in FLOATS):
            if BYTES[own] != BYTES[kind]:
                raise PtxError(f"register {operand} of {own} cannot hold {kind}")
            return f"{name} = bits<{C_TYPES[own]}>({expression});"
        if own == "pred" or kind == "pred":
            raise PtxError(f"register {operand} of {own} cannot hold {kind}")
        return f"{name} = static_cast<{C_TYPES[own]}>({expression});"

    def address(self, operand, space):
        """An address in brackets as (C++ of a 64-bit number, space)."""
        found = re.fullmatch(r"\[([%\w$]+)(?:\+(-?\d+))?\]", operand)
        if not found:
            raise PtxError(f"address '{operand}' is not understood")
        base, offset = found[1], int(found[2] or 0)
        variable = self.variable(base)
        if variable:
            if space == "generic":
                space = {"param": "parameter", "const": "global"}.get(variable.space, variable.space)
            return f"{self.address_of(variable, 'u64')} + {offset}", space
        plus = f" + std::uint64_t({offset}ll)" if offset else ""
        return f"{self.read(base, 'u64')}{plus}", space

    def predicate(self, operand):
        """A predicate, perhaps negated or a number."""
        if operand.startswith("!"):
            return f"!{self.predicate(operand[1:])}"
        if re.fullmatch(r"-?\d+", operand):
            return "true" if int(operand) else "false"
        found = self.register(operand)
        if not found or found[1] != "pred":
            raise PtxError(f"'{operand}' is not a predicate")
        return found[0]


def read_register(name, own, kind):
    if own == kind:
        return name
    if "pred" in (own, kind):
        raise PtxError(f"a register of {own} is read as {kind}")
    if (own in FLOATS) != (kind in FLOATS) or (own in FLOATS and own != kind):
        if BYTES[own] != BYTES[kind]:
            raise PtxError(f"a register of {own} is read as {kind}")
        return f"bits<{C_TYPES[kind]}>({name})"
    return f"static_cast<{C_TYPES[kind]}>({name})"


def literal_of(number, kind):
    if kind == "pred":
        return "true" if number else "false"
    return f"static_cast<{C_TYPES[kind]}>({number % (1 << 64)}ull)"
