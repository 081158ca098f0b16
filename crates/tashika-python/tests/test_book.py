"""The Python code of the book: the blocks of its chapter, and the cells of its notebooks, run in
order."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

BOOK = Path(__file__).parents[3] / "docs/book/src"


def chapter():
    text = (BOOK / "python.md").read_text(encoding="utf-8")
    return re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def notebook(name):
    cells = json.loads((BOOK / name).read_text(encoding="utf-8"))["cells"]
    return [cell["source"] for cell in cells if cell["cell_type"] == "code"]


def run(blocks, folder, monkeypatch):
    """The names that the blocks define."""
    shutil.copy(BOOK / "room.gltf", folder)
    monkeypatch.chdir(folder)
    names = {}
    assert len(blocks) > 1
    for block in blocks:
        exec(compile(block, "book", "exec"), names)  # noqa: S102
    return names


@pytest.mark.parametrize("blocks", [chapter(), notebook("first.ipynb")], ids=["chapter", "notebook"])
def test_the_python_of_the_book_runs(blocks, tmp_path, monkeypatch):
    assert run(blocks, tmp_path, monkeypatch)["image"]["radiance"].shape[2] == 3


def test_the_notebook_of_illuminance_runs(tmp_path, monkeypatch):
    names = run(notebook("illuminance.ipynb"), tmp_path, monkeypatch)
    stored = np.load(tmp_path / "plane.npz")
    assert np.array_equal(stored["illuminance"], names["lux"]) and stored["position"].shape == (36, 3)
