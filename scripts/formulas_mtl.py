"""Reflectance of materials of Wavefront MTL, by the reading of its formulas in the guide."""

import numpy as np

from formulas_gltf import metallic_roughness
from material_math import COLOR, constant, dielectric, lambert, phong, row_of, scaled, smooth, sum_of_rows

KD = "Kd " + " ".join(f"{c:g}" for c in COLOR)
KS = np.array([0.3, 0.3, 0.2])


def materials():
    yield KD, row_of(lambert(COLOR))
    for illum in (0, 1):
        yield f"illum {illum}; {KD}", row_of(lambert(COLOR))
        yield f"illum {illum}; {KD}; Ks 0.3 0.3 0.2; Ns 5", row_of(lambert(COLOR))
    for exponent in (5, 40, 400):
        yield f"illum 2; {KD}; Ks 0.3 0.3 0.2; Ns {exponent}", row_of(phong(COLOR, KS, exponent))
    yield f"{KD}; Ks 0.3 0.3 0.2; Ns 40", row_of(phong(COLOR, KS, 40))
    for text in ("d 0.4", "Tr 0.6"):
        yield f"{KD}; {text}", sum_of_rows(scaled(0.4, row_of(lambert(COLOR))), constant(np.full(3, 0.6)))
    # Rays are traced in the mirror direction; 5 has Fresnel's reflectance, by Schlick that of Ks.
    for diffuse in (0.0, 0.2):
        kd, base = " ".join(f"{c:g}" for c in np.full(3, diffuse)), row_of(lambert(np.full(3, diffuse)))
        mirror = constant(np.array([0.7, 0.6, 0.5]))
        yield f"illum 3; Kd {kd}; Ks 0.7 0.6 0.5", sum_of_rows(base, mirror)
        mirror = smooth(lambda cos: np.array([0.7, 0.6, 0.5]) * (1 - (1 - cos) ** 5) + (1 - cos) ** 5)
        yield f"illum 5; Kd {kd}; Ks 0.7 0.6 0.5", sum_of_rows(base, mirror)
    filter_ = np.array([0.9, 0.6, 0.3])
    for index in (1.3, 1.5):
        glass = smooth(lambda cos: dielectric(cos, index) + (1 - dielectric(cos, index)) * filter_)
        for illum in (4, 7, 9):
            yield f"illum {illum}; Tf 0.9 0.6 0.3; Ni {index}; d 0.2", glass
        # Without Fresnel: the rest that Ks leaves.
        plain = constant(0.04 + 0.96 * filter_)
        yield f"illum 6; Ks 0.04 0.04 0.04; Tf 0.9 0.6 0.3; Ni {index}; d 0.2", plain
    for metallic, roughness in ((0.0, 0.4), (0.5, 0.6), (1.0, 0.8)):
        text = f"{KD}; Pr {roughness}; Pm {metallic}; Ni 1.5"
        yield text, row_of(metallic_roughness(COLOR, metallic, roughness, 0.04))
