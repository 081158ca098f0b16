#!/usr/bin/env python3
"""Compares `tashika glare` with Radiance's `evalglare` on fisheye pictures that tashika rendered.

    python3 scripts/glare_beside.py PROGRAM EVALGLARE PICTURE.exr...

Each picture is written as a picture of Radiance (RGBE, 1 % a step) with the view `-vta -vh 180 -vv
180`, and both programs evaluate it with Radiance's photometry. Needs numpy.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "blender/tashika"))
import exr  # noqa: E402


def write_rgbe(path, colors):
    """Writes lines from the top as shared exponents."""
    height, width, _ = colors.shape
    largest = colors.max(axis=-1)
    mantissa, exponent = numpy.frexp(largest)
    scale = numpy.where(largest > 1e-32, mantissa * 256 / numpy.maximum(largest, 1e-38), 0)
    bytes_ = numpy.zeros((height, width, 4), dtype=numpy.uint8)
    bytes_[..., :3] = numpy.clip(colors * scale[..., None], 0, 255)
    bytes_[..., 3] = numpy.where(scale > 0, exponent + 128, 0)
    header = "#?RADIANCE\nVIEW= -vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180\nFORMAT=32-bit_rle_rgbe\n\n"
    path.write_bytes(header.encode() + f"-Y {height} +X {width}\n".encode() + bytes_.tobytes())


def main():
    program, evalglare, *pictures = sys.argv[1:]
    print("| picture | sources | E_v (lx) | evalglare | L_b (cd/m²) | evalglare | DGP | evalglare | UGR | evalglare |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for picture in pictures:
            hdr = pathlib.Path(folder) / "picture.hdr"
            write_rgbe(hdr, exr.File(picture).plane("R", "G", "B")[::-1])
            ours = [program, "glare", picture, "--photometry", "radiance", "--json", "-"]
            found = json.loads(subprocess.run(ours, check=True, capture_output=True, text=True).stdout)
            other = subprocess.run([evalglare, "-d", str(hdr)], check=True, capture_output=True, text=True).stdout
            last = next(line for line in other.splitlines() if line.startswith("dgp,"))
            names, numbers = last.split(":", 1)
            theirs = dict(zip(names.replace(" ", "").split(","), numbers.split()))
            count = next(line for line in other.splitlines() if line.strip()).split()[0]
            ugr = f"{found['ugr']['value']:.2f}" if found["ugr"] else "none"
            print(
                f"| {pathlib.Path(picture).stem} | {len(found['sources'])} ({count}) "
                f"| {found['vertical_illuminance']['value']:.1f} | {float(theirs['E_v']):.1f} "
                f"| {found['background']['value']:.2f} | {float(theirs['lum_backg']):.2f} "
                f"| {found['dgp']['value']:.4f} | {float(theirs['dgp']):.4f} "
                f"| {ugr} | {float(theirs['ugr']):.2f} |"
            )


main()
