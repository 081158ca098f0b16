"""Pictures that are claimed as a whole."""

import numpy as np
import pytest

import tashika

FEW = dict(size=(48, 36), error=0.25, share=0.9, assurance=0.9, audit=60, vpls=5000)


def test_a_picture_says_what_share_of_it_is_certain():
    image = tashika.render(tashika.builtin("tiny"), claim="audited", **FEW)
    claim = image.picture_claim
    # If the first interim analysis is undecided, twice as many pixels are checked.
    assert claim["reached"] and claim["audited"] in (60, 120)
    assert claim["upper_outside"] <= 0.1
    assert image.tally["audited"] == claim["population"]
    verdicts = image["audited"][..., 2]
    assert np.count_nonzero(verdicts) == claim["audited"]
    assert np.count_nonzero(verdicts == 2) == claim["outside"]
    judged = tashika.compare(image, image).picture
    assert judged["held"] and judged["claim"] == claim and judged["within"] == judged["of"] == claim["population"]


def test_a_quality_is_a_claim_and_an_error():
    image = tashika.render(
        tashika.builtin("tiny"), quality="draft", size=(48, 36), share=0.9, assurance=0.9, audit=60, time=0.001
    )
    claim = image.picture_claim
    assert (claim["error"], claim["passes"]) == (0.1, 1)
    assert image.metadata["claim"] == "audited"
    final = tashika.render(tashika.builtin("tiny"), quality="final", size=(4, 3), vpls=500, max_pairs=64)
    assert final.picture_claim is None and final.metadata["error"] == 0.02


def test_what_does_not_go_with_it_is_said(tmp_path):
    scene = tashika.builtin("tiny")
    with pytest.raises(tashika.OptionError, match="checkpoint"):
        tashika.render(scene, claim="audited", checkpoint=tmp_path / "kept", **FEW)
    with pytest.raises(tashika.OptionError, match="time"):
        tashika.render(scene, claim="audited", time=-1.0, **FEW)
    with pytest.raises(tashika.OptionError, match="draft"):
        tashika.render(scene, quality="best")
    small = dict(size=(4, 3), vpls=200, max_pairs=64)
    for said in (dict(share=0.5), dict(time=5.0), dict(audit=20)):
        with pytest.raises(tashika.OptionError, match="none without claim audited"):
            tashika.render(scene, **said, **small)
    with pytest.raises(tashika.OptionError, match="quality = draft; expected none with claim calibrated"):
        tashika.render(scene, quality="draft", error=0.05, claim="calibrated")


def test_parts_claim_nothing_and_are_audited_when_they_are_joined():
    scene = tashika.builtin("tiny")
    few = dict(FEW, size=(70, 40), method="path", claim="audited", error=0.5)
    del few["vpls"]
    parts = {of: [tashika.render(scene, tiles=(k, of), **few) for k in range(1, of + 1)] for of in (2, 3)}
    assert all(part.picture_claim is None and part.complete for of in parts for part in parts[of])
    two, three = (tashika.merge(parts[of]) for of in (2, 3))
    claim = two.picture_claim
    assert claim["reached"] and claim["looks"] == 1 and claim == three.picture_claim
    assert list(two) == list(three) and all(np.array_equal(two[plane], three[plane], equal_nan=True) for plane in two)
    assert np.count_nonzero(two["audited"][..., 2]) == claim["audited"]
    some = tashika.merge(parts[3][:2])
    assert some.picture_claim is None and not some.complete
    assert tashika.merge([some, parts[3][2]]).picture_claim == claim
    with pytest.raises(tashika.OptionError, match="time"):
        tashika.render(scene, tiles=(1, 2), time=5.0, **few)
