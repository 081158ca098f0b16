#!/usr/bin/env python3
"""Whether intervals hold what other seeds found: no reference is needed to see that they do not.

    pip install OpenEXR numpy
    python3 scripts/seeds_beside_seeds.py target/release/tashika SEEDS SCENE [OPTION...]

Renders with seeds 1 to SEEDS. Each pixel's value is held against the mean of those of the other seeds, and its half-width `h` against
the distance: that mean is off too, by an error whose half-width is `g = sqrt(sum of theirs squared) / (SEEDS - 1)`, so that of intervals that
are right at their confidence as many hold within `sqrt(h^2 + g^2)`. What no seed met is not seen. Told are the share of pixels that claim,
of claims that hold, and that are within the error of that mean (relative to it, or the film's absolute error); pixels of which the mean
is worth nothing (g above a half of what is tolerated) are left out of the last.
"""

import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR

LUMINANCE = [0.2126729, 0.7151522, 0.0721750]


def planes(path):
    file = OpenEXR.File(path, separate_channels=True)
    channels = file.channels()
    luminance = sum(weight * channels[name].pixels.astype(float) for weight, name in zip(LUMINANCE, "RGB"))
    return luminance, channels["half_width.Y"].pixels.astype(float), channels["rays.n"].pixels.mean(), file.header()


def main():
    program, seeds, scene, *options = sys.argv[1:]
    seeds = int(seeds)
    values, widths, rays = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, seeds + 1):
            out = f"{folder}/{seed}.exr"
            done = subprocess.run([program, "render", scene, *options, "--seed", str(seed), "-q", "-o", out])
            if done.returncode not in (0, 4):
                sys.exit(done.returncode)
            value, width, ray, header = planes(out)
            values.append(value)
            widths.append(width)
            rays.append(ray)
    values, widths = np.array(values), np.array(widths)
    error = float(header["tashika:error"][0])
    absolute = float(header["tashika:error_absolute"][0])
    claims = widths > 0
    others = (values.sum(axis=0) - values) / (seeds - 1)
    of_others = np.sqrt((widths**2).sum(axis=0) - widths**2) / (seeds - 1)
    # Pixels that some seed says nothing of tell nothing.
    told = claims & claims.all(axis=0)
    rendered = claims.any(axis=0)
    distance = np.abs(values - others)
    holds = distance <= np.hypot(widths, of_others)
    tolerated = np.maximum(error * others, absolute)
    clear = told & (of_others <= 0.5 * tolerated)
    within = f"{(distance <= tolerated)[clear].mean():.1%}" if clear.any() else "-"
    print(
        f"{np.mean(rays) / rendered.mean():9.0f} rays a pixel; {claims[:, rendered].mean():.1%} claim; of {told.sum()} that can be held to "
        f"others {holds[told].mean():.1%} hold; of {clear.sum()} {within} are within {error:g}"
    )
    low = (values - others)[told & ~holds] < 0
    print(f"of those that do not hold {low.mean() if low.size else 0:.0%} are too dark")


main()
