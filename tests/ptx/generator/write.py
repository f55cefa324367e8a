"""A module of PTX as a C++ source: a function for each kernel, and tables of kernels and variables."""

import re

import arithmetic
import meetings
import memory
from operands import C_TYPES, Operands
from parse import Label, PtxError

KINDS = ("kInteger", "kFloat32", "kFloat64", "kGlobal", "kShared", "kOther", "kAtomic", "kMeeting", "kControl")
TRANSLATIONS = arithmetic.TRANSLATIONS | memory.TRANSLATIONS
# Identifiers with numbers of the file's path, or of the architectures compiled for. The runtime drops them too when a
# kernel is asked for (runtime/names.cpp).
NUMBERED = re.compile(r"(_GLOBAL__N_|_INTERNAL)_[0-9a-f]{8}_\d+_(\w+)_cu_[0-9a-f]{8}|(CUB|THRUST)_\d+_SM_[\d_]+(?:NS)?")
STARTS = re.compile(r"(\d+)(?=_GLOBAL__N__|_INTERNAL_|CUB_|THRUST_)")


def plain(name):
    """A kernel's or variable's mangled name without such numbers. There an identifier follows its length, before which
    there may be a digit of something else."""
    result, done = "", 0
    for start in STARTS.finditer(name):
        for skipped in range(len(start[1])):
            end = start.end() + int(start[1][skipped:])
            found = NUMBERED.fullmatch(name, start.end(), end)
            if found and end <= len(name):
                word = "".join(part for part in found.groups() if part)
                result += name[done:start.start() + skipped] + str(len(word)) + word
                done = end
                break
    return result + name[done:]


def kind_of(instruction):
    """How it is counted (device/thread.h)."""
    name, kind = instruction.opcode[0], instruction.opcode[-1]
    if name in ("atom", "red"):
        return "kAtomic"
    if name in ("ld", "st"):
        kinds = {"global": "kGlobal", "generic": "kGlobal", "shared": "kShared"}
        return kinds.get(memory.space_of(instruction.opcode), "kOther")
    if name in meetings.TRANSLATIONS or name in ("membar", "fence", "activemask"):
        return "kMeeting"
    if name in ("bra", "ret", "exit"):
        return "kControl"
    return {"f32": "kFloat32", "f64": "kFloat64"}.get(kind, "kInteger")


def label_name(name):
    return re.sub(r"\W|_", "", name)


class KernelWriter:
    def __init__(self, kernel, module):
        self.kernel, self.operands, self.resumes, self.lines = kernel, Operands(kernel, module), 0, []
        self.pieces = []  # kinds of instructions, and how many

    def write(self, number):
        instructions = self.kernel.body
        for place, item in enumerate(instructions):
            if place == 0 or isinstance(item, Label) or ends_block(instructions[place - 1]):
                self.count(instructions, place)
            if isinstance(item, Label):
                continue
            try:
                text = self.translate(item)
            except (PtxError, KeyError, ValueError, IndexError) as error:
                why = error if isinstance(error, PtxError) else "is not understood"
                raise PtxError(f"line {item.line}: kernel {self.kernel.name}: '{item.text}': {why}") from None
            self.lines.append(f"  {self.guard(item)}{text}")
        return self.function(number)

    def guard(self, item):
        return f"if ({'!' if item.guard_negated else ''}{self.operands.predicate(item.guard)}) " if item.guard else ""

    def count(self, instructions, place):
        """A label, if one is here, and the piece from here to the next one or the next branch: what is in it."""
        if isinstance(instructions[place], Label):
            self.lines.append(f"{label_name(instructions[place].name)}:;")
            place += 1
        kinds = {}
        while place < len(instructions) and not isinstance(instructions[place], Label):
            kind = kind_of(instructions[place])
            kinds[kind] = kinds.get(kind, 0) + 1
            if ends_block(instructions[place]):
                break
            place += 1
        if kinds:
            self.lines.append(f"  thread.visit({len(self.pieces)});")
            self.pieces.append(kinds)

    def translate(self, i):
        name = i.opcode[0]
        if name == "bra":
            return f"goto {label_name(i.operands[0])};"
        if name in ("ret", "exit"):
            return "return Outcome::finished;"
        if name == "trap":
            return f"{{ thread.line = {i.line}; refuse(thread, \"the kernel gave up: trap\"); }}"
        if name == "activemask":  # no thread is promised company
            return self.operands.write(i.operands[0], "b32", "1u << thread.lane()")
        if name in meetings.TRANSLATIONS:
            asked, given = meetings.TRANSLATIONS[name](i, self.operands)
            return f"{{ thread.line = {i.line}; {asked} {self.stop(meetings.outcome(i))} {given} }}"
        if name not in TRANSLATIONS:
            raise PtxError("is not understood")
        text = TRANSLATIONS[name](i, self.operands)
        if name in memory.TRANSLATIONS and name != "cvta":
            text = f"thread.line = {i.line}; {text}"
        if memory.may_wait(i):
            ready = "true" if name == "nanosleep" else "thread.lets_others_run()"
            return f"{{ {{ {text} }} if ({ready}) {{ {self.stop('Outcome::yielded')} }} }}"
        return f"{{ {text} }}"

    def stop(self, outcome):
        """Back to the scheduler, and on from here at the next call."""
        self.resumes += 1
        return f"s.resume = {self.resumes}; return {outcome}; resume{self.resumes}:;"

    def function(self, number):
        families = "".join(f"  {C_TYPES[kind]} {family}[{count}];\n" for family, (kind, count) in self.kernel.registers.items())
        cases = "".join(f"    case {n}: goto resume{n};\n" for n in range(1, self.resumes + 1))
        body = "\n".join(self.lines)
        jump = f"  switch (s.resume) {{\n    default: break;\n{cases}  }}\n" if cases else ""
        return (f"// {plain(self.kernel.name)}\nstruct Registers{number} {{\n  int resume;\n{families}}};\n"
                f"Outcome kernel{number}(Thread& thread, void* registers) {{\n"
                f"  auto& s = *static_cast<Registers{number}*>(registers);\n{jump}{body}\n"
                f"  return Outcome::finished;\n}}\n")  # fmt: skip


def ends_block(item):
    return not isinstance(item, Label) and item.opcode[0] in ("bra", "ret", "exit")


def piece_table(pieces, number):
    rows = "".join(f"    {{{', '.join(str(kinds.get(kind, 0)) for kind in KINDS)}}},\n" for kinds in pieces)
    return f"const Piece pieces{number}[] = {{\n{rows}    {{}}}};\n"


def kernel_row(kernel, number, file, pieces, meets):
    fenced = any(memory.fences(i) for i in kernel.body if not isinstance(i, Label))
    return (f'    {{"{plain(kernel.name)}", "{file}", kernel{number}, sizeof(Registers{number}), {kernel.bytes_of("shared")}, '
            f'{kernel.bytes_of("local")}, {kernel.parameter_bytes}, {kernel.max_threads}, '
            f"parameters{number}, pieces{number}, {pieces}, "
            f"{'true' if meets else 'false'}, {'true' if fenced else 'false'}}},\n")  # fmt: skip


def parameter_table(kernel, number):
    rows = "".join(f"{{{p.offset}, {p.size}}}, " for p in kernel.parameters.values())
    return f"const Parameter parameters{number}[] = {{{rows}{{0, 0}}}};\n"


def write_symbols(module):
    text, rows = "", ""
    for n, variable in enumerate(module.variables.values()):
        initial = "nullptr"
        if variable.initial:
            initial = f"initial{n}"
            text += f"const unsigned char initial{n}[] = {{{', '.join(map(str, variable.initial))}}};\n"
        rows += f'    {{"{plain(variable.name)}", {variable.size}, {variable.align}, {initial}, 0}},\n'
    # One more, so that there is an array where there are no variables. Those of shared memory keep their places.
    return f"{text}Symbol symbols[] = {{\n{rows}    {{nullptr, 0, 1, nullptr, 0}}}};\n"


def write_module(module, name):
    writers = [KernelWriter(kernel, module) for kernel in module.kernels]
    kernels = [writer.write(n) for n, writer in enumerate(writers)]
    parameters = "".join(parameter_table(kernel, n) for n, kernel in enumerate(module.kernels))
    pieces = "".join(piece_table(writer.pieces, n) for n, writer in enumerate(writers))
    rows = "".join(kernel_row(writer.kernel, n, module.file, len(writer.pieces), writer.resumes > 0)
                   for n, writer in enumerate(writers))  # fmt: skip
    empty = "" if rows else "    {nullptr, nullptr, nullptr, 0, 0, 0, 0, 0, nullptr, nullptr, 0, false, false},\n"
    return (f"// Written by tests/ptx/generator from {module.file}.\n"
            '#include "tests/ptx/device/access.h"\n\nnamespace ptx {\nnamespace {\n\n'
            f"{write_symbols(module)}\n{''.join(kernels)}\n{parameters}{pieces}"
            f"const Kernel kernels[] = {{\n{rows}{empty}}};\n\n"
            "}  // namespace\n\n"
            f"extern const Module module_{name};\n"
            f"const Module module_{name}{{kernels, {len(module.kernels)}, symbols, {len(module.variables)}}};\n\n"
            "}  // namespace ptx\n")  # fmt: skip


def write_table(names):
    """Where the runtime finds the modules."""
    declared = "".join(f"extern const Module module_{name};\n" for name in names)
    listed = "".join(f"&module_{name}, " for name in names)
    return ('// Written by tests/ptx/generator.\n#include "tests/ptx/device/thread.h"\n\nnamespace ptx {\n'
            f"{declared}const Module* const modules[] = {{{listed}nullptr}};\n}}  // namespace ptx\n")  # fmt: skip
