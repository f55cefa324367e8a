"""The command line `parloc sweep`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

from ..errors import Error, UsageError
from .effects import Scores
from .run import SweepResult, sweep

INTERRUPTED = 130

HELP = """Trials over ranges of settings, on many machines; a table and a page of them.
Usage: parloc sweep S.yaml --out DIR [OPTIONS]

  S.yaml                  Scenarios or logs, filters, trials, ranges of settings
  --out DIR               For table.csv, report.html and all parts. The same
                          command again goes on with what is missing
  --engine E              Who computes: local, slurm, dask, tcp://HOST:PORT of
                          a Dask scheduler, or none: others, by DIR/part.sh
  --jobs K                Parts at once (all cores, or GPUs)
  --parts N               Into how many parts the trials of a point are divided
  --sbatch OPTION         For Slurm, as --sbatch=--partition=x; may come again
  --attempts N            Tries of a part that is killed before a new trial (3)
  --quiet                 No progress and no summary

S.yaml, say:  scenarios: configs/office_scenario.yaml
              trials: 100
              settings:
                particles: [500, 1000, 2000]
                sensor.sigma_hit: {from: 0.05, to: 0.4, steps: 4, scale: log}
docs/sweeps.md"""


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see parloc sweep --help)")


def parsed(words: Sequence[str]) -> argparse.Namespace:
    parser = Parser(prog="parloc sweep", add_help=False, allow_abbrev=False)
    parser.add_argument("plan", metavar="S.yaml")
    parser.add_argument("--out", required=True)
    parser.add_argument("--engine", default="local")
    parser.add_argument("--jobs", type=at_least_one)
    parser.add_argument("--parts", type=at_least_one)
    parser.add_argument("--sbatch", action="append", default=[])
    parser.add_argument("--attempts", type=at_least_one, default=3)
    parser.add_argument("--quiet", action="store_true")
    return parser.parse_args(words)


def at_least_one(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1_000_000:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1 to 1000000, got '{text}'")
    return int(text)


def summary(result: SweepResult) -> str:
    points = Scores(result.table).points()
    lines = [f"{len(result.table)} trials of {len({p.point for p in points})} points"]
    for p in points[:3]:
        settings = ", ".join(f"{name}={value}" for name, value in settings_of(result, p.point).items())
        error = f", error {p.error_m.mean:.4f} m" if p.error_m.count else ""
        lines.append(f"  point {p.point}{f' {p.filter}' if p.filter else ''} ({settings}): success {100 * p.success.mean:.1f} %"
                     f" ({100 * p.success.low:.1f} to {100 * p.success.high:.1f}){error}")
    return "\n".join([*lines, f"report            {result.page} (beside it: table.csv)"])


def settings_of(result: SweepResult, point: int) -> dict[str, object]:
    columns = result.table.columns
    names = list(columns)
    row = columns["point"].index(point)
    first = names.index("filter") + 1 if "filter" in names else names.index("source") + 1
    return {name: columns[name][row] for name in names[first : names.index("seed")]}


def complain(message: str) -> None:
    print("parloc: " + "".join(c if c.isprintable() else " " for c in message), file=sys.stderr)


def main(words: Sequence[str]) -> int:
    if "--help" in words or "-h" in words:
        print(HELP)
        return 0
    signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGINT))
    try:
        o = parsed(words)
        result = sweep(o.plan, out=o.out, engine=o.engine, jobs=o.jobs, parts=o.parts, attempts=o.attempts, options=o.sbatch,
                       progress=not o.quiet)
    except Error as error:
        complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        complain(f"interrupted; what is finished stays in {os.path.abspath(o.out)}, the same command goes on with the rest")
        return INTERRUPTED
    if not o.quiet and len(result.table):
        print(summary(result))
    if not o.quiet and o.engine == "none" and result.missing:
        print(f"{result.missing} runs are to be computed: sh {result.folder}/part.sh K for each line K of parts.txt there "
              "(docs/sweeps.md). Then the same command again.")
    if not result.failed:
        return 0
    more = f", and {len(result.failed) - 1} more" if len(result.failed) > 1 else ""
    complain(f"{result.missing} runs are incomplete: {result.failed[0]}{more}")
    code = result.failed[0].code
    return code if code and 0 < code < 7 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
