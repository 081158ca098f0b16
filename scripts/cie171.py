#!/usr/bin/env python3
"""Cases after CIE 171:2006, section 5, by `tashika sensors`, against their closed forms.

    python3 scripts/cie171.py PROGRAM [SEEDS]

Each case is a small scene for which illuminance is known: by Lambert's formula for polygons, by the
inverse square law, by the balance of flux in a closed room, or by an integral over the opening,
which is computed here to six digits. Printed is a table of all sensors with a seed of 1, and below
it the share of intervals, over all seeds, that hold the closed form. The dimensions are our own:
the formulas, not the tables of the report, are the reference.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def factor(corners, place, normal):
    """Irradiance of a polygon of radiance 1, wholly in front of the sensor (Lambert 1760)."""
    total = 0.0
    for k, corner in enumerate(corners):
        a, b = unit(minus(corner, place)), unit(minus(corners[(k + 1) % len(corners)], place))
        edge = cross(a, b)
        total += 0.5 * math.acos(max(-1.0, min(1.0, dot(a, b)))) * dot(normal, unit(edge))
    return abs(total)


def through(corner, a, b, place, normal, luminance, steps=400):
    """Irradiance by a sky of the given luminance through a parallelogram; midpoint rule."""
    area = cross(a, b)
    total = 0.0
    for i in range(steps):
        for j in range(steps):
            u, v = (i + 0.5) / steps, (j + 0.5) / steps
            d = minus([c + u * x + v * y for c, x, y in zip(corner, a, b)], place)
            squared = dot(d, d)
            direction = [x / math.sqrt(squared) for x in d]
            cos = max(0.0, dot(normal, direction))
            total += luminance(direction) * cos * abs(dot(area, direction)) / squared
    return total / steps**2


def overcast(direction):
    """Luminance of the overcast sky with 10,000 lx on a horizontal plane; black ground."""
    return 10_000 * 9 / (7 * math.pi) * (1 + 2 * direction[1]) / 3 if direction[1] > 0 else 0.0


def uniform(direction):
    return 10_000 / math.pi if direction[1] > 0 else 0.0


class Model:
    """Quadrilaterals with materials, as Wavefront OBJ."""

    def __init__(self):
        self.quads = []

    def add(self, corner, a, b, material):
        far = [c + x + y for c, x, y in zip(corner, a, b)]
        ends = [[c + x for c, x in zip(corner, a)], far, [c + y for c, y in zip(corner, b)]]
        self.quads.append(([corner, *ends], material))

    def room(self, size, material, openings=()):
        """A closed room from the origin, with its front wall or roof around an opening left out."""
        w, h, d = size
        sides = {
            "floor": ([0, 0, 0], [w, 0, 0], [0, 0, d]),
            "roof": ([0, h, 0], [0, 0, d], [w, 0, 0]),
            "back": ([0, 0, 0], [0, h, 0], [w, 0, 0]),
            "front": ([0, 0, d], [w, 0, 0], [0, h, 0]),
            "left": ([0, 0, 0], [0, 0, d], [0, h, 0]),
            "right": ([w, 0, 0], [0, h, 0], [0, 0, d]),
        }
        for name, (corner, a, b) in sides.items():
            hole = dict(openings).get(name)
            parts = [(0, 1, 0, 1)]
            if hole:
                s, t, u, v = hole
                parts = [(0, s, 0, 1), (t, 1, 0, 1), (s, t, 0, u), (s, t, v, 1)]
            for s, t, u, v in parts:
                at = [c + s * x + u * y for c, x, y in zip(corner, a, b)]
                self.add(at, [(t - s) * x for x in a], [(v - u) * y for y in b], material)

    def write(self, folder, materials):
        lines = ["mtllib case.mtl"]
        for corners, _ in self.quads:
            lines += ["v " + " ".join(f"{c:.9g}" for c in corner) for corner in corners]
        for k, (_, material) in enumerate(self.quads):
            lines += [f"usemtl {material}", "f " + " ".join(str(4 * k + n) for n in range(1, 5))]
        (folder / "case.obj").write_text("\n".join(lines) + "\n")
        text = "".join(f"newmtl {name}\n{body}\n" for name, body in materials.items())
        (folder / "case.mtl").write_text(text)
        return folder / "case.obj"


GREY = {"black": "Kd 0 0 0", "half": "Kd 0.5 0.5 0.5", "lamp": "Kd 0 0 0\nKe 100 100 100", "white": "Kd 0.8 0.8 0.8"}
UP = [0, 1, 0]


def cases():
    """Name, model, options, sensors with their illuminance."""
    ground = Model()
    ground.add([-20, -1, -20], [0, 0, 40], [40, 0, 0], "black")
    sensors = []
    for x in (0.0, 1.0, 2.0, 4.0):
        sensors.append(([x, 0, 0], UP, 1000 * 3 / (9 + x * x) ** 1.5))
    watts = 4 * math.pi * 1000
    yield "point source (5.2)", ground, ["--light", f"point:0,3,0,{watts:.9g}"], sensors

    area = Model()
    area.add([-20, -1, -20], [0, 0, 40], [40, 0, 0], "black")
    area.add([-0.5, 2, -1], [1, 0, 0], [0, 0, 2], "lamp")
    lamp = [[-0.5, 2, -1], [0.5, 2, -1], [0.5, 2, 1], [-0.5, 2, 1]]
    sensors = [(p, n, 100 * factor(lamp, p, n)) for p, n in [([0, 0, 0], UP), ([1, 0, 1], UP), ([3, 1, 0], [-1, 0, 0])]]
    yield "area source (5.3)", area, [], sensors

    for size in (1, 2):
        low, high = 0.5 - size / 8, 0.5 + size / 8
        roof = Model()
        roof.room([4, 3, 4], "black", [("roof", (low, high, low, high))])
        corner, a, b = [4 * low, 3, 4 * low], [size, 0, 0], [0, 0, size]
        for name, sky in (("overcast", overcast), ("uniform", uniform)):
            places = [([2, 0.001, 2], UP), ([1, 0.001, 1], UP), ([3.5, 0.001, 2], UP)]
            sensors = [(p, n, through(corner, a, b, p, n, sky)) for p, n in places]
            yield f"sky through {size} m x {size} m of roof, {name} (5.10)", roof, ["--environment", f"cie:{name}"], sensors

    window = Model()
    window.room([4, 3, 4], "black", [("front", (0.25, 0.75, 1 / 3, 2 / 3))])
    corner, a, b = [1, 1, 4], [2, 0, 0], [0, 1, 0]
    for name, sky in (("overcast", overcast), ("uniform", uniform)):
        places = [([2, 0.001, 3], UP), ([2, 0.001, 1], UP), ([2, 1.5, 1], [0, 0, 1])]
        sensors = [(p, n, through(corner, a, b, p, n, sky)) for p, n in places]
        yield f"sky through a window, {name} (5.11)", window, ["--environment", f"cie:{name}"], sensors

    plate = Model()
    plate.add([-0.5, 0, -0.5], [0, 0, 1], [1, 0, 0], "half")
    square = [[-0.5, 0, -0.5], [-0.5, 0, 0.5], [0.5, 0, 0.5], [0.5, 0, -0.5]]
    # Relative to the plate's own illuminance, which the first sensor measures.
    places = [([0, 0.001, 0], UP), ([-1, 0.3, 0], [1, 0, 0]), ([-2, 1, 0.5], [1, 0, 0])]
    sensors = [(p, n, 0.5 * factor(square, p, n) / math.pi if n != UP else None) for p, n in places]
    yield "reflection by a lit square (5.6)", plate, ["--light", "sun:elevation=90,azimuth=0"], sensors

    for material, reflectance in (("half", 0.5), ("white", 0.8)):
        cube = Model()
        cube.room([4, 4, 4], material)
        mean = watts / (6 * 16) / (1 - reflectance)
        grid = [((k % 8 + 0.5) / 2, (k // 8 + 0.5) / 2) for k in range(64)]
        sensors = [([x, 0.0005, z], UP, None) for x, z in grid]
        yield f"closed cube, reflectance {reflectance}, mean of a face (5.8)", cube, ["--light", f"point:2,2,2,{watts:.9g}"], (sensors, mean)


def run(program, scene, points, options, seed):
    command = [program, "sensors", scene, "--points", points, "--error", "5%", "--seed", str(seed), *options]
    output = subprocess.run(command, capture_output=True, text=True, check=False)
    if output.returncode not in (0, 4):
        sys.exit(output.stderr)
    rows = csv.DictReader(line for line in output.stdout.splitlines() if not line.startswith("#"))
    return [(float(row["illuminance"]), float(row["half_width"])) for row in rows]


def main():
    program, seeds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
    held = count = 0
    print("| case | sensor | closed form (lx) | tashika (lx) | off | holds |\n|---|---|---:|---:|---:|---|")
    for name, model, options, sensors in cases():
        mean = None
        if isinstance(sensors, tuple):
            sensors, mean = sensors
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            scene = model.write(folder, GREY)
            points = folder / "case.pts"
            points.write_text("".join(" ".join(f"{v:.9g}" for v in [*p, *n]) + "\n" for p, n, _ in sensors))
            for seed in range(1, seeds + 1):
                found = run(program, scene, points, options, seed)
                rows = []
                if mean is not None:
                    value, half = (sum(part) / len(found) for part in zip(*found))
                    rows.append((f"mean of {len(found)}", mean, value, half))
                else:
                    own = found[0][0] if sensors[0][2] is None else 1.0
                    for (place, _, truth), (value, half) in zip(sensors, found):
                        if truth is not None:
                            rows.append((" ".join(f"{v:g}" for v in place), truth * own, value, half))
                for label, truth, value, half in rows:
                    holds = abs(value - truth) <= half + 1e-4 * truth
                    held, count = held + holds, count + 1
                    if seed == 1:
                        off = value / truth - 1
                        print(f"| {name} | {label} | {truth:.4g} | {value:.4g} ± {half:.2g} | {off:+.2%} | {'yes' if holds else '**no**'} |", flush=True)
    print(f"\n{held} of {count} intervals hold the closed form ({held / count:.1%}).")


main()
