#!/usr/bin/env python3
"""Compares pictures of Mitsuba scenes: paths of tashika against paths of Mitsuba 3.

    pip install mitsuba numpy
    python3 scripts/mitsuba_pictures.py target/release/tashika 96x64 1024 SCENE.xml...

Printed for each scene are the ratio of mean radiances (luminance, ours over Mitsuba's), with its
standard error from the difference of two halves of each picture, and the 95th percentile of the
differences of pixels, relative to Mitsuba's, beside its value by noise alone. The film's filter is
a box. Where LLVM is not found, name its library in `DRJIT_LIBLLVM_PATH`.
"""

import os
import re
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def adapted(text, size):
    """The scene with this size of film, a box filter and paths of any length."""
    for name, value in zip(("width", "height"), size):
        text = re.sub(rf'(<integer name="{name}" value=")[^"]*"', rf'\g<1>{value}"', text)
    # A film without a filter has a Gaussian one.
    text = re.sub(r"<rfilter\b[^>]*?(/>|>.*?</rfilter>)", "", text, flags=re.S)
    text = re.sub(r"<film\b[^>]*[^/]>", r'\g<0><rfilter type="box"/>', text)
    # Removes a parameter of older versions that Mitsuba 3 does not read; its value is 1.
    text = re.sub(r'<float name="ext(_e|E)ta" value="1(\.0*)?"\s*/>', "", text)
    # Ours renders media where the file's integrator does.
    kind = "volpath" if "volpath" in text else "path"
    path = f'<integrator type="{kind}"><integer name="max_depth" value="-1"/></integrator>'
    if re.search(r'<scene version="[01]\.', text):
        path = path.replace("max_depth", "maxDepth")
    return re.sub(r"<integrator\b[^>]*?(/>|>.*?</integrator>)", path, text, count=1, flags=re.S)


def pictures(scene, text, samples, seeds):
    """Pictures of the given samples a pixel, one for each seed, of the text as the scene."""
    folder = os.path.dirname(os.path.abspath(scene))
    with tempfile.NamedTemporaryFile("w", suffix=".xml", dir=folder, delete=False) as file:
        file.write(text)
    try:
        loaded = mi.load_file(file.name)
        for seed in seeds:
            yield np.array(mi.render(loaded, spp=samples, seed=seed))[..., :3]
    finally:
        os.remove(file.name)


def half_pictures(scene, text, samples):
    """Luminances of two pictures with half of the samples each."""
    return [picture @ LUMINANCE for picture in pictures(scene, text, samples // 2, (1, 2))]


def of_mitsuba(scene, size, paths):
    return half_pictures(scene, adapted(open(scene, encoding="utf-8").read(), size), paths)


def of_ours(program, scene, size, paths):
    halves = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in ("1", "2"):
            image = os.path.join(folder, f"{seed}.exr")
            command = [program, "render", scene, "--method", "path", "--paths", str(paths // 2), "--seed", seed, "-o", image]
            subprocess.run([*command, "--size", f"{size[0]}x{size[1]}"], check=True, capture_output=True)
            bitmap = mi.Bitmap(image)
            names = [field.name for field in bitmap.struct_()]
            pixels = np.array(bitmap)[..., [names.index(channel) for channel in "RGB"]]
            halves.append(pixels @ LUMINANCE)
    return halves


def main():
    program, size, paths, *scenes = sys.argv[1:]
    size = [int(part) for part in size.split("x")]
    for scene in scenes:
        halves = [of_ours(program, scene, size, int(paths)), of_mitsuba(scene, size, int(paths))]
        ours, theirs = (0.5 * (a + b) for a, b in halves)
        # Halves differ by twice the error of their mean, pixel by pixel.
        error = np.hypot(*(0.5 * (a - b) for a, b in halves))
        spread = np.sqrt((error**2).sum()) / error.size / theirs.mean()
        lit = theirs > 0.01 * theirs.mean()
        off = np.abs(ours - theirs)[lit] / theirs[lit]
        name = os.path.relpath(scene)
        print(
            f"{name}: mean {ours.mean() / theirs.mean():.4f} +- {spread:.4f}, "
            f"95th percentile {np.quantile(off, 0.95):.3f}, of noise {np.quantile(error[lit] / theirs[lit], 0.95):.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
