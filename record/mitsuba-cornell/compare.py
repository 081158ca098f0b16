#!/usr/bin/env python3
"""The same Cornell box in tashika (exact many-light sum and path tracer) and in Mitsuba 3.

usage: compare.py SCENE.xml [--size 64] [--tashika PROGRAM] [--out DIR]

Needs: pip install mitsuba numpy. SCENE.xml is a Mitsuba 3 scene of diffuse rectangles and cubes with one area
light and a perspective camera that looks along -z, as `mi3-cornell-box/scene_v3.xml`. It is written as glTF for tashika:
`KHR_materials_specular` of 0 makes the material Lambertian.

Every estimate comes with a standard error: Mitsuba's and the exact sum's from independent repetitions, the path
tracer's from its own plane. Printed are the ratio of the means and how the pixels' differences are distributed in units of
their common error; for equal truths |z| < 1.96 holds for 95 % of the pixels and the z of the means is a draw from N(0, 1).
"""
import argparse, base64, json, pathlib, struct, subprocess, sys
import xml.etree.ElementTree as ET

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])

RECTANGLE = ([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)])
CUBE = (
    [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)],
    [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
     (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)],
)


def numbers(text):
    return [float(v) for v in text.replace(",", " ").split()]


def gltf(root):
    """The scene as a glTF dictionary with all data inside."""
    blob, views, accessors, meshes, materials, nodes = bytearray(), [], [], [], [], []

    def accessor(data, component, kind, bounds=None):
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        blob.extend(data)
        count = len(data) // 4 // (3 if kind == "VEC3" else 1)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind, **(bounds or {})})
        return len(accessors) - 1

    reflectance = {b.get("id"): numbers(b.find(".//rgb").get("value")) for b in root.findall("bsdf")}
    for shape in root.findall("shape"):
        vertices, triangles = RECTANGLE if shape.get("type") == "rectangle" else CUBE
        m = np.array(numbers(shape.find("transform/matrix").get("value"))).reshape(4, 4)
        if np.linalg.det(m[:3, :3]) < 0:
            triangles = [(a, c, b) for a, b, c in triangles]
        world = [tuple((m @ np.array([*v, 1.0]))[:3]) for v in vertices]
        lo, hi = np.min(world, 0).astype(np.float32), np.max(world, 0).astype(np.float32)
        position = accessor(struct.pack(f"<{3 * len(world)}f", *sum(world, ())), 5126, "VEC3",
                            {"min": lo.tolist(), "max": hi.tolist()})
        flat = sum(triangles, ())
        indices = accessor(struct.pack(f"<{len(flat)}I", *flat), 5125, "SCALAR")
        material = {
            "pbrMetallicRoughness": {"baseColorFactor": [*reflectance[shape.find("ref").get("id")], 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
        }
        emitter = shape.find("emitter/rgb")
        if emitter is not None:
            radiance = np.array(numbers(emitter.get("value")))
            material["emissiveFactor"] = (radiance / radiance.max()).tolist()
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": float(radiance.max())}
        materials.append(material)
        meshes.append({"primitives": [{"attributes": {"POSITION": position}, "indices": indices, "material": len(materials) - 1}]})
        nodes.append({"mesh": len(meshes) - 1})
    camera = np.array(numbers(root.find("sensor/transform/matrix").get("value"))).reshape(4, 4)
    fov = float(root.find("sensor/float[@name='fov']").get("value"))
    nodes.append({"camera": 0, "translation": camera[:3, 3].tolist()})
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "extensionsUsed": ["KHR_materials_specular", "KHR_materials_emissive_strength"],
        "cameras": [{"type": "perspective", "name": "main", "perspective": {"yfov": float(np.radians(fov)), "znear": 0.01}}],
        "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}],
    }


def planes(path):
    """Luminance and standard error of a tashika EXR."""
    bitmap = mi.Bitmap(str(path))
    names = [c.name for c in bitmap.struct_()]
    data = np.array(bitmap, dtype=np.float64)
    channel = lambda n: data[..., names.index(n)]
    return np.stack([channel(c) for c in "RGB"], -1) @ WEIGHTS, channel("standard_error.Y")


def repeated(values):
    """Mean and standard error over independent repetitions."""
    values = np.array(values)
    return values.mean(0), values.std(0, ddof=1) / np.sqrt(len(values))


def report(name, a, b):
    (ma, ea), (mb, eb) = a, b
    z = (ma - mb) / np.hypot(ea, eb)
    error = np.hypot(np.sqrt((ea**2).sum()), np.sqrt((eb**2).sum())) / ma.size
    difference = ma.mean() - mb.mean()
    print(f"| {name} | {ma.mean():.5f} | {mb.mean():.5f} | {100 * difference / mb.mean():+.3f} % ± {100 * error / mb.mean():.3f} % "
          f"| {difference / error:+.2f} | {100 * (np.abs(z) < 1.96).mean():.1f} % | {np.abs(z).max():.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--tashika", default="target/release/tashika")
    parser.add_argument("--out", default="/tmp/tashika-mitsuba-cornell")
    parser.add_argument("--sets", type=int, default=24)
    parser.add_argument("--vpls", type=int, default=3000)
    parser.add_argument("--paths", type=int, default=2048)
    options = parser.parse_args()
    out = pathlib.Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    root = ET.parse(options.scene).getroot()
    (out / "cornell.gltf").write_text(json.dumps(gltf(root)))

    def tashika(name, *arguments):
        target = out / f"{name}.exr"
        command = [options.tashika, "render", str(out / "cornell.gltf"), "-o", str(target),
                   "--size", f"{options.size}x{options.size}", "-q", *arguments]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=sys.stderr)
        return planes(target)

    scene = mi.load_file(options.scene, resx=options.size, resy=options.size)
    sensor = mi.load_dict({
        "type": "perspective", "fov": float(root.find("sensor/float[@name='fov']").get("value")),
        "to_world": mi.ScalarTransform4f(np.array(numbers(root.find("sensor/transform/matrix").get("value"))).reshape(4, 4)),
        "film": {"type": "hdrfilm", "width": options.size, "height": options.size, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        "sampler": {"type": "independent"},
    })
    integrator = mi.load_dict({"type": "path", "max_depth": 66, "rr_depth": 10})
    render = lambda seed: np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=options.paths // 4, seed=seed), dtype=np.float64) @ WEIGHTS
    mitsuba = repeated([render(seed) for seed in range(16)])
    path = tashika("path", "--method", "path", "--paths", str(options.paths))
    exact = repeated([
        tashika("exact", "--method", "exact", "--vpls", str(options.vpls), "--gather", "2", "--clamp", "off", "--seed", str(seed))[0]
        for seed in range(1, options.sets + 1)
    ])
    print(f"Mitsuba {mi.__version__} `{mi.variant()}`, {options.size}×{options.size}, {4 * options.paths} paths a pixel; tashika: "
          f"{options.paths} paths a pixel; {options.sets} sets of {options.vpls} VPLs × 2 gather points, no clamp.\n")
    print("| this against that | mean of this | mean of that | difference of means | z of means | pixels with abs z < 1.96 | largest abs z |")
    print("|---|---|---|---|---|---|---|")
    report("tashika `path` against Mitsuba `path`", path, mitsuba)
    report("tashika `exact` against Mitsuba `path`", exact, mitsuba)
    report("tashika `exact` against tashika `path`", exact, path)


if __name__ == "__main__":
    main()
