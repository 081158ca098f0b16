"""The camera: what it shows where, which Blender's own `world_to_camera_view` says."""

import numpy
import pytest
from bpy_extras.object_utils import world_to_camera_view
from scenes import camera, cube, material, plane

#: In pixels: the centre of light of a small thing, from which 1024 paths a pixel tell.
PLACE = 0.1
#: Of a picture that is moved to the nearest half pixel, in each direction.
SHIFTED = 0.25 + PLACE

TURNED = {"at": (2.5, -4.0, 1.8), "towards": (0.2, 0.1, 0.4)}


@pytest.mark.parametrize(
    ("size", "said"),
    [
        ((60, 40), {"lens": 30.0}),
        ((40, 60), {"lens": 30.0}),
        ((60, 40), {"lens": 30.0, "sensor_fit": "HORIZONTAL", "sensor_width": 30.0}),
        ((40, 60), {"lens": 30.0, "sensor_fit": "HORIZONTAL", "sensor_width": 30.0}),
        ((60, 40), {"lens": 20.0, "sensor_fit": "VERTICAL", "sensor_height": 20.0}),
        ((40, 60), {"lens": 20.0, "sensor_fit": "VERTICAL", "sensor_height": 20.0}),
        ((60, 40), {"lens": 30.0, "shift_x": 0.21, "shift_y": -0.13}),
        ((41, 60), {"lens": 30.0, "shift_x": -0.19, "shift_y": 0.07}),
        ((60, 41), {"lens": 30.0, "shift_x": -0.1, "sensor_fit": "VERTICAL"}),
        ((60, 40), {"type": "ORTHO", "ortho_scale": 5.0}),
        ((40, 60), {"type": "ORTHO", "ortho_scale": 5.0}),
        ((60, 40), {"type": "ORTHO", "ortho_scale": 5.0, "shift_x": 0.2, "shift_y": 0.1}),
        ((40, 60), {"type": "ORTHO", "ortho_scale": 4.0, "sensor_fit": "HORIZONTAL"}),
    ],
)
def test_a_lamp_is_where_blender_says(scene, render, asked, size, said):
    asked("--method", "path", "--paths", "1024")
    scene.render.resolution_x, scene.render.resolution_y = size
    view = camera(scene, **TURNED, **said)
    small = cube(
        scene, half=0.04, of=material("shining", (0.0, 0.0, 0.0), emission=5.0), at=(0.3, -0.2, 0.75)
    )
    told = world_to_camera_view(scene, view, small.location)
    expected = numpy.array([told.x * size[0], (1.0 - told.y) * size[1]])
    assert all(2.0 < expected) and all(expected < numpy.array(size) - 2.0), "the lamp is in the picture"

    light = render(scene)[..., 1]
    rows, columns = numpy.indices(light.shape) + 0.5
    seen = numpy.array([(light * columns).sum(), (light * rows).sum()]) / light.sum()
    tolerance = SHIFTED if "shift_x" in said else PLACE
    assert abs(seen - expected).max() < tolerance, (seen, expected)


def test_panoramas_have_the_front_in_the_middle(scene, render, asked):
    asked("--method", "path", "--paths", "16")
    scene.render.resolution_x, scene.render.resolution_y = 64, 32
    view = camera(scene, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), type="PANO")
    (view.data if hasattr(view.data, "panorama_type") else view.data.cycles).panorama_type = "EQUIRECTANGULAR"
    # Ahead and to the right by 45 degrees, and up by as much as its height says.
    cube(scene, half=0.1, of=material("shining", (0.0, 0.0, 0.0), emission=5.0), at=(1.0, -1.0, 2.0**0.5))
    light = render(scene)[..., 1]
    row, column = numpy.unravel_index(light.argmax(), light.shape)
    assert abs(column + 0.5 - 64 * (0.5 + 45 / 360)) <= 2.0
    assert abs(row + 0.5 - 32 * (0.5 - 45 / 180)) <= 2.0


def test_a_lens_blurs_as_blenders_does(scene, render, asked):
    """The radius of the disk that a point becomes: `R·|d − f|/f` at the distance `d` of a lens of radius `R` focused at `f`."""
    asked("--method", "path", "--paths", "8192")
    scene.render.resolution_x, scene.render.resolution_y = 32, 32
    view = camera(scene, (0.0, 0.0, 4.0), (0.0, 0.0, 0.0), lens=50.0, sensor_width=36.0)
    view.data.dof.use_dof, view.data.dof.focus_distance, view.data.dof.aperture_fstop = True, 2.0, 0.1
    half = 0.04
    plane(scene, half=half, of=material("shining", (0.0, 0.0, 0.0), emission=500.0))
    light = render(scene)[..., 1]
    rows, columns = numpy.indices(light.shape) + 0.5 - 16.0
    seen = (light * (rows**2 + columns**2)).sum() / light.sum()
    pixel = 36.0 / 50.0 * 4.0 / 32.0
    radius = 0.050 / (2.0 * 0.1) * (4.0 - 2.0) / 2.0
    # Mean squares of distances from the middle add: of a disk half of its radius squared, of a square and a pixel a sixth of the side's.
    expected = (radius**2 / 2.0 + (2.0 * half) ** 2 / 6.0) / pixel**2 + 1.0 / 6.0
    # Some 5,000 paths meet the square.
    assert seen == pytest.approx(expected, rel=0.05)
