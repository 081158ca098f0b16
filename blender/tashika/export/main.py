"""Writes a scene as glTF, and what glTF does not carry as options of the program.

    blender --background --factory-startup --python main.py -- REQUEST.json
    python main.py -- REQUEST.json                                    (where Blender is the Python module bpy)

The request names the file of the scene (`blend`), the `scene` and its `view_layer`, the `size` of the picture, the `folder` to write
to, and whether scripts of the file may run (`scripts`). The folder gets `scene.glb` and `scene.json`: `options` of the program and
`notes` of what was left out, or why it `failed`.
"""

import json
import sys
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from export import camera, lights, objects, world
from export.words import CannotBeRendered, Notes

#: Options of Blender's exporter; those that a version of it does not have are left out.
EXPORTER = {
    "export_format": "GLB",
    "use_active_scene": True,
    "export_cameras": True,
    "export_lights": True,
    # Watts become W/sr, not candela, which is what the program takes numbers for.
    "export_import_convert_lighting_mode": "COMPAT",
    "export_animations": False,
    "export_current_frame": True,
    "export_apply": False,
    "export_skins": False,
    "export_morph": False,
    "export_yup": True,
    "export_image_format": "AUTO",
    "export_image_webp_fallback": True,
}


class Taker(bpy.types.RenderEngine):
    """A render engine that renders nothing: only engines are given the scene as renders see it."""

    bl_idname = "TASHIKA_TAKER"
    bl_label = "tashika: take the scene apart"
    bl_use_preview = False

    #: Called with the depsgraph; what it raised.
    take = None
    raised = None

    def update(self, _data, depsgraph):
        try:
            Taker.take(depsgraph)
        except Exception as error:  # Blender would print it and go on.
            Taker.raised = error

    def render(self, _depsgraph):
        pass


def make_plain(request, notes):
    """The plain scene, and the options of the program that go with it."""
    made = {}
    plain = bpy.data.scenes.new("plain")

    def take(depsgraph):
        # Blender comes with every view layer, whichever is asked for.
        if depsgraph.view_layer.name != request["view_layer"]:
            return
        size, folder = request["size"], Path(request["folder"])
        objects.add(depsgraph, plain, notes)
        lights.add(depsgraph, plain, notes)
        made["options"] = camera.add(depsgraph, plain, size, request["region"], notes)
        made["options"] += world.options(depsgraph.scene.world, folder, notes)

    Taker.take = staticmethod(take)
    bpy.utils.register_class(Taker)
    scene = bpy.data.scenes[request["scene"]]
    # Materials are exported as the scene that is shown has them at its frame.
    plain.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    settings = scene.render
    settings.engine = Taker.bl_idname
    settings.resolution_x, settings.resolution_y = request["size"]
    settings.resolution_percentage = 100
    settings.use_border = settings.use_multiview = settings.use_compositing = settings.use_sequencer = False
    bpy.ops.render.render(scene=scene.name)
    if Taker.raised:
        raise Taker.raised
    if "options" not in made:
        raise CannotBeRendered(f"the scene {scene.name} renders nothing")
    return plain, made["options"]


def export(plain, path):
    bpy.context.window.scene = plain
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    options = {name: value for name, value in EXPORTER.items() if name in known}
    bpy.ops.export_scene.gltf(filepath=str(path), **options)


def _in_short(error):
    """The last line of an error that says what is wrong: operators give whole tracebacks."""
    lines = [
        line for line in str(error).splitlines() if line.strip() and not line.startswith((" ", "Location:"))
    ]
    return lines[-1] if lines else type(error).__name__


def main():
    request = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
    folder = Path(request["folder"])
    notes = Notes()
    try:
        bpy.ops.wm.open_mainfile(filepath=request["blend"], load_ui=False, use_scripts=request["scripts"])
        plain, options = make_plain(request, notes)
        export(plain, folder / "scene.glb")
        said = {"options": options, "notes": notes.lines()}
    except CannotBeRendered as reason:
        said = {"failed": str(reason)}
    except Exception as error:  # Of others' code; whoever asked has to be told.
        traceback.print_exc()
        said = {"failed": f"the scene cannot be written as glTF: {_in_short(error)}"}
    (folder / "scene.json").write_text(json.dumps(said))


if __name__ == "__main__":
    main()
