#!/usr/bin/env python3
"""Processor time of Mitsuba 3's path tracer until as many of its pixels are right as in our render.

    tashika render SCENE.xml --truth transport --size 64x64 --error 2% --threads 1 -o ours.exr
    python3 mitsuba_beside.py SCENE.xml ours.exr --reference-samples 40960

A pixel is right if its luminance is within --error of the reference, which is Mitsuba's own, with
random numbers of its own; its paths are as long as ours, whatever the scene sets. Scenes have to
take the width of their image from the parameter `res`, and be square. Needs the packages mitsuba,
OpenEXR and numpy; run it with `taskset -c 0` for the processor time of one thread.
"""

import argparse
import resource

import mitsuba as mi
import numpy as np
import OpenEXR

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance_of_file(path):
    with OpenEXR.File(path) as file:
        return np.asarray(file.channels()["RGB"].pixels, dtype=np.float64) @ LUMINANCE


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def batches(scene, integrator, samples, first_seed):
    """Mean luminance over ever more batches of samples, with the processor time of all so far."""
    total, spent, seed = 0.0, 0.0, first_seed
    while True:
        begun = processor_seconds()
        image = np.array(mi.render(scene, integrator=integrator, spp=samples, seed=seed), dtype=np.float64)
        spent += processor_seconds() - begun
        total = total + image[..., :3] @ LUMINANCE
        seed += 1
        yield total / (seed - first_seed), spent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("ours", help="a render of the same scene with --truth transport")
    parser.add_argument("--error", type=float, default=0.02)
    parser.add_argument("--reference-samples", type=int, default=40960)
    parser.add_argument("--step", type=int, default=1024, help="samples a pixel from one look to the next")
    parser.add_argument("--most", type=int, default=24, help="looks")
    args = parser.parse_args()

    mi.set_variant("llvm_ad_rgb")
    ours = luminance_of_file(args.ours)
    height, width = ours.shape
    if height != width:
        parser.error(f"{args.ours} has {width}x{height} pixels; expected a square")
    scene = mi.load_file(args.scene, res=width)
    integrator = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})

    looks = -(-args.reference_samples // args.step)
    for _, (reference, _) in zip(range(looks), batches(scene, integrator, args.step, first_seed=1_000)):
        pass
    right = lambda image: float((np.abs(image - reference) <= args.error * reference).mean())
    print(f"ours: {100 * right(ours):.1f} % within {100 * args.error:g} %, mean {ours.mean() / reference.mean():.4f} of the reference's")
    print("| samples | processor time (s) | within |\n|---:|---:|---:|")
    for look, (image, spent) in zip(range(1, args.most + 1), batches(scene, integrator, args.step, first_seed=1_000_000)):
        print(f"| {look * args.step} | {spent:.1f} | {100 * right(image):.1f} % |", flush=True)
        if right(image) >= right(ours):
            break


if __name__ == "__main__":
    main()
