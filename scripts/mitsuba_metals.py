#!/usr/bin/env python3
"""Writes the optical constants of Mitsuba 3's conductor materials, for the reader of its files.

    pip install mitsuba
    python3 scripts/mitsuba_metals.py > crates/tashika-formats/src/io/mitsuba/metals.rs

The names are those of the table of materials in Mitsuba's documentation (plugin `conductor`).
"""

import mitsuba as mi

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
NAMES = """a-C Ag Al AlAs AlAs_palik AlSb AlSb_palik Au Be Be_palik Cr CsI CsI_palik Cu Cu_palik Cu2O Cu2O_palik CuO
CuO_palik d-C d-C_palik Hg Hg_palik HgTe HgTe_palik Ir Ir_palik K K_palik Li Li_palik MgO MgO_palik Mo Mo_palik Na_palik
Nb Nb_palik Ni_palik Rh Rh_palik Se Se_palik SiC SiC_palik SnTe SnTe_palik Ta Ta_palik Te Te_palik ThF4 ThF4_palik TiC
TiC_palik TiN TiN_palik TiO2 TiO2_palik VC VC_palik V_palik VN VN_palik W""".split()


def constants(name):
    found = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
    return [value for key in ("eta.value", "k.value") for value in list(found[key])]


def main():
    rows = []
    for name in NAMES:
        try:
            rows.append((name, constants(name)))
        except RuntimeError:
            continue
    print("//! Written by `scripts/mitsuba_metals.py`.\n")
    print(f"/// Name, `η` and `k` (red, green, blue) of each metal that Mitsuba {mi.__version__} names.")
    print("#[rustfmt::skip]")
    print(f"pub(super) const METALS: [(&str, [f32; 3], [f32; 3]); {len(rows)}] = [")
    for name, values in rows:
        values = [f"{value:.5f}" for value in values]
        print(f'    ("{name}", [{", ".join(values[:3])}], [{", ".join(values[3:])}]),')
    print("];")


if __name__ == "__main__":
    main()
