"""Pictures through a configuration of OpenColorIO: displays and views of your own pipeline.

    import tashika.ocio

    pixels = tashika.ocio.display(image)                            # as $OCIO says, or else as ocio://default does
    tashika.ocio.save("kitchen.png", image, "sRGB - Display", "Un-tone-mapped",
                      config="show.ocio", exposure=1.5)

With radiance `c` (linear Rec. 709) and an exposure of `e` stops a pixel becomes
`round(255 · view(2ᵉ c))`. Here `view` is OpenColorIO's transform from linear Rec. 709 to that view
of that display, with values clipped to [0, 1]. These pixels are computed by OpenColorIO. Unlike all
other results of this package, they may differ between machines and versions of that library.

Needs `pip install tashika[ocio]`. Held to this by tests/test_ocio.py.
"""

from __future__ import annotations

import contextlib
import os
import struct
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import Image
from ._errors import Error, FileError, InputError, OptionError, UnsupportedError

if TYPE_CHECKING:
    import PyOpenColorIO
    from numpy.typing import NDArray

#: Configuration that is read if neither an argument nor the environment names one.
DEFAULT = "ocio://default"

#: Names of linear Rec. 709 in the configurations of the Academy, of its earlier versions and of
#: Blender.
_LINEAR_REC709 = (
    "lin_rec709_srgb",
    "Linear Rec.709 (sRGB)",
    "lin_rec709",
    "lin_srgb",
    "Linear Rec.709",
    "Utility - Linear - Rec.709",
    "Utility - Linear - sRGB",
)

#: The largest half: some views of OpenColorIO turn far brighter values black.
_BRIGHTEST = 65504.0


def display(
    image: Image,
    display: str | None = None,
    view: str | None = None,
    *,
    config: str | os.PathLike[str] | PyOpenColorIO.Config | None = None,
    from_space: str | None = None,
    exposure: float | None = 0.0,
    plane: str = "",
) -> NDArray[np.uint8]:
    """An image as a display shows it: bytes of shape (height, width, 3), rows from the top.

    - `display`, `view`: names in the configuration; by default its defaults.
    - `config`: a file (`.ocio`, `.ocioz`), a built-in configuration ("ocio://studio-config-latest")
      or a `PyOpenColorIO.Config`. By default it is the one that the environment variable OCIO
      names, or else "ocio://default", whose views are those of the installed version of
      OpenColorIO.
    - `from_space`: the configuration's name for linear Rec. 709, the space of the image. By default
      it is found by the usual names or by the role `aces_interchange`.
    - `exposure`: stops from -64 to 64, before the view; None puts the log-average at middle gray,
      as `Image.save` does. At 0, "radiance" looks as in any other program that shows the OpenEXR
      file with this configuration.
    - `plane`: a plane of colours, or of one channel as gray; by default "radiance".

    Pixels that were not rendered are black, and so are channels that are not a number; nothing is
    brighter than the largest half, 65504.

    Raises `OptionError` for an unknown name, with the known ones, `FileError` and `InputError` for
    configurations that cannot be read, `UnsupportedError` if OpenColorIO is not installed.
    """
    return _shown(image, display, view, config, from_space, exposure, plane)[0]


def save(
    path: str | os.PathLike[str],
    image: Image,
    display: str | None = None,
    view: str | None = None,
    *,
    config: str | os.PathLike[str] | PyOpenColorIO.Config | None = None,
    from_space: str | None = None,
    exposure: float | None = 0.0,
    plane: str = "",
) -> None:
    """Writes the result of `display` as a PNG file, whole or not at all.

    Pixels that were not rendered are transparent. The file does not record its display. Raises the
    exceptions of `display`, and `FileError` if the file cannot be written.
    """
    place = Path(path)
    if place.suffix.lower() != ".png":
        raise _option("path", place, "a file name ending in .png")
    pixels, rendered = _shown(image, display, view, config, from_space, exposure, plane)
    _write(place, _png(np.dstack([pixels, np.where(rendered, 255, 0).astype(np.uint8)])))


def _shown(
    image: Image,
    display: str | None,
    view: str | None,
    config: Any,
    from_space: str | None,
    exposure: float | None,
    plane: str,
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Returns the bytes, and a mask of the rendered pixels."""
    if exposure is not None and not -64 <= exposure <= 64:
        raise _option("exposure", exposure, "None, or stops from -64 to 64")
    colors = _colors(image, plane)
    stop = image.get("stop")
    rendered = np.ones(colors.shape[:2], bool) if stop is None else stop != 0
    processor = _processor(config, from_space, display, view)
    stops = _automatic_stops(colors[rendered]) if exposure is None else exposure
    with np.errstate(over="ignore"):
        colors *= np.float32(2.0**stops)
    np.nan_to_num(colors, copy=False, nan=0.0)
    np.clip(colors, -_BRIGHTEST, _BRIGHTEST, out=colors)
    processor.applyRGB(colors)
    np.nan_to_num(colors, copy=False, nan=0.0)
    pixels = (np.clip(colors, 0, 1) * 255 + np.float32(0.5)).astype(np.uint8)
    pixels[~rendered] = 0
    return pixels, rendered


def _colors(image: Image, plane: str) -> NDArray[np.float32]:
    """Returns red, green and blue of the plane, as a writable copy."""
    planes = image.planes

    def channels(name: str) -> list[int]:
        """Indices of red, green and blue; empty if the plane has no colour."""
        names = planes[name]["channels"]
        is_color = len(names) == 1 or set("RGB") <= set(names)
        if not is_color or image[name].dtype != np.float32:
            return []
        return [0, 0, 0] if len(names) == 1 else [names.index(channel) for channel in "RGB"]

    name = plane or "radiance"
    if name not in planes or not channels(name):
        raise _option("plane", name, f"one of {', '.join(filter(channels, planes))}")
    return np.ascontiguousarray(np.atleast_3d(image[name])[..., channels(name)])


def _automatic_stops(colors: NDArray[np.float32]) -> float:
    """Stops that put the log-average of the luminances at middle gray, as
    `film::automatic_stops`."""
    with np.errstate(over="ignore", invalid="ignore"):
        luminances = (colors @ np.array([0.2126, 0.7152, 0.0722], np.float32)).astype(np.float64)
    luminances = luminances[(luminances > 0) & np.isfinite(luminances)]
    if luminances.size == 0:
        return 0.0
    counted = luminances[luminances >= 1e-4 * luminances.mean()]
    return float(np.clip(np.log2(0.18) - np.log2(counted).mean(), -64, 64))


def _library() -> Any:
    try:
        import PyOpenColorIO
    except ModuleNotFoundError as error:
        raise UnsupportedError(
            "OpenColorIO is not installed for this Python; expected what `pip install tashika[ocio]` installs"
        ) from error
    return PyOpenColorIO


def _configuration(config: Any) -> tuple[Any, str]:
    """Returns the configuration, and its name for messages."""
    ocio = _library()
    if isinstance(config, ocio.Config):
        return config, config.getName() or "the configuration"
    name = os.fspath(config or os.environ.get("OCIO") or DEFAULT)
    is_file = not name.startswith("ocio://")
    if is_file and not os.path.isfile(name):
        raise FileError(
            f"{name}: there is no such file; expected a configuration of OpenColorIO, or {DEFAULT}"
        )
    try:
        return ocio.Config.CreateFromFile(name), name
    except (ocio.Exception, ocio.ExceptionMissingFile) as error:
        if is_file:
            raise InputError(f"{name}: {error}; expected a configuration of OpenColorIO") from error
        built_in = (f"ocio://{known[0]}" for known in ocio.BuiltinConfigRegistry().getBuiltinConfigs())
        raise _option("config", name, f"a file, {DEFAULT}, {', '.join(built_in)}") from error


def _processor(config: Any, from_space: str | None, display: str | None, view: str | None) -> Any:
    """Returns the processor that converts linear Rec. 709 to the view, in place."""
    ocio = _library()
    config, name = _configuration(config)
    source, before = _source(config, name, from_space)
    display = config.getDefaultDisplay() if display is None else display
    view = config.getDefaultView(display, source) if view is None else view
    try:
        way = ocio.GroupTransform()
        for transform in [*before, ocio.DisplayViewTransform(src=source, display=display, view=view)]:
            way.appendTransform(transform)
        return config.getProcessor(way).getDefaultCPUProcessor()
    except (ocio.Exception, ocio.ExceptionMissingFile) as error:
        raise _why(config, name, display, view, error) from error


def _why(config: Any, name: str, display: str, view: str, error: Exception) -> Error:
    """Error for a display and a view that OpenColorIO refuses; it compares both without case."""
    displays, views = ([*names] for names in (config.getDisplays(), config.getViews(display)))
    if display.lower() not in (known.lower() for known in displays):
        return _option("display", repr(display), f"one of {_listed(displays)} ({name})")
    if view.lower() not in (known.lower() for known in views):
        return _option("view", repr(view), f"one of {_listed(views)}, of the display {display!r} ({name})")
    return InputError(
        f"{name}: display {display!r}, view {view!r}: {error}; expected a view that OpenColorIO can make"
    )


def _source(config: Any, name: str, from_space: str | None) -> tuple[str, list[Any]]:
    """Returns the colour space (or role) that is the input of the view, and the transforms from
    linear Rec. 709 to it."""
    ocio = _library()
    spaces = _listed(config.getColorSpaceNames())
    if from_space is not None:
        if config.getColorSpace(from_space) is None:
            raise _option("from_space", repr(from_space), f"one of {spaces} ({name})")
        return from_space, []
    for known in _LINEAR_REC709:
        if config.getColorSpace(known) is not None:
            return known, []
    if config.hasRole("aces_interchange"):
        way = ocio.Config.CreateFromFile(DEFAULT).getProcessor(_LINEAR_REC709[0], "ACES2065-1")
        return "aces_interchange", [way.createGroupTransform()]
    raise _option("from_space", None, f"what {name} calls linear Rec. 709, of {spaces}")


def _option(name: str, value: object, expected: str) -> OptionError:
    return OptionError(f"{name} = {value}; expected {expected}")


def _listed(names: Any) -> str:
    return ", ".join(map(repr, names)) or "none, for there are none"


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG file of red, green, blue and opacity."""
    height, width, _ = pixels.shape
    # Each row begins with its filter, 1: a byte is stored as its difference from the pixel to the
    # left.
    left = np.pad(pixels, ((0, 0), (1, 0), (0, 0)))[:, :-1]
    rows = np.pad((pixels - left).reshape(height, width * 4), ((0, 0), (1, 0)), constant_values=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    data = zlib.compress(rows.tobytes())
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def _write(path: Path, data: bytes) -> None:
    """Writes a file under another name and renames it; writes directly to other kinds of files."""
    place = Path(os.path.realpath(path))
    partial = place.with_name(f"{place.name}.{os.getpid()}.partial")
    try:
        if place.exists() and not place.is_file():
            place.write_bytes(data)
            return
        partial.write_bytes(data)
        os.replace(partial, place)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise FileError(f"{path}: {error.strerror}") from error
