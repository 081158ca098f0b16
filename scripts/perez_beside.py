#!/usr/bin/env python3
"""Compares `--environment perez:` with Radiance's `gendaylit`, a dozen states of the sky.

    python3 scripts/perez_beside.py PROGRAM GENDAYLIT

Each sky is rendered as a picture of all directions and compared with the luminance by the
coefficients that `gendaylit -O 2` prints. Columns: clearness and brightness as printed by
`gendaylit`; diffuse horizontal illuminance of the picture over irradiance times efficacy;
illuminance by the sun over `gendaylit`'s; ratio of the luminances (mean over directions at least 5
degrees above the horizon); and the largest deviation of a direction from that ratio, of all of
these directions and of those at least 3 degrees from the sun.

`gendaylit` normalises by a sum over 145 directions, `tashika` by an integral, so that the ratio
differs from 1. Needs numpy.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "blender/tashika"))
import exr  # noqa: E402

# Direct normal and diffuse horizontal irradiance (W/m2), elevation and azimuth of the sun.
CASES = [
    (0, 120, 40, 150),
    (10, 200, 60, 180),
    (30, 200, 60, 90),
    (100, 250, 55, 200),
    (150, 150, 25, 250),
    (200, 250, 60, 180),
    (375, 250, 60, 300),
    (540, 180, 60, 135),
    (700, 140, 45, 170),
    (900, 90, 60, 180),
    (600, 60, 15, 270),
    (850, 70, 35, 100),
]
# Without the reflection, +x would be to the left: pbrt is left-handed.
SCENE = """Scale -1 1 1
LookAt 0 0 0  0 0 -1  0 1 0
Camera "perspective"
WorldBegin
Shape "trianglemesh" "point3 P" [0 -50 0  0.01 -50 0  0 -50 0.01] "integer indices" [0 1 2]
"""
SIZE = (512, 256)


def beside(gendaylit, direct, diffuse, elevation, azimuth):
    """Clearness, brightness, illuminance by the sun, scale, coefficients, direction to the sun."""
    command = [gendaylit, "-ang", str(elevation), str(azimuth - 180), "-W", str(direct), str(diffuse), "-O", "2"]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    lines = text.splitlines()
    state = next(line for line in lines if line.startswith("# epsilon")).split(":")[1].split()
    sun = float(next(line for line in lines if line.startswith("3 ")).split()[1])
    sky = [float(word) for word in next(line for line in lines if line.startswith("10 ")).split()[1:]]
    solid_angle = 2 * math.pi * (1 - math.cos(math.radians(0.2665)))
    return float(state[0]), float(state[1]), sun * solid_angle, sky[0], sky[2:7], sky[7:10]


def picture(program, folder, environment):
    """Luminances of a picture of all directions, and the words of the sky."""
    scene, image = folder / "sky.pbrt", folder / "sky.exr"
    scene.write_text(SCENE)
    base = [str(scene), f"--environment={environment}"]
    render = ["--projection", "spherical", "--method", "path", "--paths", "4", "--size", f"{SIZE[0]}x{SIZE[1]}", "-q", "-o", str(image)]
    subprocess.run([program, "render", *base, *render], check=True)
    info = subprocess.run([program, "info", *base, "--json", "-"], check=True, capture_output=True, text=True)
    changes = [text for text in json.loads(info.stdout)["changes"] if text.startswith("sun at")]
    # Lines from the top.
    return exr.File(image).plane("G")[::-1, :, 0].astype(float), changes[0]


def main():
    program, gendaylit = sys.argv[1:3]
    width, height = SIZE
    theta = (numpy.arange(height) + 0.5) / height * math.pi
    phi = (numpy.arange(width) + 0.5) / width * 2 * math.pi
    theta, phi = numpy.meshgrid(theta, phi, indexing="ij")
    # Up is z in the frame of gendaylit, north y: the middle of the picture is north.
    direction = numpy.stack([-numpy.sin(phi) * numpy.sin(theta), -numpy.cos(phi) * numpy.sin(theta), numpy.cos(theta)])
    weight = numpy.where(theta < math.pi / 2, numpy.cos(theta) * numpy.sin(theta), 0)
    weight *= (math.pi / height) * (2 * math.pi / width)
    print("| DNI | DHI | elevation | azimuth | ε | Δ | diffuse (lx) | off | sun off | ratio | deviation | 3° from the sun |")
    print("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for direct, diffuse, elevation, azimuth in CASES:
            epsilon, delta, sun, scale, (a, b, c, d, e), to_sun = beside(
                gendaylit, direct, diffuse, elevation, azimuth
            )
            # gendaylit -ang has the distance of the sun of day 0.
            sky = f"perez:dni={direct},dhi={diffuse},elevation={elevation},azimuth={azimuth},date=2000-12-31"
            found, words = picture(program, pathlib.Path(folder), sky)
            gamma = numpy.arccos(numpy.clip(numpy.tensordot(to_sun, direction, 1), -1, 1))
            up = numpy.maximum(direction[2], 1e-3)
            relative = (1 + a * numpy.exp(b / up)) * (1 + c * numpy.exp(d * gamma) + e * numpy.cos(gamma) ** 2)
            high = direction[2] > math.sin(math.radians(5))
            ratio = found[high] / (scale * relative[high])
            mean = ratio.mean()
            far = (gamma > math.radians(3))[high]
            stated = words.split("diffuse horizontal ")[1].split(" lx")[0]
            ours = float(words.split("direct normal ")[1].split(" lx")[0])
            print(
                f"| {direct} | {diffuse} | {elevation} | {azimuth} | {epsilon:.3f} | {delta:.3f} | {stated} "
                f"| {(found * weight).sum() / float(stated) - 1:+.2%} | {ours / sun - 1 if sun else 0:+.2%} "
                f"| {mean:.4f} | {abs(ratio / mean - 1).max():.2%} | {abs(ratio[far] / mean - 1).max():.2%} |"
            )


main()
