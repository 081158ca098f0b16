#!/usr/bin/env python3
"""Intervals of `tashika sensors` against `rtrace -I` of Radiance.

    pip install pyradiance numpy
    python3 scripts/radiance_sensors.py PROGRAM SCENE.rad POINTS.pts RUNS SAMPLES [OPTIONS...]

rtrace measures each sensor RUNS times with SAMPLES ambient samples, ten bounces, no interpolation
and random numbers that are not correlated. The spread of the runs is the standard error of the
truth. OPTIONS go to tashika. For each sensor, both illuminances (lx) with their errors, the
difference, and a verdict are printed: within both errors are differences of at most the half-width
and two standard errors together.
"""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import pyradiance

HOME = pathlib.Path(pyradiance.__file__).parent
# Weights of Radiance's channels, and its lumens of a watt.
WEIGHTS = 179 * np.array([0.265074126, 0.670114631, 0.064811243])
# Bounces, no interpolation, weights so small that no path ends early, area lights in small parts.
SETTINGS = "-h -I -u+ -ab 10 -aa 0 -as 0 -lr -20 -lw 1e-9 -dt 0 -dc 1 -dj 0.9 -ds 0.02 -dr 4 -dp 0 -st 0 -ss 1"


def run(command, folder, data=None):
    """Bytes that a program of Radiance writes."""
    environment = {**os.environ, "RAYPATH": f".:{HOME / 'lib'}"}
    command = [str(HOME / "bin" / command[0]), *command[1:]]
    done = subprocess.run(command, cwd=folder, env=environment, input=data, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr.decode())
    return done.stdout


def truths(scene, points, runs, samples):
    """Illuminance of each sensor (lx), and its standard error."""
    with tempfile.NamedTemporaryFile(suffix=".oct") as octree:
        octree.write(run(["oconv", scene.name], scene.parent))
        octree.flush()
        lines = "".join(f"{' '.join(point)}\n" * runs for point in points)
        output = run(["rtrace", *SETTINGS.split(), "-ad", str(samples), octree.name], scene.parent, lines.encode())
    rows = np.array([line.split()[:3] for line in output.decode().splitlines() if line.strip()], float)
    of_runs = (rows @ WEIGHTS).reshape(len(points), runs)
    return of_runs.mean(axis=1), of_runs.std(axis=1, ddof=1) / np.sqrt(runs)


def readings(program, scene, points, options):
    """Illuminance of each sensor (lx), and the half-width of its interval."""
    command = [program, "sensors", scene, "--points", points, "--photometry", "radiance", *options]
    output = subprocess.run(command, capture_output=True, text=True, check=False)
    if output.returncode not in (0, 4):
        sys.exit(output.stderr)
    rows = list(csv.DictReader(line for line in output.stdout.splitlines() if not line.startswith("#")))
    value = np.array([float(row["illuminance"]) for row in rows])
    return value, np.array([float(row["half_width"] or "inf") for row in rows])


def main():
    program, scene, points, runs, samples, *options = sys.argv[1:]
    scene, points = pathlib.Path(scene).resolve(), pathlib.Path(points).resolve()
    lines = [line.split("#")[0].split() for line in points.read_text(encoding="utf-8").splitlines()]
    begun = time.monotonic()
    value, half = readings(program, scene, points, options)
    between = time.monotonic()
    truth, error = truths(scene, [line for line in lines if line], int(runs), int(samples))
    ended = time.monotonic()
    within = np.abs(value - truth) <= half + 2 * error
    print("sensor     rtrace  2 errors    tashika  half-width  difference")
    for k, agrees in enumerate(within):
        off = value[k] / truth[k] - 1
        print(
            f"{k + 1:6} {truth[k]:10.2f} {2 * error[k]:9.2f} {value[k]:10.2f} {half[k]:11.2f} {off:10.2%}"
            f"  {'within' if agrees else 'OUTSIDE'}"
        )
    print(
        f"{scene.stem}: {within.sum()} of {len(within)} within both errors; median difference "
        f"{np.median(value / truth - 1):.2%}; tashika {between - begun:.0f} s, rtrace {ended - between:.0f} s"
    )


if __name__ == "__main__":
    main()
