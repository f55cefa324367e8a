"""How every study measures: the programs that it runs, several runs at a time, and its command line. Needs Python 3.10."""

import argparse
import concurrent.futures
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
OUT = ROOT / "docs" / "results"
DATA = pathlib.Path(os.environ.get("PARLOC_DATA", ROOT.parent / "shared" / "data"))


class Failure(Exception):
    """Ends the measurement with one line and an exit code."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


# ---- Running programs --------------------------------------------------------------------------------------------------


class Program:
    """Runs a program; stop() ends all runs in progress and refuses new ones."""

    def __init__(self, path, timeout_s=None):
        self.path, self.timeout_s = pathlib.Path(path), timeout_s
        self.lock, self.running, self.stopped = threading.Lock(), set(), False
        if not os.access(self.path, os.X_OK) or self.path.is_dir():
            raise Failure(2, f"{self.path}: expected the parloc program; build it (cmake --preset cpu && cmake --build "
                             "--preset cpu) or give --parloc")

    def __call__(self, *arguments, environment=None):
        command = [str(self.path), *map(str, arguments)]
        with self.lock:
            if self.stopped:
                raise Failure(130, "interrupted")
            # Its own session: Ctrl-C at the terminal reaches this script only, which then ends the runs itself.
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                       text=True, errors="replace", cwd=ROOT, env={**os.environ, **(environment or {})},
                                       start_new_session=True)
            self.running.add(process)
        try:
            out, err = process.communicate(timeout=self.timeout_s)
        except subprocess.TimeoutExpired:
            raise Failure(3, f"{self.path} took longer than {self.timeout_s} s") from None
        finally:
            process.kill()  # nothing happens to one that has ended
            with self.lock:
                self.running.discard(process)
        if process.returncode != 0:
            message = re.search(r"^\s*Message:\s*(.+)", out + err, re.MULTILINE)  # how MRPT words it
            last = message[1] if message else (err.strip().splitlines() or ["no message"])[-1]
            raise Failure(130 if self.stopped else 3, f"exit code {process.returncode} of {' '.join(command)}: {last}")
        return out

    def stop(self):
        with self.lock:
            self.stopped = True
            for process in self.running:
                process.kill()


class Bench:
    """What a study works with: its options, the program, and a folder for what is of no use afterwards."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.program = Program(args.parloc)
        args.out.mkdir(parents=True, exist_ok=True)
        if not os.access(args.out, os.W_OK):
            raise Failure(2, f"{args.out}: expected a folder that can be written")

    def measure(self, run, keys, text_of, *programs):
        """run(bench, *key) of all keys {key: result} in their order, --jobs at a time, and how it ended: None or a Failure."""
        results, end, keys = {}, None, dict.fromkeys(keys)
        pool = concurrent.futures.ThreadPoolExecutor(getattr(self.args, "jobs", 1))
        try:
            futures = {pool.submit(run, self, *key): key for key in keys}
            for future in concurrent.futures.as_completed(futures):
                key = futures[future]
                results[key] = future.result()
                print(f"[{len(results):3}/{len(keys)}] {text_of(key, results[key])}", file=sys.stderr, flush=True)
        except (KeyboardInterrupt, Failure) as stop:
            end = stop if isinstance(stop, Failure) else Failure(130, "interrupted")
            for program in (self.program, *programs):
                program.stop()
        pool.shutdown(cancel_futures=True)
        return {key: results[key] for key in keys if key in results}, end


# ---- Command line ------------------------------------------------------------------------------------------------------


def positive(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return int(text)


def option(flag, default, text, **keywords):
    """For a study's command line; `text` ends with the default if that can be shown."""
    shown = f" ({default})" if isinstance(default, (str, int, float)) and default else ""
    return flag, {"default": default, "help": text + shown, **keywords}


def count(flag, default, text, **keywords):
    return option(flag, default, text, type=positive, metavar="N", **keywords)


def path(flag, default, text, metavar="DIR"):
    return option(flag, default, text, type=pathlib.Path, metavar=metavar)


def subset(flag, names, text, metavar):
    """Some of the names; all by default."""
    return option(flag, list(names), f"{text}: of {', '.join(names)} (all)", nargs="+", choices=list(names), metavar=metavar)


JOBS = count("--jobs", 1, "runs at a time")
LOGS_FOLDER = path("--data", DATA, "folder of the recorded logs (PARLOC_DATA, else ../shared/data)")
COMMON = (path("--out", OUT, "folder for the results (docs/results)"),
          path("--parloc", ROOT / "build/cpu/parloc", "the program (build/cpu/parloc)", "FILE"))


ENDS = """Exit code: 0 all is well and every bar kept, 1 a bar missed, 2 wrong usage or a missing or broken file, 3 a run of a
program failed, 130 interrupted: what is finished is kept, where a page can be made of it as NAME.partial.*, beside an earlier
page."""


def parse(description, commands, arguments=None):
    parser = argparse.ArgumentParser(description=description, epilog=ENDS, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = "|".join(run.__name__ for run in commands)
    choices = parser.add_subparsers(required=True, metavar=names) if len(commands) > 1 else None
    for run, options in commands.items():
        command = choices.add_parser(run.__name__, help=run.__doc__, description=run.__doc__) if choices else parser
        command.set_defaults(run=run)
        for flag, keywords in options:
            command.add_argument(flag, **keywords)
    args = parser.parse_args(arguments)
    for name, value in vars(args).items():  # programs run in the repository's folder
        if isinstance(value, pathlib.Path):
            setattr(args, name, value.absolute())
    return args


def reported(work):
    """What work() returns, with one line and an exit code for what goes wrong."""
    name = pathlib.Path(sys.argv[0]).name
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return work()
    except Failure as failure:
        print(f"{name}: {failure}", file=sys.stderr)
        return failure.code
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2


def study(description, commands, check=None):
    """The exit code of a study: commands {run: its options}, of which the command line names one if there are several.
    check(args) refuses what does not fit together, run(bench) measures, writes, and says the code."""
    def work():
        args = parse(description, {run: (*options, *COMMON) for run, options in commands.items()})
        if check:
            check(args)
        with tempfile.TemporaryDirectory(prefix="parloc_") as folder:
            return args.run(Bench(args, pathlib.Path(folder)))
    return reported(work)
