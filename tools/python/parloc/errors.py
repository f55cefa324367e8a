"""What parloc raises: one class per kind of error, each also the built-in exception that Python's users expect."""


class Error(Exception):
    """Every error that parloc raises by itself; its text is one line that says what was expected.

    `kind` is "internal", "usage", "input", "config", "output" or "backend"; `exit_code` is the one that the program
    `parloc` gives for it. This very class means a defect in parloc, or a device that failed.
    """

    kind = "internal"
    exit_code = 1


class UsageError(Error, ValueError):
    """A call makes no sense, such as a run without a start."""

    kind = "usage"
    exit_code = 2


class InputError(Error, ValueError):
    """A map, log, scan or trajectory cannot be read or makes no sense."""

    kind = "input"
    exit_code = 3


class ConfigError(Error, ValueError):
    """A setting is unknown or has an impossible value."""

    kind = "config"
    exit_code = 4


class OutputError(Error, OSError):
    """A result cannot be written."""

    kind = "output"
    exit_code = 5


class BackendError(Error, RuntimeError):
    """The backend asked for is not built, or has no device."""

    kind = "backend"
    exit_code = 6
