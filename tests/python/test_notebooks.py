"""The notebooks run, cell by cell, as one reads them."""

import json

import pytest
from conftest import ROOT

FOLDER = ROOT / "docs" / "notebooks"


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.ipynb")))
def test_notebook(name, monkeypatch):
    for package in ("matplotlib", "pandas"):
        pytest.importorskip(package)
    import matplotlib.pyplot as plt

    monkeypatch.chdir(FOLDER)
    cells = json.loads((FOLDER / f"{name}.ipynb").read_text())["cells"]
    names = {}
    ran = 0
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        assert cell["outputs"] == [] and cell["execution_count"] is None, "notebooks are kept without results"
        exec(compile("".join(cell["source"]), f"{name}.ipynb, cell {ran}", "exec"), names)
        ran += 1
    assert ran > 0 and plt.get_fignums()  # each has a picture
    plt.close("all")
