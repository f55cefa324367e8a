"""The stubs come with the package, and are Python. What they leave without a word, tools/reference/build finds."""

from pathlib import Path

import parloc


def test_stubs_are_shipped():
    declared = (Path(parloc.__file__).parent / "_parloc.pyi").read_text()
    assert "class Localizer:" in declared and "def sigma_hit(self) -> float:" in declared
    assert (Path(parloc.__file__).parent / "py.typed").exists()
    compile(declared, "_parloc.pyi", "exec")
