"""Writes crates/tashika-report/src/measures/independent.txt: measures by independent programs.

    pip install flip-evaluator==1.7 scikit-image==0.26.0
    python3 scripts/picture_measures.py

FLIP is by NVIDIA's own program, SSIM and PSNR are by scikit-image. The pictures are `reference` and
`changed`, which the tests of `measures` make by the same formulas, in linear Rec. 709. Rows: a
change, a measure, numbers.
"""

from pathlib import Path

import flip_evaluator
import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

WIDTH, HEIGHT = 56, 44
# Pixels whose values of the maps are written: inside, at an edge of the picture, in a corner.
PLACES = ((20, 17), (31, 30), (0, 25), (55, 43))
OUT = Path(__file__).parent.parent / "crates/tashika-report/src/measures/independent.txt"


def reference(x, y):
    """A ramp with stripes in red, a texture in green, a board in blue."""
    board = (x // 9 + y // 7) % 2
    return [(x + 14 * ((x + y) % 16 < 6)) / 70, (3 * x + 5 * y) % 31 / 40 + board / 8, (1 + 3 * board) / 5]


def changed(change, x, y):
    """The reference with an error of that kind."""
    color = reference(x, y)
    if change == "noise":
        return [max(0.0, v + ((7 * x + 13 * y + 5 * c + x * y) % 11 - 5) / 40) for c, v in enumerate(color)]
    if change == "shift":
        return reference(x + 2, y + 1)
    if change == "dark":
        return [0.8 * v for v in color]
    if change == "hue":
        return [color[2], color[0], color[1]] if x > y else color
    # Isolated bright pixels, as they come from paths of great weight.
    return [1.0, 1.0, 1.0] if (x * x + 3 * y) % 97 == 0 else color


def picture(of):
    """A picture of float64, clamped to 0 to 1, rows first."""
    rows = [[of(x, y) for x in range(WIDTH)] for y in range(HEIGHT)]
    return np.clip(np.array(rows, dtype=np.float64), 0, 1)


def encoded(linear):
    """IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def main():
    truth = picture(reference)
    rows = []
    for change in ("noise", "shift", "dark", "hue", "fireflies"):
        test = picture(lambda x, y, change=change: changed(change, x, y))
        a, b = encoded(test), encoded(truth)
        rows.append((change, "psnr", [peak_signal_noise_ratio(b, a, data_range=1)]))
        luma = [p @ np.array([0.2126, 0.7152, 0.0722]) for p in (a, b)]
        options = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False, "data_range": 1}
        ssim, similar = structural_similarity(*luma, full=True, **options)
        rows.append((change, "ssim", [ssim] + [similar[y, x] for x, y in PLACES[:2]]))
        both = [p.astype(np.float32) for p in (truth, test)]
        for density in (67, 30):
            found = flip_evaluator.evaluate(*both, "LDR", False, False, True, {"ppd": density})
            rows.append((change, f"flip{density}", [found[1]] + [found[0][y, x, 0] for x, y in PLACES]))
    lines = [f"{change} {measure} " + " ".join(f"{v:.7f}" for v in values) for change, measure, values in rows]
    OUT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
