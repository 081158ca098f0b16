"""Reflectance of materials of pbrt-v3 and pbrt-v4, by their documented formulas."""

import numpy as np

from material_math import (
    COLOR, NO_VALUES, added, conductor, constant, dielectric, diffuse_base, facets, lambert, layered, metal, metal_base,
    rgb, rough_glass, row_of, scaled, scattering_half_space, schlick, smooth, sum_of_rows, unit,
    without_values,
)  # fmt: skip

PLAIN = '"bool remaproughness" false'
ETA, K = np.array([0.2, 0.9, 1.4]), np.array([3.6, 2.3, 1.9])
DIM = np.array([0.3, 0.2, 0.1])


def grey_facets(alpha, eta, factor):
    """Facets with the reflectance of a dielectric."""

    def f(wo, wi):
        lobe, cos = facets(wo, wi, alpha)
        return factor * (dielectric(cos, eta) * lobe)[..., None]

    return f


def remapped(roughness):
    """Converts roughness to `α` by `RoughnessToAlpha` of pbrt-v3."""
    x = np.log(max(roughness, 1e-3))
    return 1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))


def oren_nayar(color, sigma):
    """Pharr, Jakob and Humphreys 2016, section 8.4.1; `sigma` in degrees."""
    s2 = np.radians(sigma) ** 2
    a, b = 1 - s2 / (2 * (s2 + 0.33)), 0.45 * s2 / (s2 + 0.09)

    def f(wo, wi):
        (co, ci) = wo[..., 2], wi[..., 2]
        so, si = np.sqrt(1 - co * co), np.sqrt(1 - ci * ci)
        across = np.maximum(wo[..., 0] * wi[..., 0] + wo[..., 1] * wi[..., 1], 0)
        # cos Δφ sin α tan β, with α the larger angle: sin_o sin_i cos Δφ over the larger cosine.
        return color / np.pi * (a + b * across / np.maximum(np.maximum(co, ci), 1e-9))[..., None]

    return f


def ashikhmin_shirley(diffuse, specular, alpha):
    """`FresnelBlend`: Pharr, Jakob and Humphreys 2016, section 8.5."""

    def f(wo, wi):
        h = unit(wo + wi)
        co, ci, cos = wo[..., 2], wi[..., 2], (h * wo).sum(-1)
        d = alpha**2 / (np.pi * ((alpha**2 - 1) * h[..., 2] ** 2 + 1) ** 2)
        below = 28 / (23 * np.pi) * diffuse * (1 - specular) * ((1 - (1 - co / 2) ** 5) * (1 - (1 - ci / 2) ** 5))[..., None]
        return below + schlick(specular, cos) * (d / (4 * cos * np.maximum(co, ci)))[..., None]

    return f


def disney(
    color, metallic, roughness, eta=1.5, tint=0.0, sheen=0.0, sheen_tint=0.5, transmission=0.0, flatness=0.0, through=0.0
):  # fmt: skip
    """Burley 2012 and 2015, as combined by pbrt-v3: the tint counts in the metallic part."""
    hue = color / (color @ [0.212671, 0.715160, 0.072169])
    opaque = (1 - metallic) * (1 - transmission)
    f0 = (1 - metallic) * ((eta - 1) / (eta + 1)) ** 2 * (1 - tint + tint * hue) + metallic * color

    def f(wo, wi):
        lobe, cos = facets(wo, wi, max(roughness**2, 1e-3), separate=True)
        o, i, d = ((1 - c) ** 5 for c in (wo[..., 2], wi[..., 2], cos))
        retro = 2 * roughness * cos * cos
        # Scattering below a flat surface, after Hanrahan and Krueger 1993.
        f90 = roughness * cos * cos
        flat = (1 + (f90 - 1) * o) * (1 + (f90 - 1) * i)
        flat = 1.25 * (flat * (1 / (wo[..., 2] + wi[..., 2]) - 0.5) + 0.5)
        shape = (1 - through) * ((1 - flatness) * (1 - o / 2) * (1 - i / 2) + flatness * flat)
        shape = shape + retro * (o + i + o * i * (retro - 1))
        cloth = sheen * (1 - sheen_tint + sheen_tint * hue) * d[..., None]
        below = opaque * (color / np.pi * shape[..., None] + cloth)
        return below + ((1 - metallic) * dielectric(cos, eta)[..., None] + metallic * schlick(f0, cos)) * lobe[..., None]

    return f


def clear_coat(weight, gloss):
    """Burley 2012, section 5.6: GTR1, Schlick's reflectance 0.04, shadowing by facets of 0.25."""
    alpha = 0.1 + (0.001 - 0.1) * gloss

    def f(wo, wi):
        h = unit(wo + wi)
        co, ci, cos = wo[..., 2], wi[..., 2], (h * wo).sum(-1)
        d = (alpha**2 - 1) / (np.pi * np.log(alpha**2) * (1 + (alpha**2 - 1) * h[..., 2] ** 2))
        shadow = [1 / (c + np.sqrt(0.25**2 + c * c - 0.25**2 * c * c)) for c in (co, ci)]
        return (0.25 * weight * d * shadow[0] * shadow[1] * (0.04 + 0.96 * (1 - cos) ** 5))[..., None] * np.ones(3)

    return f


def brushed_metal(color, roughness, anisotropic):
    """Facets that are elongated along the first axis."""
    aspect = np.sqrt(1 - 0.9 * anisotropic)
    widths = roughness**2 / aspect, roughness**2 * aspect

    def f(wo, wi):
        lobe, cos = facets(wo, wi, widths, separate=True)
        return schlick(color, cos) * lobe[..., None]

    return f


def words(roughness, remap):
    return f'"float roughness" {roughness}' + ("" if remap else " " + PLAIN)


def roughnesses(*plain):
    """Roughness in the words of pbrt-v3, and its `α`."""
    yield words(0.05, True), remapped(0.05)
    for alpha in plain:
        yield words(alpha, False), alpha


def version_3():
    yield f'"matte" "rgb Kd" {rgb(COLOR)}', row_of(lambert(COLOR))
    for sigma in (20, 60):
        yield f'"matte" "rgb Kd" {rgb(COLOR)} "float sigma" {sigma}', row_of(oren_nayar(COLOR, sigma))
    for text, alpha in roughnesses(0.1, 0.3, 0.6):
        text = f'"plastic" "rgb Kd" {rgb(COLOR)} "rgb Ks" {rgb(DIM)} {text}'
        yield text, row_of(added(lambert(COLOR), grey_facets(alpha, 1.5, DIM)))
    metal_words = f'"metal" "rgb eta" {rgb(ETA)} "rgb k" {rgb(K)}'
    for text, alpha in roughnesses(0.2, 0.5):
        yield f"{metal_words} {text}", row_of(metal(lambda cos: conductor(cos, ETA, K), alpha))
    yield f'"mirror" "rgb Kr" {rgb(COLOR)}', constant(COLOR)
    factors = np.array([0.2, 1.0, 0.2]), np.array([1.0, 0.2, 0.2])
    text = f'"rgb Kr" {rgb(factors[0])} "rgb Kt" {rgb(factors[1])}'
    for eta in (1.3, 1.5, 1.9):
        passed = smooth(lambda cos: factors[1] + (factors[0] - factors[1]) * dielectric(cos, eta))
        yield f'"glass" {text} "float eta" {eta}', passed
        for alpha in (0.2, 0.5):
            rough = f'"float uroughness" {alpha} "float vroughness" {alpha} {PLAIN}'
            yield f'"glass" {text} "float eta" {eta} {rough}', rough_glass(alpha, eta, *factors)
    yield from uber()
    for alpha in (0.1, 0.3, 0.6):
        for specular in (0.05, 0.5):
            text = f'"substrate" "rgb Kd" {rgb(COLOR)} "rgb Ks" {rgb(np.full(3, specular))}'
            text += f' "float uroughness" {alpha} "float vroughness" {alpha} {PLAIN}'
            yield text, row_of(ashikhmin_shirley(COLOR, np.full(3, specular), alpha))
    yield from translucent()
    for amount in (0.2, 0.7):
        parts = f'MakeNamedMaterial "a" "string type" "matte" "rgb Kd" {rgb(COLOR)} '
        parts += f'MakeNamedMaterial "b" "string type" "metal" "rgb eta" {rgb(ETA)} "rgb k" {rgb(K)} {words(0.3, False)} '
        text = f'Material "mix" "string namedmaterial1" "a" "string namedmaterial2" "b" "rgb amount" {rgb(amount)}'
        other = metal(lambda cos: conductor(cos, ETA, K), 0.3)
        yield parts + text, sum_of_rows(scaled(amount, row_of(lambert(COLOR))), scaled(1 - amount, row_of(other)))
    color = f'"disney" "rgb color" {rgb(COLOR)}'
    for metallic in (0.0, 0.5, 1.0):
        for roughness in (0.45, 0.8):
            text = f'{color} "float metallic" {metallic} "float roughness" {roughness}'
            yield text, row_of(disney(COLOR, metallic, roughness))
    text = f'{color} "float speculartint" 1 "float sheen" 0.8 "float eta" 1.8 "float roughness" 0.6'
    yield text, row_of(disney(COLOR, 0, 0.6, 1.8, 1.0, 0.8))
    for transmission in (0.3, 1.0):
        text = f'{color} "float spectrans" {transmission} "float roughness" 0.5'
        # The reflection at the boundary is that of the facets, once.
        through = rough_glass(0.25, 1.5, 0.0, transmission * np.sqrt(COLOR), separate=True)
        yield text, without_values(sum_of_rows(row_of(disney(COLOR, 0, 0.5, transmission=transmission)), through))
    for gloss in (0.2, 0.6):
        text = f'{color} "float clearcoat" 1 "float clearcoatgloss" {gloss} "float roughness" 0.6'
        yield text, row_of(added(disney(COLOR, 0, 0.6), clear_coat(1.0, gloss)))
    for roughness in (0.4, 0.7):
        text = f'{color} "float anisotropic" 0.9 "float metallic" 1 "float roughness" {roughness}'
        yield text, row_of(brushed_metal(COLOR, roughness, 0.9))
    for flatness, through in ((0.0, 1.0), (0.5, 0.4)):
        # Transmitted light is diffuse, and its share is half of the number.
        text = f'{color} "bool thin" true "float flatness" {flatness} "float difftrans" {through} "float roughness" 0.6'
        sheet = disney(COLOR, 0, 0.6, flatness=flatness, through=through / 2)
        yield text, sum_of_rows(row_of(sheet), (constant(through / 2 * COLOR)[0], NO_VALUES))
    yield from below_the_surface('"kdsubsurface" "rgb Kd"')
    text = f'{color} "float clearcoat" 1 "float clearcoatgloss" 0.2 "float roughness" 0.5 "float spectrans" 0.7'
    opaque = row_of(added(disney(COLOR, 0, 0.5, transmission=0.7), clear_coat(1.0, 0.2)))
    through = rough_glass(0.25, 1.5, 0.0, 0.7 * np.sqrt(COLOR), separate=True)
    yield text, without_values(sum_of_rows(opaque, through))


def uber():
    for text, alpha in roughnesses(0.3, 0.6):
        base = added(lambert(COLOR / 2), grey_facets(alpha, 1.8, DIM))
        kinds = f'"uber" "rgb Kd" {rgb(COLOR / 2)} "rgb Ks" {rgb(DIM)} "float eta" 1.8 {text}'
        yield kinds, row_of(base)
        mirror = smooth(lambda cos: 0.3 * dielectric(cos, 1.8))
        yield f'{kinds} "rgb Kr" [0.3 0.3 0.3]', sum_of_rows(row_of(base), mirror)
        passed = smooth(lambda cos: 0.2 * (1 - dielectric(cos, 1.8)))
        yield f'{kinds} "rgb Kr" [0.3 0.3 0.3] "rgb Kt" [0.2 0.2 0.2]', sum_of_rows(row_of(base), mirror, passed)
        rest = np.full(3, 0.4)
        found = sum_of_rows(scaled(0.6, row_of(base)), constant(rest))
        yield f'{kinds} "rgb opacity" [0.6 0.6 0.6]', found


def translucent():
    for alpha in (0.2, 0.5):
        for specular in (0.0, 0.25):
            text = f'"translucent" "rgb Kd" {rgb(COLOR)} "rgb Ks" {rgb(np.full(3, specular))}'
            text += f' "rgb reflect" [0.4 0.4 0.4] "rgb transmit" [0.6 0.6 0.6] {words(alpha, False)}'
            glass = rough_glass(alpha, 1.5, 0.0, 0.6 * specular)
            diffuse = row_of(lambert(0.4 * COLOR)), (constant(0.6 * COLOR)[0], NO_VALUES)
            found = sum_of_rows(*diffuse, row_of(grey_facets(alpha, 1.5, 0.4 * specular)), glass)
            yield text, without_values(found) if specular else found


def below_the_surface(words):
    """A dielectric over a base that returns the given share of the light that enters, in the
    distribution of light that leaves (Pharr et al. 2023, section 11.4)."""
    for eta in (1.3, 1.5):
        albedos, _ = smooth(lambda cos: dielectric(cos, eta) + (1 - dielectric(cos, eta)) * COLOR)
        yield f'{words} {rgb(COLOR)} "float eta" {eta} "float roughness" 0', (albedos, NO_VALUES)
    for albedo in (0.6, 0.95):
        scattering, absorption = 3 * albedo, 3 * (1 - albedo)
        kind = words.split()[0].replace("kdsub", "sub")
        text = f'{kind} "rgb sigma_s" {rgb(scattering)} "rgb sigma_a" {rgb(absorption)} "float eta" 1.3 "float roughness" 0'
        yield text, scattering_half_space(np.full(3, albedo), 1.3)


def version_4():
    yield f'"diffuse" "rgb reflectance" {rgb(COLOR)}', row_of(lambert(COLOR))
    albedos, values = row_of(lambert(COLOR))
    for scale in (1.0, 0.5):
        text = f'"diffusetransmission" "rgb reflectance" {rgb(COLOR)} "rgb transmittance" [0.2 0.3 0.4] "float scale" {scale}'
        yield text, scaled(scale, ([a + [0.2, 0.3, 0.4] for a in albedos], values))
    plain = f'{PLAIN} "float roughness"'
    for alpha in (0.2, 0.5):
        text = f'"conductor" "rgb eta" {rgb(ETA)} "rgb k" {rgb(K)} {plain} {alpha}'
        yield text, row_of(metal(lambda cos: conductor(cos, ETA, K), alpha))
        k = 2 * np.sqrt(COLOR) / np.sqrt(1 - COLOR)
        text = f'"conductor" "rgb reflectance" {rgb(COLOR)} {plain} {alpha}'
        yield text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), alpha))
    text = f'"conductor" "rgb reflectance" {rgb(COLOR)} "float roughness" 0.25'
    yield text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), 0.5))
    for eta in (1.3, 1.5, 1.9):
        yield f'"dielectric" "float eta" {eta}', constant(np.ones(3))
        for alpha in (0.1, 0.2, 0.5):
            yield f'"dielectric" "float eta" {eta} {plain} {alpha}', rough_glass(alpha, eta)
        yield f'"thindielectric" "float eta" {eta}', constant(np.ones(3))
        for alpha in (0.0, 0.1, 0.3, 0.6):
            text = f'"coateddiffuse" "rgb reflectance" {rgb(COLOR)} "float eta" {eta} {plain} {alpha}'
            yield text, layered(diffuse_base(COLOR), max(alpha, 1e-4), eta)
    for coat, alpha in ((0.0, 0.0), (0.0, 0.3), (0.2, 0.2), (0.3, 0.05)):
        text = f'"coatedconductor" "rgb conductor.eta" {rgb(ETA)} "rgb conductor.k" {rgb(K)} {PLAIN}'
        text += f' "float interface.roughness" {coat} "float conductor.roughness" {alpha}'
        base = metal_base(lambda cos: conductor(cos, ETA / 1.5, K / 1.5), max(alpha, 1e-4))
        yield text, layered(base, max(coat, 1e-4), 1.5)
    for amount in (0.2, 0.7):
        parts = f'MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" {rgb(COLOR)} '
        parts += f'MakeNamedMaterial "b" "string type" "conductor" "rgb eta" {rgb(ETA)} "rgb k" {rgb(K)} {plain} 0.3 '
        text = f'Material "mix" "string materials" ["a" "b"] "float amount" {amount}'
        other = metal(lambda cos: conductor(cos, ETA, K), 0.3)
        yield parts + text, sum_of_rows(scaled(1 - amount, row_of(lambert(COLOR))), scaled(amount, row_of(other)))
    yield from below_the_surface('"subsurface" "rgb reflectance"')
    k = 2 * np.sqrt(COLOR) / np.sqrt(1 - COLOR)
    for along, across in ((0.1, 0.4), (0.4, 0.1)):
        brushed = f'{PLAIN} "float uroughness" {along} "float vroughness" {across}'
        text = f'"conductor" "rgb reflectance" {rgb(COLOR)} {brushed}'
        yield text, row_of(metal(lambda cos: conductor(cos, np.ones(3), k), (along, across)))
        yield f'"dielectric" "float eta" 1.5 {brushed}', rough_glass((along, across), 1.5)
