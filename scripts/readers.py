"""Checks OpenEXR files by other readers, as documented in crates/tashika-formats/src/io/exr/mod.rs.

    python readers.py PROGRAM

PROGRAM is the built `tashika`. Needs the Python packages OpenEXR (3, the reference implementation),
OpenImageIO and numpy. Renders a small built-in scene, whole and in part, and reads both files with
both; ends with an AssertionError where they disagree with each other, with the documentation or
with the program's report of that render. Mattes are read as programs for compositing read them: by
their manifest, with a hash that is written out here.
"""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy
import OpenEXR
import OpenImageIO

SIZE = (64, 48)
CROP = (13, 7, 40, 25)
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)

# Planes and their channels, and those that hold whole numbers: the render's list in
# crates/tashika-core/src/render/mod.rs.
PLANES = {
    "": ("R", "G", "B"),
    "standard_error": ("Y",),
    "half_width": ("Y",),
    "half_width_parts": ("clustering", "lights", "compensation"),
    "luminance_parts": ("emission", "vpls", "paths", "missing"),
    "claim": ("id",),
    "stop": ("id",),
    "pairs": ("n",),
    "rays": ("n",),
    "depth": ("Z",),
    "normal": ("X", "Y", "Z"),
    "albedo": ("R", "G", "B"),
    "coverage": ("A",),
}
WHOLE = {"claim.id", "stop.id"}

# Planes of `--cryptomatte=4`: layers of two ranks, and the keys of their metadata.
MATTES = {"CryptoObject": "3ae39a5", "CryptoMaterial": "be359d6"}

# Names of tashika:* attributes and their types; texts elsewhere.
NUMBERS = {"confidence": float, "error": float, "gather.points": int, "seed": int, "vpls": int}


def full_names():
    """Names of all channels, as documented."""
    return {f"{plane}.{c}" if plane else c for plane, channels in PLANES.items() for c in channels}


class Reference:
    """A file as the reference implementation's own Python module reads it."""

    def __init__(self, path, parts=()):
        file = OpenEXR.File(str(path), separate_channels=True)
        if parts:
            assert [part.name() for part in file.parts] == list(parts), [part.name() for part in file.parts]
        else:
            assert len(file.parts) == 1, "one part, so that every tool reads it"
        self.attributes = file.header()
        self.headers = [part.header for part in file.parts]
        self.channels = {
            name: channel.pixels for k in range(len(file.parts)) for name, channel in file.channels(k).items()
        }
        self.data = self.window("dataWindow")
        self.display = self.window("displayWindow")
        self.aspect = self.attributes["pixelAspectRatio"]

    def window(self, name):
        """Returns x, y, width, height; the file has the first and the last pixel."""
        first, last = self.attributes[name]
        return (int(first[0]), int(first[1]), int(last[0] - first[0] + 1), int(last[1] - first[1] + 1))

    def attribute(self, name):
        """Returns a value; this reader has numbers of type double as arrays of one."""
        value = self.attributes[name]
        return value.item() if isinstance(value, numpy.ndarray) and value.size == 1 else value


class Other:
    """A file as OpenImageIO reads it."""

    def __init__(self, path):
        file = OpenImageIO.ImageInput.open(str(path))
        assert file, OpenImageIO.geterror()
        spec = file.spec()
        self.attributes = {a.name: a.value for a in spec.extra_attribs}
        self.data = (spec.x, spec.y, spec.width, spec.height)
        self.display = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
        self.aspect = self.attributes["PixelAspectRatio"]
        self.channels = {}
        part = 0
        while file.seek_subimage(part, 0):
            spec = file.spec()
            kinds = spec.channelformats or [spec.format] * spec.nchannels
            for i, (name, kind) in enumerate(zip(spec.channelnames, kinds)):
                # Read one by one in their own types: all together would be made floats.
                pixels = file.read_image(part, 0, i, i + 1, kind)
                assert pixels is not None, file.geterror()
                self.channels[name] = pixels[:, :, 0]
            part += 1
        file.close()

    def attribute(self, name):
        """Returns a value."""
        return self.attributes[name]


def check_film(path, window, report):
    """Both readers find in the file the values of the documentation and of the program's report."""
    reference, other = Reference(path), Other(path)
    for reader in (reference, other):
        who = f"{path.name} by {type(reader).__name__}"
        assert set(reader.channels) == full_names(), f"{who}: {sorted(reader.channels)}"
        for name, pixels in reader.channels.items():
            kind = numpy.uint32 if name in WHOLE else numpy.float32
            assert pixels.dtype == kind, f"{who}: {name} is {pixels.dtype}"
            assert pixels.shape == (window[3], window[2]), f"{who}: {name} is {pixels.shape}"
        assert reader.data == window, f"{who}: data window {reader.data}"
        assert reader.display == (0, 0, *SIZE), f"{who}: display window {reader.display}"
        assert reader.aspect == 1.0, f"{who}: pixels of {reader.aspect}"
        check_attributes(reader, who, report)
    for name in full_names():
        ours, theirs = reference.channels[name], other.channels[name]
        assert ours.tobytes() == theirs.tobytes(), f"{path.name}: {name} differs between the readers"
    assert numpy.isfinite(reference.channels["R"]).all() and reference.channels["R"].max() > 0
    colors = [reference.channels[c].astype(numpy.float64) for c in "RGB"]
    means = [float(c.mean()) for c in colors]
    # Sums of 32-bit numbers in 64 bits: only the last rounding to 32 bits differs.
    assert numpy.allclose(means, report["mean_radiance"], rtol=2**-23, atol=0), f"{means}, {report['mean_radiance']}"
    assert int((reference.channels["claim.id"] != 0).sum()) == report["promise_met"]
    assert int((reference.channels["stop.id"] != 0).sum()) == report["pixels"] == window[2] * window[3]


def check_attributes(reader, who, report):
    """Standard attributes and the program's own, their types and values."""
    primaries = tuple(reader.attribute("chromaticities"))
    assert numpy.allclose(primaries, REC_709, rtol=0, atol=1e-6), f"{who}: chromaticities {primaries}"
    assert reader.attribute("software") == f"tashika {report['version']}", f"{who}: software"
    # OpenImageIO has its own name for the standard's `comments`.
    comments = reader.attributes.get("comments") or reader.attributes.get("ImageDescription")
    assert comments and comments.startswith(f"{report['scene']} by {report['method']}: radiance"), f"{who}: {comments}"
    assert "within 5 % of the sum over its virtual point lights at 90 %" in comments, f"{who}: {comments}"
    expected = {
        "scene": report["scene"],
        "camera": report["camera"],
        "method": report["method"],
        "truth": report["truth"],
        "version": report["version"],
        "tiles": report["tiles"],
        "complete": "true",
        "claim": "calibrated",
        "error": 0.05,
        "confidence": 0.9,
        "seed": report["seed"],
        "gather.points": report["gather"],
        "gather.filter": report["filter"],
        "vpls": report["lights"]["count"],
    }
    for name, value in expected.items():
        found = reader.attribute(f"tashika:{name}")
        assert type(found) is NUMBERS.get(name, str), f"{who}: tashika:{name} is of type {type(found)}"
        assert found == value, f"{who}: tashika:{name} is {found!r}, not {value!r}"
    planes = json.loads(reader.attribute("tashika:planes"))
    assert {p["name"]: tuple(p["channels"]) for p in planes} == PLANES, f"{who}: {planes}"
    assert planes[0]["unit"] == "W·m⁻²·sr⁻¹", f"{who}: text beyond ASCII became {planes[0]['unit']!r}"
    assert all(p["doc"] for p in planes), f"{who}: {planes}"


def check_layouts(program, folder, options):
    """Every layout has the same samples, parts of the planes' names, tiles, and its compression."""
    command = [program, "render", "builtin:tiny", *options, "--crop", ",".join(map(str, CROP)), "-o"]
    plain = folder / "plain.exr"
    subprocess.run([*command, plain], check=True, timeout=120)
    expected = Reference(plain)
    compressions = {
        "none": OpenEXR.NO_COMPRESSION,
        "rle": OpenEXR.RLE_COMPRESSION,
        "zips": OpenEXR.ZIPS_COMPRESSION,
        "zip": OpenEXR.ZIP_COMPRESSION,
        "piz": OpenEXR.PIZ_COMPRESSION,
    }
    for flags in ("", "parts,", "tiles,", "parts,tiles,"):
        for name, compression in compressions.items():
            path = folder / "layout.exr"
            subprocess.run([*command, path, "--exr", flags + name], check=True, timeout=120)
            parts = [plane or "rgb" for plane in PLANES] if "parts" in flags else ()
            reference, other = Reference(path, parts), Other(path)
            for header in reference.headers:
                assert header["compression"] == compression, f"{flags}{name}: {header['compression']}"
                kind = OpenEXR.tiledimage if "tiles" in flags else OpenEXR.scanlineimage
                assert header.get("type", kind) == kind, f"{flags}{name}: {header['type']}"
                assert ("tiles" in header) == ("tiles" in flags), f"{flags}{name}"
            for reader in (reference, other):
                assert set(reader.channels) == full_names(), f"{flags}{name}: {sorted(reader.channels)}"
                for channel, pixels in reader.channels.items():
                    same = pixels.tobytes() == expected.channels[channel].tobytes()
                    assert same, f"{flags}{name} by {type(reader).__name__}: {channel}"
            assert reference.attributes["tashika:planes"] == expected.attributes["tashika:planes"]
    refused = subprocess.run([*command, folder / "lossy.exr", "--exr", "dwaa"], capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "keeps all bits" in refused.stderr, refused.stderr


def murmur3(data):
    """MurmurHash3 of 32 bits, seed 0."""

    def scrambled(block):
        k = int.from_bytes(block, "little") * 0xCC9E2D51 & 0xFFFFFFFF
        return (k << 15 | k >> 17) * 0x1B873593 & 0xFFFFFFFF

    whole = len(data) // 4 * 4
    h = 0
    for i in range(0, whole, 4):
        h ^= scrambled(data[i : i + 4])
        h = ((h << 13 | h >> 19) * 5 + 0xE6546B64) & 0xFFFFFFFF
    h ^= scrambled(data[whole:]) ^ len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & 0xFFFFFFFF
    h = (h ^ h >> 13) * 0xC2B2AE35 & 0xFFFFFFFF
    return h ^ h >> 16


def matte_number(name):
    """The number of a name: never that of a zero, a denormal, an infinity or NaN."""
    number = murmur3(name.encode())
    return number ^ 1 << 23 if number >> 23 & 255 in (0, 255) else number


def check_mattes(path):
    """Layers, metadata and manifests of mattes; shares of pixels, and edges between objects."""
    # Published values, and the numbers in an image of another renderer.
    published = {"hello": 0x248BFA47, "The quick brown fox jumps over the lazy dog": 0x2E4FF723, "bunny": 0x13851A76}
    for name, number in published.items():
        assert murmur3(name.encode()) == number, name
    reference, other = Reference(path), Other(path)
    for layer, key in MATTES.items():
        assert f"{murmur3(layer.encode()):08x}"[:7] == key
        for reader in (reference, other):
            said = {name: reader.attribute(f"cryptomatte/{key}/{name}") for name in ("name", "hash", "conversion", "manifest")}
            assert said["name"] == layer and said["hash"] == "MurmurHash3_32" and said["conversion"] == "uint32_to_float32", said
        manifest = json.loads(said["manifest"])
        assert len(manifest) > 3, manifest
        for name, number in manifest.items():
            assert int(number, 16) == matte_number(name), f"{layer}: {name} is {number}"
            assert numpy.isfinite(struct.unpack("<f", struct.pack("<I", int(number, 16)))[0])
        channels = [f"{layer}{k:02}.{c}" for k in range(2) for c in "RGBA"]
        assert f"{layer}02.R" not in reference.channels
        for name in channels:
            assert reference.channels[name].dtype == numpy.float32
            assert reference.channels[name].tobytes() == other.channels[name].tobytes(), f"{name} differs between the readers"
        numbers = numpy.stack([reference.channels[name] for name in channels[0::2]])
        shares = numpy.stack([reference.channels[name] for name in channels[1::2]])
        assert (shares.sum(axis=0) <= 1 + 1e-6).all() and (numpy.diff(shares, axis=0) <= 0).all()
        known = {int(number, 16) for number in manifest.values()}
        assert set(numbers.view(numpy.uint32)[shares > 0].tolist()) <= known, f"{layer}: numbers that no name has"
        assert not numbers.view(numpy.uint32)[shares == 0].any()
        assert (shares[1] > 0).sum() > 20, f"{layer}: pixels on edges have both sides"
        largest = reference.channels[{"CryptoObject": "object_id", "CryptoMaterial": "material_id"}[layer] + ".id"]
        assert largest.dtype == numpy.uint32 and largest.tobytes() == numbers[0].tobytes()
        coverage = reference.channels["coverage.A"]
        assert (abs(shares.sum(axis=0) - coverage) < 1e-6).all(), "shares add up to what is seen of surfaces"


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, window in [("whole", (0, 0, *SIZE)), ("part", CROP)]:
            image, report = folder / f"{name}.exr", folder / f"{name}.json"
            options = ["--size", "x".join(map(str, SIZE)), "--truth", "vpl", "--vpls", "200", "--gather", "2"]
            options += ["--error", "5%", "--max-pairs", "100k", "--confidence", "90%", "--seed", "7", "--quiet"]
            options += ["--crop", ",".join(map(str, CROP))] if window == CROP else []
            command = [program, "render", "builtin:tiny", *options, "-o", image, "--json", report]
            subprocess.run(command, check=True, timeout=120)
            check_film(image, window, json.loads(report.read_text()))
        plain = options[: options.index("--quiet") + 1]
        check_layouts(program, folder, plain)
        mattes = folder / "mattes.exr"
        subprocess.run([program, "render", "builtin:tiny", *plain, "--cryptomatte=4", "-o", mattes], check=True, timeout=120)
        check_mattes(mattes)
    versions = f"OpenEXR {OpenEXR.__version__}, OpenImageIO {OpenImageIO.__version__}"
    print(f"files in all layouts, two of {len(full_names())} channels read alike by {versions}")


if __name__ == "__main__":
    main()
