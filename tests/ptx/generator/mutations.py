"""Faults put into kernels on purpose, so that tests can be shown to see them."""

from parse import Instruction, PtxError


def without_fusing(kernel):
    """fma, written as a product and a sum: it rounds twice."""
    for place, i in reversed(list(enumerate(kernel.body))):
        if isinstance(i, Instruction) and i.opcode[0] == "fma":
            kind, (to, a, b, c) = i.opcode[-1], i.operands
            family = f"unfused_{kind}_"
            kernel.registers[family] = (kind, 1)
            product = Instruction(i.line, ["mul", "rn", kind], [f"%{family}0", a, b], i.guard, i.guard_negated)
            i.opcode, i.operands = ["add", "rn", kind], [to, f"%{family}0", c]
            kernel.body.insert(place, product)


def without_barriers(kernel):
    kernel.body = [i for i in kernel.body if not isinstance(i, Instruction) or i.opcode[:2] != ["bar", "sync"]]


def without_atomics(kernel):
    """An atomic addition, written as a load, a sum and a store."""
    for place, i in reversed(list(enumerate(kernel.body))):
        if isinstance(i, Instruction) and i.opcode[0] in ("atom", "red") and "add" in i.opcode:
            space = [part for part in i.opcode if part in ("global", "shared")]
            kind, (to, address, value) = i.opcode[-1], (i.operands if i.opcode[0] == "atom" else ["_", *i.operands])
            families = [f"plain_{name}_{kind}_" for name in ("old", "sum")]
            for family in families:
                kernel.registers[family] = ("b" + kind[1:] if kind[0] in "us" else kind, 1)
            old, total = (f"%{family}0" for family in families)
            parts = [(["ld", *space, kind], [old, address]), (["add", kind], [total, old, value]),
                     (["st", *space, kind], [address, total])]  # fmt: skip
            parts += [(["mov", kind], [to, old])] if to != "_" else []
            kernel.body[place:place + 1] = [Instruction(i.line, *part, i.guard, i.guard_negated) for part in parts]


def with_wider_bounds(kernel):
    """Every comparison of an unsigned number with the end of a range lets the end itself through."""
    for i in kernel.body:
        if isinstance(i, Instruction) and i.opcode[0] == "setp" and i.opcode[-1] in ("u64", "u32"):
            i.opcode[1] = {"ge": "gt", "lt": "le"}.get(i.opcode[1], i.opcode[1])


MUTATIONS = {"fma": without_fusing, "barrier": without_barriers, "atomic": without_atomics, "bound": with_wider_bounds}


def apply(name, module):
    if name not in MUTATIONS:
        raise PtxError(f"there is no mutation '{name}'; there are {', '.join(MUTATIONS)}")
    for kernel in module.kernels:
        MUTATIONS[name](kernel)
