"""Participating media from arrays, against closed forms."""

import math

import numpy as np
import pytest

import tashika

SIZE = (4, 3)
#: A lamp of radiance 2, four metres in front of the camera.
LAMP = tashika.Mesh(
    [[-9, -9, -4], [9, -9, -4], [9, 9, -4], [-9, 9, -4]],
    [[0, 1, 2], [0, 2, 3]],
    material=tashika.Material.diffuse(0).emitting(2),
)
#: Looks along -z; its view is so narrow that all its rays are the axis.
CAMERA = tashika.Camera((0, 0, 0), (0, 0, -1), vertical_fov=0.01, size=SIZE)
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE_SIDES = [
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
]  # fmt: skip


def radiance(scene, paths=4):
    image = tashika.render(scene, method="path", paths=paths)
    return image["radiance"].mean(axis=(0, 1))


def box(transform, **sides):
    cube = {"material": tashika.Material.boundary(), "transforms": transform}
    return tashika.Mesh(CUBE, CUBE_SIDES, **cube, **sides)


def placed(scale, move):
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = move
    return matrix


def test_a_camera_stands_in_what_absorbs():
    dark = tashika.Medium((0.1, 0.2, 0.5), 0)
    scene = tashika.Scene.build([LAMP], camera=CAMERA.within(dark))
    expected = [2 * math.exp(-4 * sigma) for sigma in (0.1, 0.2, 0.5)]
    np.testing.assert_allclose(radiance(scene), expected, rtol=1e-4)
    left = tashika.render(scene, method="path", paths=1)["transmittance"]
    np.testing.assert_allclose(left, np.broadcast_to(np.array(expected) / 2, left.shape), rtol=1e-4)
    clear = tashika.Scene.build([LAMP], camera=CAMERA)
    np.testing.assert_allclose(radiance(clear), [2, 2, 2], rtol=1e-5)


def test_a_box_has_a_medium_inside():
    inside = tashika.Medium(0.7, 0)
    # From z = -3 to z = -1.
    scene = tashika.Scene.build([LAMP, box(placed(2, (-1, -1, -3)), inside=inside)], camera=CAMERA)
    np.testing.assert_allclose(radiance(scene), [2 * math.exp(-1.4)] * 3, rtol=1e-4)
    outside = tashika.Scene.build([LAMP, box(placed(2, (-1, -1, -3)), outside=inside)], camera=CAMERA.within(inside))
    np.testing.assert_allclose(radiance(outside), [2 * math.exp(-1.4)] * 3, rtol=1e-4)


def test_densities_vary_as_their_array_says():
    # The density is 1 in red and 2 in green at the far end along z, and 0 elsewhere. This tests the
    # order of axes and channels.
    density = np.zeros((2, 1, 1, 3))
    density[0, 0, 0] = (1, 2, 0)
    transform = placed(2, (-1, -1, -3))
    smoke = tashika.Medium(0.8, 0, density=density, transform=transform)
    scene = tashika.Scene.build([LAMP, box(transform, inside=smoke)], camera=CAMERA)
    # Along the ray, the density goes from a half at the edge to 1 in a quarter of the way, and then
    # to 0 in half of the way.
    mean = 0.25 * 0.75 + 0.5 * 0.5
    found = -np.log(radiance(scene, paths=20_000) / 2)
    np.testing.assert_allclose(found, [0.8 * 2 * mean * k for k in (1, 2, 0)], rtol=0.02, atol=1e-3)


def test_what_is_scattered_is_the_albedo():
    # The surroundings have the radiance 1. A medium of albedo 1 is then as bright and changes
    # nothing; a medium of albedo 0.5 is much darker.
    def seen(albedo):
        grid = np.full((1, 1, 1), albedo)
        transform = placed(2, (-1, -1, -3))
        milk = tashika.Medium(1, 1, density=np.ones((1, 1, 1)), albedo=grid, transform=transform)
        return radiance(tashika.Scene.build([box(transform, inside=milk)], camera=CAMERA, sky=1), paths=2000)

    np.testing.assert_allclose(seen(1), [1, 1, 1], rtol=0.03)
    assert (seen(0.5) < 0.8).all()


def test_what_is_wrong_is_said():
    with pytest.raises(tashika.OptionError, match=r"density.*\(depth, height, width\)"):
        tashika.Medium(0, 1, density=np.ones((2, 2)))
    with pytest.raises(tashika.InputError, match="g between -1 and 1"):
        tashika.Medium(0, 1, g=1.5)
    with pytest.raises(tashika.InputError, match="albedos from 0 to 1"):
        tashika.Medium(0, 1, density=np.ones((1, 1, 1)), albedo=np.full((1, 1, 1), 2.0))
    with pytest.raises(tashika.OptionError, match="transform"):
        tashika.Medium(0, 1, density=np.ones((1, 1, 1)), transform=np.zeros((2, 4, 4)))


def test_media_are_rendered_by_paths():
    fog = tashika.Medium(0.1, 0.3, g=0.4, name="fog")
    scene = tashika.Scene.build([LAMP], camera=CAMERA.within(fog))
    image = tashika.render(scene, error=0.2)
    assert image.metadata["method"] == "path"
    assert repr(fog) == '<tashika.Medium "fog">'
