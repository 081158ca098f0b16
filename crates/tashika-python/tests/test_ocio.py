"""Pictures through OpenColorIO: by formula, by that library itself, and refused input."""

import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

import tashika
import tashika.ocio
from conftest import SUM

ocio = pytest.importorskip("PyOpenColorIO")

#: Largest error of OpenColorIO's fast powers, in codes of 8 bits: four times the error on [0, 1],
#: which is 0.0025.
POWERS = 0.01
#: Rounding is an error of half a code.
ROUNDING = 0.5 + POWERS


@pytest.fixture(autouse=True)
def no_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OCIO", raising=False)


def film(path: Path, pixels: object, stop: object = None) -> tashika.Image:
    """An image of these colours, read from an OpenEXR file without compression."""
    colors = np.atleast_3d(np.asarray(pixels, np.float32))
    height, width, _ = colors.shape
    channels = {"B": colors[..., 2], "G": colors[..., 1], "R": colors[..., 0]}
    if stop is not None:
        channels["stop"] = np.asarray(stop, np.uint32).reshape(height, width)
    kinds = {np.dtype(np.uint32): 0, np.dtype(np.float32): 2}
    listed = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", kinds[channel.dtype], 0, 1, 1)
        for name, channel in channels.items()
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", listed + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", bytes(8)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    head = struct.pack("<ii", 20000630, 2) + b"".join(
        name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
        for name, kind, value in attributes
    ) + b"\0"  # fmt: skip
    rows = [b"".join(channel[y].tobytes() for channel in channels.values()) for y in range(height)]
    blocks = [struct.pack("<ii", y, len(row)) + row for y, row in enumerate(rows)]
    begins = np.cumsum([len(head) + 8 * height, *map(len, blocks[:-1])]).astype("<u8")
    path.write_bytes(head + begins.tobytes() + b"".join(blocks))
    return tashika.read(path)


def configuration(path: Path, linear: str = "lin_rec709_srgb", **roles: str) -> Path:
    """A file with one display, which shows the reference space unchanged, or by the curve of
    sRGB."""
    config = ocio.Config()
    config.setVersion(2, 1)
    config.addColorSpace(ocio.ColorSpace(name=linear))
    curve = ocio.ExponentWithLinearTransform(gamma=[2.4] * 3 + [1], offset=[0.055] * 3 + [0])
    curve.setDirection(ocio.TRANSFORM_DIR_INVERSE)
    config.addColorSpace(ocio.ColorSpace(name="curved", fromReference=curve))
    lost = ocio.FileTransform(src="lost.spi1d")
    config.addColorSpace(ocio.ColorSpace(name="of a file", fromReference=lost))
    for view, space in {"as it is": linear, "sRGB": "curved", "lost": "of a file"}.items():
        config.addDisplayView("monitor", view, space)
    for role, space in {"default": linear, **roles}.items():
        config.setRole(role, space)
    path.write_text(config.serialize(), encoding="utf-8")
    return path


def srgb(linear: np.ndarray) -> np.ndarray:
    """The curve of IEC 61966-2-1 on [0, 1], for codes of 8 bits before they are rounded."""
    linear = np.clip(linear.astype(np.float64), 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def by_hand(image: tashika.Image, config: object, display: str, view: str) -> np.ndarray:
    """Codes of 8 bits before they are rounded, pixel by pixel, by OpenColorIO alone."""
    way = ocio.DisplayViewTransform(src="Linear Rec.709 (sRGB)", display=display, view=view)
    processor = config.getProcessor(way).getDefaultCPUProcessor()  # type: ignore[attr-defined]
    pixels = image["radiance"].reshape(-1, 3).tolist()
    shown = np.float64([processor.applyRGB(pixel) for pixel in pixels])
    return 255 * np.clip(shown, 0, 1).reshape(image["radiance"].shape)


def test_views_are_those_of_the_formula(tmp_path: Path) -> None:
    config = configuration(tmp_path / "a.ocio")
    ramp = np.linspace(-0.2, 1.3, 301, dtype=np.float32)
    colors = np.stack([ramp, ramp[::-1], ramp**2], axis=-1).reshape(7, 43, 3)
    image = film(tmp_path / "a.exr", colors)
    curved = tashika.ocio.display(image, "monitor", "sRGB", config=config)
    assert curved.shape == (7, 43, 3) and curved.dtype == np.uint8
    assert np.abs(curved - srgb(colors)).max() <= ROUNDING
    # Codes of 0.25, 0.5 and 0.1 by the standard: 0.5371, 0.7354, 0.3492.
    few = film(tmp_path / "few.exr", [[[0.25, 0.5, 0.1]]])
    assert tashika.ocio.display(few, "monitor", "sRGB", config=config).tolist() == [[[137, 188, 89]]]
    plain = tashika.ocio.display(image, "monitor", "as it is", config=config)
    assert np.abs(plain - 255 * np.clip(colors, 0, 1)).max() <= 0.5 + 1e-4
    # The first view is the default, and a configuration may be passed as an object.
    loaded = ocio.Config.CreateFromFile(str(config))
    assert np.array_equal(tashika.ocio.display(image, config=loaded), plain)
    assert np.array_equal(image["radiance"], colors), "what is shown is a copy"


def test_exposure_comes_before_the_view(tmp_path: Path, image: tashika.Image) -> None:
    config = configuration(tmp_path / "a.ocio")
    few = film(tmp_path / "few.exr", [[[0.0625, 0.125, 0.025]]])
    shown = tashika.ocio.display(few, "monitor", "sRGB", config=config, exposure=2)
    assert shown.tolist() == [[[137, 188, 89]]]
    # The library's own automatic exposure, which a comparison reports for its reference.
    stops = tashika.compare(image, image).exposure_stops
    assert stops is not None and abs(stops) > 0.1
    automatic = tashika.ocio._automatic_stops(image["radiance"].reshape(-1, 3))
    assert abs(automatic - stops) < 1e-4
    shown = tashika.ocio.display(image, "monitor", "sRGB", config=config, exposure=None)
    assert np.abs(shown - srgb(image["radiance"] * 2**stops)).max() <= ROUNDING
    # Pixels that are black or were not rendered do not count.
    part = film(tmp_path / "part.exr", [[[0.72] * 3, [0] * 3, [900] * 3]], stop=[1, 1, 0])
    shown = tashika.ocio.display(part, config=config, exposure=None)
    assert shown[0].tolist() == [[46] * 3, [0] * 3, [0] * 3], "255 · 0.18 = 45.9"


def test_the_configuration_is_an_argument_that_of_the_environment_or_that_of_the_library(
    image: tashika.Image, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = ocio.Config.CreateFromFile("ocio://default")
    display = config.getDefaultDisplay()
    shown = tashika.ocio.display(image)
    assert "ACES" in config.getDefaultView(display)
    assert np.abs(shown - by_hand(image, config, display, config.getDefaultView(display))).max() <= ROUNDING
    plain = tashika.ocio.display(image, "sRGB - Display", "Un-tone-mapped")
    assert np.abs(plain - srgb(image["radiance"])).max() <= ROUNDING and not np.array_equal(plain, shown)
    # The environment replaces the default, and an argument replaces the environment.
    own = configuration(tmp_path / "a.ocio")
    monkeypatch.setenv("OCIO", str(own))
    by_own = tashika.ocio.display(image)
    assert np.array_equal(by_own, tashika.ocio.display(image, "monitor", "as it is", config=own))
    assert not np.array_equal(by_own, shown)
    assert np.array_equal(tashika.ocio.display(image, config="ocio://default"), shown)
    monkeypatch.setenv("OCIO", "")
    assert np.array_equal(tashika.ocio.display(image), shown)


def test_linear_rec_709_is_found_by_name_and_by_role(tmp_path: Path) -> None:
    image = film(tmp_path / "a.exr", [[[1, 1, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    names = ("lin_rec709_srgb", "Linear Rec.709 (sRGB)", "lin_rec709", "lin_srgb", "Linear Rec.709")
    for name in (*names, "Utility - Linear - Rec.709", "Utility - Linear - sRGB"):
        config = configuration(tmp_path / "a.ocio", name)
        assert tashika.ocio.display(image, config=config)[0, 1:].tolist() == (255 * np.eye(3)).tolist()
    # The configuration's reference space is the Academy's, AP0. White stays white, and the
    # primaries of Rec. 709 become the columns of the matrix to AP0 (adapted by Bradford's).
    config = configuration(tmp_path / "a.ocio", "theirs", aces_interchange="theirs")
    matrix = np.float64(
        [[0.43963, 0.08978, 0.01754], [0.38299, 0.81344, 0.11155], [0.17738, 0.09678, 0.87091]]
    )
    found = tashika.ocio.display(image, config=config)
    assert found[0, 0].tolist() == [255] * 3
    assert np.abs(found[0, 1:] - 255 * matrix).max() <= 0.5 + 255 * 1e-5
    as_said = tashika.ocio.display(image, config=config, from_space="theirs")
    assert as_said[0, 1].tolist() == [255, 0, 0]
    with pytest.raises(
        tashika.OptionError, match="from_space = None; expected what .* calls linear Rec. 709, of 'raw'"
    ):
        tashika.ocio.display(image, config=ocio.Config.CreateRaw())
    raw = tashika.ocio.display(image, config=ocio.Config.CreateRaw(), from_space="raw")
    assert raw[0, 1].tolist() == [255, 0, 0]


def test_what_is_refused_says_what_there_is(image: tashika.Image, tmp_path: Path) -> None:
    config = configuration(tmp_path / "a.ocio")

    def refused(kind: type[tashika.Error], match: str, *names: str, **said: object) -> None:
        with pytest.raises(kind, match=match):
            tashika.ocio.display(image, *names, **{"config": config, **said})  # type: ignore[arg-type]

    refused(tashika.OptionError, r"display = 'wall'; expected one of 'monitor' \(.*a\.ocio\)", "wall")
    refused(
        tashika.OptionError, r"view = 'film'; expected one of 'as it is', 'sRGB', 'lost'", "monitor", "film"
    )
    refused(
        tashika.OptionError, "view = 'film'; expected one of .*'Un-tone-mapped'", view="film", config=None
    )
    refused(tashika.InputError, r"a\.ocio: display 'monitor', view 'lost': .*lost\.spi1d", "monitor", "lost")
    refused(
        tashika.OptionError,
        "from_space = 'XYZ'; expected one of 'lin_rec709_srgb', 'curved'",
        from_space="XYZ",
    )
    for exposure in (65, float("nan")):
        refused(
            tashika.OptionError, f"exposure = {exposure}; expected None, or stops from -64", exposure=exposure
        )
    refused(
        tashika.OptionError,
        "plane = claim; expected one of radiance, standard_error, half_width, pairs",
        plane="claim",
    )
    refused(tashika.FileError, r"absent\.ocio", config=tmp_path / "absent.ocio")
    (tmp_path / "bad.ocio").write_text("ocio_profile_version: {")
    refused(tashika.InputError, r"bad\.ocio: .*expected a configuration", config=tmp_path / "bad.ocio")
    refused(
        tashika.OptionError,
        "config = ocio://nothing; expected .*, ocio://cg-config-v1",
        config="ocio://nothing",
    )
    refused(tashika.OptionError, "display = ''; expected one of none", config=empty())


def empty() -> object:
    """A configuration without displays."""
    config = ocio.Config()
    config.addColorSpace(ocio.ColorSpace(name="lin_rec709_srgb"))
    return config


def test_a_library_that_is_not_there_is_said_with_how_to_get_it(
    image: tashika.Image, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "PyOpenColorIO", None)
    with pytest.raises(tashika.UnsupportedError, match=r"pip install tashika\[ocio\]"):
        tashika.ocio.display(image)


def test_no_number_is_too_much(tmp_path: Path) -> None:
    nan, inf = float("nan"), float("inf")
    row = [[nan] * 3, [inf] * 3, [1e25] * 3, [3e38] * 3, [-inf] * 3, [0.18, nan, 0.18], [7] * 3]
    image = film(tmp_path / "a.exr", [row], stop=[1, 1, 1, 1, 1, 1, 0])
    own, academy = configuration(tmp_path / "a.ocio"), "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1"
    for config in (own, academy, "ocio://default"):
        for exposure in (-64, 0, 64, None):
            shown = tashika.ocio.display(image, config=config, exposure=exposure)[0].tolist()
            assert shown[0] == shown[4] == shown[6] == [0] * 3
            if exposure != -64:
                assert shown[1] == shown[2] == shown[3] == [255] * 3, (config, exposure)
    assert tashika.ocio.display(image, config=own)[0, 5].tolist() == [46, 0, 46]
    without = film(tmp_path / "without.exr", [[[0.18, 0, 0.18]]])
    for config in (academy, "ocio://default"):
        shown, black = (tashika.ocio.display(one, config=config)[0] for one in (image, without))
        assert np.array_equal(shown[5], black[0]), "one channel that is no number is black, and it alone"
    # The view's result may be NaN although its input is not: infinity times zero.
    views = ocio.Config.CreateFromFile(str(own))
    way = ocio.GroupTransform()
    way.appendTransform(ocio.LogTransform(base=10, direction=ocio.TRANSFORM_DIR_INVERSE))
    way.appendTransform(ocio.MatrixTransform([1, -1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]))
    views.addColorSpace(ocio.ColorSpace(name="powers", fromReference=way))
    views.addDisplayView("monitor", "powers", "powers")
    both = film(tmp_path / "both.exr", [[[9000, 9000, -1], [-1, -2, -0.7]]])
    with np.errstate(invalid="raise"):
        shown = tashika.ocio.display(both, view="powers", config=views)
    assert shown.tolist() == [[[0, 0, 0], [23, 3, 51]]], "255 · (0.1 - 0.01), 255 · 0.01, 255 · 0.2"


def test_planes_are_shown_too(tiny: tashika.Scene, image: tashika.Image, tmp_path: Path) -> None:
    config = configuration(tmp_path / "a.ocio")
    albedo = tashika.ocio.display(image, config=config, plane="albedo")
    assert np.abs(albedo - 255 * np.clip(image["albedo"], 0, 1)).max() <= 0.5 + 1e-4
    depth = tashika.ocio.display(image, config=config, plane="depth", exposure=-3)
    assert np.abs(depth - 255 * np.clip(image["depth"] / 8, 0, 1)[..., None]).max() <= 0.5 + 1e-4
    assert np.ptp(depth) > 0
    shown, seen = (tashika.ocio.display(image, config=config, exposure=-2, plane=plane) for plane in ("", "radiance"))
    assert np.array_equal(shown, seen) and not np.array_equal(shown, albedo)


def decoded(data: bytes) -> np.ndarray:
    """Pixels of a PNG file whose rows are filtered by the pixel to the left."""
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    chunks, at = {}, 8
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        chunks[kind] = data[at + 8 : at + 8 + length]
        assert struct.unpack_from(">I", data, at + 8 + length)[0] == zlib.crc32(kind + chunks[kind])
        at += 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert rest == [8, 6, 0, 0, 0], "8 bits of red, green, blue and opacity"
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 1 + 4 * width)
    assert (rows[:, 0] == 1).all()
    return np.cumsum(rows[:, 1:].reshape(height, width, 4), axis=1, dtype=np.uint8)


def test_pictures_are_saved(tiny: tashika.Scene, tmp_path: Path) -> None:
    part = tashika.render(tiny, tiles="1/2", gather=16, **SUM)
    rendered = part["stop"] > 0
    assert rendered.any() and not rendered.all()
    said = {"config": configuration(tmp_path / "a.ocio"), "exposure": 1.0}
    path, other = tmp_path / "a.PNG", tmp_path / "other"
    path.write_bytes(b"old")
    other.hardlink_to(path)
    tashika.ocio.save(path, part, "monitor", "sRGB", **said)
    assert other.read_bytes() == b"old", "the file is another one, not the same with other bytes"
    pixels = decoded(path.read_bytes())
    assert np.array_equal(pixels[..., :3], tashika.ocio.display(part, "monitor", "sRGB", **said))
    assert np.array_equal(pixels[..., 3], np.where(rendered, 255, 0)) and pixels[rendered].any()
    with pytest.raises(tashika.OptionError, match=r"a\.jpg; expected a file name ending in \.png"):
        tashika.ocio.save(tmp_path / "a.jpg", part)
    with pytest.raises(tashika.OptionError, match="view = 'film'"):
        tashika.ocio.save(tmp_path / "b.png", part, view="film")
    for folder in (tmp_path / "absent", tmp_path / "a.ocio"):
        with pytest.raises(tashika.FileError, match=f"{folder.name}.a\\.png: "):
            tashika.ocio.save(folder / "a.png", part)
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(tashika.FileError, match="folder"):
        tashika.ocio.save(tmp_path / "folder.png", part)
    assert sorted(found.name for found in tmp_path.iterdir()) == ["a.PNG", "a.ocio", "folder.png", "other"]
