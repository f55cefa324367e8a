"""YAML whose every value knows its line, so that what is wrong can be named where it stands. Needs PyYAML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import BackendError, ConfigError, InputError


@dataclass(frozen=True)
class Node:
    """A scalar (number, bool, text or None), a list of nodes, or a group: {key: node}."""

    value: Any
    file: str
    line: int
    key_line: int = 0  # of the key that stands before it

    def wrong(self, expected: str) -> ConfigError:
        """What to raise if this is not what was expected."""
        return ConfigError(f"{self.file}:{self.line}: {expected}, got {said(self)}")

    def texts(self, expected: str) -> list[str]:
        """A list of texts; one text stands for a list of one."""
        nodes = self.value if isinstance(self.value, list) else [self]
        if not nodes or not all(isinstance(node.value, str) for node in nodes):
            raise self.wrong(expected)
        return [node.value for node in nodes]

    def whole(self, name: str, low: int, high: int) -> int:
        """A whole number within limits."""
        if not isinstance(self.value, int) or isinstance(self.value, bool) or not low <= self.value <= high:
            raise self.wrong(f"{name}: expected a whole number from {low} to {high}")
        return self.value

    def group(self, name: str, keys: Sequence[str], needed: Sequence[str] = ()) -> dict[str, Node]:
        """A group with no other keys than these."""
        if not isinstance(self.value, dict):
            raise self.wrong(f"{name}: expected a group of {', '.join(keys)}")
        for key, node in self.value.items():
            if key not in keys:
                raise unknown_key(node, key, keys)
        for key in needed:
            if key not in self.value:
                raise ConfigError(f"{self.file}:{self.line}: {name}: expected the key '{key}' as well")
        return self.value


def unknown_key(node: Node, key: str, keys: Sequence[str]) -> ConfigError:
    """As parloc's own reader says it; `node` is what the key stands before."""
    nearest = min(keys, key=lambda known: edit_distance(key[:100], known))
    return ConfigError(f"{node.file}:{node.key_line}: unknown key '{key}'; the nearest valid key is '{nearest}'")


def edit_distance(a: str, b: str) -> int:
    """Levenshtein's: insertions, deletions and replacements of one character."""
    row = list(range(len(b) + 1))
    for i, c in enumerate(a):
        diagonal, row[0] = row[0], i + 1
        for j, d in enumerate(b):
            diagonal, row[j + 1] = row[j + 1], min(diagonal + (c != d), row[j] + 1, row[j + 1] + 1)
    return row[-1]


def said(node: Node) -> str:
    """A value as it is named in an error."""
    if isinstance(node.value, dict):
        return "a group"
    if isinstance(node.value, list):
        return f"a list of {len(node.value)}"
    return "nothing" if node.value is None else str(node.value)


def read_yaml(path: str | Path) -> Node:
    """Raises InputError for a file that cannot be read, ConfigError for one that is no YAML."""
    try:
        import yaml
    except ImportError:
        raise BackendError("a YAML file is read with PyYAML: expected that package (pip install 'parloc[sweep]')") from None
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = mark.line + 1 if mark else 1
        raise ConfigError(f"{path}:{line}: expected YAML: {getattr(error, 'problem', error)}") from None
    return node_of(root, str(path), 0) if root else Node({}, str(path), 1)


def node_of(node: Any, file: str, key_line: int) -> Node:
    """PyYAML's node with its values as parloc reads them."""
    line = node.start_mark.line + 1
    if node.id == "scalar":
        return Node(node.value if node.style else plain_value(node.value), file, line, key_line)
    if node.id == "sequence":
        return Node([node_of(item, file, 0) for item in node.value], file, line, key_line)
    group: dict[str, Node] = {}
    for key, value in node.value:
        name = str(key.value)
        if name in group:
            raise ConfigError(f"{file}:{key.start_mark.line + 1}: the key '{name}' is there twice")
        group[name] = node_of(value, file, key.start_mark.line + 1)
    return Node(group, file, line, key_line)


def plain_value(text: str) -> Any:
    """What stands without quotes. YAML 1.1 would read 1e-4 as a text, and `on` as true."""
    words = {"": None, "~": None, "null": None, "true": True, "false": False}
    if text in words:
        return words[text]
    for number in (int, float):
        try:
            return number(text) if "_" not in text else text
        except ValueError:
            pass
    return text
