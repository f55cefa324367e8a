"""`parloc tune`: settings for a robot from its recorded drives."""

from __future__ import annotations

import argparse
import shlex
import sys
from typing import Any

from .. import _parloc
from ..errors import Error, UsageError
from .drives import DriveFiles
from .results import write_results
from .space_file import read_space
from .tuner import doubt, summary, tune

_EPILOG = """A drive: --log, then its --map and --truth; several follow each other. Without a
truth the log is mapped first. The first part of each log is fitted to, the rest
judges. Run again, it goes on. docs/tune.md"""


class _OfDrive(argparse.Action):
    """--log begins a drive; --map and --truth belong to the last one."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        drives = namespace.drives
        if self.dest == "log":
            drives.append({"log": values})
        elif not drives:
            parser.error(f"{option_string}: expected --log before it")
        elif self.dest in drives[-1]:
            parser.error(f"{option_string}: {drives[-1]['log']} has one already")
        else:
            drives[-1][self.dest] = values


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        raise UsageError(f"{message} (see parloc tune --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="parloc tune",
        description="Settings for my robot from its recorded drives: are they better?",
        epilog=_EPILOG,
        formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(prog, max_help_position=26, width=80),
        usage="parloc tune --log LOG [--map M.yaml --truth T.tum] ... --out DIR",
        allow_abbrev=False,
    )
    parser.set_defaults(drives=[])
    parser.add_argument("--log", action=_OfDrive, metavar="LOG", help="A recorded drive, any format")
    parser.add_argument("--map", action=_OfDrive, metavar="M.yaml", help="Map to localize on (its own, made by slam)")
    parser.add_argument("--truth", action=_OfDrive, metavar="T.tum", help="True path in the map (slam's)")
    parser.add_argument("--config", metavar="C.yaml", help="Settings that are not tuned, and the old ones")
    parser.add_argument("--settings", metavar="S.yaml", help="What is tuned (noise of wheels and LiDAR)")
    parser.add_argument("--trials", type=int, default=100, metavar="N", help="How many sets of settings to try (100)")
    parser.add_argument("--jobs", type=int, default=0, metavar="K", help="Processes (all cores)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="Of the search (1)")
    parser.add_argument("--out", metavar="DIR", help="Journal, tune.json, report.html, tuned.yaml")
    parser.add_argument("--quiet", action="store_true", help="No progress and no verdict")
    return parser


def _progress(what: str, share: float) -> None:
    if sys.stderr.isatty():
        print(f"\r{what} {100 * share:3.0f} %\033[K", end="", file=sys.stderr, flush=True)


def _run(words: list[str]) -> None:
    args = _parser().parse_args(words)
    if not args.drives:
        raise UsageError("expected --log (see parloc tune --help)")
    if args.out is None:
        raise UsageError("expected --out (see parloc tune --help)")
    config = _parloc.read_config(args.config) if args.config else None
    tuning = tune(
        [DriveFiles(**drive) for drive in args.drives],
        args.out,
        settings=read_space(args.settings, config) if args.settings else None,
        config=config,
        trials=args.trials,
        jobs=args.jobs,
        seed=args.seed,
        progress=None if args.quiet else _progress,
    )
    files = write_results(tuning, shlex.join(["parloc", "tune", *words]))
    if not args.quiet:
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr)
        print(summary(tuning))
        if doubt(tuning):
            print(f"warning: {doubt(tuning)}", file=sys.stderr)
        print(*files, sep="\n", file=sys.stderr)


def main(words: list[str]) -> int:
    """Runs the command and returns its exit code (docs/exit_codes.md)."""
    try:
        _run(words)
    except KeyboardInterrupt:
        print("\nparloc: interrupted; the same command goes on from here", file=sys.stderr)
        return 130
    except Error as error:
        print(f"parloc: {error}", file=sys.stderr)
        return error.exit_code
    except ModuleNotFoundError as missing:
        print(f"parloc: tune needs {missing.name}: pip install 'parloc[tune]'", file=sys.stderr)
        return 6
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
