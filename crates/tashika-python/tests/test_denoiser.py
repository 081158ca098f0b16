"""Audited pictures that Open Image Denoise has smoothed, where it is installed."""

import numpy as np
import pytest

import tashika

OPTIONS = dict(size=(48, 32), error=0.3, share=0.8, assurance=0.9, audit=60, claim="audited")


def test_a_library_that_is_not_there_is_said_with_how_to_get_it():
    with pytest.raises(tashika.OptionError, match="pip install pyoidn"):
        tashika.render(tashika.builtin("tiny"), **OPTIONS, denoiser="/nowhere/libOpenImageDenoise.so.2")


def test_the_picture_says_what_smoothed_it_and_is_audited():
    pytest.importorskip("pyoidn")
    scene = tashika.builtin("tiny")
    ours = tashika.render(scene, **OPTIONS, denoiser="own")
    image = tashika.render(scene, **OPTIONS, denoiser="oidn")
    assert image.metadata["denoiser"].startswith("oidn 2.")
    assert "denoiser" not in ours.metadata
    assert image.picture_claim["audited"] in (60, 120)
    assert image.picture_claim["reached"] and ours.picture_claim["reached"]
    assert not np.array_equal(image["radiance"], ours["radiance"])


def test_a_denoiser_goes_with_audited_pictures_alone():
    with pytest.raises(tashika.OptionError, match="denoiser = oidn; expected none without claim audited"):
        tashika.render(tashika.builtin("tiny"), size=(8, 6), vpls=200, method="exact", denoiser="oidn")
