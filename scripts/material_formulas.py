#!/usr/bin/env python3
"""Writes the reflectance of materials of pbrt, Mitsuba 0.6, glTF and MTL by the formulas of their
formats, for the suite's `formula_materials`.

    pip install numpy
    python3 scripts/material_formulas.py > crates/tashika/tests/suite/formula_materials.txt

A row is a format, a material in its words, and the numbers of `material_table.py`; `nan` where the
material has no value at single directions. The modules `formulas_*` have the materials of one
format each and name their sources. If formats are named, only these are written.
"""

import sys

import formulas_gltf
import formulas_mitsuba
import formulas_mtl
import formulas_pbrt
from material_math import begin_again
from material_table import numbers

FORMATS = {
    "pbrt-v3": formulas_pbrt.version_3,
    "pbrt-v4": formulas_pbrt.version_4,
    "Mitsuba 0.6": formulas_mitsuba.materials,
    "glTF": formulas_gltf.materials,
    "MTL": formulas_mtl.materials,
}


def main():
    print("# Written by scripts/material_formulas.py.")
    for name in sys.argv[1:] or FORMATS:
        begin_again()
        for text, found in FORMATS[name]():
            print(name, "|", text, "|", numbers(*found), flush=True)


if __name__ == "__main__":
    main()
