#!/usr/bin/env python3
"""Disjoint intervals of two seeds: one of the two is wrong, which needs no reference to be seen.

    pip install OpenEXR numpy
    cargo xtask measure seeds [--seeds N] [--truth FOLDER] [--limit SHARE] SCENE... [-- OPTION...]

Renders each scene with seeds 1 to N (2), of the given OPTIONs (default: --size 64x36 --error 20%).
One row a scene:

    claim     share of the pixels that claim
    disjoint  share of the pairs of claims of a pixel, by two seeds, whose intervals are disjoint
    means     largest distance of the image's mean from the mean of all seeds, relative
    width     median half-width of the claims, relative
    kept      share of the claims that cover the value of FOLDER/SCENE.exr, within two of its
              standard errors where it has them; and the mean of the image over that of the truth
    rays      mean over the pixels

Exits with 1 if the share of disjoint pairs of a scene is above SHARE.
"""

import argparse
import itertools
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR

LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750])
DEFAULT = ["--size", "64x36", "--error", "20%"]


class Picture:
    """Luminance and the planes of a film, one row of the image after the other."""

    def __init__(self, path):
        channels = OpenEXR.File(str(path), separate_channels=True).channels()
        self.planes = {name: channel.pixels.astype(float) for name, channel in channels.items()}
        self.luminance = sum(weight * self.planes[name] for weight, name in zip(LUMINANCE, "RGB"))

    def plane(self, name):
        found = (self.planes[f"{name}.{channel}"] for channel in ("Y", "n", "id") if f"{name}.{channel}" in self.planes)
        return next(found, np.zeros_like(self.luminance))


def render(program, scene, options, seeds):
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, seeds + 1):
            out = f"{folder}/{seed}.exr"
            line = [program, "render", str(scene), *options, "--seed", str(seed), "--accept-budget", "-q", "-o", out]
            subprocess.run(line, check=True)
            yield Picture(out)


def disjoint(one, other, claims):
    both = claims[0] & claims[1]
    apart = np.abs(one.luminance - other.luminance) > one.plane("half_width") + other.plane("half_width")
    return (both & apart).sum(), both.sum()


def row(pictures, truth):
    claims = [np.nan_to_num(picture.plane("claim")) > 0 for picture in pictures]
    pairs = [
        disjoint(pictures[a], pictures[b], (claims[a], claims[b]))
        for a, b in itertools.combinations(range(len(pictures)), 2)
    ]
    apart, both = np.sum(pairs, axis=0)
    means = np.array([picture.luminance.mean() for picture in pictures])
    widths = np.concatenate(
        [(p.plane("half_width") / np.maximum(p.luminance, 1e-12))[claim] for p, claim in zip(pictures, claims)]
    )
    found = {
        "claim": f"{np.mean(claims):.1%}",
        "disjoint": f"{apart / max(both, 1):.2%}",
        "means": f"{np.abs(means / means.mean() - 1).max():.1%}",
        "width": f"{np.median(widths) if widths.size else np.nan:.3f}",
        "kept": "-",
        "rays": f"{np.mean([picture.plane('rays').mean() for picture in pictures]):.0f}",
    }
    if truth:
        slack = 2 * truth.plane("standard_error")
        kept = [np.abs(p.luminance - truth.luminance) <= p.plane("half_width") + slack for p in pictures]
        share = np.concatenate([k[c] for k, c in zip(kept, claims)]).mean()
        found["kept"] = f"{share:.1%} {means.mean() / truth.luminance.mean():.3f}"
    return found, apart / max(both, 1)


def main():
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--truth", type=pathlib.Path)
    parser.add_argument("--limit", type=float)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    asked = parser.parse_args(words[:cut])
    options = words[cut + 1 :] or DEFAULT
    too_many = []
    for number, scene in enumerate(asked.scenes):
        truth = asked.truth / f"{scene.stem}.exr" if asked.truth else None
        pictures = list(render(asked.program, scene, options, asked.seeds))
        found, share = row(pictures, Picture(truth) if truth and truth.is_file() else None)
        if number == 0:
            print(f"{'':24}" + "".join(f"{name:>14}" for name in found))
        print(f"{scene.stem:24}" + "".join(f"{value:>14}" for value in found.values()), flush=True)
        if asked.limit is not None and share > asked.limit:
            too_many.append(scene.stem)
    if too_many:
        sys.exit(f"more than {asked.limit:.1%} of the intervals are disjoint: {', '.join(too_many)}")


main()
