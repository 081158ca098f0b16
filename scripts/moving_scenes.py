#!/usr/bin/env python3
"""Writes scenes in which objects move, from scenes of Mitsuba in which nothing moves.

    pip install numpy
    python3 scripts/moving_scenes.py scene_v3.xml fan SCENE_OUT.xml
        the Cornell box: a fan of three blades turns by 90 degrees
    python3 scripts/moving_scenes.py room_glossy.xml knot SCENE_OUT.xml
        a room: its knot goes and turns

The shutter is to be open from 0 to 1 s (`--shutter 0,1`). The new scene has to lie beside the old
one, whose files it names.
"""

import sys

import numpy as np


def turned(angle):
    """Rotation around the vertical axis."""
    c, s = np.cos(angle), np.sin(angle)
    m = np.eye(4)
    m[0, 0], m[0, 2], m[2, 0], m[2, 2] = c, s, -s, c
    return m


def moved(*way):
    m = np.eye(4)
    m[:3, 3] = way
    return m


def animation(keys):
    """Animation of (time, matrix) keys."""
    of_key = '<transform time="{:g}"><matrix value="{}"/></transform>'
    return '<animation name="to_world">{}</animation>'.format(
        "".join(of_key.format(t, " ".join(f"{v:.9g}" for v in m.ravel())) for t, m in keys)
    )


def fan(scene):
    blade = moved(0.3, 0, 0) @ np.diag([0.28, 0.01, 0.09, 1])
    shapes = ""
    for number in range(3):
        at = [(t, moved(0, 1.45, 0) @ turned(2 * np.pi * number / 3 + t * np.pi / 2) @ blade) for t in np.linspace(0, 1, 5)]
        shapes += f'<shape type="cube" id="blade{number}">{animation(at)}<ref id="ShortBoxBSDF"/></shape>'
    return scene.replace("</scene>", shapes + "</scene>")


def knot(scene):
    keys = [(0, np.eye(4)), (1, moved(0.3, 0.1, 0.1) @ turned(0.3))]
    shape = '<shape type="ply" id="knot">'
    return scene.replace(shape, shape + animation(keys))


def main():
    source, what, out = sys.argv[1:]
    with open(source, encoding="utf-8") as file:
        scene = file.read()
    changed = {"fan": fan, "knot": knot}[what](scene)
    assert changed != scene, f"{source} has nothing that {what} asks for"
    with open(out, "w", encoding="utf-8") as file:
        file.write(changed)


main()
