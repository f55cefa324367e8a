"""PTX text as data: a module of variables and kernels, a kernel of declarations and instructions."""

import re
from dataclasses import dataclass, field


class PtxError(Exception):
    """What this tool does not understand, or refuses: one line for whoever reads the build's log."""


@dataclass
class Instruction:
    line: int
    opcode: list[str]  # "add.rn.f32" by its dots
    operands: list[str]
    guard: str | None = None  # the predicate's register
    guard_negated: bool = False

    @property
    def text(self):
        return f"{'.'.join(self.opcode)} {', '.join(self.operands)}".strip()


@dataclass
class Label:
    line: int
    name: str


@dataclass
class Variable:
    """Memory with a name: shared, local, or of the module (global, const)."""

    name: str
    space: str
    align: int
    size: int
    offset: int = 0
    initial: bytes = b""
    is_extern: bool = False


@dataclass
class Kernel:
    name: str
    line: int
    parameters: dict[str, Variable] = field(default_factory=dict)
    parameter_bytes: int = 0
    registers: dict[str, tuple[str, int]] = field(default_factory=dict)  # family: (type, count)
    variables: dict[str, Variable] = field(default_factory=dict)
    body: list[Instruction | Label] = field(default_factory=list)
    max_threads: int = 1024

    def bytes_of(self, space):
        return max((v.offset + v.size for v in self.variables.values() if v.space == space), default=0)


@dataclass
class Module:
    file: str
    variables: dict[str, Variable] = field(default_factory=dict)
    kernels: list[Kernel] = field(default_factory=list)


SIZES = {"8": 1, "16": 2, "32": 4, "64": 8}
DECLARATION = re.compile(
    r"(?P<words>(?:\.\w+ )*?)(?:\.align (?P<align>\d+) )?\.(?P<kind>[bsuf])(?P<bits>8|16|32|64) "
    r"(?P<name>[\w$%]+)(?P<array>(?:\[\d*\])*)(?: ?= ?(?P<initial>.*))?$"
)
IGNORED = (".loc", ".file", ".pragma", ".maxnreg", ".minnctapersm", ".version", ".target", ".address_size")


def statements(text):
    """(line, statement) for each; braces that open and close a scope are statements of their own."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
    word, line, started, braces = "", 1, 1, 0
    for character in text:
        if character == "\n":
            line += 1
        if not word.strip():
            started, word = line, ""
        stripped = " ".join(word.split())
        if character == "{" and (not stripped or re.search(r"\.(entry|func)\b", stripped)):
            if stripped:
                yield started, stripped
            yield line, "{"
            word = ""
        elif character == "}" and braces == 0:
            yield line, "}"
            word = ""
        elif character == ";" or (character == ":" and re.fullmatch(r"[$\w]+", stripped)):
            if not stripped.startswith(IGNORED):
                yield started, stripped + (":" if character == ":" else "")
            word = ""
        elif character == "\n" and stripped.startswith(IGNORED):
            word = ""
        else:
            braces += {"{": 1, "}": -1}.get(character, 0)
            word += character


def split_operands(text):
    """At the commas that are in no brace or bracket."""
    parts, depth, part = [], 0, ""
    for character in text:
        depth += {"{": 1, "[": 1, "}": -1, "]": -1}.get(character, 0)
        if character == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += character
    return parts + [part.strip()] if part.strip() else parts


def parse_variable(statement, line):
    """A declaration of memory, or None."""
    found = DECLARATION.match(statement)
    if not found:
        return None
    words = found["words"].split()
    spaces = [w[1:] for w in words if w[1:] in ("shared", "local", "global", "const", "param")]
    if not spaces:
        return None
    width = SIZES[found["bits"]]
    count = 1
    for extent in re.findall(r"\[(\d*)\]", found["array"]):
        count *= int(extent or 0)
    initial = parse_initial(found["initial"], width, found["kind"], line) if found["initial"] else b""
    return Variable(found["name"], spaces[0], int(found["align"] or width), width * count, 0, initial, ".extern" in words)


def parse_initial(text, width, kind, line):
    values = [v for v in re.split(r"[\s,{}]+", text) if v]
    data = bytearray()
    for value in values:
        bits = re.fullmatch(r"0[fFdD]([0-9A-Fa-f]+)", value)
        if not bits and not re.fullmatch(r"-?(0x[0-9A-Fa-f]+|\d+)", value):
            raise PtxError(f"line {line}: initial value '{value}' is not understood")
        number = int(bits.group(1), 16) if bits else int(value, 0)
        data += (number % (1 << 8 * width)).to_bytes(width, "little")
    return bytes(data)


def place(variable, end):
    variable.offset = (end + variable.align - 1) // variable.align * variable.align
    return variable.offset + variable.size


def parse_header(statement, line):
    found = re.search(r"\.entry ([\w$]+) ?\((.*?)\)(.*)$", statement)
    if not found:
        raise PtxError(f"line {line}: only kernels are understood, not '{statement[:60]}'")
    kernel = Kernel(found[1], line)
    for text in split_operands(found[2]):
        variable = parse_variable(text, line)
        if variable is None:
            raise PtxError(f"line {line}: parameter '{text}' is not understood")
        kernel.parameter_bytes = place(variable, kernel.parameter_bytes)
        kernel.parameters[variable.name] = variable
    bound = re.search(r"\.(?:maxntid|reqntid) ([\d, ]+)", found[3])
    if bound:
        kernel.max_threads = 1
        for extent in bound[1].split(","):
            kernel.max_threads *= int(extent)
    return kernel


def parse_instruction(statement, line):
    guard = re.match(r"@(!?)(%?[\w$]+) (.*)$", statement)
    if guard:
        statement = guard[3]
    opcode, _, rest = statement.partition(" ")
    return Instruction(line, opcode.split("."), split_operands(rest), guard[2] if guard else None, bool(guard and guard[1]))


class KernelReader:
    """Takes the statements of one kernel. Registers of inner scopes get names of their own."""

    def __init__(self, kernel, module):
        self.kernel, self.module, self.renamed, self.scopes = kernel, module, [], 0

    def take(self, line, statement):
        """False after the last one."""
        if statement == "{":
            self.renamed.append(dict(self.renamed[-1]) if self.renamed else {})
            self.scopes += 1
        elif statement == "}":
            self.renamed.pop()
        elif statement.endswith(":"):
            self.kernel.body.append(Label(line, statement[:-1]))
        elif statement.startswith(".reg "):
            self.declare_registers(statement, line)
        elif statement.startswith("."):
            self.declare_memory(statement, line)
        else:
            instruction = parse_instruction(statement, line)
            names = self.renamed[-1]  # of the scopes around
            instruction.operands = [re.sub(r"[%$\w]+", lambda m: names.get(m[0], m[0]), o) for o in instruction.operands]
            instruction.guard = names.get(instruction.guard, instruction.guard)
            self.kernel.body.append(instruction)
        return bool(self.renamed)

    def declare_registers(self, statement, line):
        found = re.match(r"\.reg \.(\w+) (.*)$", statement)
        for name in split_operands(found[2]):
            family = re.fullmatch(r"%(\w+)<(\d+)>", name)
            if family and len(self.renamed) == 1:
                self.kernel.registers[family[1]] = (found[1], int(family[2]))
            elif not family:
                own = f"%scope{self.scopes}_{name.strip('%')}_"
                self.renamed[-1][name] = own + "0"
                self.kernel.registers[own[1:]] = (found[1], 1)
            else:
                raise PtxError(f"line {line}: a family of registers in an inner scope")

    def declare_memory(self, statement, line):
        variable = parse_variable(statement, line)
        if variable is None or variable.space not in ("shared", "local"):
            raise PtxError(f"line {line}: '{statement[:60]}' is not understood")
        place(variable, self.kernel.bytes_of(variable.space))
        self.kernel.variables[variable.name] = variable

    def finish(self):
        """Shared memory of the module that the kernel names; that of a size chosen at the launch comes last."""
        named = {word for item in self.kernel.body if isinstance(item, Instruction)
                 for operand in item.operands for word in re.findall(r"[\w$]+", operand)}
        used = [v for v in self.module.variables.values() if v.space == "shared" and v.name in named]
        for variable in sorted(used, key=lambda v: v.is_extern):
            own = Variable(variable.name, "shared", variable.align, variable.size)
            place(own, self.kernel.bytes_of("shared"))
            self.kernel.variables[own.name] = own


def parse(text, file):
    module, reader = Module(file), None
    for line, statement in statements(text):
        if reader:
            if not reader.take(line, statement):
                reader.finish()
                reader = None
        elif ".entry" in statement or ".func" in statement:
            module.kernels.append(parse_header(statement, line))
            reader = KernelReader(module.kernels[-1], module)
        else:
            variable = parse_variable(statement, line)
            if variable is None:
                raise PtxError(f"line {line}: '{statement[:60]}' is not understood")
            module.variables[variable.name] = variable
    return module
