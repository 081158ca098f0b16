#!/usr/bin/env python3
"""Compares a camera that moves with Mitsuba 3, whose cameras stand: with the mean of its pictures at many times.

    pip install mitsuba numpy
    python3 scripts/mitsuba_moving.py target/release/tashika 64x64 8192 SCENE.xml [METHOD...]

The camera of the scene gets two keys, 0 s and 1 s: where it is, and 0.6 to its right, 1.2 ahead and turned by 8 degrees. Ours
is one picture with the shutter open from 0 to 1 s, by paths and by each of the further options (default: --error 2%); Mitsuba's is the
mean of 64 pictures in the middle of as many parts of that time. Told are the ratio of mean luminances with its standard
error, and the differences of pixels: the root of their mean square, relative to the mean, beside what the standard errors of both make of
it; the same for the camera that stands in the middle, to show what the motion changes. The film's filter is a box. Where LLVM is not found, name
its library in `DRJIT_LIBLLVM_PATH`.
"""

import os
import re
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np
from mitsuba_pictures import LUMINANCE, adapted

TIMES = 64
# The sensor comes first in the file.
SENSOR = re.compile(r'<transform name="to_world">\s*<matrix value="([^"]*)"\s*/>\s*</transform>')


def pose(first, time):
    """Camera to world: a turn about the camera's own up, and a way along its own axes, even in time."""
    angle = np.radians(8.0) * time
    sin, cos = np.sin(angle), np.cos(angle)
    turn = np.array([[cos, 0, sin, 0], [0, 1, 0, 0], [-sin, 0, cos, 0], [0, 0, 0, 1]])
    way = np.eye(4)
    way[:3, 3] = np.array([-0.6, 0.0, 1.2]) * time
    return first @ way @ turn


def matrix(m):
    return f'<matrix value="{" ".join(repr(float(x)) for x in m.flatten())}"/>'


def main():
    program, size, paths, scene, *methods = sys.argv[1:]
    size, paths = [int(side) for side in size.split("x")], int(paths)
    text = adapted(open(scene, encoding="utf-8").read(), size)
    first = np.array(SENSOR.search(text).group(1).split(), float).reshape(4, 4)
    folder = os.path.dirname(os.path.abspath(scene))

    def written(transform):
        file = tempfile.NamedTemporaryFile("w", suffix=".xml", dir=folder, delete=False)
        with file:
            file.write(SENSOR.sub(transform, text, count=1))
        return file.name

    def stills():
        """Means of both halves of the seeds."""
        halves = [0, 0]
        for k in range(TIMES):
            name = written(f'<transform name="to_world">{matrix(pose(first, (k + 0.5) / TIMES))}</transform>')
            try:
                loaded = mi.load_file(name)
                for half in (0, 1):
                    image = mi.render(loaded, spp=max(1, paths // 2 // TIMES), seed=2 * k + half)
                    halves[half] = halves[half] + np.array(image)[..., :3] @ LUMINANCE / TIMES
            finally:
                os.remove(name)
        return halves

    keys = [f'<transform time="{time}">{matrix(pose(first, time))}</transform>' for time in (0, 1)]
    moving = written(f'<animation name="to_world">{"".join(keys)}</animation>')

    def ours(options):
        halves = []
        with tempfile.TemporaryDirectory() as out:
            for seed in ("1", "2"):
                image = os.path.join(out, f"{seed}.exr")
                command = [program, "render", moving, *options, "--seed", seed, "-o", image]
                subprocess.run([*command, "--size", f"{size[0]}x{size[1]}", "--accept-budget"], check=True, capture_output=True)
                bitmap = mi.Bitmap(image)
                names = [field.name for field in bitmap.struct_()]
                halves.append(np.array(bitmap)[..., [names.index(c) for c in "RGB"]] @ LUMINANCE)
        return halves

    def tell(name, ours, theirs):
        a, b = sum(ours) / 2, sum(theirs) / 2
        noise = [(half[0] - half[1]) / 2 for half in (ours, theirs)]
        count = np.sqrt(a.size)
        error = np.sqrt(sum(np.mean(n**2) for n in noise)) / count / b.mean()
        rms, expected = np.sqrt(np.mean((a - b) ** 2)), np.sqrt(sum(np.mean(n**2) for n in noise))
        print(f"| {name} | {a.mean() / b.mean():.5f} ± {error:.5f} | {rms / b.mean():.4f} | {expected / b.mean():.4f} |", flush=True)

    try:
        reference = stills()
        print("| ours | mean, ours over Mitsuba's | differences of pixels | of noise alone |\n|---|---|---|---|")
        blurred = ["--shutter", "0,1"]
        tell("paths", ours([*blurred, "--method", "path", "--paths", str(paths // 2)]), reference)
        for method in methods or ["--error 2%"]:
            tell(f"`{method}`", ours([*blurred, *method.split()]), reference)
        tell("paths, standing in the middle", ours(["--at", "0.5", "--method", "path", "--paths", str(paths // 2)]), reference)
    finally:
        os.remove(moving)


if __name__ == "__main__":
    main()
