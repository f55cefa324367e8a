"""`pip install .` gives the package and the program, and the first example of docs/python.md runs with them.

Usage: install_check.py FOLDER [-DOPTION=VALUE...]: built and installed there, anew.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def first_example():
    return re.search(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.S).group(1)


def main():
    folder = Path(sys.argv[1]).resolve()
    tree = folder / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    options = [f"--config-settings=cmake.define.{option.removeprefix('-D')}" for option in sys.argv[2:]]
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--root-user-action=ignore",
         "--no-deps", "--no-build-isolation", f"--target={tree}", f"--config-settings=build-dir={folder / 'build'}",
         *options, str(ROOT)],
        check=True,
    )
    # Nothing of the sources but the maps: the package is the installed one.
    environment = os.environ | {"PYTHONPATH": f"{tree}:{os.environ.get('PYTHONPATH', '')}", "MPLBACKEND": "Agg"}
    where = subprocess.run([sys.executable, "-c", "import parloc; print(parloc.__file__, parloc.__version__)"], cwd=ROOT,
                           env=environment, check=True, capture_output=True, text=True).stdout.split()
    assert where[0].startswith(str(tree)), where
    said = subprocess.run([tree / "bin" / "parloc", "--version"], check=True, capture_output=True, text=True).stdout
    assert said.split() == ["parloc", where[1]], (said, where)
    print(subprocess.run([sys.executable, "-c", first_example()], cwd=ROOT, env=environment, check=True,
                         capture_output=True, text=True).stdout)
    for shipped in ("py.typed", "_parloc.pyi", "errors.py", "sweeps/engines/slurm.py"):
        assert (tree / "parloc" / shipped).exists(), shipped


if __name__ == "__main__":
    main()
