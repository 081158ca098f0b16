"""Renders that continue where they ended: the same bits, whatever ended them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import tashika

#: Some hundred tiles, a second or two of work.
RENDER = {"size": (160, 120), "vpls": 1500, "method": "exact", "gather": 4, "seed": 5}


@pytest.fixture(scope="module")
def whole(tiny: tashika.Scene) -> tashika.Image:
    return tashika.render(tiny, **RENDER)


def same(image: tashika.Image, whole: tashika.Image) -> bool:
    bits = [np.array_equal(image[name].view(np.uint32), whole[name].view(np.uint32)) for name in whole]
    return all(bits) and image.metadata == whole.metadata


class Enough(Exception):
    pass


def begin(scene: tashika.Scene, checkpoint: Path, **changed: object) -> None:
    """Renders a third of the image."""

    def progress(pixels: int, of: int, promise_met: int, rays: int) -> None:
        if pixels > of // 3:
            raise Enough

    with pytest.raises(Enough):
        tashika.render(scene, checkpoint=checkpoint, progress=progress, **{**RENDER, **changed})


def test_what_an_exception_ended_goes_on(tiny: tashika.Scene, whole: tashika.Image, tmp_path: Path) -> None:
    file = tmp_path / "a.checkpoint"
    begin(tiny, file)
    kept = file.stat().st_size
    told: list[int] = []
    image = tashika.render(tiny, checkpoint=file, progress=lambda pixels, *_: told.append(pixels), **RENDER)
    assert same(image, whole)
    assert told[0] > 160 * 120 // 3, "it went on"
    assert file.stat().st_size > kept, "it stays until the caller removes it"
    # Once more, from stored tiles alone.
    assert same(tashika.render(tiny, checkpoint=file, **RENDER), whole)


@pytest.mark.skipif(os.name != "posix", reason="signals to processes are of POSIX")
def test_what_was_killed_goes_on(tiny: tashika.Scene, whole: tashika.Image, tmp_path: Path) -> None:
    file = tmp_path / "a.checkpoint"
    program = f"import tashika; tashika.render(tashika.builtin('tiny'), checkpoint={str(file)!r}, **{RENDER!r})"
    child = subprocess.Popen([sys.executable, "-c", program])
    deadline = time.monotonic() + 60
    # The head is some hundred bytes, a tile some thousand.
    while (not file.exists() or file.stat().st_size < 100_000) and time.monotonic() < deadline:
        time.sleep(0.01)
    child.kill()
    assert child.wait() == -signal.SIGKILL, "it was killed in its work"
    told: list[int] = []
    image = tashika.render(tiny, checkpoint=file, progress=lambda pixels, *_: told.append(pixels), **RENDER)
    assert same(image, whole) and told[0] > 0


def test_damage_is_warned_of_and_rendered_again(
    tiny: tashika.Scene, whole: tashika.Image, tmp_path: Path
) -> None:
    file = tmp_path / "a.checkpoint"
    begin(tiny, file)
    bytes_of_file = bytearray(file.read_bytes())
    bytes_of_file[len(bytes_of_file) // 2] ^= 1
    file.write_bytes(bytes_of_file)
    with pytest.warns(UserWarning, match="a.checkpoint: it is damaged: its last .* bytes are not as"):
        image = tashika.render(tiny, checkpoint=file, **RENDER)
    assert same(image, whole)


def test_of_another_render_is_refused(tiny: tashika.Scene, tmp_path: Path) -> None:
    file = tmp_path / "a.checkpoint"
    begin(tiny, file)
    with pytest.raises(tashika.InputError, match='seed = "5", not "6"'):
        tashika.render(tiny, checkpoint=file, **{**RENDER, "seed": 6})
    with pytest.raises(tashika.FileError, match="absent"):
        tashika.render(tiny, checkpoint=tmp_path / "absent" / "a.checkpoint", **RENDER)


def test_scenes_of_arrays_are_told_by_their_numbers(tmp_path: Path) -> None:
    def scene(height: float) -> tashika.Scene:
        corners = np.array([[-1, 0, -1], [-1, 0, 1], [1, height, 1]])
        mesh = tashika.Mesh(corners, [[0, 1, 2]], material=tashika.Material.diffuse(0.5))
        return tashika.Scene.build([mesh], camera=tashika.Camera((0, 3, 0.1), (0, 0, 0)), sky=1)

    file = tmp_path / "a.checkpoint"
    begin(scene(0), file, vpls=200)
    with pytest.raises(tashika.InputError, match=r"scene\.digest"):
        tashika.render(scene(1e-6), checkpoint=file, **{**RENDER, "vpls": 200})
    assert tashika.render(scene(0), checkpoint=file, **{**RENDER, "vpls": 200}).complete

    few = {"size": (40, 30), "truth": "vpl", "vpls": 50, "gather": 1}
    parts = [tashika.render(scene(h), tiles=(n, 2), **few) for n, h in [(1, 0), (2, 1e-6)]]
    with pytest.raises(tashika.InputError, match=r"scene\.digest"):
        tashika.merge(parts)
