"""The render engine: from a scene to a picture, by two other programs."""

import html
import json
import re
import shutil
import sys
import tempfile
import traceback
from pathlib import Path

import bpy
import numpy

from . import exr, preferences, program

EXPORTER = Path(__file__).parent / "export" / "main.py"
#: Passes beside the colours: name in Blender, and channel of the OpenEXR file.
PASSES = {"Half width": "half_width.Y", "Claim": "claim.id"}
#: What was said of the last picture of each scene, by its name.
statements = {}


class TashikaRenderEngine(bpy.types.RenderEngine):
    bl_idname = "TASHIKA"
    bl_label = "tashika"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def update(self, data, depsgraph):
        """Writes the scene to a file, while nothing else can change it."""
        scene = depsgraph.scene.original
        # One folder for all view layers of a frame.
        if getattr(self, "folder", None) is None:
            self.folder, self.layers = Path(tempfile.mkdtemp(prefix="tashika-")), 0
        try:
            data.libraries.write(str(self.folder / "scene.blend"), {scene}, path_remap="ABSOLUTE")
        except (RuntimeError, OSError) as error:
            self.report({"ERROR"}, f"the scene cannot be written to {self.folder}: {error}")

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name in PASSES:
            self.register_pass(scene, renderlayer, name, 1, "X", "VALUE")

    def render(self, depsgraph):
        """Renders the scene that was written."""
        ours = preferences.of(bpy.context)
        scene = depsgraph.scene
        statements.pop(scene.name, None)
        # Blender writes what there is, and does not expect that to be nothing.
        self.end_result(self._begin(depsgraph, _region(scene.render, self.resolution_x, self.resolution_y)))
        try:
            if (self.folder / "scene.blend").is_file():
                self._render(depsgraph, ours)
        except program.Failure as failure:
            self._fail(scene.name, str(failure))
        except exr.Unreadable as failure:
            self._fail(scene.name, f"the picture cannot be read: {failure}")
        except Exception as failure:  # A fault of ours: Blender would show a black picture.
            traceback.print_exc()
            self._fail(scene.name, f"fault of the add-on: {type(failure).__name__}: {failure}")

    def render_frame_finish(self):
        """Removes the files, after the last view layer."""
        if preferences.of(bpy.context).keep_files:
            self.report({"INFO"}, f"tashika: the files of this render are in {self.folder}")
        else:
            shutil.rmtree(self.folder, ignore_errors=True)
        self.folder = None

    def _fail(self, name, words):
        statements[name] = words
        self.report({"ERROR"}, words)

    def _render(self, depsgraph, ours):
        # Before the export, which is in vain without it.
        path = program.find(bpy.path.abspath(ours.program) if ours.program else "")
        self.layers += 1
        folder = self.folder / str(self.layers)
        folder.mkdir()
        size = [self.resolution_x, self.resolution_y]
        region = _region(depsgraph.scene.render, *size)
        taken = self._export(depsgraph, folder, size, region)
        if taken is None:
            return
        for note in taken["notes"]:
            self.report({"WARNING"}, f"tashika: {note}")
        picture = folder / "picture.exr"
        command = [path, "render", folder / "scene.glb", *taken["options"]]
        command += depsgraph.scene.original.tashika.options()
        command += ["--threads", ours.threads, "--log", "json"]
        command += ["-o", picture, "--json", picture.with_suffix(".json")]
        log = program.Log(self._tell)
        exit_code = program.run(command, self._stopped, log.hear)
        for note in log.notes:
            self.report({"INFO"}, f"tashika: {note}")
        if not picture.is_file():
            if self._stopped():
                return
            raise log.failure(exit_code)
        if exit_code not in program.WITH_PICTURE and not self._stopped():
            raise log.failure(exit_code)
        self._show(depsgraph, exr.File(picture), region)
        self._state(depsgraph.scene.name, picture.with_suffix(".html"), exit_code)

    def _export(self, depsgraph, folder, size, region):
        """Writes the scene as glTF to the folder; options and notes, or nothing if the user wants to stop."""
        self._tell("writing the scene", 0.0)
        request = {
            "blend": str(self.folder / "scene.blend"),
            "scene": depsgraph.scene.name,
            "view_layer": depsgraph.view_layer.name,
            "size": size,
            "region": region,
            "folder": str(folder),
            "scripts": bpy.context.preferences.filepaths.use_scripts_auto_execute,
        }
        (folder / "request.json").write_text(json.dumps(request))
        # Where Blender is a Python module, there is no program but Python.
        blender = bpy.app.binary_path
        before = [blender, "--background", "--factory-startup", "--python"] if blender else [sys.executable]
        said = []
        program.run([*before, EXPORTER, "--", folder / "request.json"], self._stopped, said.append)
        if self._stopped():
            return None
        try:
            taken = json.loads((folder / "scene.json").read_text())
        except (OSError, ValueError):
            last = next((line for line in reversed(said) if line.strip()), "it said nothing")
            raise program.Failure(f"the scene cannot be written as glTF: {last.strip()}") from None
        if "failed" in taken:
            raise program.Failure(taken["failed"])
        return taken

    def _stopped(self):
        """Whether the user wants to stop."""
        return self.test_break()

    def _tell(self, words, share):
        self.update_stats("", words)
        self.update_progress(share)

    def _begin(self, depsgraph, region):
        """The result of this view layer, which is of the region alone."""
        return self.begin_result(0, 0, region[2], region[3], layer=depsgraph.view_layer.name)

    def _show(self, depsgraph, file, region):
        """Puts the picture into the result."""
        width, height = region[2:]
        if (file.width, file.height) != (width, height):
            raise exr.Unreadable(f"it has {file.width}x{file.height} pixels, not {width}x{height}")
        for name in PASSES:
            self.add_pass(name, 1, "X", layer=depsgraph.view_layer.name)
        result = self._begin(depsgraph, region)
        if not result.layers:
            self.end_result(result, cancel=True)
            return
        passes = result.layers[0].passes
        _fill(passes["Combined"], _combined(file, depsgraph.scene.render.film_transparent))
        for name, channel in PASSES.items():
            _fill(passes[name], file.plane(channel))
        self.end_result(result)

    def _state(self, name, page, exit_code):
        """Keeps what the page says of the picture."""
        text = page.read_text(encoding="utf-8") if page.is_file() else ""
        found = re.search(r"<h1>(?:[^:<]*: )?([^<]*)</h1>", text)
        words = html.unescape(found[1]) if found else ""
        if self._stopped():
            words = f"cancelled; {words}"
        statements[name] = words
        if exit_code in (4, 5):
            self.report({"WARNING"}, f"tashika: {words}")


def _region(settings, width, height):
    """What of the picture is rendered: x, y, width, height in pixels from the top left."""
    if not settings.use_border:
        return [0, 0, width, height]
    # As Blender does it: in 32 bits, rounded down.
    left, right = (
        int(numpy.float32(x) * numpy.float32(width)) for x in (settings.border_min_x, settings.border_max_x)
    )
    low, high = (
        int(numpy.float32(y) * numpy.float32(height)) for y in (settings.border_min_y, settings.border_max_y)
    )
    return [left, height - high, right - left, high - low]


def _combined(file, transparent):
    """Colours with opacity, which is 1 unless the film is transparent."""
    colors = file.plane("R", "G", "B")
    if transparent and "coverage.A" in file:
        cover = file.plane("coverage.A")
        return numpy.concatenate([colors * cover, cover], axis=-1)
    return numpy.concatenate([colors, numpy.ones_like(colors[..., :1])], axis=-1)


def _fill(one, samples):
    """Sets the samples of a pass."""
    one.rect.foreach_set(samples.astype(numpy.float32).ravel())


def register():
    bpy.utils.register_class(TashikaRenderEngine)


def unregister():
    bpy.utils.unregister_class(TashikaRenderEngine)
