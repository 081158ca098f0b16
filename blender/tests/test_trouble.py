"""What goes wrong is told in words that help, and rendering can be stopped."""

import bpy
import numpy
import pytest
from conftest import folder
from scenes import camera, cube_on_plane, plane


def preferences(addon):
    return bpy.context.preferences.addons[addon.name].preferences


def test_a_wrong_path_is_named_with_the_way_to_a_right_one(scene, render, addon, tmp_path):
    cube_on_plane(scene)
    preferences(addon).program = str(tmp_path / "nowhere")
    with pytest.raises(
        RuntimeError, match=r"nowhere, which the preferences .* is no program; .*cargo install --path"
    ):
        render(scene)
    assert "cargo install" in addon.engine.statements[scene.name]


def test_the_search_path_is_looked_at(scene, render, addon, program, monkeypatch, tmp_path, asked):
    asked("--method", "path", "--paths", "1")
    cube_on_plane(scene)
    preferences(addon).program = ""
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RuntimeError, match="the program tashika was not found; .*cargo install"):
        render(scene)
    (tmp_path / "tashika").symlink_to(program)
    assert render(scene)[..., :3].max() > 0.0


def test_errors_are_told_in_the_words_of_the_program(scene, render, asked):
    cube_on_plane(scene)
    asked("--error", "900%")
    with pytest.raises(RuntimeError, match=r"tashika: error: --error = 9; expected above 0, at most 1"):
        render(scene)
    asked("--camera", "nobody", "--method", "path")
    with pytest.raises(RuntimeError, match="tashika: .*nobody"):
        render(scene)


@pytest.mark.parametrize(
    ("without", "told"),
    [("camera", "the scene has no camera"), ("surfaces", "there is no surface to render")],
)
def test_scenes_that_cannot_be_rendered_say_why(scene, render, without, told):
    if without == "camera":
        plane(scene)
        # Blender itself refuses a scene without a camera.
        told = "[Cc]amera"
    else:
        camera(scene, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    with pytest.raises(RuntimeError, match=told):
        render(scene)


def stop_after(addon, monkeypatch, condition):
    """The user presses escape as soon as the condition holds."""
    state = {"asked": False}

    def stopped(_self):
        state["asked"] = state["asked"] or condition()
        return state["asked"]

    monkeypatch.setattr(addon.engine.TashikaRenderEngine, "_stopped", stopped)


def test_stopping_shows_what_is_finished(scene, render, addon, monkeypatch):
    """A render that would take days: that it ends is what is tested."""
    cube_on_plane(scene)
    scene.tashika.claim, scene.tashika.tolerance = "PIXELS", 0.1
    seen = []
    tell = addon.engine.TashikaRenderEngine._tell
    monkeypatch.setattr(
        addon.engine.TashikaRenderEngine,
        "_tell",
        lambda self, words, share: (seen.append(share), tell(self, words, share)),
    )
    stop_after(addon, monkeypatch, lambda: any(seen))
    picture = render(scene)
    assert addon.engine.statements[scene.name].startswith("cancelled; ")
    lit = picture[..., :3].sum(axis=-1) > 0.0
    assert lit.any() and not lit.all()


def test_stopping_before_anything_is_finished(scene, render, addon, monkeypatch, tmp_path):
    cube_on_plane(scene)
    stop_after(addon, monkeypatch, lambda: True)
    render(scene)
    assert not (folder(tmp_path) / "picture.exr").exists()
    assert scene.name not in addon.engine.statements


def test_temporary_files_are_removed(scene, render, addon, asked, tmp_path):
    asked("--method", "path", "--paths", "1")
    cube_on_plane(scene)
    preferences(addon).keep_files = False
    scene.view_layers.new("other")
    render(scene)
    render(scene)
    assert not list(tmp_path.glob("tashika-*"))


def test_standard_panels_are_shown_while_the_addon_is_on(addon):
    wanted = (
        "RENDER_PT_format", "RENDER_PT_output", "DATA_PT_lens", "DATA_PT_camera_dof", "DATA_PT_EEVEE_light", "DATA_PT_spot",
        "DATA_PT_camera_dof_aperture", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface", "EEVEE_MATERIAL_PT_context_material",
    )  # fmt: skip
    panels = {panel.__name__: panel for panel in bpy.types.Panel.__subclasses__()}
    assert [name for name in wanted if "TASHIKA" not in panels[name].COMPAT_ENGINES] == []
    assert "TASHIKA" not in panels["VIEWLAYER_PT_layer_passes"].COMPAT_ENGINES
    addon.root.unregister()
    try:
        assert not any("TASHIKA" in panels[name].COMPAT_ENGINES for name in wanted)
        assert not hasattr(bpy.types.Scene, "tashika")
    finally:
        addon.root.register()
    assert "TASHIKA" in panels["DATA_PT_lens"].COMPAT_ENGINES


class Layout:
    """What a panel draws on; each property has to be there."""

    def __init__(self):
        self.shown, self.layout = [], self

    def column(self):
        return self

    def prop(self, of, name, **_):
        assert name in of.bl_rna.properties, name
        self.shown.append(name)

    def label(self, text="", **_):
        self.shown.append(text)


def test_panels_show_what_is_asked_and_what_was_said(scene, addon, monkeypatch):
    scene.tashika.claim = "PIXELS"
    drawn = Layout()
    addon.panels.TASHIKA_PT_claim.draw(drawn, bpy.context)
    assert drawn.shown == ["claim", "tolerance", "confidence", "seed"]
    scene.tashika.claim, drawn = "DRAFT", Layout()
    addon.panels.TASHIKA_PT_claim.draw(drawn, bpy.context)
    assert drawn.shown == ["claim", "time_limit", "seed"]
    told = "at least 95 % of the pixels are within 10 % of light transport, 99 % sure"
    monkeypatch.setitem(addon.engine.statements, scene.name, told)
    drawn = Layout()
    addon.panels.TASHIKA_PT_result.draw(drawn, bpy.context)
    assert len(drawn.shown) > 1 and " ".join(drawn.shown) == told
    addon.panels.TASHIKA_PT_film.draw(Layout(), bpy.context)


def test_files_of_others_are_refused(addon, tmp_path):
    file = tmp_path / "picture.exr"
    for data in (
        b"",
        b"P6 1 1 255\n000",
        numpy.array([20000630, 2], "<i4").tobytes() + b"channels\0chlist\0\xff\xff\xff\x7f",
    ):
        file.write_bytes(data)
        with pytest.raises(addon.exr.Unreadable):
            addon.exr.File(file)
