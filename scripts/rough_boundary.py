#!/usr/bin/env python3
"""Writes the table of `tashika::bsdf::boundary`: transmittance of rough dielectric boundaries.

    pip install numpy
    python3 scripts/rough_boundary.py > crates/tashika-scene/src/bsdf/boundary/table.rs

Transmittance at a cosine is the mean, over the normals that are visible from there, of the unmasked
transmittance of a facet (Walter et al. 2007, equations 21, 27 and 34; visible normals of GGX by
Dupuy and Benyoub 2023, of Beckmann's by their slopes, Heitz and d'Eon 2014); reflectance from the
inside likewise. For each roughness and index, transmittance is fitted by
`k T(c) + q0 + q1 c + q2 c^2 + q3 c^3`, `T` being that of the smooth boundary: least squares over 20
Chebyshev nodes of the cosine, relative to it.
"""

import numpy as np

ALPHAS = [0.02, 0.04, 0.07, 0.11, 0.17, 0.25, 0.36, 0.5, 0.65, 0.82, 1.0]
IORS = [1.02, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.75, 1.9, 2.1, 2.4, 2.7, 3.1, 3.6, 4.2, 5.0]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
U, V = np.meshgrid(0.5 + 0.5 * NODES, 0.5 + 0.5 * NODES)
WEIGHT = np.outer(WEIGHTS, WEIGHTS) / 4
SLOPES = np.linspace(-6, 6, 20001)


def fresnel(cos, eta):
    """Reflectance of a facet, and the cosine behind it."""
    squared = 1 - (1 - cos * cos) / eta**2
    behind = np.sqrt(np.maximum(squared, 0))
    across = (cos - eta * behind) / (cos + eta * behind)
    along = (eta * cos - behind) / (eta * cos + behind)
    return np.where(squared <= 0, 1, 0.5 * (across**2 + along**2)), behind


def ggx_normals(seen_from):
    """Visible normals of a surface of roughness 1, not normalised."""
    z = (1 - U) * (1 + seen_from[2]) - seen_from[2]
    sine, phi = np.sqrt(np.maximum(1 - z * z, 0)), 2 * np.pi * V
    return np.stack([sine * np.cos(phi) + seen_from[0], sine * np.sin(phi), np.maximum(z + seen_from[2], 0)])


def slopes(cos, sine, share):
    """Quantiles of the slopes, along a direction, that are visible from it."""
    density = np.maximum(cos + SLOPES * sine, 0) * np.exp(-(SLOPES**2))
    below = np.concatenate([[0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp(share, below / below[-1], SLOPES)


def beckmann_normals(seen_from):
    return np.stack([slopes(seen_from[2], seen_from[0], U), slopes(1, 0, V), np.ones_like(U)])


def facets(cos, alpha, normals_of):
    """A direction and the normals that are visible from it."""
    cos = max(cos, 1e-6)
    direction = np.array([np.sqrt(1 - cos * cos), 0, cos])
    stretched = direction * [alpha, 1, 1]
    normals = normals_of(stretched / np.linalg.norm(stretched)) * np.array([alpha, alpha, 1])[:, None, None]
    return direction, normals / np.linalg.norm(normals, axis=0)


def ggx_unmasked(across):
    return 2 / (1 + np.sqrt(1 + across**2))


def independent(unmasked):
    """Unmasked share on the other side, if masking of the two sides is independent."""
    return lambda _, across: unmasked(across)


def correlated(seen, across):
    """Unmasked share on the other side, for GGX facets whose heights are equal for both sides
    (Heitz 2014, equation 99)."""
    one, other = (1 / ggx_unmasked(slope) for slope in (seen, across))
    return one / (one + other - 1)


def beckmann_unmasked(across):
    a = 1 / np.maximum(across, 1e-15)
    a = np.minimum(a, 1.6)
    return np.minimum((3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a), 1)


def slope(direction, alpha):
    return alpha * np.sqrt((direction[0] ** 2 + direction[1] ** 2) / np.maximum(direction[2] ** 2, 1e-30))


def transmittance(cos, alpha, eta, normals_of, unshadowed):
    direction, normals = facets(cos, alpha, normals_of)
    incidence = np.tensordot(direction, normals, 1)
    reflected, behind = fresnel(incidence, eta)
    on = normals * (incidence / eta - behind) - direction[:, None, None] / eta
    sees = (on[2] < 0) & ((on * normals).sum(0) < 0)
    return float((unshadowed(slope(direction, alpha), slope(on, alpha)) * (1 - reflected) * sees * WEIGHT).sum())


def reflectance(cos, alpha, eta, normals_of, unshadowed):
    direction, normals = facets(cos, alpha, normals_of)
    incidence = np.tensordot(direction, normals, 1)
    reflected, _ = fresnel(incidence, eta)
    on = 2 * incidence * normals - direction[:, None, None]
    sees = (on[2] > 0) & ((on * normals).sum(0) > 0)
    return float((unshadowed(slope(direction, alpha), slope(on, alpha)) * reflected * sees * WEIGHT).sum())


def fitted(alpha, eta, *model):
    cosines = 0.5 - 0.5 * np.cos(np.pi * (np.arange(20) + 0.5) / 20)
    wanted = np.array([transmittance(c, alpha, eta, *model) for c in cosines])
    smooth = 1 - fresnel(cosines, eta)[0]
    importance = np.sqrt(np.minimum(1, cosines / 0.1)) / np.maximum(wanted, 0.2)
    basis = np.stack([smooth, *(cosines**k for k in range(4))], 1) * importance[:, None]
    # Where there is hardly a boundary, the smooth one is nearly constant too: the smallest change
    # is taken.
    damping = 1e-6 * np.eye(5)
    bent = basis.T @ (wanted * importance) + damping @ [1, 0, 0, 0, 0]
    # Mitsuba's models by a mean over 64 cosines, ends included, as in Mitsuba: 1 % below the
    # integral.
    mean = (np.arange(200) + 0.5) / 200 if model[1] is correlated else np.linspace(0, 1, 64)
    inside = 2 * np.mean([c * reflectance(c, alpha, 1 / eta, *model) for c in mean])
    return [*np.linalg.solve(basis.T @ basis + damping, bent), inside]


def main():
    print("//! Written by `scripts/rough_boundary.py`.\n")
    print("// Numbers of a fit may look like a constant.\n#![allow(clippy::approx_constant)]\n")
    print("/// Roughness `α` of the rows; before them are smooth boundaries.")
    print(f"pub(super) const ALPHAS: [f32; {len(ALPHAS)}] = {ALPHAS};\n")
    print("/// Index of refraction `η` of the columns.")
    print(f"pub(super) const IORS: [f32; {len(IORS)}] = {IORS};\n")
    print("/// `k`, `q₀` to `q₃`, and the reflectance from the inside.")
    print(f"pub(super) type Fits = [[[f32; 6]; {len(IORS)}]; {len(ALPHAS)}];")
    write("GGX", "Table of GGX facets, correlated by height.", ggx_normals, correlated)
    write("GGX_INDEPENDENT", "Table of GGX facets.", ggx_normals, independent(ggx_unmasked))
    write("BECKMANN", "Table of Beckmann's facets.", beckmann_normals, independent(beckmann_unmasked))


def write(name, words, *model):
    print(f"\n/// {words}")
    print("#[rustfmt::skip]")
    print(f"pub(super) const {name}: Fits = [")
    for alpha in ALPHAS:
        rows = (", ".join(f"{value:.5f}" for value in fitted(alpha, eta, *model)) for eta in IORS)
        print("    [\n" + "".join(f"        [{row}],\n" for row in rows) + "    ],")
    print("];")


if __name__ == "__main__":
    main()
