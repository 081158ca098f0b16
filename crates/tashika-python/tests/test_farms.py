"""The scripts of the book's chapter on farms: submission to PBS, a run on this machine, and the
Kubernetes jobs, by their schema and by their own commands."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tashika

FARM = Path(__file__).parents[3] / "docs/book/src/farm"
SIZE = (40, 30)


def pbs(*words: str, folder: Path) -> str:
    line = [sys.executable, str(FARM / "pbs.py"), "builtin:tiny", "image.exr", "--size", *map(str, SIZE), *words]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_pbs_is_asked_for_what_was_said(tmp_path: Path) -> None:
    pytest.importorskip("dask_jobqueue")
    words = ["--cores", "12", "--memory", "24GB", "--queue", "render", "--walltime", "01:30:00", "--print-job"]
    job = pbs(*words, folder=tmp_path)
    said = [line.removeprefix("#PBS ") for line in job.splitlines() if line.startswith("#PBS ")]
    assert "-q render" in said and "-l walltime=01:30:00" in said, job
    assert any(line.startswith("-l select=1:ncpus=12:mem=2") for line in said), job
    started = next(line for line in job.splitlines() if "dask_worker" in line or "dask worker" in line)
    assert "--nthreads 12" in started and "--memory-limit" in started, started
    assert not (tmp_path / "image.exr").exists(), "nothing was rendered"


def test_the_same_script_renders_on_this_machine(tmp_path: Path, tiny: tashika.Scene) -> None:
    pytest.importorskip("distributed")
    pbs("--local", "2", "--error", "0.5", folder=tmp_path)
    image, whole = tashika.read(tmp_path / "image.exr"), tashika.render(tiny, size=SIZE, error=0.5)
    for name in whole:
        assert np.array_equal(image[name].view(np.uint32), whole[name].view(np.uint32)), name


def jobs() -> list[dict]:
    yaml = pytest.importorskip("yaml")
    return list(yaml.safe_load_all((FARM / "kubernetes.yaml").read_text(encoding="utf-8")))


def test_kubernetes_takes_the_jobs() -> None:
    validate = pytest.importorskip("kubernetes_validate")
    for job in jobs():
        validate.validate(job, validate.latest_version(), strict=True)
    shares, merge = (job["spec"] for job in jobs())
    assert shares["completionMode"] == "Indexed" and shares["parallelism"] == shares["completions"]
    for spec in (shares, merge):
        env = {entry["name"]: entry["value"] for entry in container(spec)["env"]}
        assert int(env["SHARES"]) == shares["completions"], "both jobs know how many shares there are"


def container(spec: dict) -> dict:
    (only,) = spec["template"]["spec"]["containers"]
    return only


def test_the_commands_of_the_jobs_make_the_image(tmp_path: Path, program: Path) -> None:
    shares, merge = (job["spec"] for job in jobs())
    known = tmp_path / "bin"
    known.mkdir()
    (known / "tashika").symlink_to(program)
    options = f"--size {SIZE[0]}x{SIZE[1]} --truth vpl --vpls 200 --gather 2 --error 5%"

    def run(spec: dict, **env: str) -> None:
        said = {entry["name"]: entry["value"] for entry in container(spec)["env"]}
        said |= {"FOLDER": str(tmp_path), "PATH": f"{known}:{os.environ['PATH']}", **env}
        line = [*container(spec)["command"], *container(spec)["args"]]
        done = subprocess.run(line, env=said, cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr

    for index in range(shares["completions"]):
        run(shares, SCENE="builtin:tiny", OPTIONS=options, JOB_COMPLETION_INDEX=str(index))
    run(merge)
    line = [program, "render", "builtin:tiny", *options.split(), "-q", "-o", "whole.exr"]
    subprocess.run(line, cwd=tmp_path, timeout=300)
    assert (tmp_path / "kitchen.exr").read_bytes() == (tmp_path / "whole.exr").read_bytes()
