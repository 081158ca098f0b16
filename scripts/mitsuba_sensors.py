#!/usr/bin/env python3
"""Intervals of `tashika sensors` against the `irradiancemeter` of Mitsuba 3, and seed against seed.

    pip install mitsuba numpy
    python3 scripts/mitsuba_sensors.py PROGRAM SCENE.xml POINTS.pts PATHS SEEDS [OPTIONS...]

Mitsuba measures each sensor on a black square of a millimetre, by PATHS paths in RUNS independent
runs, whose spread gives the standard error of the truth. tashika measures the sensors with seeds 1
to SEEDS. Printed are the share of intervals that hold the truth (an interval counts as wrong only
if the truth is more than two standard errors outside), the share of pairs of intervals of two
seeds that are disjoint, the share of sensors that reached the error, rays, and the median time.
"""

import csv
import itertools
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np
from mitsuba_pictures import LUMINANCE, adapted

# The compiled variants of Mitsuba 3.9.1 fail on these sensors.
mi.set_variant("scalar_rgb")
RUNS = 16
# Side of the square on which a sensor of Mitsuba lies (m), and its distance from the place.
SIDE, LIFT = 1e-3, 1e-4


def meter(number, place, normal):
    """A square with a sensor, in the format of Mitsuba's files."""
    right = np.cross(normal, [0, 1, 0] if abs(normal[1]) < 0.9 else [1, 0, 0])
    target, origin = place + normal, place + LIFT * normal
    at = [", ".join(f"{v:.9g}" for v in vector) for vector in (origin, target, right)]
    return f"""<shape type="rectangle" id="meter{number}">
        <transform name="to_world"><scale value="{SIDE / 2}"/>
            <lookat origin="{at[0]}" target="{at[1]}" up="{at[2]}"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
        <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="1"/>
            <integer name="height" value="1"/><rfilter type="box"/></film></sensor></shape>\n"""


def truths(scene, points, paths):
    """Luminous irradiance of each sensor, and its standard error."""
    text = adapted(scene.read_text(encoding="utf-8"), (16, 16))
    meters = "".join(meter(k, place, normal) for k, (place, normal) in enumerate(points))
    if 'version="0.' in text:
        meters = meters.replace("to_world", "toWorld")
    text = text.replace("</scene>", meters + "</scene>")
    with tempfile.NamedTemporaryFile("w", suffix=".xml", dir=scene.parent, delete=False) as file:
        file.write(text)
    try:
        loaded = mi.load_file(file.name, optimize=False)
    finally:
        os.remove(file.name)
    meters = [s for s in loaded.sensors() if "Irradiance" in type(s).__name__ or "irradiance" in str(s).lower()]
    assert len(meters) == len(points), [type(s).__name__ for s in loaded.sensors()]
    of_runs = [
        [np.array(mi.render(loaded, sensor=s, spp=paths // RUNS, seed=seed)).reshape(-1)[:3] @ LUMINANCE for s in meters]
        for seed in range(1, RUNS + 1)
    ]
    of_runs = np.array(of_runs)
    return of_runs.mean(axis=0), of_runs.std(axis=0, ddof=1) / np.sqrt(RUNS)


def readings(program, scene, points, seed, options):
    """Rows of the table of one seed."""
    command = [program, "sensors", scene, "--points", points, "--seed", str(seed), *options]
    output = subprocess.run(command, capture_output=True, text=True, check=False)
    if output.returncode not in (0, 4):
        sys.exit(output.stderr)
    return list(csv.DictReader(line for line in output.stdout.splitlines() if not line.startswith("#")))


def main():
    program, scene, points, paths, seeds, *options = sys.argv[1:]
    lines = [line.split("#")[0].split() for line in pathlib.Path(points).read_text().splitlines()]
    places = [np.array(line, float) for line in lines if line]
    places = [(p[:3], p[3:] / np.linalg.norm(p[3:])) for p in places]
    truth, error = truths(pathlib.Path(scene), places, int(paths))
    tables, seconds = [], []
    for seed in range(1, int(seeds) + 1):
        begun = time.monotonic()
        tables.append(readings(program, scene, points, seed, options))
        seconds.append(time.monotonic() - begun)
    value = np.array([[float(row["illuminance"]) for row in table] for table in tables])
    half = np.array([[float(row["half_width"] or "inf") for row in table] for table in tables])
    rays = np.array([[float(row["rays"]) for row in table] for table in tables])
    reached = np.mean([[row["stop"] in ("rule_met", "complete") for row in table] for table in tables])
    outside = np.abs(value - truth) - half
    kept = np.mean(outside <= 2 * error)
    pairs = list(itertools.combinations(range(len(tables)), 2))
    disjoint = np.mean([np.abs(value[a] - value[b]) > half[a] + half[b] for a, b in pairs]) if pairs else 0.0
    off = value.mean(axis=0) / truth - 1
    print(
        f"{pathlib.Path(scene).parent.name}/{pathlib.Path(scene).stem}: {len(places)} sensors, {len(tables)} seeds; "
        f"kept {kept:.1%} (exactly {np.mean(outside <= 0):.1%}), disjoint {disjoint:.2%}, reached {reached:.1%}, "
        f"rays {rays.mean():.0f}, {np.median(seconds):.1f} s; "
        f"truth: median error {np.median(error / truth):.2%}; mean over seeds off by {np.median(np.abs(off)):.2%} in the median, "
        f"{np.max(np.abs(off)):.2%} at most"
    )


main()
