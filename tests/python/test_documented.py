"""Every public name says what it is, and what is offered is what the stubs have."""

import inspect
from pathlib import Path

import parloc

# What a nanobind class has of every Python object, and what says nothing of its own.
UNSAID = {"__init__", "__doc__", "__module__", "__new__", "__getstate__", "__setstate__"}


def public_members():
    for name in parloc.__all__:
        if name == "__version__":
            continue
        thing = getattr(parloc, name)
        yield name, thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    yield f"{name}.{member}", value


def test_every_public_name_has_a_docstring():
    def says(thing):
        # A function of nanobind begins with its signature, one with several with a line that says so.
        lines = (inspect.getdoc(thing) or "").splitlines()
        return any(line and "->" not in line and line != "Overloaded function." for line in lines)

    assert [name for name, thing in public_members() if not says(thing) and not isinstance(thing, str | int)] == []


def test_every_setting_has_a_docstring():
    config = parloc.Config()
    for name in config.names():
        holder, _, key = name.rpartition(".")
        thing = type(getattr(config, holder) if holder else config)
        assert getattr(thing, key).__doc__, name


def test_stubs_are_shipped():
    declared = (Path(parloc.__file__).parent / "_parloc.pyi").read_text()
    assert "class Localizer:" in declared and "def sigma_hit(self) -> float:" in declared
    assert (Path(parloc.__file__).parent / "py.typed").exists()
    compile(declared, "_parloc.pyi", "exec")
