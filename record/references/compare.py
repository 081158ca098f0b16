"""Mean radiance of scenes against reference images and Mitsuba.

    python compare.py TASHIKA FOLDER

FOLDER has the unpacked scenes (ignis-dev, mi3-*). Needs `pip install mitsuba`. Each row: the mean over the image of `path`, of the exact
sum over VPLs, of the reference image that comes with the scene, and of Mitsuba's own path tracer with paths of any length; then ratios
to Mitsuba.
"""

import os
import subprocess
import sys
import tempfile

import mitsuba
import numpy

mitsuba.set_variant("scalar_rgb")

SCENES = [  # file, reference, paths of ours, samples of Mitsuba's, VPLs, gather points
    ("ignis-dev/evaluation/point.xml", "ref-point-4096.exr", 256, 256, 1000, 4),
    ("ignis-dev/evaluation/plane.xml", "ref-plane-d6-4096.exr", 256, 256, 5000, 4),
    ("ignis-dev/evaluation/emissive-plane.xml", "ref-emissive-plane-4096.exr", 256, 256, 5000, 4),
    ("ignis-dev/evaluation/multilight.xml", "ref-multilight-4096.exr", 256, 256, 5000, 4),
    ("ignis-dev/evaluation/sphere-light.xml", "ref-sphere-light-4096.exr", 256, 256, 5000, 4),
    ("ignis-dev/evaluation/room.xml", "ref-room-4096.exr", 256, 256, 5000, 4),
    ("ignis-dev/evaluation/env.xml", "ref-env-4096.exr", 256, 256, 5000, 4),
    ("mi3-cornell-box/scene_v3.xml", None, 256, 256, 5000, 4),
    ("mi3-staircase2/scene.xml", None, 256, 256, 5000, 4),
]
SIZE = 96


def pixels(path):
    bitmap = mitsuba.Bitmap(path)
    names = [field.name.split(".")[-1] for field in bitmap.struct_()]
    channels = numpy.array(bitmap)
    return numpy.stack([channels[..., names.index(c)] for c in "RGB"], axis=-1)


def main(tashika, folder):
    print("| scene | `path` | VPLs | reference | Mitsuba | `path`/Mitsuba | VPLs/Mitsuba | reference/Mitsuba |")
    print("|---|---|---|---|---|---|---|---|")
    for name, reference, paths, samples, vpls, gather in SCENES:
        scene = os.path.join(folder, name)
        loaded = mitsuba.load_file(scene)
        width, height = loaded.sensors()[0].film().size()
        small = [SIZE, max(1, round(SIZE * height / width))]
        size = f"{small[0]}x{small[1]}"
        parameters = mitsuba.traverse(loaded)
        for key in [k for k in parameters.keys() if k.endswith("film.size") or k.endswith("film.crop_size")]:
            parameters[key] = small
        parameters.update()
        with tempfile.TemporaryDirectory() as work:
            means = []
            for options in (["--method", "path", "--paths", str(paths)], ["--vpls", str(vpls), "--gather", str(gather)]):
                out = os.path.join(work, "out.exr")
                subprocess.run([tashika, "render", scene, "--allow-outside", "--size", size, "-q", "-o", out] + options, check=True)
                means.append(pixels(out).mean(axis=(0, 1)))
        integrator = mitsuba.load_dict({"type": "path", "max_depth": -1})
        theirs = numpy.array(mitsuba.render(loaded, integrator=integrator, spp=samples))[..., :3].mean(axis=(0, 1))
        given = None
        if reference:
            given = pixels(os.path.join(folder, "ignis-dev/evaluation/references", reference)).mean(axis=(0, 1))
        show = lambda c: "–" if c is None else " ".join(f"{v:.4g}" for v in c)
        ratio = lambda c: "–" if c is None else f"{c.mean() / theirs.mean():.3f}"
        row = [os.path.basename(os.path.dirname(name)) + "/" + os.path.basename(name), show(means[0]), show(means[1]), show(given), show(theirs)]
        row += [ratio(means[0]), ratio(means[1]), ratio(given)]
        print("| " + " | ".join(row) + " |", flush=True)


main(*sys.argv[1:])
