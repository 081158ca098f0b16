#!/usr/bin/env python3
"""Compares moving scenes with Mitsuba 3, which has no motion: with its mean over many times.

    pip install mitsuba numpy
    python3 scripts/mitsuba_moving.py target/release/tashika 64x64 8192 SCENE.xml [METHOD...]
    python3 scripts/mitsuba_moving.py target/release/tashika 64x64 8192 SCENE.xml --objects

The camera of the scene gets two keys, 0 s and 1 s: its own pose, and one 0.6 to its right, 1.2
ahead and turned by 8 degrees. With `--objects` the camera stands, and the boxes and the lamp of the
Cornell box go and turn instead (by paths only). Ours is one picture with the shutter open from 0 to
1 s, by paths and by each of the further options (default: --error 2%); Mitsuba's is the mean of 64
pictures in the middle of as many parts of that time. Printed are the ratio of mean luminances with
its standard error, and the root mean square of the differences of pixels, relative to the mean,
beside its value by the standard errors of both. The same numbers are printed for the scene that
stands in the middle, to show the effect of the motion. The film's filter is a box. Where LLVM is
not found, name its library in `DRJIT_LIBLLVM_PATH`. """

import os
import re
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np
from mitsuba_pictures import LUMINANCE, adapted

TIMES = 64
TRANSFORM = r'<transform name="to_world">\s*<matrix value="([^"]*)"\s*/>\s*</transform>'


def turn(axis, angle):
    """Rotation around an axis of the coordinates."""
    sin, cos = np.sin(angle), np.cos(angle)
    i, j = [k for k in range(3) if k != axis]
    m = np.eye(4)
    m[i, i], m[i, j], m[j, i], m[j, j] = cos, -sin, sin, cos
    return m if axis != 1 else m.T


def way(offset):
    m = np.eye(4)
    m[:3, 3] = offset
    return m


def of_camera(first, time):
    """Camera to world: a turn around its own up, and a way along its axes, even in time."""
    return first @ way(np.array([-0.6, 0.0, 1.2]) * time) @ turn(1, np.radians(8.0) * time)


def of_shape(offset, degrees):
    """Shape to world: a turn around its third axis, across which it is square, and a way."""
    return lambda first, time: way(np.array(offset) * time) @ first @ turn(2, np.radians(degrees) * time)


# Moving parts: the place in the file, and the pose over time. The sensor comes first in the file.
CAMERA = [(TRANSFORM, of_camera)]
OBJECTS = [
    (rf'(?<=id="{name}">)\s*{TRANSFORM}', of_shape(*how))
    for name, how in {
        "ShortBox": ([0.25, 0.4, 0.1], 100.0),
        "TallBox": ([-0.2, 0.0, 0.3], -60.0),
        "Light": ([-0.5, -0.3, 0.2], 0.0),
    }.items()
]


def matrix(m):
    return f'<matrix value="{" ".join(repr(float(x)) for x in m.flatten())}"/>'


def main():
    program, size, paths, scene, *methods = sys.argv[1:]
    are_objects = methods == ["--objects"]
    movers = OBJECTS if are_objects else CAMERA
    size, paths = [int(side) for side in size.split("x")], int(paths)
    text = adapted(open(scene, encoding="utf-8").read(), size)
    folder = os.path.dirname(os.path.abspath(scene))

    def written(transform):
        """The scene with the poses of each mover replaced by `transform`."""
        changed = text
        for where, pose in movers:
            first = np.array(re.search(where, text).group(1).split(), float).reshape(4, 4)
            changed = re.sub(where, transform(lambda time: matrix(pose(first, time))), changed, count=1)
        file = tempfile.NamedTemporaryFile("w", suffix=".xml", dir=folder, delete=False)
        with file:
            file.write(changed)
        return file.name

    def stills():
        """Means of both halves of the seeds."""
        halves = [0, 0]
        for k in range(TIMES):
            middle = (k + 0.5) / TIMES
            name = written(lambda at: f'<transform name="to_world">{at(middle)}</transform>')
            try:
                loaded = mi.load_file(name)
                for half in (0, 1):
                    image = mi.render(loaded, spp=max(1, paths // 2 // TIMES), seed=2 * k + half)
                    halves[half] = halves[half] + np.array(image)[..., :3] @ LUMINANCE / TIMES
            finally:
                os.remove(name)
        return halves

    def animation(at):
        keys = [f'<transform time="{time}">{at(time)}</transform>' for time in (0, 1)]
        return f'<animation name="to_world">{"".join(keys)}</animation>'

    moving = written(animation)

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
        for method in [] if are_objects else methods or ["--error 2%"]:
            tell(f"`{method}`", ours([*blurred, *method.split()]), reference)
        tell("paths, standing in the middle", ours(["--at", "0.5", "--method", "path", "--paths", str(paths // 2)]), reference)
    finally:
        os.remove(moving)


if __name__ == "__main__":
    main()
