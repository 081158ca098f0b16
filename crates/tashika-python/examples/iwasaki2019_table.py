"""The table of `tashika experiment iwasaki2019`: pixels of each method within the error.

python iwasaki2019_table.py kitchen.glb --size 320 180 --vpls 10000 --gather 16 --pixels 500
"""

import argparse

import tashika


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("scene", help="a scene file, builtin:room or builtin:tiny")
    options.add_argument("--size", type=int, nargs=2, metavar=("WIDTH", "HEIGHT"))
    options.add_argument("--vpls", type=int, default=55_000)
    options.add_argument("--gather", type=int, default=256)
    options.add_argument("--error", type=float, default=0.02)
    options.add_argument("--confidence", type=float, default=0.95)
    options.add_argument("--pixels", type=int, help="pixels at random (all of them)")
    typed = options.parse_args()

    rows = tashika.coverage(
        tashika.load(typed.scene),
        errors=[typed.error],
        confidences=[typed.confidence],
        pixels=typed.pixels,
        size=typed.size,
        vpls=typed.vpls,
        gather=typed.gather,
    )
    print(f"{'method':<20}{'within the error':>18}{'worst':>12}{'rays/pixel':>12}")
    for row in rows:
        worst = "infinite" if row["worst"] is None else f"{row['worst']:.2%}"
        within = f"{row['within_tolerance'] * row['pixels']:,.0f} of {row['pixels']:,}"
        print(f"{row['method']:<20}{within:>18}{worst:>12}{row['rays_per_pixel']:>12,.0f}")


if __name__ == "__main__":
    main()
