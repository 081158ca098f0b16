"""The package renders the same planes, bit for bit, as the program `tashika` with the same
options."""

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tashika


def run(program: Path, *typed: object) -> None:
    """Runs the program, quietly; exit code 4, for pixels out of budget, is accepted."""
    done = subprocess.run([str(program), *map(str, typed), "--quiet"], capture_output=True, text=True)
    assert done.returncode in (0, 4), done.stderr


def assert_same(ours: tashika.Image, theirs: tashika.Image) -> None:
    assert ours.metadata == theirs.metadata
    assert (ours.size, ours.window, ours.complete) == (theirs.size, theirs.window, theirs.complete)
    assert sorted(ours) == sorted(theirs)
    for name in ours:
        assert ours[name].dtype == theirs[name].dtype, name
        assert np.array_equal(ours[name], theirs[name], equal_nan=True), name


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("--truth vpl", {"truth": "vpl"}),
        ("--crop 3,2,9,7 --error 5% --confidence 80% --claim certified", {
            "crop": (3, 2, 9, 7), "error": 0.05, "confidence": 0.8, "claim": "certified",
        }),
        ("--truth vpl --control channels --absolute 0.01 --gather 2 --seed 7 --clamp 0.1 --tiles 2/3", {
            "truth": "vpl", "control": "channels", "absolute": 0.01, "gather": 2, "seed": 7, "clamp": 0.1, "tiles": (2, 3),
        }),
        ("--method exact --filter blackman-harris", {"method": "exact", "filter": "blackman-harris"}),
        ("--method path --paths 2 --projection fisheye --fov 200", {
            "method": "path", "paths": 2, "projection": "fisheye", "fov": 200,
        }),
        ("--method path --paths 2 --lens-radius 0.1 --focus-distance 1.5 --blades 5 --blade-rotation 20", {
            "method": "path", "paths": 2, "lens_radius": 0.1, "focus_distance": 1.5, "blades": 5, "blade_rotation": 20,
        }),
        ("--method mdlc --max-pairs 50", {"method": "mdlc", "max_pairs": 50}),
        ("--method iwasaki2019 --clamp off", {"method": "iwasaki2019", "clamp": "off"}),
    ],
)  # fmt: skip
def test_sums_over_lights(program: Path, tmp_path: Path, typed: str, said: dict[str, Any]) -> None:
    file = tmp_path / "theirs.exr"
    # Paths find emitters by themselves.
    vpls = {} if said.get("method") == "path" else {"vpls": 300}
    options = [*typed.split(), "--size", "16x12", *(word for name, n in vpls.items() for word in (f"--{name}", n))]
    run(program, "render", "builtin:tiny", "-o", file, *options)
    ours = tashika.render(tashika.builtin("tiny"), size=(16, 12), **vpls, **said)
    assert_same(ours, tashika.read(file))


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("--size 8x6 --passes 2", {"size": (8, 6), "passes": 2}),
        ("--method path --size 8x6 --filter tent", {"method": "path", "size": (8, 6), "filter": "tent"}),
        ("--method path --size 4x3 --error 20% --paths 512", {
            "method": "path", "size": (4, 3), "error": 0.2, "paths": 512,
        }),
        ("--truth transport --size 2x2 --error 50% --vpls 5k", {
            "truth": "transport", "size": (2, 2), "error": 0.5, "vpls": 5000,
        }),
    ],
)  # fmt: skip
def test_defaults(program: Path, tmp_path: Path, typed: str, said: dict[str, Any]) -> None:
    file = tmp_path / "theirs.exr"
    run(program, "render", "builtin:tiny", "-o", file, *typed.split())
    assert_same(tashika.render(tashika.builtin("tiny"), **said), tashika.read(file))


def test_lights_and_rows(program: Path, tmp_path: Path) -> None:
    file, rows = tmp_path / "lights.vpl", tmp_path / "rows.json"
    run(program, "vpl", "builtin:tiny", "--vpls", 300, "-o", file)
    lights = tashika.vpls(tashika.builtin("tiny"), count=300)
    again = tmp_path / "again.vpl"
    lights.save(again)
    assert again.read_bytes() == file.read_bytes()

    options = ["--size", "16x12", "--vpl-file", file, "--methods", "mdlc,tashika", "--error", "2%,5%"]
    options += ["--confidence", "80%,95%", "--pixels", 20, "--seeds", 2, "--by", "brightness"]
    run(program, "coverage", "builtin:tiny", *options, "--json", rows)
    ours = tashika.coverage(
        tashika.builtin("tiny"), size=(16, 12), vpls=tashika.VplSet.load(file), methods=["mdlc", "tashika"],
        errors=[0.02, 0.05], confidences=[0.8, 0.95], pixels=20, seeds=2, by=["brightness"],
    )  # fmt: skip
    theirs = json.loads(rows.read_text())
    for row in ours + theirs:
        del row["seconds"]
    assert ours == theirs


def test_comparisons(program: Path, tmp_path: Path) -> None:
    files = [tmp_path / "ours.exr", tmp_path / "exact.exr"]
    for file, method in zip(files, ["lightcuts", "exact"]):
        tashika.render(tashika.builtin("tiny"), size=(16, 12), vpls=300, method=method).save(file)
    told = tmp_path / "told.json"
    run(program, "compare", *files, "--error", "1%", "--json", told)
    theirs = json.loads(told.read_text())
    ours = tashika.compare(*map(tashika.read, files), error=0.01)
    for name in set(theirs) - {"image", "reference", "files", "worst_at"}:
        assert getattr(ours, name) == theirs[name], name
    assert list(ours.worst_at) == theirs["worst_at"]


def test_the_version_is_that_of_the_program(program: Path) -> None:
    told = subprocess.run([str(program), "--version"], capture_output=True, text=True, check=True).stdout
    assert told.split() == ["tashika", tashika.__version__]
