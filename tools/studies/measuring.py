"""What the tools share that measure the program: running it, saying where, writing pages, and their command line."""

import argparse
import concurrent.futures
import datetime
import json
import os
import pathlib
import platform
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


# ---- Running the program -----------------------------------------------------------------------------------------------


class Program:
    """Runs parloc; stop() ends all runs in progress and refuses new ones."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.lock, self.running, self.stopped = threading.Lock(), set(), False
        if not os.access(self.path, os.X_OK) or self.path.is_dir():
            raise Failure(2, f"{self.path}: expected the parloc program; build it (cmake --preset cpu && cmake --build "
                             "--preset cpu) or give --parloc")

    def __call__(self, *arguments):
        command = [str(self.path), *map(str, arguments)]
        with self.lock:
            if self.stopped:
                raise Failure(130, "interrupted")
            # Its own session: Ctrl-C at the terminal reaches this script only, which then ends the runs itself.
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
                                       start_new_session=True)
            self.running.add(process)
        try:
            out, err = process.communicate()
        except BaseException:
            process.kill()
            raise
        finally:
            with self.lock:
                self.running.discard(process)
        if process.returncode != 0:
            last = (err.strip().splitlines() or ["no message"])[-1]
            raise Failure(130 if self.stopped else 3, f"exit code {process.returncode} of {' '.join(command)}: {last}")
        return out

    def stop(self):
        with self.lock:
            self.stopped = True
            for process in self.running:
                process.kill()


def measure(program, jobs, tasks, text_of):
    """The results of tasks [(key, function)] by key, `jobs` at a time, and how it ended: None or a Failure."""
    results, end = {}, None
    pool = concurrent.futures.ThreadPoolExecutor(jobs)
    try:
        futures = {pool.submit(function): key for key, function in tasks}
        for future in concurrent.futures.as_completed(futures):
            key = futures[future]
            results[key] = future.result()
            print(f"[{len(results):3}/{len(tasks)}] {text_of(key, results[key])}", file=sys.stderr, flush=True)
    except (KeyboardInterrupt, Failure) as stop:
        end = stop if isinstance(stop, Failure) else Failure(130, "interrupted")
        program.stop()
    pool.shutdown(cancel_futures=True)
    return {key: results[key] for key, _ in tasks if key in results}, end


# ---- Where and how it was measured -------------------------------------------------------------------------------------


def git(*arguments):
    try:
        return subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def commit():
    """The commit of this tree; -dirty if a file that git knows differs from it."""
    short = git("rev-parse", "--short", "HEAD")
    if short is None:
        return "unknown (no git repository)"
    return short + ("-dirty" if git("--no-optional-locks", "status", "--porcelain", "--untracked-files=no") else "")


def cpu_model():
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", open("/proc/cpuinfo").read(), re.MULTILINE)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()


def operating_system():
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return platform.platform()


def compiler(build):
    """Compiler and build type from CMake's files in the program's folder, if it lies in its build folder."""
    try:
        rules = next(build.glob("CMakeFiles/*/CMakeCXXCompiler.cmake")).read_text()
        cache = (build / "CMakeCache.txt").read_text()
    except (StopIteration, OSError):
        return "unknown (the program does not lie in its build folder)"
    names = [re.search(pattern, text, re.MULTILINE) for pattern, text in (
        (r'^set\(CMAKE_CXX_COMPILER_ID "(.*)"\)', rules), (r'^set\(CMAKE_CXX_COMPILER_VERSION "(.*)"\)', rules),
        (r"^CMAKE_BUILD_TYPE:\w+=(.*)$", cache))]
    return " ".join(name[1] for name in names if name)


def circumstances(program):
    return {
        "command": " ".join([f"tools/{pathlib.Path(sys.argv[0]).name}", *sys.argv[1:]]),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "commit": commit(),
        "program": program("--version").strip(),
        "compiler": compiler(program.path.resolve().parent),
        "machine": f"{cpu_model()}, {os.cpu_count()} cores",
        "system": operating_system(),
    }


# ---- Pages -------------------------------------------------------------------------------------------------------------


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def circumstances_text(record):
    rows = [(key, f"`{record[key]}`" if key == "command" else record[key])
            for key in ("command", "date", "commit", "program", "compiler", "machine", "system", "backend")]
    return "## Where and when\n\n" + table(("", ""), rows)


def first_lines(title, record):
    """Title, a warning if partial, and how many runs kept their bars."""
    judged = [run for run in record["runs"] if "within_bars" in run]
    good = sum(run["within_bars"] for run in judged)
    text = f"# {title}\n"
    if record["partial"]:
        text += (f"\n**Partial: ended after {len(record['runs'])} of {record['runs_planned']} runs "
                 f"({record['ended_by']}).**\n")
    if not judged:
        return text
    which = "runs" if len(judged) == len(record["runs"]) else "runs on logs that have bars"
    return text + (f"\nAll {good}" if good == len(judged) else f"\n**{good} of {len(judged)}**") + f" {which} are within all bars.\n"


def json_text(record):
    """The record with one line per run."""
    head = json.dumps({key: value for key, value in record.items() if key != "runs"}, indent=1)
    runs = ",\n  ".join(map(json.dumps, record["runs"]))
    return f'{head[:-2]},\n "runs": [\n  {runs}\n ]\n}}\n'


def write_results(folder, name, record, text):
    """NAME.md and NAME.json; a partial result gets its own name so that it replaces no complete one."""
    stem = name + (".partial" if record["partial"] else "")
    for suffix, content in ((".json", json_text(record)), (".md", text.rstrip() + "\n")):
        path = folder / (stem + suffix)
        draft = path.with_name(path.name + ".tmp")
        draft.write_text(content)
        draft.replace(path)
        print(path, file=sys.stderr)


def within(values, bars):
    return all(values[key] <= bar for key, bar in bars.items())


def finish(args, name, program_record, planned, results, end, page):
    """Writes what there is, and gives the exit code."""
    runs = list(results.values())
    if not runs:
        raise end
    backends, configs = {run.pop("backend") for run in runs}, [run.pop("config") for run in runs]
    record = {"partial": end is not None, "ended_by": str(end) if end else None, "runs_planned": planned,
              **program_record, "backend": ", ".join(sorted(backends)),
              "config": {key: value for key, value in configs[0].items() if key != "seed"}, "runs": runs}
    write_results(args.out, name, record, page(record))
    if end:
        raise end
    return 0 if all(run.get("within_bars", True) for run in runs) else 1


# ---- Command line ------------------------------------------------------------------------------------------------------


def positive(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got '{text}'")
    return int(text)


def add_arguments(parser, jobs="runs at a time", all_cores=False):
    """--jobs, --out and --parloc, which every tool has that runs parloc."""
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() if all_cores else 1, metavar="K",
                        help=f"{jobs} ({'all cores' if all_cores else 1})")
    parser.add_argument("--out", type=pathlib.Path, default=OUT, metavar="DIR", help="folder for the results (docs/results)")
    parser.add_argument("--parloc", type=pathlib.Path, default=ROOT / "build/cpu/parloc", metavar="FILE",
                        help="the program (build/cpu/parloc)")


def parse(parser):
    """With absolute paths: programs run in the repository's folder."""
    args = parser.parse_args()
    for name, value in vars(args).items():
        if isinstance(value, pathlib.Path):
            setattr(args, name, value.absolute())
    return args


def interrupt(*_):
    raise KeyboardInterrupt


def reported(name, work):
    """work(), with one line and an exit code for what goes wrong; the same for every tool."""
    signal.signal(signal.SIGTERM, interrupt)
    try:
        return work()
    except Failure as failure:
        print(f"{name}.py: {failure}", file=sys.stderr)
        return failure.code
    except KeyboardInterrupt:
        print(f"{name}.py: interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"{name}.py: {error}", file=sys.stderr)
        return 2


def program_and_folder(args):
    """The program, once it is known that its results can be written."""
    program = Program(args.parloc)
    args.out.mkdir(parents=True, exist_ok=True)
    if not os.access(args.out, os.W_OK):
        raise Failure(2, f"{args.out}: expected a folder that can be written")
    return program


def run_tool(name, args, run):
    """run(args, program, work folder)."""
    def work():
        program = program_and_folder(args)
        with tempfile.TemporaryDirectory(prefix=f"parloc_{name}_") as folder:
            return run(args, program, pathlib.Path(folder))
    return reported(name, work)
