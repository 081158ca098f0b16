#!/usr/bin/env python3
"""Writes what materials of pbrt-v4, glTF and MTL reflect by the formulas of their formats, for the suite's `formula_materials`.

    pip install numpy
    python3 crates/tashika-bench/material_formulas.py > crates/tashika/tests/suite/formula_materials.txt

A row is a format, a material in its words, and the numbers of `material_table.py`; `nan` where the material has no
value at single directions. Sources: Pharr et al. 2023, sections 9.3 to 9.7 and 14.3 (pbrt-v4); glTF 2.0, appendix B, with
masking and shadowing correlated by height; the guide (MTL). Coats of pbrt are simulated: paths go in and out of a rough interface over
a diffuse base.
"""

import numpy as np

from material_table import ELEVATIONS, PAIRS, numbers

RNG = np.random.default_rng(1)
PATHS = 1 << 20
COLOR = np.array([0.7, 0.4, 0.1])


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def direction(elevation, azimuth):
    e, a = np.radians(elevation), np.radians(azimuth)
    return np.stack(np.broadcast_arrays(np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)), axis=-1)


def dielectric(cos, eta):
    """Fresnel's equations for a ratio `eta` of indices, behind over before; 1 under total reflection."""
    g2 = eta * eta - 1 + cos * cos
    g = np.sqrt(np.maximum(g2, 0))
    s, p = (cos - g) / (cos + g), (eta * eta * cos - g) / (eta * eta * cos + g)
    return np.where(g2 <= 0, 1.0, 0.5 * (s * s + p * p))


def conductor(cos, eta, k):
    index = np.asarray(eta) + 1j * np.asarray(k)
    cos = np.asarray(cos)[..., None]
    inside = np.sqrt(1 - (1 - cos * cos) / (index * index))
    p = (index * cos - inside) / (index * cos + inside)
    s = (cos - index * inside) / (cos + index * inside)
    return 0.5 * (np.abs(p) ** 2 + np.abs(s) ** 2)


def schlick(f0, cos):
    return f0 + (1 - f0) * ((1 - cos) ** 5)[..., None]


def smith(w, alpha):
    """Heitz's `Lambda` of GGX, with `alpha` for all directions, or along and across the first axis."""
    along, across = np.broadcast_to(alpha, 2)
    slope = ((along * w[..., 0]) ** 2 + (across * w[..., 1]) ** 2) / np.maximum(w[..., 2] ** 2, 1e-12)
    return 0.5 * (np.sqrt(1 + slope) - 1)


def facets(wo, wi, alpha):
    """`D G / (4 c_o c_i)` and `h.wo`, with `alpha` for all directions, or along and across the first axis."""
    h = unit(wo + wi)
    along, across = np.broadcast_to(alpha, 2)
    d = 1 / (np.pi * along * across * ((h[..., 0] / along) ** 2 + (h[..., 1] / across) ** 2 + h[..., 2] ** 2) ** 2)
    g = 1 / (1 + smith(wo, alpha) + smith(wi, alpha))
    return d * g / (4 * wo[..., 2] * wi[..., 2]), (h * wo).sum(-1)


def albedo(f, elevation):
    """`f` times the cosine over the hemisphere."""
    cos = (np.arange(500) + 0.5) / 500
    azimuth = (np.arange(1000) + 0.5) / 1000 * 2 * np.pi
    c, a = np.meshgrid(cos, azimuth)
    s = np.sqrt(1 - c * c)
    wi = np.stack([s * np.cos(a), s * np.sin(a), c], axis=-1)
    return 2 * np.pi * (f(direction(elevation, 0.0), wi) * c[..., None]).mean((0, 1))


def row_of(f):
    values = []
    for elevation, other, azimuth in PAIRS:
        wi = direction(other, azimuth)
        values.append(f(direction(elevation, 0.0), wi) * wi[2])
    return [albedo(f, elevation) for elevation in ELEVATIONS], values


NO_VALUES = [np.full(3, np.nan)] * len(PAIRS)


def visible_normals(wo, alpha):
    """Normals of facets that each of `wo` sees (Heitz 2018)."""
    stretch = [*np.broadcast_to(alpha, 2), 1.0]
    stretched = unit(wo * stretch)
    across = np.stack([-stretched[:, 1], stretched[:, 0], np.zeros(len(wo))], axis=-1)
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(length > 1e-9, across / np.maximum(length, 1e-9), [1.0, 0.0, 0.0])
    along = np.cross(stretched, across)
    u, v = RNG.random((2, len(wo)))
    r, angle = np.sqrt(u), 2 * np.pi * v
    x, y = r * np.cos(angle), r * np.sin(angle)
    s = 0.5 * (1 + stretched[:, 2])
    y = (1 - s) * np.sqrt(np.maximum(1 - x * x, 0)) + s * y
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    h = x[:, None] * across + y[:, None] * along + z[:, None] * stretched
    return unit(h * stretch)


def through_interface(wo, alpha, eta):
    """Draws where light from `wo` (z > 0) goes at a rough interface: directions, whether they are reflected, and weights."""
    h = visible_normals(wo, alpha)
    cos = (h * wo).sum(-1)
    reflected = RNG.random(len(wo)) < dielectric(cos, eta)
    mirror = 2 * cos[:, None] * h - wo
    cos_t = np.sqrt(np.maximum(1 - (1 - cos * cos) / eta**2, 0))
    bent = (cos / eta - cos_t)[:, None] * h - wo / eta
    out = np.where(reflected[:, None], mirror, bent)
    right = np.where(reflected, out[:, 2] > 0, out[:, 2] < 0)
    o, i = smith(wo, alpha), smith(out, alpha)
    return out, reflected, np.where(right, (1 + o) / (1 + o + i), 0.0)


def rough_glass(alpha, eta):
    def at(elevation):
        wo = np.tile(direction(elevation, 0.0), (PATHS, 1))
        return np.full(3, through_interface(wo, alpha, eta)[2].mean())

    return [at(elevation) for elevation in ELEVATIONS], NO_VALUES


def coated(reflectance, alpha, eta):
    def at(elevation):
        wo = np.tile(direction(elevation, 0.0), (PATHS, 1))
        out, reflected, weight = through_interface(wo, alpha, eta)
        found = np.full(3, weight[reflected].sum())
        weight = weight[~reflected][:, None] * np.ones(3)
        for _ in range(60):
            weight = weight * reflectance
            if not len(weight):
                break
            u, v = RNG.random((2, len(weight)))
            r, z = np.sqrt(u), np.sqrt(np.maximum(1 - u, 1e-9))
            up = np.stack([r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v), z], axis=-1)
            # From the inside the interface is the same, upside down.
            _, reflected, factor = through_interface(up, alpha, 1 / eta)
            weight = weight * factor[:, None]
            found += weight[~reflected].sum(0)
            weight = weight[reflected]
        return found / PATHS

    return [at(elevation) for elevation in ELEVATIONS], NO_VALUES


def rgb(color):
    return "[" + " ".join(f"{c:g}" for c in np.broadcast_to(color, 3)) + "]"


def lambert(color):
    return lambda wo, wi: np.broadcast_to(color / np.pi, (*wi.shape[:-1], 3))


def metal(fresnel, alpha):
    def f(wo, wi):
        lobe, cos = facets(wo, wi, alpha)
        return fresnel(cos) * lobe[..., None]

    return f


def metallic_roughness(base, metallic, roughness, f0, anisotropy=0.0):
    across = roughness**2
    along = across + (1 - across) * anisotropy**2

    def f(wo, wi):
        lobe, cos = facets(wo, wi, (along, across))
        layer = schlick(np.full(3, f0), cos)
        dielectric = (1 - layer) * base / np.pi + layer * lobe[..., None]
        return (1 - metallic) * dielectric + metallic * schlick(base, cos) * lobe[..., None]

    return f


def phong(diffuse, specular, exponent):
    def f(wo, wi):
        mirror = wo * [-1.0, -1.0, 1.0]
        cos = np.maximum((mirror * wi).sum(-1), 0)[..., None]
        return diffuse / np.pi + specular * (exponent + 2) / (2 * np.pi) * cos**exponent

    return f


def materials():
    pbrt = "pbrt-v4"
    yield pbrt, f'"diffuse" "rgb reflectance" {rgb(COLOR)}', row_of(lambert(COLOR))
    text = f'"diffusetransmission" "rgb reflectance" {rgb(COLOR)} "rgb transmittance" [0.2 0.3 0.4]'
    albedos, values = row_of(lambert(COLOR))
    yield pbrt, text, ([a + [0.2, 0.3, 0.4] for a in albedos], values)
    plain = '"bool remaproughness" false "float roughness"'
    for alpha in (0.2, 0.5):
        eta, k = np.array([0.2, 0.9, 1.4]), np.array([3.6, 2.3, 1.9])
        text = f'"conductor" "rgb eta" {rgb(eta)} "rgb k" {rgb(k)} {plain} {alpha}'
        yield pbrt, text, row_of(metal(lambda cos: conductor(cos, eta, k), alpha))
        k = 2 * np.sqrt(COLOR) / np.sqrt(1 - COLOR)
        text = f'"conductor" "rgb reflectance" {rgb(COLOR)} {plain} {alpha}'
        yield pbrt, text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), alpha))
        yield pbrt, f'"dielectric" "float eta" 1.5 {plain} {alpha}', rough_glass(alpha, 1.5)
    text = f'"conductor" "rgb reflectance" {rgb(COLOR)} "float roughness" 0.25'
    yield pbrt, text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), 0.5))
    yield pbrt, '"thindielectric" "float eta" 1.5', ([np.ones(3)] * 3, NO_VALUES)
    for eta in (1.3, 1.5, 1.9):
        for alpha in (0.0, 0.1, 0.3, 0.6):
            text = f'"coateddiffuse" "rgb reflectance" {rgb(COLOR)} "float eta" {eta} {plain} {alpha}'
            yield pbrt, text, coated(COLOR, max(alpha, 1e-4), eta)
    for metallic in (0.0, 0.3, 1.0):
        for roughness in (0.45, 0.8):
            color = ", ".join(f"{c:g}" for c in (*COLOR, 1))
            text = f'{{ "baseColorFactor": [{color}], "metallicFactor": {metallic}, "roughnessFactor": {roughness} }}'
            text = f'{{ "pbrMetallicRoughness": {text} }}'
            yield "glTF", text, row_of(metallic_roughness(COLOR, metallic, roughness, 0.04))
    for anisotropy, roughness in ((0.5, 0.45), (0.9, 0.3)):
        text = f'{{ "baseColorFactor": [{color}], "roughnessFactor": {roughness} }}'
        extension = f'"extensions": {{ "KHR_materials_anisotropy": {{ "anisotropyStrength": {anisotropy} }} }}'
        text = f'{{ "pbrMetallicRoughness": {text}, {extension} }}'
        yield "glTF", text, row_of(metallic_roughness(COLOR, 1.0, roughness, 0.04, anisotropy))
    text = '{ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_ior": { "ior": 1.8 } } }'
    yield "glTF", text, row_of(metallic_roughness(np.ones(3), 0.0, 1.0, (0.8 / 2.8) ** 2))
    kd = " ".join(f"{c:g}" for c in COLOR)
    yield "MTL", f"Kd {kd}", row_of(lambert(COLOR))
    for exponent in (5, 40):
        text = f"illum 2; Kd {kd}; Ks 0.3 0.3 0.2; Ns {exponent}"
        yield "MTL", text, row_of(phong(COLOR, np.array([0.3, 0.3, 0.2]), exponent))
    yield "MTL", f"Kd {kd}; Pr 0.6; Pm 0.5; Ni 1.5", row_of(metallic_roughness(COLOR, 0.5, 0.6, 0.04))
    for along, across in ((0.1, 0.4), (0.4, 0.1)):
        brushed = f'"bool remaproughness" false "float uroughness" {along} "float vroughness" {across}'
        text = f'"conductor" "rgb reflectance" {rgb(COLOR)} {brushed}'
        yield pbrt, text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), (along, across)))
        yield pbrt, f'"dielectric" "float eta" 1.5 {brushed}', rough_glass((along, across), 1.5)


def main():
    print("# Written by crates/tashika-bench/material_formulas.py.")
    for name, text, found in materials():
        print(name, "|", text, "|", numbers(*found))


if __name__ == "__main__":
    main()
