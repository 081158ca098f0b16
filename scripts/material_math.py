"""Reflection at facets, boundaries and layers, for the scripts that write tables of materials.

Directions are unit vectors around the normal `z`, angles are degrees. Sources: Pharr, Jakob and
Humphreys 2016, chapter 8; Pharr et al. 2023, sections 9.3 to 9.7 and 14.3. Layers are simulated:
paths go in and out of a rough interface over a base.
"""

import numpy as np

from material_table import ELEVATIONS, PAIRS

SEED = 1
RNG = np.random.default_rng(SEED)
PATHS = 1 << 18
COLOR = np.array([0.7, 0.4, 0.1])


def begin_again():
    """Restarts the random numbers, so that each format has the same, whatever comes before it."""
    RNG.bit_generator.state = np.random.default_rng(SEED).bit_generator.state


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def direction(elevation, azimuth):
    e, a = np.radians(elevation), np.radians(azimuth)
    return np.stack(np.broadcast_arrays(np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)), axis=-1)


def dielectric(cos, eta):
    """Fresnel's equations for indices of ratio `eta`, behind over before; 1 at total reflection."""
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
    """Heitz's `Lambda` of GGX; `alpha` for all directions, or along and across the first axis."""
    along, across = np.broadcast_to(alpha, 2)
    slope = ((along * w[..., 0]) ** 2 + (across * w[..., 1]) ** 2) / np.maximum(w[..., 2] ** 2, 1e-12)
    return 0.5 * (np.sqrt(1 + slope) - 1)


def facets(wo, wi, alpha, separate=False):
    """`D G / (4 c_o c_i)` and `h.wo`; `separate`: masking and shadowing are independent."""
    h = unit(wo + wi)
    along, across = np.broadcast_to(alpha, 2)
    d = 1 / (np.pi * along * across * ((h[..., 0] / along) ** 2 + (h[..., 1] / across) ** 2 + h[..., 2] ** 2) ** 2)
    o, i = smith(wo, alpha), smith(wi, alpha)
    g = 1 / ((1 + o) * (1 + i) if separate else 1 + o + i)
    return d * g / (4 * wo[..., 2] * wi[..., 2]), (h * wo).sum(-1)


def sheen(wo, wi, roughness):
    """Fibres of `KHR_materials_sheen`, by Estevez and Kulla 2017, without its colour."""
    alpha = roughness**2
    rest = (1 - alpha) ** 2
    a, b, c, d, e = (
        rough + (fine - rough) * rest
        for rough, fine in [(21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801), (-1.97760, -1.27393), (-4.32054, -4.85967)]
    )

    def curve(x):
        return a / (1 + b * x**c) + d * x + e

    def hidden(cos):
        return np.exp(np.where(cos < 0.5, curve(cos), 2 * curve(0.5) - curve(np.maximum(1 - cos, 0))))

    cos_o, cos_i = wo[..., 2], wi[..., 2]
    sine2 = 1 - unit(wo + wi)[..., 2] ** 2
    distribution = (2 + 1 / alpha) * np.maximum(sine2, 0) ** (0.5 / alpha) / (2 * np.pi)
    return distribution / ((1 + hidden(cos_o) + hidden(cos_i)) * 4 * cos_o * cos_i)


def albedo(f, elevation):
    """Integral of `f` times the cosine over the hemisphere."""
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
    """Normals of facets that are visible from each of `wo` (Heitz 2018)."""
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


def through_interface(wo, alpha, eta, separate=False):
    """Draws directions of light from `wo` (z > 0) at a rough interface: directions, true where they
    are reflected, and weights."""
    h = visible_normals(wo, alpha)
    cos = (h * wo).sum(-1)
    reflected = RNG.random(len(wo)) < dielectric(cos, eta)
    mirror = 2 * cos[:, None] * h - wo
    cos_t = np.sqrt(np.maximum(1 - (1 - cos * cos) / eta**2, 0))
    bent = (cos / eta - cos_t)[:, None] * h - wo / eta
    out = np.where(reflected[:, None], mirror, bent)
    right = np.where(reflected, out[:, 2] > 0, out[:, 2] < 0)
    o, i = smith(wo, alpha), smith(out, alpha)
    return out, reflected, np.where(right, 1 / (1 + i) if separate else (1 + o) / (1 + o + i), 0.0)


def simulated(at):
    """A row of the albedo `at` an elevation, by paths, without values of single directions."""
    return [at(elevation) for elevation in ELEVATIONS], NO_VALUES


def constant(color):
    return [np.broadcast_to(color, 3)] * len(ELEVATIONS), NO_VALUES


def smooth(albedo_of):
    """A row of mirrors and panes: an albedo by the cosine of the angle."""
    return [np.broadcast_to(albedo_of(np.sin(np.radians(e))), 3) for e in ELEVATIONS], NO_VALUES


def rough_glass(alpha, eta, reflectance=1.0, transmittance=1.0, separate=False):
    def at(elevation):
        wo = np.tile(direction(elevation, 0.0), (PATHS, 1))
        _, reflected, weight = through_interface(wo, alpha, eta, separate)
        parts = weight[reflected].sum(), weight[~reflected].sum()
        return (parts[0] * np.ones(3) * reflectance + parts[1] * np.ones(3) * transmittance) / PATHS

    return simulated(at)


def diffuse_base(reflectance):
    def base(wo):
        u, v = RNG.random((2, len(wo)))
        r, z = np.sqrt(u), np.sqrt(np.maximum(1 - u, 1e-9))
        up = np.stack([r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v), z], axis=-1)
        return up, np.broadcast_to(reflectance, (len(wo), 3))

    return base


def metal_base(fresnel, alpha):
    def base(wo):
        h = visible_normals(wo, alpha)
        cos = (h * wo).sum(-1)
        up = 2 * cos[:, None] * h - wo
        o, i = smith(wo, alpha), smith(up, alpha)
        weight = np.where(up[:, 2] > 0, (1 + o) / (1 + o + i), 0.0)
        up[:, 2] = np.abs(up[:, 2])
        return up, fresnel(cos) * weight[:, None]

    return base


def layered(base, alpha, eta):
    """Reflectance of a rough interface over a base. `base` draws directions, with their factors."""

    def at(elevation):
        wo = np.tile(direction(elevation, 0.0), (PATHS, 1))
        out, reflected, weight = through_interface(wo, alpha, eta)
        found = np.full(3, weight[reflected].sum())
        weight, wo = weight[~reflected][:, None] * np.ones(3), -out[~reflected]
        wo[:, 2] = np.abs(wo[:, 2])
        for _ in range(60):
            if not len(weight):
                break
            up, factor = base(wo)
            weight = weight * factor
            # From the inside the interface is that from the outside, upside down.
            out, reflected, factor = through_interface(up, alpha, 1 / eta)
            weight = weight * factor[:, None]
            found += weight[~reflected].sum(0)
            weight, wo = weight[reflected], out[reflected]
            wo[:, 2] = np.abs(wo[:, 2])
        return found / PATHS

    return simulated(at)


def rough_transmittance(alpha, eta, separate):
    """Transmittance of a rough interface from the outside, by the cosine of the angle."""
    cosines = np.linspace(0.01, 1, 64)

    def passed(cos):
        wo = np.tile([np.sqrt(1 - cos * cos), 0.0, cos], (1 << 16, 1))
        _, reflected, weight = through_interface(wo, alpha, eta, separate)
        return np.where(reflected, 0, weight).mean()

    known = np.array([passed(cos) for cos in cosines])
    return lambda cos: np.interp(cos, cosines, known)


def scattering_half_space(albedo, eta):
    """A smooth boundary over a medium that scatters evenly in all directions, of that
    single-scattering albedo."""
    count = 1 << 16

    def at(elevation):
        cos = np.sin(np.radians(elevation))
        entering = 1 - dielectric(cos, eta)
        weight = np.full((count, 3), entering)
        z, down = np.zeros(count), np.full(count, np.sqrt(1 - (1 - cos * cos) / eta**2))
        found = np.full(3, count * (1 - entering))
        for _ in range(2000):
            if not len(weight):
                break
            z = z + down * -np.log(1 - RNG.random(len(z)))
            above = z < 0
            passed = 1 - dielectric(np.abs(down), 1 / eta)
            found += (weight[above] * passed[above, None]).sum(0)
            # The rest is mirrored, and scatters at the mirrored position.
            weight = weight * np.where(above, 1 - passed, 1.0)[:, None] * albedo
            z, down = np.abs(z), 2 * RNG.random(len(z)) - 1
            alive = weight.max(-1) > 1e-4
            z, down, weight = z[alive], down[alive], weight[alive]
        return found / count

    return simulated(at)


def rgb(color):
    return "[" + " ".join(f"{c:g}" for c in np.broadcast_to(color, 3)) + "]"


def lambert(color):
    return lambda wo, wi: np.broadcast_to(color / np.pi, (*wi.shape[:-1], 3))


def metal(fresnel, alpha):
    def f(wo, wi):
        lobe, cos = facets(wo, wi, alpha)
        return fresnel(cos) * lobe[..., None]

    return f


def phong(diffuse, specular, exponent):
    def f(wo, wi):
        mirror = wo * [-1.0, -1.0, 1.0]
        cos = np.maximum((mirror * wi).sum(-1), 0)[..., None]
        return diffuse / np.pi + specular * (exponent + 2) / (2 * np.pi) * cos**exponent

    return f


def added(*lobes):
    return lambda wo, wi: sum(lobe(wo, wi) for lobe in lobes)


def scaled(factor, row):
    """A row times a colour."""
    albedos, values = row
    return [a * factor for a in albedos], [v * factor for v in values]


def without_values(row):
    """The row of a material that is sampled and not evaluated."""
    return row[0], NO_VALUES


def sum_of_rows(*rows):
    """The sum of rows; a row without values adds nothing at single directions."""
    albedos = [sum(row[0][i] for row in rows) for i in range(len(ELEVATIONS))]
    values = [sum(np.nan_to_num(row[1][i]) for row in rows) for i in range(len(PAIRS))]
    return albedos, values
