#!/usr/bin/env python3
"""Writes the table of `tashika::bsdf::sheen`: the albedo of the fibres of cloth.

    pip install numpy
    python3 scripts/sheen_albedo.py > crates/tashika-scene/src/bsdf/sheen/table.rs

It is the integral of the sheen of `KHR_materials_sheen` times the cosine, by the formulas of
`material_math.sheen`, with Gauss's nodes in the square root of the cosine and in the azimuth.
"""

import numpy as np

from material_math import sheen

ROUGHNESSES = [0.1, 0.125, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0]
STEPS = 16
NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)
ROOTS, AZIMUTHS = np.meshgrid(0.5 + 0.5 * NODES, np.pi * (0.5 + 0.5 * NODES), indexing="ij")
WEIGHT = np.outer(WEIGHTS * (0.5 + 0.5 * NODES), WEIGHTS) * np.pi


def directions(cosines, azimuths=0.0):
    sines = np.sqrt(np.maximum(1 - cosines**2, 0))
    parts = np.broadcast_arrays(sines * np.cos(azimuths), sines * np.sin(azimuths), cosines)
    return np.stack(parts, axis=-1)


def albedo(cosine, roughness):
    wi = directions(ROOTS**2, AZIMUTHS)
    wo = np.broadcast_to(directions(np.asarray(cosine)), wi.shape)
    return (WEIGHT * wi[..., 2] * sheen(wo, wi, roughness)).sum()


def main():
    print("//! Written by `scripts/sheen_albedo.py`.\n")
    print("/// Roughness of the rows.")
    print(f"pub(super) const ROUGHNESSES: [f32; {len(ROUGHNESSES)}] =")
    print(f"    {ROUGHNESSES};\n")
    print("/// `E` at cosines of `(k / 16)²`.")
    print("#[rustfmt::skip]")
    print(f"pub(super) const ALBEDOS: [[f32; {STEPS + 1}]; {len(ROUGHNESSES)}] = [")
    for roughness in ROUGHNESSES:
        row = [albedo(max((k / STEPS) ** 2, 1e-6), roughness) for k in range(STEPS + 1)]
        print("    [" + ", ".join(f"{value:.5f}" for value in row) + "],")
    print("];")


if __name__ == "__main__":
    main()
