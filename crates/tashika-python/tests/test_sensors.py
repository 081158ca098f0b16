"""Illuminance at sensors."""

import math

import numpy as np
import pytest

import tashika


def furnace(radiance=1.0, reflectance=0.5):
    """A closed box of 2 m whose walls emit and reflect: radiance / (1 - reflectance) everywhere."""
    wall = tashika.Material.diffuse(reflectance).emitting(radiance)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = []
    for side in sides:
        a, b, c, d = side
        normal = np.cross(corners[b] - corners[a], corners[c] - corners[a])
        if normal @ corners[a] > 0:
            b, d = d, b
        triangles += [[a, b, c], [a, c, d]]
    mesh = tashika.Mesh(corners, triangles, material="wall")
    camera = tashika.Camera((0, 0, 0), (0, 0, -1))
    return tashika.Scene.build([mesh], materials={"wall": wall}, camera=camera)


def test_sensors_in_a_furnace_measure_its_radiance():
    scene = furnace()
    points = [[0.2, 0.1, 0, 0, 1, 0], [0, 0, 0.3, 1, 1, 0]]
    for shape in ("plane", "cylinder", "sphere"):
        found = tashika.sensors(scene, points, shape=shape, error=0.05, vpls=50_000)
        truth = 2 * math.pi
        assert np.all(np.abs(found["illuminance"] - truth) <= found["half_width"] + 1e-3)
        assert np.all(found["half_width"] <= 0.05 * truth)
        assert found["claim"] == ["calibrated"] * 2
    low, high = found["summary"]["mean"]["interval"]
    assert low <= truth <= high
    cie = tashika.sensors(scene, points, photometry="cie", error=0.05, vpls=50_000)
    same = tashika.sensors(scene, points, error=0.05, vpls=50_000)
    assert np.allclose(cie["illuminance"], 683 * same["illuminance"])


def test_files_and_grids_are_measured(tmp_path):
    scene = furnace()
    table = tmp_path / "desk.csv"
    table.write_text("name,x,y,z,nx,ny,nz\nwest,-0.5,0,0,0,1,0\neast,0.5,0,0,0,1,0\n")
    found = tashika.sensors(scene, table, error=0.1, vpls=20_000)
    assert found["name"] == ["west", "east"]
    assert found["position"][1].tolist() == [0.5, 0, 0]
    grid = tashika.sensors(scene, grid="-0.5,0,-0.5..0.5,0,0.5:0.5", error=0.1, vpls=20_000)
    assert grid["illuminance"].shape == (4,)
    again = tashika.sensors(scene, grid="-0.5,0,-0.5..0.5,0,0.5:0.5", error=0.1, vpls=20_000, threads=1)
    assert np.array_equal(grid["illuminance"], again["illuminance"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "either points or a grid"),
        ({"points": [[0, 0, 0]]}, "the shape \\(n, 6\\)"),
        ({"points": [[0, 0, 0, 0, 0, 0]]}, "sensor 1"),
        ({"points": [[0, 0, float("nan"), 0, 0, 1]]}, "sensor 1"),
        ({"points": np.zeros((0, 6))}, "one sensor or more"),
        ({"grid": "floor"}, "no spacing"),
        ({"grid": "floor:1"}, "the name of an object"),
        ({"points": [[0, 0, 0, 0, 1, 0]], "shape": "cube"}, "plane, cylinder, sphere"),
        ({"points": [[0, 0, 0, 0, 1, 0]], "claim": "audited"}, "calibrated or certified"),
        ({"points": [[0, 0, 0, 0, 1, 0]], "photometry": "lux"}, "scene, cie, radiance"),
    ],
)
def test_what_cannot_be_measured_is_refused(arguments, message):
    with pytest.raises(tashika.Error, match=message):
        tashika.sensors(furnace(), **arguments)
    with pytest.raises(TypeError, match="did you mean 'photometry'"):
        tashika.sensors(furnace(), photometri="cie")
