#!/usr/bin/env python3
"""Compares direct light in Mitsuba 3 by points sampled on emitters and by directions from BSDFs.

    pip install mitsuba numpy
    python3 scripts/mitsuba_direct.py 64x64 8192 SCENE.xml...

Both estimate the same picture. A difference means that the light sent by emitters is not the light
received from them. The causes are two: shadow segments end short of the emitter by a share of their
length, and emitters are evaluated with their shading normals. Principled and diffuse materials are
replaced by a diffuse one of reflectance 0.5, so that both estimates have little noise. If LLVM is
not found, set `DRJIT_LIBLLVM_PATH` to the path of its library. """

import re
import sys

import numpy as np
from mitsuba_pictures import adapted, half_pictures


def direct(text, size, emitter_samples, bsdf_samples):
    integrator = (
        f'<integrator type="direct"><integer name="emitter_samples" value="{emitter_samples}"/>'
        f'<integer name="bsdf_samples" value="{bsdf_samples}"/></integrator>'
    )
    diffuse = '<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>'
    text = re.sub(r'<bsdf type="(?:principled|diffuse)">.*?</bsdf>', diffuse, adapted(text, size), flags=re.S)
    return re.sub(r"<integrator\b.*?</integrator>", integrator, text, count=1, flags=re.S)


def main():
    size, samples, *scenes = sys.argv[1:]
    size = [int(part) for part in size.split("x")]
    for scene in scenes:
        text = open(scene, encoding="utf-8").read()
        points = half_pictures(scene, direct(text, size, 1, 0), int(samples))
        directions = half_pictures(scene, direct(text, size, 0, 1), 2 * int(samples))
        error = np.hypot(*(0.5 * (halves[0] - halves[1]) for halves in (points, directions)))
        mean = np.mean(points)
        spread = np.sqrt((error**2).sum()) / error.size / mean
        print(f"{scene}: by directions over by points {np.mean(directions) / mean:.4f} +- {spread:.4f}", flush=True)


if __name__ == "__main__":
    main()
