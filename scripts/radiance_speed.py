#!/usr/bin/env python3
"""Time and measured error of many sensors, by `tashika sensors` and by `rtrace -I` of Radiance.

    pip install pyradiance numpy
    python3 scripts/radiance_speed.py PROGRAM SCENE.rad X0,Y0,X1,Y1,Z COUNT [OPTIONS...]

COUNT × COUNT sensors look up from a horizontal rectangle. tashika measures them with OPTIONS
(default: --error 5%), rtrace with the parameters ACCURATE, both on two threads. The errors are
those of TRUTHS sensors, drawn at random, against rtrace without interpolation, as in
radiance_sensors.py.
"""

import pathlib
import sys
import tempfile
import time

import numpy as np
from radiance_sensors import WEIGHTS, readings, run, truths

TRUTHS = 64
# Parameters that handbooks call accurate: indirect light is interpolated between fine samples.
ACCURATE = "-h -I -ab 6 -aa 0.1 -ar 512 -ad 4096 -as 1024 -lw 1e-5 -dt 0 -dc 1 -ds 0.05 -dj 0.7"


def by_rtrace(scene, lines):
    """Illuminance of the sensors (lx) by the parameters ACCURATE, and its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        octree, cache = pathlib.Path(folder) / "octree", pathlib.Path(folder) / "ambient"
        octree.write_bytes(run(["oconv", scene.name], scene.parent))
        command = ["rtrace", "-n", "2", "-af", str(cache), *ACCURATE.split(), str(octree)]
        begun = time.time()
        output = run(command, scene.parent, lines.encode())
        seconds = time.time() - begun
    rows = np.array([line.split()[:3] for line in output.decode().splitlines() if line.strip()], float)
    return rows @ WEIGHTS, seconds


def report(name, found, seconds, truth, error):
    """Prints a row: seconds, errors at the sensors with a truth."""
    relative = np.abs(found - truth) / truth
    within = np.mean(relative <= 0.05)
    row = [f"{seconds:.1f} s", f"{np.median(relative):.2%}", f"{np.quantile(relative, 0.95):.2%}", f"{within:.0%}"]
    print(f"{name:>8}  " + "  ".join(f"{cell:>8}" for cell in row), f"  truth ± {np.median(error / truth):.2%}")


def main():
    program, scene, place, count, *options = sys.argv[1:]
    program, scene, count = str(pathlib.Path(program).resolve()), pathlib.Path(scene).resolve(), int(count)
    x0, y0, x1, y1, z = map(float, place.split(","))
    places = [(x, y) for y in np.linspace(y0, y1, count) for x in np.linspace(x0, x1, count)]
    points = [f"{x:.5f} {y:.5f} {z:.5f} 0 0 1".split() for x, y in places]
    lines = "".join(" ".join(point) + "\n" for point in points)
    with tempfile.NamedTemporaryFile("w", suffix=".pts") as file:
        file.write(lines)
        file.flush()
        begun = time.time()
        ours, half = readings(program, str(scene), file.name, options or ["--error", "5%"])
        seconds = time.time() - begun
    chosen = np.random.default_rng(1).choice(len(points), TRUTHS, replace=False)
    truth, error = truths(scene, [points[i] for i in chosen], 16, 2048)
    print(f"{len(points)} sensors\n{'':>8}  {'time':>8}  {'median':>8}  {'95 % of':>8}  {'in 5 %':>8}")
    report("tashika", ours[chosen], seconds, truth, error)
    theirs, seconds = by_rtrace(scene, lines)
    report("rtrace", theirs[chosen], seconds, truth, error)
    kept = np.abs(ours[chosen] - truth) <= half[chosen] + 2 * error
    print(f"intervals kept: {kept.sum()} of {TRUTHS}")


if __name__ == "__main__":
    main()
