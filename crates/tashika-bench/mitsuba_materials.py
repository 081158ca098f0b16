#!/usr/bin/env python3
"""Writes how much Mitsuba 3 says that its materials reflect, for the suite's `mitsuba_materials`.

    pip install mitsuba numpy
    python3 crates/tashika-bench/mitsuba_materials.py > crates/tashika/tests/suite/mitsuba_materials.txt

A row is a BSDF in Mitsuba's XML and nine numbers: the directional albedo (red, green, blue) where
the surface is seen 75, 40 and 12 degrees above it, a mean over 2^20 samples of `BSDF.sample`. Where LLVM is not found, name
its library in `DRJIT_LIBLLVM_PATH` (19 works, 14 does not).
"""

import math

import drjit as dr
import mitsuba as mi
import numpy

mi.set_variant("llvm_ad_rgb")
SAMPLES = 1 << 20
ELEVATIONS = (75, 40, 12)
COLOR = '<rgb name="{}" value="0.7 0.4 0.1"/>'


def number(name, value):
    return f'<float name="{name}" value="{value}"/>'


def boolean(name, value):
    return f'<boolean name="{name}" value="{str(value).lower()}"/>'


def string(name, value):
    return f'<string name="{name}" value="{value}"/>'


def bsdf(kind, *inside):
    return f'<bsdf type="{kind}">{"".join(inside)}</bsdf>'


def materials():
    diffuse = COLOR.format("diffuse_reflectance")
    yield bsdf("diffuse", COLOR.format("reflectance"))
    for ior in (1.3, 1.5, 1.9):
        for nonlinear in (False, True):
            inside = (number("int_ior", ior), number("ext_ior", 1.0), boolean("nonlinear", nonlinear), diffuse)
            yield bsdf("plastic", *inside)
            for alpha in (0.02, 0.05, 0.1, 0.25, 0.5):
                yield bsdf("roughplastic", string("distribution", "ggx"), number("alpha", alpha), *inside)
    for alpha in (0.05, 0.25, 0.5):
        yield bsdf("roughplastic", number("alpha", alpha), diffuse)
    for metal in ("Au", "Cu", "Al", "none"):
        yield bsdf("conductor", string("material", metal))
    for distribution in ("ggx", "beckmann"):
        for alpha in (0.05, 0.25, 0.5):
            yield bsdf(
                "roughconductor",
                string("material", "Au"),
                string("distribution", distribution),
                number("alpha", alpha),
            )
    for ior in (1.3, 1.5, 1.9):
        yield bsdf("thindielectric", number("int_ior", ior), number("ext_ior", 1.0))
    for ior in (1.3, 1.5, 1.9):
        # Channels tell what is reflected from what is refracted.
        factors = ("specular_reflectance", "0.2 1.0 0.2"), ("specular_transmittance", "1.0 0.2 0.2")
        factors = [f'<rgb name="{name}" value="{value}"/>' for name, value in factors]
        inside = (number("int_ior", ior), number("ext_ior", 1.0), *factors)
        yield bsdf("dielectric", *inside)
        for distribution in ("ggx", "beckmann"):
            for alpha in (0.05, 0.25, 0.5):
                yield bsdf("roughdielectric", string("distribution", distribution), number("alpha", alpha), *inside)
    for metallic in (0.0, 0.3, 1.0):
        for roughness in (0.1, 0.3, 0.6, 1.0):
            yield bsdf(
                "principled",
                COLOR.format("base_color"),
                number("metallic", metallic),
                number("roughness", roughness),
            )
    plain = bsdf("diffuse", COLOR.format("reflectance"))
    yield bsdf("twosided", plain)


def albedo(xml, elevation):
    material = mi.load_string(xml.replace("<bsdf", '<bsdf version="3.0.0"', 1))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(elevation, SAMPLES)
    angle = math.radians(elevation)
    found = dr.zeros(mi.SurfaceInteraction3f, SAMPLES)
    found.wi = mi.Vector3f(math.cos(angle), 0, math.sin(angle))
    found.t = 1.0
    found.n = mi.Normal3f(0, 0, 1)
    found.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    # Of flux: without the square of the index by which refraction changes radiance.
    _, weight = material.sample(mi.BSDFContext(mi.TransportMode.Importance), found, sampler.next_1d(), sampler.next_2d())
    weight = dr.select(dr.isfinite(weight), weight, 0)
    return [numpy.array(weight[channel]).mean() for channel in range(3)]


def main():
    print(f"# Written by crates/tashika-bench/mitsuba_materials.py with Mitsuba {mi.__version__}.")
    for xml in materials():
        numbers = (value for elevation in ELEVATIONS for value in albedo(xml, elevation))
        print(xml, *(f"{value:.4f}" for value in numbers))


if __name__ == "__main__":
    main()
