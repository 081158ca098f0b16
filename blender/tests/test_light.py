"""Lamps and worlds: as bright as closed forms and Cycles say."""

import math

import bpy
import numpy
import pytest
from scenes import camera, cube, lamp, material, plane, world

#: What the paths leave open where lamps have a size, of which half of a sphere is seen: 65,536 in all, 2.5 standard errors.
NOISE = 0.01
HEIGHT, ASIDE = 2.0, 0.3
D2 = HEIGHT**2 + ASIDE**2
COS = HEIGHT / math.sqrt(D2)


def white_plane(scene):
    """A white plane, of which the camera sees a small place that is `ASIDE` from the point below the lamp."""
    plane(scene, half=50.0, of=material("white", (1.0, 1.0, 1.0)))
    camera(scene, (ASIDE, 0.0, 5.0), (ASIDE, 0.0, 0.0), angle=0.02)
    scene.render.resolution_x = scene.render.resolution_y = 8


def by_cycles(scene, render, samples=64):
    """The same by Cycles, direct light alone."""
    if not bpy.app.build_options.cycles:
        pytest.skip("this bpy has no Cycles")
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.max_bounces = samples, False, 0
    scene.cycles.device = "CPU"
    return render(scene)


LAMPS = {
    "point": ("POINT", {"shadow_soft_size": 0.0}, 1.0 / (4.0 * math.pi)),
    "sphere": ("POINT", {"shadow_soft_size": 0.1}, 1.0 / (4.0 * math.pi)),
    "spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.5, "spot_blend": 0.0}, 1.0 / (4.0 * math.pi)),
    "square": ("AREA", {"shape": "SQUARE", "size": 0.1}, COS / math.pi),
    "ellipse": ("AREA", {"shape": "ELLIPSE", "size": 0.1, "size_y": 0.05}, COS / math.pi),
}


@pytest.mark.parametrize("name", LAMPS)
def test_watts(scene, render, asked, record_property, name):
    """A white plane under a lamp: `E/π`, with the irradiance `E = I cos/d²` of the intensity `I` of 100 W."""
    asked("--method", "path", "--paths", "1024")
    kind, said, intensity = LAMPS[name]
    white_plane(scene)
    lamp(scene, kind, 100.0, (0.0, 0.0, HEIGHT), **said)
    ours = render(scene)[..., 1].mean()
    expected = 100.0 * intensity * COS / D2 / math.pi
    assert ours == pytest.approx(expected, rel=1e-3 if name in {"point", "spot"} else NOISE)
    theirs = by_cycles(scene, render)[..., 1].mean()
    record_property("ratio", float(ours / theirs))
    print(f"{name}: {ours / expected:.4f} of the closed form, {ours / theirs:.4f} of Cycles")
    assert ours == pytest.approx(theirs, rel=2e-3 if name in {"point", "spot"} else NOISE)


def test_suns_exposure_and_colour(scene, render, asked):
    asked("--method", "path", "--paths", "4")
    white_plane(scene)
    sun = lamp(scene, "SUN", 3.0, (1.0, 0.0, 1.0), color=(1.0, 0.5, 0.25), angle=0.0)
    if hasattr(sun.data, "exposure"):
        sun.data.exposure = 1.0
    ours = render(scene)[..., :3].mean(axis=(0, 1))
    doubled = 2.0 if hasattr(sun.data, "exposure") else 1.0
    expected = 3.0 * doubled * math.sqrt(0.5) / math.pi * numpy.array([1.0, 0.5, 0.25])
    assert ours == pytest.approx(expected, rel=1e-3)
    assert ours == pytest.approx(by_cycles(scene, render)[..., :3].mean(axis=(0, 1)), rel=2e-3)


def test_surfaces_shine_and_worlds_are_even(scene, render, asked):
    """What shines by 3 has a radiance of 3; a white plane in a world of 0.4 times 2 is as bright as that."""
    asked("--method", "path", "--paths", "1024")
    white_plane(scene)
    world(scene, (0.4, 0.4, 0.4), 2.0)
    assert render(scene)[..., 1].mean() == pytest.approx(0.8, rel=NOISE)
    cube(scene, of=material("shining", (0.0, 0.0, 0.0), emission=3.0))
    assert render(scene)[..., 1].mean() == pytest.approx(3.0, rel=1e-3)


def environment(scene, tmp_path, turn, kind, depth):
    """A world of an image in which each direction has another colour, turned about the vertical."""
    width, height = 64, 32
    rows, columns = numpy.indices((height, width))
    turns = 2.0 * math.pi * (columns + 0.5) / width
    colors = [1.2 + numpy.sin(turns), 1.2 + numpy.cos(turns), rows / height, numpy.ones_like(turns)]
    samples = numpy.stack(colors, axis=-1).astype(numpy.float32)
    image = bpy.data.images.new("sky", width, height, float_buffer=depth == "float")
    image.pixels.foreach_set((samples if depth == "float" else samples / 2.4).ravel())
    ending, image.file_format = ("exr", "OPEN_EXR") if depth == "float" else ("png", "PNG")
    image.filepath_raw = str(tmp_path / f"sky.{ending}")
    image.save()
    tree = world(scene, (0.0, 0.0, 0.0), 1.5).node_tree
    texture, mapping, place = (
        tree.nodes.new(f"ShaderNode{n}") for n in ("TexEnvironment", "Mapping", "TexCoord")
    )
    texture.image = bpy.data.images.load(image.filepath_raw)
    mapping.vector_type = kind
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, turn)
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Background"].inputs["Color"])


@pytest.mark.parametrize(
    ("turn", "kind", "depth"),
    [(0.0, "POINT", "float"), (0.7, "POINT", "float"), (-2.0, "TEXTURE", "float"), (0.0, "POINT", "byte")],
)
def test_the_sky_is_turned_as_cycles_turns_it(scene, render, asked, tmp_path, turn, kind, depth):
    asked("--method", "path", "--paths", "16")
    environment(scene, tmp_path, turn, kind, depth)
    plane(scene, half=0.01, at=(0.0, 0.0, -5.0))
    camera(scene, (0.0, 0.0, 0.0), (1.0, 0.6, 0.3), lens=20.0)
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    ours = render(scene)[..., :3]
    theirs = by_cycles(scene, render)[..., :3]
    assert numpy.ptp(theirs[..., 0]) > 0.1, "the sky is not the same everywhere"
    # Both look between texels, of which one in this image is up to 0.15 from the next.
    assert abs(ours - theirs).max() < 0.05
