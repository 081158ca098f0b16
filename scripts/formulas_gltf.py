"""Reflectance of glTF 2.0 materials and extensions, by appendix B and the extensions' texts."""

import json

import numpy as np

from material_math import (
    COLOR, NO_VALUES, albedo, constant, facets, rough_glass, row_of, scaled, schlick, sheen, smooth, sum_of_rows,
)  # fmt: skip

PALE = [0.9, 0.6, 0.3]


def dielectric_part(base, roughness, f0, weight=1.0):
    """Layer by `fresnel_mix` of KHR_materials_specular: the base receives the light that the layer
    does not reflect in its brightest channel."""

    def f(wo, wi):
        lobe, cos = facets(wo, wi, roughness**2)
        layer = weight * schlick(np.minimum(np.broadcast_to(f0, 3), 1), cos)
        return (1 - layer.max(-1, keepdims=True)) * base / np.pi + layer * lobe[..., None]

    return f


def brushed_metal(base, roughness, strength):
    """KHR_materials_anisotropy: facets that are elongated along the first axis."""
    across = roughness**2
    along = across + (1 - across) * strength**2

    def f(wo, wi):
        lobe, cos = facets(wo, wi, (along, across))
        return schlick(base, cos) * lobe[..., None]

    return f


def metallic_roughness(base, metallic, roughness, f0, weight=1.0):
    def f(wo, wi):
        lobe, cos = facets(wo, wi, roughness**2)
        part = dielectric_part(base, roughness, f0, weight)(wo, wi)
        return (1 - metallic) * part + metallic * schlick(base, cos) * lobe[..., None]

    return f


def coated(base, clearcoat, roughness):
    """Coat by `fresnel_coat` of KHR_materials_clearcoat, at the angle of view."""

    def f(wo, wi):
        layer = clearcoat * (0.04 + 0.96 * (1 - wo[..., 2]) ** 5)
        lobe, _ = facets(wo, wi, roughness**2)
        return (1 - layer)[..., None] * base(wo, wi) + (layer * lobe)[..., None]

    return f


def under_sheen(base, color, roughness):
    """KHR_materials_sheen, the base scaled by the albedo that the viewer sees."""

    def white(wo, wi):
        return sheen(wo, wi, roughness)[..., None] * np.ones(3)

    def f(wo, wi):
        elevation = float(np.degrees(np.arcsin(wo[..., 2].flat[0])))
        left = max(0, 1 - max(color) * albedo(white, elevation)[0])
        return left * base(wo, wi) + color * sheen(wo, wi, roughness)[..., None]

    return f


def straight(base, roughness, f0):
    """A pane: light through its one face goes straight on, spread as widely as the mirror image."""

    def f(wo, wi):
        lobe, cos = facets(wo, wi, roughness**2)
        return (1 - schlick(np.full(3, f0), cos)) * base * lobe[..., None]

    return f


def text_of(roughness, metallic=0.0, color=COLOR, **extensions):
    core = {"baseColorFactor": [*map(float, color), 1], "metallicFactor": metallic, "roughnessFactor": roughness}
    found = {"pbrMetallicRoughness": core}
    if extensions:
        found["extensions"] = {f"KHR_materials_{name}": fields for name, fields in extensions.items()}
    return json.dumps(found)


def materials():
    for metallic in (0.0, 0.3, 1.0):
        for roughness in (0.45, 0.8):
            yield text_of(roughness, metallic), row_of(metallic_roughness(COLOR, metallic, roughness, 0.04))
    for ior in (1.0, 1.3, 1.8):
        found = metallic_roughness(COLOR, 0.0, 0.6, ((ior - 1) / (ior + 1)) ** 2)
        yield text_of(0.6, ior={"ior": ior}), row_of(found)
    for factor in (0.0, 0.5):
        for metallic in (0.0, 0.4):
            found = metallic_roughness(COLOR, metallic, 0.5, 0.04, factor)
            yield text_of(0.5, metallic, specular={"specularFactor": factor}), row_of(found)
    for metallic in (0.0, 0.4):
        found = metallic_roughness(COLOR, metallic, 0.5, 0.04 * np.array([8, 4, 1]))
        yield text_of(0.5, metallic, specular={"specularColorFactor": [8, 4, 1]}), row_of(found)
    for f0, ior in ((0.04, {}), (0.0816, {"ior": {"ior": 1.8}})):
        # Smooth: a mirror, and the light through its one face.
        pane = smooth(lambda cos: f0 + (1 - f0) * (1 - cos) ** 5 + (1 - f0) * (1 - (1 - cos) ** 5) * COLOR)
        yield text_of(0.0, transmission={"transmissionFactor": 1}, **ior), pane
    for roughness in (0.3, 0.7):
        for factor in (0.6, 1.0):
            opaque, glass = dielectric_part(COLOR, roughness, 0.04), dielectric_part(np.zeros(3), roughness, 0.04)
            behind = scaled(factor, (row_of(straight(COLOR, roughness, 0.04))[0], NO_VALUES))
            seen = sum_of_rows(scaled(1 - factor, row_of(opaque)), scaled(factor, row_of(glass)))
            yield text_of(roughness, transmission={"transmissionFactor": factor}), sum_of_rows(seen, behind)
    for roughness in (0.0, 0.5):
        text = text_of(roughness, color=PALE, transmission={"transmissionFactor": 1}, volume={"thicknessFactor": 1})
        # By Fresnel's equations, which Schlick's formula approximates.
        yield text, rough_glass(max(roughness**2, 1e-4), 1.5, 1.0, np.array(PALE))
    for factor in (0.3, 1.0):
        fields = {"diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": [0.5, 0.6, 0.8]}
        front = row_of(dielectric_part((1 - factor) * COLOR, 0.6, 0.04))
        through = dielectric_part(factor * np.array([0.5, 0.6, 0.8]), 0.6, 0.04)
        black = dielectric_part(np.zeros(3), 0.6, 0.04)
        behind = [a - b for a, b in zip(row_of(through)[0], row_of(black)[0])]
        yield text_of(0.6, diffuse_transmission=fields), sum_of_rows(front, (behind, NO_VALUES))
    for glossiness in (0.2, 0.6):
        f0 = np.array([0.3, 0.2, 0.1])
        fields = {"diffuseFactor": [*COLOR, 1], "specularFactor": [*f0], "glossinessFactor": glossiness}
        base, alpha = COLOR * (1 - f0.max()), (1 - glossiness) ** 2

        def f(wo, wi):
            lobe, cos = facets(wo, wi, alpha)
            return (1 - schlick(f0, cos)) * base / np.pi + schlick(f0, cos) * lobe[..., None]

        yield json.dumps({"extensions": {"KHR_materials_pbrSpecularGlossiness": fields}}), row_of(f)
    blended = json.loads(text_of(0.45))
    blended["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.3
    blended["alphaMode"] = "BLEND"
    opaque = row_of(metallic_roughness(COLOR, 0.0, 0.45, 0.04))
    yield json.dumps(blended), sum_of_rows(scaled(0.3, opaque), constant(np.full(3, 0.7)))
    for metallic, clearcoat, roughness in ((0.0, 1.0, 0.45), (0.0, 0.5, 0.8), (0.3, 1.0, 0.6), (1.0, 1.0, 0.5)):
        found = row_of(coated(metallic_roughness(COLOR, metallic, 0.6, 0.04), clearcoat, roughness))
        fields = {"clearcoatFactor": clearcoat, "clearcoatRoughnessFactor": roughness}
        yield text_of(0.6, metallic, clearcoat=fields), found
    tint = np.array([0.9, 0.6, 0.2])
    for metallic, roughness in ((0.0, 0.3), (0.0, 0.7), (0.4, 1.0), (0.0, 0.05)):
        fields = {"sheenColorFactor": [*tint], "sheenRoughnessFactor": roughness}
        found = under_sheen(metallic_roughness(COLOR, metallic, 0.6, 0.04), tint, roughness)
        yield text_of(0.6, metallic, sheen=fields), row_of(found)
    coat, sheen_fields = {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.5}, {"sheenColorFactor": [*tint], "sheenRoughnessFactor": 0.5}
    found = coated(under_sheen(metallic_roughness(COLOR, 0.0, 0.6, 0.04), tint, 0.5), 1.0, 0.5)
    yield text_of(0.6, sheen=sheen_fields, clearcoat=coat), row_of(found)
    for strength, roughness in ((0.5, 0.45), (0.9, 0.3)):
        found = row_of(brushed_metal(COLOR, roughness, strength))
        yield text_of(roughness, 1.0, anisotropy={"anisotropyStrength": strength}), found
