#!/usr/bin/env python3
"""Writes the room that the book renders: walls, a lamp, a matt and a metal block.

    python3 scripts/book_room.py > docs/book/src/room.gltf
"""

import base64
import json
import math
import struct

NAMES = ["white", "red", "green", "lamp", "metal"]
COLORS = [[0.75, 0.75, 0.75], [0.6, 0.1, 0.08], [0.12, 0.4, 0.12], [0, 0, 0], [0.9, 0.7, 0.4]]


def quad(corner, along, across):
    ends = [corner, *([sum(p) for p in zip(corner, *sides)] for sides in ([along], [along, across], [across]))]
    normal = [along[1] * across[2] - along[2] * across[1], along[2] * across[0] - along[0] * across[2], along[0] * across[1] - along[1] * across[0]]
    length = math.hypot(*normal)
    return [(end, [v / length for v in normal]) for end in ends]


def block(centre, half, angle):
    c, s = math.cos(angle), math.sin(angle)
    u, w, v = [half[0] * c, 0, -half[0] * s], [half[2] * s, 0, half[2] * c], [0, half[1], 0]

    def at(a, b, d):
        return [centre[i] + a * u[i] + b * v[i] + d * w[i] for i in range(3)]

    def twice(x):
        return [2 * n for n in x]

    faces = []
    faces += quad(at(-1, -1, 1), twice(u), twice(v)) + quad(at(1, -1, -1), twice([-n for n in u]), twice(v))
    faces += quad(at(1, -1, 1), twice([-n for n in w]), twice(v)) + quad(at(-1, -1, -1), twice(w), twice(v))
    return faces + quad(at(-1, 1, 1), twice(u), twice([-n for n in w]))


PARTS = [
    quad([-1, 0, 1], [2, 0, 0], [0, 0, -2])
    + quad([-1, 2, -1], [2, 0, 0], [0, 0, 2])
    + quad([-1, 0, -1], [2, 0, 0], [0, 2, 0])
    + block([0.38, 0.3, 0.3], [0.28, 0.3, 0.28], -0.3),
    quad([-1, 0, 1], [0, 0, -2], [0, 2, 0]),
    quad([1, 0, -1], [0, 0, 2], [0, 2, 0]),
    quad([-0.3, 1.99, -0.3], [0.6, 0, 0], [0, 0, 0.6]),
    block([-0.38, 0.6, -0.3], [0.28, 0.6, 0.28], 0.35),
]


def main():
    data, views, accessors, primitives = b"", [], [], []

    def add(kind, component, values, form, bounds=None):
        nonlocal data
        packed = b"".join(struct.pack(form, *value) for value in values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        data += packed + b"\0" * (-len(packed) % 4)
        accessor = {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
        accessors.append({**accessor, **(bounds or {})})
        return len(accessors) - 1

    for material, corners in enumerate(PARTS):
        places = [place for place, _ in corners]
        bounds = {"min": [min(c) for c in zip(*places)], "max": [max(c) for c in zip(*places)]}
        triangles = [(4 * k + a,) for k in range(len(corners) // 4) for a in (0, 1, 2, 0, 2, 3)]
        attributes = {
            "POSITION": add("VEC3", 5126, places, "<3f", bounds),
            "NORMAL": add("VEC3", 5126, [normal for _, normal in corners], "<3f"),
        }
        indices = add("SCALAR", 5123, triangles, "<H")
        primitives.append({"attributes": attributes, "indices": indices, "material": material})
    materials = []
    for name, color in zip(NAMES, COLORS):
        metal = name == "metal"
        core = {"baseColorFactor": [*color, 1], "metallicFactor": float(metal), "roughnessFactor": 0.3 if metal else 1.0}
        materials.append({"name": name, "pbrMetallicRoughness": core})
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 17}}
    materials[3].update(emissiveFactor=[1, 0.9, 0.75], extensions=strength)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document = {
        "asset": {"version": "2.0", "generator": "scripts/book_room.py"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": views,
        "accessors": accessors,
        "materials": materials,
        "meshes": [{"name": "room", "primitives": primitives}],
        "cameras": [
            {"name": "front", "type": "perspective", "perspective": {"yfov": 0.67, "znear": 0.1, "aspectRatio": 1}},
            {"name": "near", "type": "perspective", "perspective": {"yfov": 0.4, "znear": 0.1, "aspectRatio": 1}},
        ],
        "nodes": [
            {"name": "room", "mesh": 0},
            {"name": "front", "camera": 0, "translation": [0, 1, 3.9]},
            {"name": "near", "camera": 1, "translation": [0, 0.9, 3.2]},
        ],
        "scenes": [{"nodes": [0, 1, 2]}],
        "scene": 0,
    }
    print(json.dumps(document))


if __name__ == "__main__":
    main()
