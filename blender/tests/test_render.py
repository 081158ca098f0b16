"""A render by the engine: its picture is the program's, its passes are there, and what is said of it is what the page says."""

import json
import re
import subprocess

import bpy
import numpy
import pytest
from conftest import ROOT, folder, pixels
from scenes import cube_on_plane, lamp


@pytest.mark.parametrize(
    ("said", "typed"),
    [
        ({"claim": "DRAFT"}, "--quality draft --seed 1"),
        ({"claim": "GOOD", "time_limit": 90, "seed": 7}, "--quality good --time 90s --seed 7"),
        ({"claim": "PIXELS", "time_limit": 90, "tolerance": 0.1}, "--error 0.1% --confidence 95% --seed 1"),
        (
            {"claim": "PIXELS", "tolerance": 33.3, "confidence": 99.9},
            "--error 33.3% --confidence 99.9% --seed 1",
        ),
    ],
)
def test_settings_are_options(scene, said, typed):
    for name, value in said.items():
        setattr(scene.tashika, name, value)
    assert scene.tashika.options() == typed.split()


def test_the_version_is_that_of_the_project():
    version = re.compile(r'^version = "(.*)"', re.MULTILINE)
    files = (ROOT / "Cargo.toml", ROOT / "blender/tashika/blender_manifest.toml")
    project, addon = (version.search(file.read_text())[1] for file in files)
    assert addon == project


def test_files_are_read_as_blender_reads_them(scene, render, addon, asked, tmp_path):
    asked("--method", "path", "--paths", "1")
    cube_on_plane(scene)
    theirs = render(scene)
    ours = addon.exr.File(tmp_path / "still.exr")
    assert numpy.array_equal(ours.plane("R", "G", "B", "A")[::-1], theirs)


def test_the_picture_is_that_of_the_program(scene, render, program, addon, tmp_path):
    cube_on_plane(scene)
    said = scene.tashika
    said.claim, said.tolerance, said.confidence, said.seed = "PIXELS", 50.0, 90.0, 3
    ours = render(scene)
    assert ours.shape == (36, 48, 4)
    assert ours[..., :3].mean() > 0.01
    assert (ours[..., 3] == 1.0).all()

    again = tmp_path / "again.exr"
    kept = folder(tmp_path)
    typed = "--camera camera --size 48x36 --error 50% --confidence 90% --seed 3 --quiet --threads 1"
    command = [
        program,
        "render",
        kept / "scene.glb",
        "--environment",
        kept / "environment.pfm",
        *typed.split(),
        "-o",
        again,
    ]
    subprocess.run(command, check=True)
    assert numpy.array_equal(ours[..., :3], addon.exr.File(again).plane("R", "G", "B")[::-1])


def in_layers(scene, tmp_path):
    """Lets the scene be written with all passes; the file."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
    if hasattr(settings, "use_exr_interleave"):
        settings.use_exr_interleave = True
    scene.render.filepath = str(tmp_path / "layers.exr")
    return scene.render.filepath


def test_passes_are_those_of_the_file(scene, asked, addon, tmp_path):
    cube_on_plane(scene)
    # A budget that some pixels exceed, so that no two passes are the same.
    asked("--error", "20%", "--max-pairs", "256")
    layers = in_layers(scene, tmp_path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    ours = addon.exr.File(layers)
    theirs = addon.exr.File(folder(tmp_path) / "picture.exr")
    for name, channel in {"Half width.X": "half_width.Y", "Claim.X": "claim.id", "Combined.G": "G"}.items():
        assert numpy.array_equal(ours.plane(f"ViewLayer.{name}"), theirs.plane(channel)), name
    assert not numpy.array_equal(theirs.plane("claim.id"), theirs.plane("stop.id"))
    # Calibrated intervals, and the picture's pixels are not all the same.
    assert 3.0 in numpy.unique(theirs.plane("claim.id"))
    assert len(numpy.unique(theirs.plane("half_width.Y"))) > 100


def test_view_layers_are_rendered_one_by_one(scene, asked, addon, tmp_path):
    asked("--method", "path", "--paths", "4")
    cube_on_plane(scene)
    group = bpy.data.collections.new("group")
    scene.collection.children.link(group)
    cube = scene.objects["cube"]
    group.objects.link(cube)
    scene.collection.objects.unlink(cube)
    other = scene.view_layers.new("other")
    other.layer_collection.children["group"].exclude = True
    file = in_layers(scene, tmp_path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    layers = addon.exr.File(file)
    names = ("ViewLayer", "other")
    whole, without = (layers.plane(*(f"{name}.Combined.{c}" for c in "RGB"))[18, 24] for name in names)
    # The cube is red, the plane is not.
    assert whole[0] > 2.0 * whole[1] > 0.0
    assert without[0] < 2.0 * without[1]
    assert len(list(folder(tmp_path).parent.glob("[12]/picture.exr"))) == 2


def test_the_statement_is_that_of_the_page(scene, render, addon, tmp_path):
    cube_on_plane(scene)
    scene.tashika.claim, scene.tashika.time_limit = "DRAFT", 5
    render(scene)
    told = addon.engine.statements[scene.name]
    claim = json.loads((folder(tmp_path) / "picture.json").read_text())["picture_claim"]
    assert told.startswith("at least ")
    assert "of the pixels are within 10 % of light transport, 99 % sure" in told
    assert f"; {claim['audited']} pixels were checked, {claim['outside']} were" in told


def test_the_film_is_transparent_where_nothing_is(scene, render, asked):
    # Path tracing as a method of its own tells nothing of surfaces.
    asked("--error", "50%")
    cube_on_plane(scene)
    bpy.data.objects.remove(scene.objects["plane"])
    scene.render.film_transparent = True
    picture = render(scene)
    assert (picture[0, 0] == 0.0).all()
    assert picture[18, 24, 3] == 1.0
    assert picture[18, 24, :3].max() > 0.0


@pytest.mark.parametrize("border", [(0.1, 0.333, 0.51, 0.77), (0.0, 0.0, 0.5, 0.5), (0.31, 0.47, 0.98, 1.0)])
def test_a_region_is_that_part_of_the_picture(scene, render, asked, border):
    asked("--method", "path", "--paths", "2")
    cube_on_plane(scene)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 101, 67, 50
    whole = render(scene)
    assert whole.shape == (33, 50, 4)
    settings = scene.render
    settings.use_border = True
    settings.border_min_x, settings.border_min_y, settings.border_max_x, settings.border_max_y = border
    within = render(scene)
    settings.use_crop_to_border = True
    alone = render(scene)
    height, width, _ = alone.shape
    left, top = int(border[0] * 50), 33 - int(border[3] * 33)
    part = (slice(top, top + height), slice(left, left + width))
    assert numpy.array_equal(alone, whole[part])
    assert within.shape == whole.shape
    assert numpy.array_equal(within[part], alone)
    assert within[..., :3].sum() == pytest.approx(alone[..., :3].sum(), rel=1e-5)


def test_a_film_of_several_frames_moves(scene, asked, tmp_path):
    asked("--method", "path", "--paths", "64")
    cube_on_plane(scene)
    scene.camera.name = scene.camera.data.name = "camera"
    cube, white = scene.objects["cube"], scene.objects["plane"].data.materials[0]
    color = white.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    for frame, x, red in [(1, 0.0, 0.8), (2, 1.0, 0.4)]:
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
        color.default_value = (red, 0.8, red, 1.0)
        color.keyframe_insert("default_value", frame=frame)
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(tmp_path / "frame")
    bpy.ops.render.render(animation=True, scene=scene.name)
    first, second = (pixels(path) for path in sorted(tmp_path.glob("frame*.exr")))
    # Right of where the cube is first; and the plane, which is green in the second frame.
    assert abs(first - second)[..., 0].max() > 0.05
    red, green, blue = (second / first)[-1, 0, :3]
    assert (red / green, blue / green) == pytest.approx((0.5, 0.5), rel=0.03)


def test_a_scene_without_light_is_black(scene, render, asked):
    asked("--method", "path", "--paths", "1")
    cube_on_plane(scene)
    bpy.data.objects.remove(scene.objects["lamp"])
    scene.world = None
    assert (render(scene)[..., :3] == 0.0).all()
    lamp(scene, "POINT", 10.0, (0.0, 0.0, 3.0))
    assert render(scene)[..., :3].max() > 0.0
