"""Scenes: loaded, built in, and built from arrays."""

from pathlib import Path

import numpy as np
import pytest

import tashika

FLOOR = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], np.float32)
QUAD = np.array([[0, 1, 2], [0, 2, 3]])
#: A square light half a metre above the floor, facing down.
LAMP = (FLOOR * 0.25 + np.float32([0, 0.5, 0]))[::-1]


def test_an_unknown_keyword_is_refused_and_a_slip_is_told() -> None:
    scene = tashika.builtin("tiny")
    with pytest.raises(TypeError, match=r"render\(\) got an unexpected keyword argument 'eror'; did you mean 'error'\?"):
        tashika.render(scene, eror=0.1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"load\(\) got an unexpected keyword argument 'stirct'; did you mean 'strict'\?"):
        tashika.load("a.obj", stirct=True)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="unexpected keyword argument 'flavour'$"):
        tashika.render(scene, flavour=1)  # type: ignore[call-arg]


def lamp_over_floor(*, two_sided: bool = False, **camera: object) -> tashika.Scene:
    white = tashika.Material.diffuse((0.8, 0.5, 0.25))
    return tashika.Scene.build(
        meshes=[
            tashika.Mesh(FLOOR, QUAD, material="white", name="floor"),
            tashika.Mesh(
                LAMP,
                QUAD,
                material=tashika.Material.diffuse(0).emitting((3, 2, 1), two_sided=two_sided),
                name="lamp",
            ),
        ],
        materials={"white": white},
        **camera,
    )


def test_a_pixel_is_the_sum_over_the_lights() -> None:
    # The view is so narrow that the whole pixel shows one point, whose position is known to 5e-7 m.
    camera = tashika.Camera((1.2, 0.3, 0), (0.4, 0, 0.2), vertical_fov=5e-5, size=(1, 1))
    scene = lamp_over_floor(camera=camera)
    lights = tashika.vpls(scene, count=500, clamp="off")
    [found] = tashika.exact(scene, [(0, 0)], vpls=lights)

    point, up = np.float64([0.4, 0, 0.2]), np.float64([0, 1, 0])
    towards = lights.positions - point
    distance = np.linalg.norm(towards, axis=1)
    direction = towards / distance[:, None]
    geometric = (
        np.maximum(direction @ up, 0) * np.maximum(-(direction * lights.normals).sum(1), 0) / distance**2
    )
    assert np.count_nonzero(geometric) == lights.provenance["direct"] > 100
    by_hand = np.float64([0.8, 0.5, 0.25]) / np.pi * (geometric @ lights.intensities)
    # The relative tolerance is 4e-6 for the position of the point, which is 0.5 m from the lamp,
    # and the rounding of float32 elsewhere.
    assert np.allclose(found, by_hand, rtol=1e-5)


def test_a_built_scene_is_the_loaded_one(tmp_path: Path) -> None:
    rows = [f"v {x} {y} {z}" for x, y, z in np.concatenate([FLOOR, LAMP])]
    rows += [
        "mtllib a.mtl",
        "o floor",
        "usemtl white",
        "f 1 2 3",
        "f 1 3 4",
        "o lamp",
        "usemtl lamp",
        "f 5 6 7",
        "f 5 7 8",
    ]
    (tmp_path / "a.obj").write_text("\n".join(rows))
    (tmp_path / "a.mtl").write_text("newmtl white\nKd 0.8 0.5 0.25\nnewmtl lamp\nKd 0 0 0\nKe 3 2 1\n")
    # Surfaces of such files emit on both sides.
    loaded, built = tashika.load(tmp_path / "a.obj"), lamp_over_floor(two_sided=True)
    assert loaded.triangles == built.triangles == {"stored": 4, "instanced": 4}
    images = [tashika.render(scene, size=(24, 16), vpls=200, truth="vpl") for scene in (loaded, built)]
    assert images[0]["radiance"].max() > 1, "the lamp is in the picture"
    for name in images[0]:
        assert np.array_equal(images[0][name], images[1][name], equal_nan=True), name


def test_normals_and_texture_coordinates_are_taken() -> None:
    tilted = np.tile(np.float32([0.6, 0.8, 0]), (4, 1))
    mesh = tashika.Mesh(FLOOR, QUAD, material=tashika.Material.diffuse(0.5), normals=tilted, uvs=FLOOR[:, :2])
    scene = tashika.Scene.build([mesh], camera=tashika.Camera((0, 3, 0.1), (0, 0, 0)), sky=1.0)
    normal = tashika.render(scene, size=(4, 4), vpls=50, passes=1)["normal"]
    assert np.allclose(normal[2, 2], tilted[0], atol=1e-6)


@pytest.mark.parametrize(
    "material",
    [
        tashika.Material.diffuse(0.5),
        tashika.Material.phong(0.3, 0.5, 40),
        tashika.Material.conductor((0.9, 0.7, 0.3), 0.2),
        tashika.Material.coated(0.5, alpha=0.2),
        tashika.Material.mirror(0.9),
        tashika.Material.glass(ior=1.3),
        tashika.Material.phong(np.full((2, 2, 3), 0.3), np.full((2, 2), 0.5), 40),
        tashika.Material.coated(np.full((2, 2), 128, np.uint8), alpha=np.full((2, 2), 0.2)),
        tashika.Material.conductor(0.9, np.linspace(0, 0.5, 8)[None, :]),
        tashika.Material.mirror(np.ones((1, 1))).emitting(np.ones((2, 2, 3))),
    ],
    ids=repr,
)
def test_materials_are_seen(material: tashika.Material) -> None:
    sun = tashika.Light.directional((0.2, -1, 0), 3)
    camera = tashika.Camera((0, 3, 0.1), (0, 0, 0), vertical_fov=20)
    scene = tashika.Scene.build(
        [tashika.Mesh(FLOOR, QUAD, material=material)], lights=[sun], camera=camera, sky=0.5
    )
    radiance = tashika.render(scene, size=(6, 4), vpls=100, gather=16, error=0.5)["radiance"]
    assert np.isfinite(radiance).all() and (radiance > 0).all()


def test_images_are_on_surfaces_where_their_coordinates_say() -> None:
    # Seen from above with -z up, the floor's picture is upright, on a film as large as the floor.
    uvs = np.float32([[0, 0], [0, 1], [1, 1], [1, 0]])
    camera = tashika.Camera.orthographic((0, 3, 0), (0, 0, 0), 2, up=(0, 0, -1), size=(40, 20))
    picture = np.random.default_rng(7).uniform(0.1, 0.9, (4, 8, 3)).astype(np.float32)

    def albedo(picture: np.ndarray) -> np.ndarray:
        wide = FLOOR * np.float32([2, 1, 1])
        # One texel per pixel, in squares of equal texels. The middles of the squares are compared,
        # where no other colour is blended in.
        material = tashika.Material.diffuse(picture.repeat(5, 0).repeat(5, 1))
        scene = tashika.Scene.build(
            [tashika.Mesh(wide, QUAD, material=material, uvs=uvs)], camera=camera, sky=1
        )
        return tashika.render(scene, vpls=50, gather=64, error=0.5)["albedo"].reshape(4, 5, 8, 5, 3)[:, 2, :, 2]

    assert np.allclose(albedo(picture), picture, atol=1e-4)
    assert np.allclose(albedo(picture[:, :, 0]), picture[:, :, :1], atol=1e-4), "gray"
    stored = np.uint8(np.round(255 * picture))
    decoded = np.where(stored / 255 <= 0.04045, stored / 255 / 12.92, ((stored / 255 + 0.055) / 1.055) ** 2.4)
    assert np.allclose(albedo(stored), decoded, atol=1e-4), "bytes are sRGB"


def test_a_map_of_the_sky_is_turned_as_documented() -> None:
    sky = np.zeros((3, 4, 3), np.float32)
    # Up is red, the middle columns (-z) green, the next (+x) blue; texels are 60 and 90 degrees
    # wide.
    sky[0], sky[1:, 1:3] = (1, 0, 0), (0, 1, 0)
    sky[1:, 3] = (0, 0, 1)
    scene = tashika.Scene.build([], sky=sky)

    def seen(towards: tuple[float, float, float]) -> np.ndarray:
        up = (0, 0, 1) if towards[1] else (0, 1, 0)
        camera = tashika.Camera((0, 0, 0), towards, up=up, vertical_fov=1, size=(1, 1))
        return tashika.render(tashika.Scene.build([], sky=sky, camera=camera), vpls=10, passes=1)["radiance"][0, 0]

    assert scene.triangles["stored"] == 0
    assert np.allclose(seen((0, 1, 0)), (1, 0, 0), atol=0.02)
    assert np.allclose(seen((0, -0.6, -1)), (0, 1, 0), atol=0.02)
    assert np.allclose(seen((0, 0.1, 1))[1], 0, atol=0.02), "behind"
    right = seen((1, -0.6, 0.1))
    assert right[2] > 0.4 and right[0] < 0.02


def test_transforms_place_a_mesh_by_columns() -> None:
    places = np.stack([np.eye(4), np.diag([0.5, 1, 0.5, 1]), np.eye(4)])
    places[1, :3, 3], places[2, :3, 3] = (3, 0, 0), (0, 0, 3)
    white = tashika.Material.diffuse(1)
    camera = tashika.Camera.orthographic((0, 9, 0), (0, 0, 0), 8, up=(0, 0, -1), size=(8, 8))
    mesh = tashika.Mesh(FLOOR, QUAD, material=white, transforms=places)
    scene = tashika.Scene.build([mesh], camera=camera, sky=1)
    assert scene.triangles == {"stored": 2, "instanced": 6}
    covered = tashika.render(scene, vpls=10, gather=256, error=0.5)["coverage"]
    wanted = np.zeros((8, 8))
    wanted[3:5, 3:5] = wanted[6:8, 3:5] = 1
    # The copy at x = 3 is half as large and covers a quarter of each of four pixels.
    wanted[3:5, 6:8] = 0.25
    assert np.allclose(covered, wanted, atol=0.05)
    for wrong, message in [
        (np.eye(3), r"the shape \[3, 3\]; expected the shape \(k, 4, 4\)"),
        (np.ones((4, 4)), "the last row .* expected 0, 0, 0, 1"),
        ([["a"]], "an array of <U1; expected an array of numbers"),
    ]:
        with pytest.raises(tashika.OptionError, match=message):
            tashika.Mesh(FLOOR, QUAD, material=white, transforms=wrong)


def test_a_spot_lights_its_cone() -> None:
    spot = tashika.Light.spot((0, 1, 0), (0, -1, 0), 5, inner=15, outer=30)
    camera = tashika.Camera.orthographic((0, 3, 0), (0, 0, 0), 2, up=(0, 0, -1), size=(41, 41))
    floor = tashika.Mesh(FLOOR, QUAD, material=tashika.Material.diffuse(0.5))
    scene = tashika.Scene.build([floor], lights=[spot], camera=camera)
    row = tashika.render(scene, vpls=10, gather=16, clamp="off", method="exact")["radiance"][20, :, 0]
    x = np.abs(np.linspace(-1, 1, 42)[:-1] + 1 / 41)
    assert np.allclose(row[20], 0.5 / np.pi * 5, rtol=0.01), "I ρ/π at one metre"
    inside = x < np.tan(np.radians(15)) - 0.05
    assert np.allclose(row[inside], 0.5 / np.pi * 5 / (1 + x[inside] ** 2) ** 1.5, rtol=0.01)
    assert (row[x > np.tan(np.radians(30)) + 0.05] == 0).all()
    fading = row[(x > 0.36) & (x < 0.5)]
    assert ((fading > 0) & (fading < 0.7)).all()
    with pytest.raises(tashika.OptionError, match="0 <= inner < outer <= 180"):
        tashika.Light.spot((0, 1, 0), (0, -1, 0), 5, inner=30, outer=30)


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        (np.zeros((2, 2, 4)), r"reflectance = an array of the shape \[2, 2, 4\]; expected a number, three"),
        (np.zeros((0, 2)), r"the shape \[0, 2\]"),
        ("red", "reflectance = an array of <U3"),
        (None, "an array of object"),
    ],
)
def test_pictures_that_cannot_be_are_refused(picture: object, message: str) -> None:
    with pytest.raises(tashika.OptionError, match=message):
        tashika.Material.diffuse(picture)
    with pytest.raises(tashika.OptionError, match="reflectance = a colour below zero"):
        tashika.Material.diffuse(np.full((1, 1), -0.5))
    with pytest.raises(tashika.InputError, match="environment"):
        tashika.Scene.build([], sky=np.full((1, 1), np.nan))


def test_what_is_missing_is_made_and_told() -> None:
    scene = tashika.Scene.build([tashika.Mesh(FLOOR, QUAD, material=tashika.Material.diffuse(1))])
    assert len(scene.cameras) == 1 and any("no camera" in note for note in scene.notes)
    named = tashika.Camera((0, 1, 0.1), (0, 0, 0), name="top", size=(20, 10))
    scene = tashika.Scene.build([], camera=named, sky=1)
    assert scene.cameras == {"top": (20, 10)} and any("no triangle" in note for note in scene.notes)
    assert tashika.render(scene, vpls=10, camera="top", passes=1).size == (20, 10)


def test_arrays_that_cannot_be_are_refused() -> None:
    white = tashika.Material.diffuse(1)

    def refused(error: type[Exception], message: str, *arrays: object, **named: object) -> None:
        with pytest.raises(error, match=message) as caught:
            tashika.Scene.build([tashika.Mesh(*arrays, **{"material": white, **named})])
        assert isinstance(caught.value, tashika.Error)

    refused(
        tashika.OptionError,
        r"vertices = an array of the shape \[4, 2\]; expected the shape \(n, 3\)",
        FLOOR[:, :2],
        QUAD,
    )
    refused(
        tashika.OptionError,
        "triangles = an array of float64; expected an array of integers",
        FLOOR,
        QUAD * 1.0,
    )
    refused(tashika.OptionError, "triangles = -1; expected indices from 0", FLOOR, QUAD - 1)
    refused(tashika.InputError, "vertex index 4; expected an index below 4", FLOOR, QUAD + 1)
    refused(tashika.InputError, "3 normals for 4 vertices", FLOOR, QUAD, normals=FLOOR[:3])
    refused(
        tashika.InputError,
        "material = red; expected a Material, or one of the scene's",
        FLOOR,
        QUAD,
        material="red",
    )
    refused(tashika.InputError, "reflectance", FLOOR, QUAD, material=tashika.Material.diffuse(-1))
    with pytest.raises(tashika.OptionError, match="a point other than the eye"):
        tashika.Camera((0, 0, 0), (0, 0, 0))
    with pytest.raises(tashika.InputError, match="emitter 0"):
        tashika.Scene.build([], lights=[tashika.Light.point((0, float("nan"), 0), 1)])
    # Invisible triangles are omitted and counted.
    scene = tashika.Scene.build([tashika.Mesh(FLOOR, [[0, 1, 2], [0, 1, 1]], material=white, name="odd")])
    assert scene.triangles_without_area == 1 and not any("area" in note for note in scene.notes)


def test_files_that_cannot_be_are_refused(tmp_path: Path) -> None:
    with pytest.raises(tashika.FileError, match="absent.obj") as caught:
        tashika.load(tmp_path / "absent.obj")
    assert isinstance(caught.value, OSError)
    (tmp_path / "a.fbx").touch()
    with pytest.raises(tashika.UnsupportedError, match=r"scenes are read from \.pbrt"):
        tashika.load(tmp_path / "a.fbx")
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")
    assert len(tashika.load(tmp_path / "a.obj").notes) >= 1
    with pytest.raises(tashika.InputError, match="because of strict=True"):
        tashika.load(tmp_path / "a.obj", strict=True)
    (tmp_path / "a.mtl").write_text("newmtl one\nmap_Kd gone.png\n")
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one\nf 1 2 3\n")
    with pytest.raises(tashika.FileError, match=r"(?s)allow_missing=True.*a\.mtl:2: .*gone.png"):
        tashika.load(tmp_path / "a.obj")
    assert any("gone.png" in note for note in tashika.load(tmp_path / "a.obj", allow_missing=True).notes)
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(tashika.InputError, match="nothing to render"):
        tashika.load(tmp_path / "a.obj")
    (tmp_path / "a.exr").write_text("no image")
    with pytest.raises(tashika.InputError, match="an OpenEXR image"):
        tashika.read(tmp_path / "a.exr")


@pytest.mark.parametrize(
    ("named", "message"),
    [
        ({"camera": "side"}, "camera = side; expected one of the scene's: main"),
        ({"size": (0, 4)}, "size = 0x4; expected 1 to 65536 pixels a side"),
        ({"crop": (30, 0, 4, 4)}, "crop = 30,0,4,4; expected"),
        ({"method": "Tashika"}, "method = Tashika; expected one of exact, .*, path"),
        ({"error": 0}, "error = 0; expected above 0"),
        ({"confidence": 1}, "confidence = 1; expected"),
        ({"claim": "proven"}, "claim = proven; expected one of calibrated, certified, audited"),
        ({"truth": "real"}, "truth = real; expected vpl or clamped or transport"),
        ({"claim": "certified", "truth": "transport"}, "claim = certified; expected calibrated"),
        ({"control": "red"}, "control = red; expected luminance or channels"),
        ({"vpls": "many"}, "vpls = many; expected a VplSet, or a number"),
        ({"vpls": 0}, "vpls = 0; expected 1 to"),
        ({"clamp": "far"}, "clamp = far; expected auto, off"),
        ({"clamp": -1}, "clamp = -1; expected auto, off"),
        ({"gather": 0}, "= 0; expected 1 to 1024"),
        ({"filter": "mitchell"}, "filter = mitchell; expected one of box, tent, gaussian, blackman-harris"),
        ({"tiles": "3/2"}, "tiles = 3/2; expected K/N"),
        ({"tiles": (0, 2)}, "tiles = 0/2; expected K/N"),
        ({"max_pairs": 0}, "max_pairs = 0; expected 1 or more"),
        ({"method": "path", "paths": 0}, "paths = 0; expected 1 to"),
        ({"threads": 100_000}, "threads = 100000; expected"),
    ],
)
def test_arguments_that_cannot_be_are_refused(
    tiny: tashika.Scene, named: dict[str, object], message: str
) -> None:
    with pytest.raises(tashika.OptionError, match=message) as caught:
        tashika.render(tiny, **named)
    assert isinstance(caught.value, ValueError)


def test_arguments_that_contradict_each_other_are_refused(tiny: tashika.Scene) -> None:
    for named, message in (
        ({"paths": 7}, "paths = 7; expected none with method tashika unless groups are asked for"),
        ({"method": "path", "vpls": 7}, "vpls = 7; expected none with method path"),
        ({"method": "mdlc", "truth": "transport"}, "truth = transport; expected vpl with method mdlc"),
    ):
        with pytest.raises(tashika.OptionError, match=message):
            tashika.render(tiny, size=(2, 2), **named)


def test_arguments_that_a_scene_leaves_without_meaning_are_warned_of(tmp_path: Path) -> None:
    (tmp_path / "fog.pbrt").write_text(
        "Integrator \"volpath\" Film \"rgb\" MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"\" \"fog\""
        " Camera \"perspective\" WorldBegin MediumInterface \"fog\" \"fog\" LightSource \"point\" Shape \"sphere\""
    )
    fog = tashika.load(tmp_path / "fog.pbrt")
    with pytest.warns(UserWarning, match="vpls means nothing to method path, which this scene needs"):
        tashika.render(fog, size=(2, 2), vpls=10, paths=7)


def test_a_scene_is_loaded_as_it_is_at_a_time(tmp_path: Path) -> None:
    (tmp_path / "s.pbrt").write_text(
        "Film \"rgb\" Camera \"perspective\" WorldBegin TransformTimes 1 3 ActiveTransform EndTime Translate 8 0 0"
        " Shape \"sphere\""
    )
    still, later = (tashika.load(tmp_path / "s.pbrt", at=at) for at in (None, 2))
    assert still.animated_seconds == later.animated_seconds == [1, 3]
    assert (still.time, later.time) == (None, 2)
    assert tashika.builtin("tiny").animated_seconds is None
    blurred = tashika.load(tmp_path / "s.pbrt", shutter=(1, 2))
    methods = [tashika.render(s, size=(4, 4), vpls=100, error=0.5).metadata["method"] for s in (later, blurred)]
    assert methods[0] != "path" and methods[1] == "path"
    assert (tashika.vpls(later, count=50).instants == [0.5]).all()
    lights = tashika.vpls(blurred, count=200, instants=4)
    assert [int(4 * share) for share in lights.instants] == [0, 1, 2, 3]
    assert lights.instant.shape == (len(lights),) and set(lights.instant) <= {0, 1, 2, 3}
    assert (np.diff(lights.instant.astype(int)) >= 0).all()
    lights.save(tmp_path / "moving.vpl")
    again = tashika.VplSet.load(tmp_path / "moving.vpl")
    sums = [tashika.render(blurred, size=(4, 4), vpls=v, claim="certified") for v in (lights, again)]
    assert (sums[0]["radiance"] == sums[1]["radiance"]).all()
    assert sums[0].metadata["vpls.instants"] == 4
    with pytest.raises(tashika.OptionError, match="instants = 0; expected 1 to 1024"):
        tashika.vpls(blurred, instants=0)
    with pytest.raises(tashika.OptionError, match="instants"):
        tashika.render(blurred, size=(4, 4), vpls=lights, instants=8)
    again = still.at(2)
    assert again.time == 2 and again.animated_seconds == [1, 3]
    pictures = [tashika.render(s, size=(8, 4), vpls=100, passes=1)["depth"] for s in (still, later, again)]
    assert (pictures[1] == pictures[2]).all() and (pictures[0] != pictures[1]).any()
    assert tashika.render(again.at(0, shutter=(1, 2)), size=(4, 4), paths=4).metadata["method"] == "path"
    with pytest.raises(tashika.OptionError, match="at = inf; expected a finite number of seconds"):
        tashika.load(tmp_path / "s.pbrt", at=float("inf"))
    with pytest.raises(tashika.OptionError, match="at = 1; expected a scene that was loaded"):
        tashika.Scene.build([tashika.Mesh(FLOOR, QUAD, material=tashika.Material.diffuse(1))]).at(1)


def test_lights_that_are_asked_for_are_beside_the_scenes_or_instead(tmp_path: Path) -> None:
    lamp = "point:0,1,0,50"
    lit = tashika.load("builtin:tiny", environment="sky:elevation=40,azimuth=120", lights=[lamp])
    assert lit.light_changes == ["environment sky:elevation=40,azimuth=120,turbidity=3", f"light {lamp}"]
    plain = tashika.load("builtin:tiny")
    pictures = [tashika.render(s, size=(8, 8), method="path", paths=4) for s in (lit, plain)]
    assert pictures[0]["radiance"].mean() > 1.2 * pictures[1]["radiance"].mean()
    assert f"light {lamp}" in pictures[0].metadata["scene.changes"]
    with pytest.raises(tashika.OptionError, match="moon"):
        tashika.load("builtin:tiny", lights=["moon"])
    with pytest.raises(tashika.FileError, match=r"absent\.hdr"):
        tashika.load("builtin:tiny", environment=str(tmp_path / "absent.hdr"))
