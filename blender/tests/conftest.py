"""Blender without a window, the add-on installed from its zip, a scene to fill, and the program.

`pip install bpy` (of the Python that it is made for) has Blender as a module; without it, or without the program, these tests are
skipped. TASHIKA names the program; otherwise it is that of `cargo build --release`.
"""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
#: Preferences and extensions go here, not to the user's; Blender looks when it is imported.
USER = tempfile.mkdtemp(prefix="tashika-tests-")
os.environ["BLENDER_USER_RESOURCES"] = USER
atexit.register(shutil.rmtree, USER, ignore_errors=True)

try:
    import bpy
except ImportError as error:
    bpy = None
    collect_ignore_glob = ["test_*.py"]
    WHY_NOT = f"bpy cannot be imported by Python {sys.version.split()[0]} ({error}): pip install bpy"


def pytest_terminal_summary(terminalreporter):
    if bpy is None:
        terminalreporter.write_line(f"all tests of the add-on for Blender are skipped: {WHY_NOT}")


def pytest_sessionfinish(session, exitstatus):
    # That there is nothing to run is no failure then.
    if bpy is None and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.OK


@pytest.fixture(scope="session")
def addon():
    """The add-on's modules, installed from the zip that Blender's own tool builds."""
    tool = Path(bpy.utils.resource_path("LOCAL"), "scripts/addons_core/bl_pkg/cli/blender_ext.py")
    made = Path(USER, "tashika.zip")
    source = ROOT / "blender" / "tashika"
    command = [sys.executable, tool, "build", "--source-dir", source, "--output-filepath", made]
    subprocess.run(command, check=True, capture_output=True)
    bpy.ops.extensions.package_install_files(filepath=str(made), repo="user_default", enable_on_install=True)
    name = "bl_ext.user_default.tashika"
    assert name in bpy.context.preferences.addons
    parts = {
        part: import_module(f"{name}.{part}") for part in ("engine", "exr", "panels", "program", "settings")
    }
    return SimpleNamespace(name=name, root=import_module(name), **parts)


@pytest.fixture(scope="session")
def program():
    """The program."""
    found = Path(os.environ.get("TASHIKA") or ROOT / "target/release/tashika")
    if not found.is_file():
        pytest.skip(f"{found} is not there: cargo build --release, or set TASHIKA to the program")
    return found.resolve()


@pytest.fixture
def scene(addon, program, tmp_path, monkeypatch):
    """An empty scene that this engine renders, small, with the program; temporary files are kept in the folder of the test."""
    ours = bpy.context.preferences.addons[addon.name].preferences
    ours.program, ours.threads, ours.keep_files = str(program), 0, True
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    before = bpy.context.window.scene
    new = bpy.data.scenes.new("scene")
    bpy.context.window.scene = new
    new.render.engine = "TASHIKA"
    new.render.resolution_x, new.render.resolution_y = 48, 36
    yield new
    bpy.context.window.scene = before
    bpy.data.scenes.remove(new)
    bpy.data.orphans_purge(do_recursive=True)


@pytest.fixture
def asked(addon, monkeypatch):
    """Asks the program for something else than the panel can say."""

    def ask(*options):
        monkeypatch.setattr(addon.settings.TashikaSettings, "options", lambda _: list(options))

    return ask


@pytest.fixture
def render(tmp_path):
    """Renders a scene; the colours, lines from the top."""

    def of(scene):
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
        settings.exr_codec = "ZIP"
        scene.render.filepath = str(tmp_path / "still.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return pixels(scene.render.filepath)

    return of


def pixels(path):
    """Colours and opacity of an image as Blender reads it, lines from the top."""
    image = bpy.data.images.load(str(path), check_existing=False)
    width, height = image.size
    samples = numpy.empty(width * height * 4, dtype=numpy.float32)
    image.pixels.foreach_get(samples)
    bpy.data.images.remove(image)
    return samples.reshape(height, width, 4)[::-1]


def folder(tmp_path):
    """Where the temporary files of the only view layer of the only render are."""
    (found,) = [path for path in tmp_path.glob("tashika-*") if path.is_dir()]
    return found / "1"
