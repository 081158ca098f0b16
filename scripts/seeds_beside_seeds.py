#!/usr/bin/env python3
"""Tests intervals against other seeds: no reference is needed to see that they miss.

    pip install OpenEXR numpy
    python3 scripts/seeds_beside_seeds.py target/release/tashika SEEDS SCENE [OPTION...]

Renders with seeds 1 to SEEDS. Each pixel's value is compared with the mean of those of the other
seeds, and its half-width `h` with the distance. That mean has an error too, of half-width
`g = sqrt(sum of their squared half-widths) / (SEEDS - 1)`. So intervals that are right at their
confidence hold as often within `sqrt(h^2 + g^2)`. Light that no seed met is not seen. Printed are
the share of pixels that claim, of claims that hold, and of claims within the error of that mean
(relative to it, or the film's absolute error); pixels whose mean is too uncertain (g above a half
of the tolerance) are omitted from the last. """

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
    # Pixels are tested if every seed has a claim there.
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
