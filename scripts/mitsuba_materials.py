#!/usr/bin/env python3
"""Writes the reflectance of Mitsuba 3's materials by itself, for the suite's `mitsuba_materials`.

    pip install mitsuba numpy
    python3 scripts/mitsuba_materials.py > crates/tashika/tests/suite/mitsuba_materials.txt

A row is a BSDF in Mitsuba's XML and 18 numbers, each three a colour: the directional albedo where
the surface is seen 75, 40 and 12 degrees above it, a mean over 2^20 samples of `BSDF.sample`; then
the BSDF times the cosine (1/sr) for each pair of directions in `PAIRS`. Where LLVM is not found,
name its library in `DRJIT_LIBLLVM_PATH` (19 works, 14 does not).
"""

import math

import drjit as dr
import mitsuba as mi
import numpy

from material_table import ELEVATIONS, PAIRS, numbers

mi.set_variant("llvm_ad_rgb")
SAMPLES = 1 << 20
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
        # Along the direction of view that all share, and across.
        for along, across in ((0.05, 0.4), (0.4, 0.05), (0.3, 0.15)):
            yield bsdf(
                "roughconductor",
                string("material", "Au"),
                string("distribution", distribution),
                number("alpha_u", along),
                number("alpha_v", across),
            )
    for ior in (1.3, 1.5, 1.9):
        yield bsdf("thindielectric", number("int_ior", ior), number("ext_ior", 1.0))
    for ior in (1.3, 1.5, 1.9):
        # Channels distinguish reflected from refracted light.
        factors = ("specular_reflectance", "0.2 1.0 0.2"), ("specular_transmittance", "1.0 0.2 0.2")
        factors = [f'<rgb name="{name}" value="{value}"/>' for name, value in factors]
        inside = (number("int_ior", ior), number("ext_ior", 1.0), *factors)
        yield bsdf("dielectric", *inside)
        for distribution in ("ggx", "beckmann"):
            for alpha in (0.05, 0.25, 0.5):
                yield bsdf("roughdielectric", string("distribution", distribution), number("alpha", alpha), *inside)
    for distribution in ("ggx", "beckmann"):
        for along, across in ((0.1, 0.4), (0.4, 0.1)):
            alphas = number("alpha_u", along), number("alpha_v", across)
            yield bsdf("roughdielectric", string("distribution", distribution), *alphas, number("int_ior", 1.5), number("ext_ior", 1.0))
    color = COLOR.format("base_color")
    for metallic in (0.0, 0.3, 1.0):
        for roughness in (0.1, 0.3, 0.6, 1.0):
            yield bsdf("principled", color, number("metallic", metallic), number("roughness", roughness))
    for tint in (0.5, 1.0):
        yield bsdf("principled", color, number("spec_tint", tint), number("metallic", 0.3), number("eta", 1.8))
        yield bsdf("principled", color, number("sheen", 0.8), number("sheen_tint", tint), number("roughness", 0.8))
    yield bsdf("principled", color, number("specular", 0.001), number("roughness", 0.55))
    for gloss in (0.2, 0.8):
        yield bsdf("principled", color, number("clearcoat", 1.0), number("clearcoat_gloss", gloss))
    yield bsdf("principled", color, number("clearcoat", 0.6), number("metallic", 0.8), number("roughness", 0.6))
    yield bsdf("principled", color, number("clearcoat", 1.0), number("spec_trans", 0.7), number("eta", 1.5))
    yield bsdf("principled", color, number("flatness", 1.0))
    for roughness in (0.1, 1.0):
        yield bsdf("principled", color, number("flatness", 0.6), number("roughness", roughness))
    yield bsdf("principled", color, number("anisotropic", 0.9))
    for anisotropic, roughness in ((0.5, 0.3), (0.9, 0.4), (0.9, 1.0)):
        yield bsdf("principled", color, number("anisotropic", anisotropic), number("roughness", roughness), number("metallic", 1.0))
    yield bsdf("principled", color, number("anisotropic", 0.6), number("roughness", 0.4), number("spec_trans", 1.0), number("eta", 1.5))
    yield bsdf("principled", color, number("spec_trans", 1.0), number("eta", 1.5))
    for share in (0.2, 0.7):
        yield bsdf("principled", color, number("spec_trans", share), number("eta", 1.5), number("metallic", 0.3))
    for roughness in (0.3, 0.8):
        inside = (color, number("eta", 1.5), number("roughness", roughness))
        yield bsdf("principledthin", *inside)
        yield bsdf("principledthin", *inside, number("diff_trans", 0.8))
        yield bsdf("principledthin", *inside, number("spec_trans", 0.6))
        yield bsdf("principledthin", *inside, number("flatness", 1.0))
        yield bsdf("principledthin", *inside, number("sheen", 0.8))
    plain = bsdf("diffuse", COLOR.format("reflectance"))
    for alpha in (0.1, 0.3):
        inside = (number("int_ior", 1.5), number("ext_ior", 1.0), diffuse, string("distribution", "ggx"))
        yield bsdf("pplastic", number("alpha", alpha), *inside)
    yield bsdf("twosided", plain)
    yield bsdf("mask", number("opacity", 0.3), plain)
    rough = bsdf("roughconductor", string("material", "Au"), number("alpha", 0.4))
    yield bsdf("blendbsdf", number("weight", 0.25), plain, rough)


def surface(angle):
    found = dr.zeros(mi.SurfaceInteraction3f, SAMPLES)
    found.wi = mi.Vector3f(math.cos(angle), 0, math.sin(angle))
    found.t = 1.0
    found.n = mi.Normal3f(0, 0, 1)
    found.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    return found


def value(material, pair):
    elevation, other, azimuth = (math.radians(angle) for angle in pair)
    direction = (math.cos(other) * math.cos(azimuth), math.cos(other) * math.sin(azimuth), math.sin(other))
    found = material.eval(mi.BSDFContext(), surface(elevation), mi.Vector3f(*direction))
    return [numpy.array(found[channel])[0] for channel in range(3)]


def albedo(material, elevation):
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(elevation, SAMPLES)
    found = surface(math.radians(elevation))
    # Albedo of flux: without the square of the index by which refraction changes radiance.
    _, weight = material.sample(mi.BSDFContext(mi.TransportMode.Importance), found, sampler.next_1d(), sampler.next_2d())
    weight = dr.select(dr.isfinite(weight), weight, 0)
    return [numpy.array(weight[channel]).mean() for channel in range(3)]


def main():
    print(f"# Written by scripts/mitsuba_materials.py with Mitsuba {mi.__version__}.")
    for xml in materials():
        material = mi.load_string(xml.replace("<bsdf", '<bsdf version="3.0.0"', 1))
        albedos = [albedo(material, elevation) for elevation in ELEVATIONS]
        print(xml, numbers(albedos, [value(material, pair) for pair in PAIRS]))


if __name__ == "__main__":
    main()
