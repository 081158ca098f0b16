#!/usr/bin/env python3
"""Renders truths for `cargo xtask measure seeds --truth FOLDER`: Mitsuba scenes, by Mitsuba 3.

    pip install mitsuba numpy OpenEXR
    python3 scripts/mitsuba_truths.py 16x9 65536 FOLDER SCENE.xml...

Writes FOLDER/SCENE.exr: the mean of RUNS pictures of independent seeds, which share the given
number of paths a pixel, and in the layer `standard_error` the standard error of the luminance, by
the spread of the runs. The film's filter is a box. Where LLVM is not found, name its library in
`DRJIT_LIBLLVM_PATH`.
"""

import pathlib
import sys

import numpy as np
import OpenEXR
from mitsuba_pictures import LUMINANCE, adapted, pictures

# Independent pictures: their spread knows the standard error to a fifth.
RUNS = 16


def main():
    size, paths, folder, *scenes = sys.argv[1:]
    size, folder = [int(side) for side in size.split("x")], pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for scene in map(pathlib.Path, scenes):
        text = adapted(scene.read_text(encoding="utf-8"), size)
        runs = np.stack(list(pictures(scene, text, int(paths) // RUNS, range(1, RUNS + 1))))
        mean = runs.mean(axis=0).astype(np.float32)
        error = (runs @ LUMINANCE).std(axis=0, ddof=1).astype(np.float32) / np.sqrt(np.float32(RUNS))
        channels = {"RGB": mean, "standard_error.Y": error}
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, channels).write(str(folder / f"{scene.stem}.exr"))
        share = np.median(error / np.maximum(mean @ LUMINANCE, 1e-12))
        print(f"{scene.stem}: mean {(mean @ LUMINANCE).mean():.5f}, median standard error {share:.1%}", flush=True)


main()
