"""Pictures that are claimed as a whole."""

import numpy as np
import pytest

import tashika

FEW = dict(size=(48, 36), error=0.25, share=0.9, assurance=0.9, audit=60, vpls=5000)


def test_a_picture_says_what_share_of_it_is_certain():
    image = tashika.render(tashika.builtin("tiny"), claim="audited", **FEW)
    claim = image.picture_claim
    assert claim["reached"] and claim["audited"] == 60
    assert claim["upper_outside"] <= 0.1
    assert image.tally["audited"] == claim["population"]
    verdicts = image["audited"][..., 2]
    assert np.count_nonzero(verdicts) == 60
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
    with pytest.warns(UserWarning, match="share means nothing"):
        tashika.render(scene, share=0.5, size=(4, 3), vpls=200, max_pairs=64)
