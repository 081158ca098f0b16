"""The camera: its place and angle as glTF has them, the rest as options of the program.

glTF knows neither the shift of a lens nor a camera that fits its sensor to the width. So the angle is that of the picture's height,
and a shifted picture is a window (`--crop`) of a larger one that is not: `W'` pixels wide, with the axis in the middle. If the axis
is at `a` pixels from the left of the picture, `k = 2a` rounded to a whole number, that is

    W' = k, window from 0            if k ≥ W
    W' = 2W − k, window from W − k   otherwise

and the same downwards: the picture is where it should be to a quarter of a pixel.

Held to this by `tests/test_framing.py`.
"""

import math

import bpy
from mathutils import Matrix

from .objects import put
from .words import CannotBeRendered

#: Height of the sensor in mm; the focal length then says the angle.
SENSOR = 24.0


def add(depsgraph, plain, size, region, notes):
    """Adds the camera to the plain scene; the options that go with it. `region` is x, y, width, height from the top left."""
    scene = depsgraph.scene
    thing = scene.camera
    if thing is None:
        raise CannotBeRendered("the scene has no camera")
    camera = thing.data
    place, turn, _ = thing.matrix_world.decompose()
    new = bpy.data.cameras.new("camera")
    put(plain, "camera", new, Matrix.LocRotScale(place, turn, None))
    plain.render.resolution_percentage = 100
    # The new camera has another name than it was given where the file has one of that name.
    if camera.type == "PANO":
        plain.render.resolution_x, plain.render.resolution_y = size
        return ["--camera", new.name, "--projection", _panorama(camera), *_said(size, region)]
    frame, window = _frame(new, thing, depsgraph, size, region, notes)
    plain.render.resolution_x, plain.render.resolution_y = frame
    # The exporter says half of the height by the longer side of the picture.
    new.ortho_scale *= max(frame) / frame[1]
    return ["--camera", new.name, *_said(frame, window), *_lens(thing)]


def _said(size, region):
    return ["--size", f"{size[0]}x{size[1]}", "--crop", ",".join(map(str, region))]


def _panorama(camera):
    of = camera if hasattr(camera, "panorama_type") else camera.cycles
    angles = [of.latitude_min, of.latitude_max, of.longitude_min, of.longitude_max]
    whole = [-math.pi / 2, math.pi / 2, -math.pi, math.pi]
    if of.panorama_type != "EQUIRECTANGULAR" or any(abs(a - b) > 1e-4 for a, b in zip(angles, whole)):
        raise CannotBeRendered(
            "of panoramic cameras only Equirectangular with all longitudes and latitudes is known"
        )
    return "spherical"


def _frame(new, thing, depsgraph, size, region, notes):
    """Sets the angle, or the height, of the new camera; the size of the frame around its axis and the region in that."""
    scene = depsgraph.scene.render
    width, height = size
    aspect = {"scale_x": scene.pixel_aspect_x, "scale_y": scene.pixel_aspect_y}
    matrix = thing.calc_matrix_camera(depsgraph, x=width, y=height, **aspect)
    if abs(matrix[0][0] * width / (matrix[1][1] * height) - 1.0) > 1e-4:
        notes.add("pixels are square: their aspect ratio is left out")
    perspective = thing.data.type == "PERSP"
    # Where the axis is in the picture, from −1 to 1, to the right and up.
    right, up = (-matrix[0][2], -matrix[1][2]) if perspective else (matrix[0][3], matrix[1][3])
    frame_width, left = _centred(width, width / 2.0 * (1.0 + right))
    frame_height, top = _centred(height, height / 2.0 * (1.0 - up))
    tangent = frame_height / height / matrix[1][1]
    new.sensor_fit, new.sensor_height = "VERTICAL", SENSOR
    if perspective:
        new.lens = SENSOR / 2.0 / tangent
    else:
        new.type, new.ortho_scale = "ORTHO", 2.0 * tangent
    x, y, across, down = region
    return (frame_width, frame_height), (left + x, top + y, across, down)


def _centred(size, axis):
    """The size of a frame in whose middle the axis is, and where the picture begins in it."""
    twice = round(2.0 * axis)
    return (twice, 0) if twice >= size else (2 * size - twice, size - twice)


def _lens(thing):
    """Depth of field."""
    camera = thing.data
    focus = camera.dof
    if not focus.use_dof or camera.type != "PERSP":
        return []
    distance = focus.focus_distance
    if focus.focus_object:
        ahead = -thing.matrix_world.to_3x3().col[2].normalized()
        there = focus.focus_object.matrix_world.translation
        distance = abs(ahead.dot(there - thing.matrix_world.translation))
    radius = 1e-3 * camera.lens / (2.0 * max(focus.aperture_fstop, 1e-5))
    said = ["--lens-radius", f"{radius:.9g}", "--focus-distance", f"{max(distance, 1e-5):.9g}"]
    if focus.aperture_blades >= 3:
        # Here a corner is half a side above the x axis, there it is up.
        turn = math.degrees(focus.aperture_rotation + math.pi / focus.aperture_blades) - 90.0
        said += ["--blades", str(focus.aperture_blades), "--blade-rotation", f"{turn:.9g}"]
    return said
