"""Images: arrays, mapping, files, pages for notebooks."""

import base64
import json
import re
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import tashika
from conftest import SUM


def test_planes_have_the_shapes_and_types_that_are_documented(image: tashika.Image) -> None:
    assert image.size == (16, 12) and image.window == (0, 0, 16, 12) and image.complete
    for name, facts in image.planes.items():
        channels = len(facts["channels"])
        shape = (12, 16) if channels == 1 else (12, 16, channels)
        kind = np.uint32 if name in ("claim", "stop") else np.float32
        assert image[name].shape == shape and image[name].dtype == kind, name
        assert facts["unit"] and facts["doc"]
    assert image["radiance"].shape == (12, 16, 3)
    assert (image["claim"] > 0).all() and (image["half_width"] >= 0).all() and image["radiance"].max() > 1


def test_arrays_are_made_once_and_cannot_be_written_to(image: tashika.Image) -> None:
    assert image["radiance"] is image["radiance"]
    with pytest.raises(ValueError, match="read-only"):
        image["radiance"][0] = 0


def test_an_image_is_a_mapping(image: tashika.Image) -> None:
    assert isinstance(image, Mapping)
    assert list(image) == image.keys() == list(dict(image)) and len(image) == len(image.keys())
    assert [name for name, _ in image.items()] == image.keys() and len(image.values()) == len(image)
    assert "claim" in image and "absent" not in image and 3 not in image
    assert image.get("absent") is None and image.get("absent", 7) == 7
    with pytest.raises(KeyError, match="absent; the planes are radiance, "):
        image["absent"]


def test_files_hold_all_of_it(image: tashika.Image, tmp_path: Path) -> None:
    image.save(tmp_path / "a.exr")
    again = tashika.read(tmp_path / "a.exr")
    assert again.metadata == image.metadata and sorted(again) == sorted(image)
    assert all(np.array_equal(again[name], image[name], equal_nan=True) for name in image)
    for layout in ("parts", "tiles,piz", "parts,tiles,none"):
        image.save(tmp_path / "b.exr", exr=layout)
        other = tashika.read(tmp_path / "b.exr")
        assert other.metadata == image.metadata and list(other) == list(again), layout
        assert all(np.array_equal(other[name], image[name], equal_nan=True) for name in image), layout
    with pytest.raises(tashika.OptionError, match="exr = dwaa; expected what keeps all bits"):
        image.save(tmp_path / "b.exr", exr="dwaa")
    image.save(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    natural = (tmp_path / "a.png").read_bytes()
    for tonemap in ("natural", "linear", "filmic", "aces", "agx"):
        image.save(tmp_path / "b.png", tonemap=tonemap)
        assert ((tmp_path / "b.png").read_bytes() == natural) == (tonemap == "natural"), tonemap
        image.save(tmp_path / "b.exr", tonemap=tonemap, exposure=3)
        assert (tmp_path / "b.exr").read_bytes() == (tmp_path / "a.exr").read_bytes(), tonemap
    with pytest.raises(tashika.OptionError, match="tonemap = sepia; expected natural, linear, filmic, aces, agx"):
        image.save(tmp_path / "b.png", tonemap="sepia")  # type: ignore[arg-type]
    image.save(tmp_path / "dark.png", exposure=-30)
    assert (tmp_path / "dark.png").read_bytes() != natural
    with pytest.raises(tashika.OptionError, match="exposure = 65; expected auto, or stops from -64 to 64"):
        image.save(tmp_path / "b.png", exposure=65)
    image.save(tmp_path / "a.html", tonemap="agx")
    assert "<option selected>agx</option>" in (tmp_path / "a.html").read_text()
    image.save(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text().startswith("<!DOCTYPE html>".lower()) or "<html" in (
        tmp_path / "a.html"
    ).read_text()
    with pytest.raises(
        tashika.OptionError, match=r"a\.jpg; expected a file name ending in \.exr, \.png or \.html"
    ):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(tashika.FileError, match="absent"):
        image.save(tmp_path / "absent" / "a.exr")


def test_threads_do_not_change_bits(tiny: tashika.Scene, image: tashika.Image) -> None:
    for threads in (1, 3):
        other = tashika.render(tiny, threads=threads, **SUM)
        assert all(np.array_equal(other[name], image[name], equal_nan=True) for name in image)
    assert not np.array_equal(tashika.render(tiny, seed=2, **SUM)["radiance"], image["radiance"])


def test_motion_vectors_are_a_plane_more(tiny: tashika.Scene, image: tashika.Image) -> None:
    with_vectors = tashika.render(tiny, motion_vectors=True, **SUM)
    assert set(with_vectors) - set(image) == {"motion"} and with_vectors["motion"].shape == (12, 16, 2)
    assert (with_vectors["motion"] == 0).all(), "nothing moves"
    assert all(np.array_equal(with_vectors[name], image[name], equal_nan=True) for name in image)
    assert with_vectors.planes["motion"]["channels"] == ["x", "y"] and with_vectors.planes["motion"]["unit"] == "pixel"


def test_mattes_are_planes_more(tiny: tashika.Scene, image: tashika.Image) -> None:
    mattes = tashika.render(tiny, cryptomatte=True, **SUM)
    assert all(np.array_equal(mattes[name], image[name], equal_nan=True) for name in image)
    layers = [f"Crypto{of}0{k}" for of in ("Object", "Material") for k in range(3)]
    assert set(mattes) - set(image) == {*layers, "object_id", "material_id"}
    manifest = json.loads(mattes.metadata["cryptomatte/3ae39a5/manifest"])
    numbers, shares = np.split(mattes["CryptoObject00"][..., [0, 2, 1, 3]], 2, axis=-1)
    assert numbers.dtype == np.float32 and (shares[..., 0] >= shares[..., 1]).all() and (shares[..., 1] > 0).any()
    assert np.array_equal(np.ascontiguousarray(numbers[..., 0]).view(np.uint32), mattes["object_id"])
    assert set(np.unique(mattes["object_id"])) - {0} <= {int(number, 16) for number in manifest.values()}
    assert set(tashika.render(tiny, cryptomatte=2, **SUM)) == set(mattes) - {*layers} | {"CryptoObject00", "CryptoMaterial00"}
    assert set(tashika.render(tiny, cryptomatte=False, **SUM)) == set(image)
    for wrong in (33, "all"):
        with pytest.raises(tashika.OptionError, match="cryptomatte"):
            tashika.render(tiny, cryptomatte=wrong, **SUM)


def test_groups_of_lights_add_up(tiny: tashika.Scene) -> None:
    options = {"size": (16, 12), "method": "path", "paths": 8}
    plain, each = tashika.render(tiny, **options), tashika.render(tiny, groups="each", **options)
    assert all(np.array_equal(each[name], plain[name], equal_nan=True) for name in plain)
    groups = [name for name in each if name.startswith("light_") and not name.endswith("_standard_error")]
    assert groups and set(each) - set(plain) == {*groups, *(f"{name}_standard_error" for name in groups)}
    assert np.allclose(sum(each[name] for name in groups), each["radiance"], rtol=1e-5, atol=0)
    lamp = groups[0].removeprefix("light_").replace("_", " ")
    named = tashika.render(tiny, groups={"key": [lamp]}, **options)
    assert np.array_equal(named["light_key"], each[groups[0]]) and named.metadata["light.groups"] == f"key={lamp}"
    for wrong in ({"key": ["no such lamp"]}, "all", 3):
        with pytest.raises(tashika.OptionError, match="groups"):
            tashika.render(tiny, groups=wrong, **options)
    # In a render with claims, the planes of groups are equal to those of path tracing with that
    # number of paths.
    claims = {"size": (16, 12), "error": 0.5, "vpls": 2000}
    plain = tashika.render(tiny, **claims)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        beside = tashika.render(tiny, groups="each", paths=8, **claims)
    assert all(np.array_equal(beside[name], plain[name], equal_nan=True) for name in plain)
    assert all(np.array_equal(beside[name], each[name], equal_nan=True) for name in groups)
    assert beside.metadata["light.groups.paths"] == 8


def test_shares_of_tiles_are_the_image(tiny: tashika.Scene, image: tashika.Image) -> None:
    parts = [tashika.render(tiny, tiles=share, gather=16, **SUM) for share in ("1/2", (2, 2))]
    whole = tashika.render(tiny, gather=16, **SUM)
    rendered = [part["stop"] > 0 for part in parts]
    assert (rendered[0] ^ rendered[1]).all() and all(mask.any() for mask in rendered)
    for part, mask in zip(parts, rendered):
        assert np.array_equal(part["radiance"][mask], whole["radiance"][mask])


def test_notebooks_show_the_image_and_its_half_widths(image: tashika.Image) -> None:
    page = image._repr_html_()
    pictures = [base64.b64decode(data) for data in re.findall(r'base64,([^"]+)"', page)]
    assert len(pictures) == 2 and all(picture.startswith(b"\x89PNG") for picture in pictures)
    assert "tiny: all 192 pixels claim to be within 2 % of the sum over its VPLs at 95 % confidence" in page
    assert repr(image).startswith("<tashika.Image 16x12: tiny: all 192 pixels")
    # Effect of another set, since the claim is about the sum over this one.
    assert re.search(r"as many others change a pixel by [\d.]+ % in the median", repr(image)), repr(image)


def test_a_render_without_an_error_is_an_audited_picture(tiny: tashika.Scene) -> None:
    said = {"size": (16, 12), "vpls": 20_000}
    picture, again = (tashika.render(tiny, passes=3, threads=threads, **said) for threads in (1, 3))
    assert np.array_equal(picture["radiance"], again["radiance"]), "fixed work has the same bits"
    claim = picture.picture_claim
    assert claim is not None and (claim["passes"], claim["looks"]) == (3, 1)
    assert "denoiser" not in picture.metadata
    assert tashika.render(tiny, error=0.2, **said).picture_claim is None
    for wrong in ({"passes": 0}, {"passes": 3, "time": 5.0}, {"passes": 3, "tiles": "1/2"}, {"passes": 3, "error": 0.1}):
        with pytest.raises(tashika.OptionError, match="passes"):
            tashika.render(tiny, **wrong, **said)


def test_names_of_scenes_are_no_markup(tiny: tashika.Scene) -> None:
    square = tashika.Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], material=tashika.Material.diffuse(1)
    )
    scene = tashika.Scene.build([square], name="<script>")
    assert "<script>" not in tashika.render(scene, size=(2, 2), vpls=10, passes=1)._repr_html_()


def test_comparisons_tell_errors_and_claims(
    tiny: tashika.Scene, image: tashika.Image, tmp_path: Path
) -> None:
    exact = tashika.render(tiny, method="exact", size=SUM["size"], vpls=SUM["vpls"])
    ours = tashika.compare(image, exact)
    assert ours.errors.shape == (12, 16) and ours.errors.dtype == np.float64
    assert ours.pixels == 192 and ours.error == 0.02 and ours.absolute == 0 and ours.error_from == "image"
    weights = np.float32([0.2126, 0.7152, 0.0722])
    by_hand, truth = image["radiance"] @ weights, exact["radiance"] @ weights
    lit = truth > 0
    # Colours and weights are float32 here: a few roundings of 6e-8 of the luminance.
    assert np.allclose(ours.errors[lit], (np.abs(by_hand - truth)[lit] / truth[lit]), rtol=0, atol=1e-6)
    assert not ours.errors[~lit].any()
    squares = (image["radiance"].astype(np.float64) - exact["radiance"]) ** 2
    assert ours.rmse is not None and np.isclose(ours.rmse, np.sqrt(squares.mean()), rtol=1e-12)
    relative = squares / (exact["radiance"].astype(np.float64) ** 2 + 0.01)
    assert ours.relmse is not None and np.isclose(ours.relmse, relative.mean(), rtol=1e-12)
    assert ours.ssim is not None and 0.9 < ours.ssim < 1
    assert ours.flip is not None and 0 < ours.flip < 0.5
    asked = tashika.compare(image, exact, 0.05)
    assert (asked.error, asked.error_from, asked.failed) == (0.05, "asked", 0)
    assert ours.worst == ours.errors.max() and ours.errors[ours.worst_at[::-1]] == ours.worst
    assert ours.claims is not None and ours.claims["of"] == 192 and ours.claims["same_truth"]
    assert ours.claims_kept == ours.claims["kept"] / 192
    assert image.coverage(exact) == {
        "error": 0.02, "pixels": 192, "within": ours.within_tolerance, "claims": ours.claims,
    }  # fmt: skip
    assert image.coverage(exact, error=1e-6)["within"] < ours.within_tolerance
    assert "base64," in ours._repr_html_() and "within 2 % of the reference" in repr(ours)
    ours.save(tmp_path / "error.png")
    ours.save(tmp_path / "error.html", tonemap="filmic")
    assert "<option selected>filmic</option>" in (tmp_path / "error.html").read_text(encoding="utf-8")
    with pytest.raises(tashika.InputError, match="an image of 16x12 pixels"):
        tashika.compare(image, tashika.render(tiny, size=(8, 6), vpls=10, passes=1))
    other = tmp_path / "other.exr"
    tashika.render(tiny, size=(8, 6), vpls=10, passes=1).save(other)
    with pytest.raises(tashika.InputError, match=r"expected what .*other\.exr shows: 8x6 pixels"):
        tashika.compare(image, tashika.read(other))


def test_comparisons_tell_disjoint_intervals(tiny: tashika.Scene, image: tashika.Image) -> None:
    exact = tashika.render(tiny, method="exact", size=SUM["size"], vpls=SUM["vpls"])
    found = tashika.compare(image, exact)
    assert found.claims is not None and found.intervals is not None
    assert list(found.intervals) == ["claimed_in_both", "disjoint", "share", "low", "high", "confidence"]
    # The interval of an exact pixel is one number: it is inside the other interval, or the claim of
    # the other is broken.
    assert found.intervals["claimed_in_both"] == found.claims["of"] == 192
    assert found.intervals["disjoint"] == 192 - found.claims["kept"]
    assert "that both films claim are disjoint" in repr(found)
    # Other seeds have other VPLs, whose sums may differ; light transport is the same.
    assert tashika.compare(image, tashika.render(tiny, seed=2, **SUM)).intervals is None
    paths = [tashika.render(tiny, size=(8, 6), method="path", error=0.3, seed=seed) for seed in (1, 2)]
    intervals = tashika.compare(*paths).intervals
    weights = np.float64([0.2126, 0.7152, 0.0722])
    distance = np.abs((paths[0]["radiance"] - paths[1]["radiance"].astype(np.float64)) @ weights)
    claimed = (paths[0]["claim"] > 0) & (paths[1]["claim"] > 0)
    apart = distance > paths[0]["half_width"].astype(np.float64) + paths[1]["half_width"] + 1e-5
    assert intervals is not None and intervals["claimed_in_both"] == claimed.sum() > 40
    assert intervals["disjoint"] == (apart & claimed).sum()
    assert intervals["low"] <= intervals["share"] == intervals["disjoint"] / claimed.sum() <= intervals["high"]
    count = tashika.render(tiny, size=(8, 6), method="path", paths=4)
    assert tashika.compare(paths[0], count).intervals is None


def test_shares_are_joined_one_after_the_other_in_any_order(tiny: tashika.Scene) -> None:
    options = {"size": (80, 60), "vpls": 300, "truth": "vpl"}
    whole = tashika.render(tiny, **options)
    parts = [tashika.render(tiny, tiles=(number, 3), **options) for number in (1, 2, 3)]
    assert not any(np.array_equal(part["stop"], whole["stop"]) for part in parts)
    joined = tashika.merge(part for part in reversed(parts))
    assert joined.complete and joined.metadata == whole.metadata
    assert all(np.array_equal(joined[name], whole[name], equal_nan=True) for name in whole)

    missing = tashika.merge([parts[0], parts[2]])
    assert not missing.complete and missing.metadata["tiles"] == "1,3/3"
    assert np.array_equal(missing["stop"] == 0, (parts[1]["stop"] != 0))

    other = tashika.render(tiny, tiles=(2, 3), seed=9, **options)
    with pytest.raises(
        tashika.InputError, match=r"part 2 \(exact\): .*seed = 9; .* in part 1 \(exact\): .*seed = 1"
    ):
        tashika.merge([parts[0], other])
    with pytest.raises(tashika.OptionError, match="at least one image"):
        tashika.merge([])
    with pytest.raises(TypeError):
        tashika.merge([parts[0], "b.exr"])


def test_lights_that_a_scene_keeps_are_those_that_were_asked_for() -> None:
    few = {"size": (6, 4), "vpls": 3000, "error": 0.5, "gather": 4}
    asked = [
        {"truth": "transport"},
        {"truth": "clamped"},
        {"truth": "transport", "seed": 2},
        {"truth": "transport", "vpls": 4000},
        {"truth": "transport", "clamp": 0.3},
        {"truth": "transport"},
    ]
    kept = tashika.builtin("tiny")
    for said in asked:
        options = {**few, **said}
        of_kept = tashika.render(kept, **options)
        fresh = tashika.render(tashika.builtin("tiny"), **options)
        assert of_kept.metadata == fresh.metadata
        assert all(np.array_equal(of_kept[name], fresh[name], equal_nan=True) for name in fresh), said
