"""The Python code of the book: the blocks of its chapter, and the cells of its notebook, run in
order."""

import json
import re
import shutil
from pathlib import Path

import pytest

BOOK = Path(__file__).parents[3] / "docs/book/src"


def chapter():
    text = (BOOK / "python.md").read_text(encoding="utf-8")
    return re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def notebook():
    cells = json.loads((BOOK / "first.ipynb").read_text(encoding="utf-8"))["cells"]
    return [cell["source"] for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.parametrize("parts", [chapter, notebook])
def test_the_python_of_the_book_runs(parts, tmp_path, monkeypatch):
    shutil.copy(BOOK / "room.gltf", tmp_path)
    monkeypatch.chdir(tmp_path)
    names = {}
    blocks = parts()
    assert len(blocks) > 1
    for block in blocks:
        exec(compile(block, str(parts.__name__), "exec"), names)  # noqa: S102
    assert names["image"]["radiance"].shape[2] == 3
