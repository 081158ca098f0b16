"""Fixtures of the tests: the small scene, and the program to compare with."""

import os
import shutil
from pathlib import Path

import pytest

import tashika

#: Few pixels, so that a render takes a fraction of a second; too many lights for their sum to be
#: computed whole.
SUM = {"size": (16, 12), "vpls": 5000, "truth": "vpl"}


@pytest.fixture(scope="session")
def tiny() -> tashika.Scene:
    """The small built-in scene."""
    return tashika.builtin("tiny")


@pytest.fixture(scope="session")
def image(tiny: tashika.Scene) -> tashika.Image:
    """A small image of that scene."""
    return tashika.render(tiny, **SUM)


@pytest.fixture(scope="session")
def program() -> Path:
    """The program `tashika` that the environment variable TASHIKA names, or the installed one."""
    found = os.environ.get("TASHIKA") or shutil.which("tashika")
    if not found:
        pytest.skip("set TASHIKA to the program to compare with")
    return Path(found).resolve()
