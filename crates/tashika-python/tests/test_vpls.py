"""Sets of virtual point lights: arrays, files, sets made of arrays."""

from pathlib import Path

import numpy as np
import pytest

import tashika


def test_arrays_have_the_shapes_that_are_documented(tiny: tashika.Scene) -> None:
    lights = tashika.vpls(tiny, count=300, seed=5, clamp=0.25)
    count = len(lights)
    assert 250 < count < 350
    for array in (lights.positions, lights.normals, lights.intensities):
        assert array.shape == (count, 3) and array.dtype == np.float32
    assert lights.kinds.shape == (count,) and lights.kinds.dtype == np.uint32
    assert set(lights.kinds) == {tashika.VplSet.KINDS.index("oriented")}
    assert np.allclose(np.linalg.norm(lights.normals, axis=1), 1, atol=1e-5)
    assert ((0 <= lights.positions) & (lights.positions <= 2)).all(), "the box is 2 m wide"
    provenance = lights.provenance
    assert (provenance["scene"], provenance["seed"], provenance["clamp_distance"]) == ("tiny", 5, 0.25)
    assert provenance["direct"] + provenance["indirect"] == count
    assert repr(lights) == f'<tashika.VplSet of "tiny": {count} lights>'


def test_files_and_threads_keep_every_bit(tiny: tashika.Scene, tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("a.vpl", "b.vpl", "c.vpl")]
    tashika.vpls(tiny, count=300).save(files[0])
    tashika.vpls(tiny, count=300, threads=1).save(files[1])
    tashika.VplSet.load(files[0]).save(files[2])
    assert len({file.read_bytes() for file in files}) == 1
    with pytest.raises(tashika.FileError, match="absent.vpl"):
        tashika.VplSet.load(tmp_path / "absent.vpl")
    files[0].write_bytes(b"other content, long enough")
    with pytest.raises(tashika.InputError, match="begins with TASHIKAV"):
        tashika.VplSet.load(files[0])


def test_a_set_of_arrays_lights_as_the_traced_one(tiny: tashika.Scene) -> None:
    traced = tashika.vpls(tiny, count=300)
    clamp = traced.provenance["clamp_distance"]
    again = tashika.VplSet.from_arrays(
        traced.positions, traced.normals, traced.intensities, traced.kinds, scene="tiny", clamp=clamp
    )
    radiance = [tashika.render(tiny, size=(8, 6), vpls=lights)["radiance"] for lights in (traced, again)]
    assert np.array_equal(*radiance)
    twice = tashika.VplSet.from_arrays(traced.positions, traced.normals, 2 * traced.intensities, clamp=clamp)
    pixels = [(x, y) for y in range(6) for x in range(8)]
    once, double = (tashika.exact(tiny, pixels, size=(8, 6), vpls=lights) for lights in (traced, twice))
    # The directly visible lamp is not part of the sum over the lights.
    lit = once.max(axis=1) < 5
    assert lit.sum() > 30 and np.allclose(double[lit], 2 * once[lit], rtol=1e-6)


def test_lights_that_cannot_be_are_refused() -> None:
    def refused(message: str, *arrays: object, **named: object) -> None:
        with pytest.raises(tashika.OptionError, match=message):
            tashika.VplSet.from_arrays(*arrays, **named)

    up = [[0, 1, 0]]
    refused(r"positions = an array of the shape \[3\]", [0, 1, 0], up, up)
    refused("normals = 2 rows; expected 1, one a light", up, up * 2, up)
    refused("in row 0; expected finite positions, unit normals", up, [[0, 2, 0]], up)
    refused("in row 1; expected .* intensities of at least 0", up * 2, up * 2, [[1, 1, 1], [0, -1, 0]])
    refused("kinds = 2; expected 0 .omni., 1 .oriented. or 3", up, up, up, [2])
    refused("clamp = -1; expected a distance", up, up, up, clamp=-1)
    assert len(tashika.VplSet.from_arrays(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))) == 0


def test_a_set_brings_its_own_clamp(tiny: tashika.Scene) -> None:
    with pytest.raises(tashika.OptionError, match="nothing beside a VplSet"):
        tashika.render(tiny, size=(2, 2), vpls=tashika.vpls(tiny, count=10), clamp="off")


def test_exact_sums_are_those_of_the_image(tiny: tashika.Scene) -> None:
    lights = tashika.vpls(tiny, count=200)
    image = tashika.render(tiny, size=(8, 6), vpls=lights, method="exact")
    pixels = [(7, 5), (0, 0), (3, 2)]
    found = tashika.exact(tiny, pixels, size=(8, 6), vpls=lights)
    assert found.shape == (3, 3) and found.dtype == np.float32
    assert np.array_equal(found, [image["radiance"][y, x] for x, y in pixels])
    assert tashika.exact(tiny, [], size=(8, 6), vpls=lights).shape == (0, 3)
    with pytest.raises(tashika.OptionError, match="pixels = 8,0; expected pixels of the image of 8x6"):
        tashika.exact(tiny, [(8, 0)], size=(8, 6), vpls=lights)


def test_rows_are_of_every_method_error_and_confidence(tiny: tashika.Scene) -> None:
    told: list[tuple[int, ...]] = []
    rows = tashika.coverage(
        tiny, methods=["lightcuts", "tashika"], errors=[0.02, 0.1], confidences=[0.5, 0.95], pixels=10, seeds=2,
        size=(8, 6), vpls=100, progress=lambda *now: told.append(now),
    )  # fmt: skip
    assert [(row["method"], row["error"], row["confidence"]) for row in rows] == [
        ("lightcuts", 0.02, None), ("lightcuts", 0.1, None),
        ("tashika", 0.02, 0.5), ("tashika", 0.02, 0.95), ("tashika", 0.1, 0.5), ("tashika", 0.1, 0.95),
    ]  # fmt: skip
    assert all(row["pixels"] == 10 and row["seeds"] == 2 and row["scene"] == "tiny" for row in rows)
    assert told
    for named, message in [
        ({"methods": ["exact"]}, "methods = exact; expected lightcuts, mdlc"),
        ({"pixels": 49}, "pixels = 49; expected 1 to 48"),
        ({"seeds": 0}, "seeds = 0; expected 1 or more"),
        ({"errors": [2.0]}, "error = 2; expected above 0"),
        ({"by": ["size"]}, "by = size; expected brightness or material"),
    ]:
        with pytest.raises(tashika.OptionError, match=message):
            tashika.coverage(tiny, size=(8, 6), vpls=100, **named)


def test_lights_that_are_given_are_summed_or_taken_for_some_of_all(tiny: tashika.Scene) -> None:
    lights = tashika.vpls(tiny, count=300)
    few = {"size": (4, 3), "vpls": lights, "max_pairs": 200}
    images = [tashika.render(tiny, truth=truth, **few) for truth in (None, "vpl", "transport")]
    assert [image.metadata["truth"] for image in images] == ["vpl", "vpl", "transport"]
    assert np.array_equal(images[0]["radiance"], images[1]["radiance"])
    assert not np.array_equal(images[1]["radiance"], images[2]["radiance"])
