"""Lamps: those without a size as glTF has them, the others as surfaces that shine.

The numbers are those of Blender's own renderer Cycles. A lamp of `P` watts (times its colour and 2 to its exposure)

* at a point, or a spot, has the radiant intensity `P/(4π)` in W/sr;
* of a radius is a sphere of radiance `P/(π A)`, of an area `A` a polygon with that radiance on its front, `A` being the area of what
  stands for it here: all shine as much as their watts say, and a sphere as a point does;
* far away (a sun) has the irradiance that its strength says, in W/m².

Held to this by `tests/test_light.py`.
"""

import math

import bmesh
import bpy
from mathutils import Matrix, Vector

from .objects import put

#: Sides of the polygon that stands for a disk.
SIDES = 32
#: A sphere as 80 triangles.
SUBDIVISIONS = 2


def add(depsgraph, plain, notes):
    """Adds all lamps to the plain scene."""
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT" and instance.show_self:
            _add_one(instance.object, instance.matrix_world.copy(), plain, notes)


def _add_one(thing, matrix, plain, notes):
    light = thing.data
    place, turn, scale = matrix.decompose()
    rigid = Matrix.LocRotScale(place, turn, None)
    color, power = _color(light), light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    if not getattr(light, "normalize", True):
        power *= light.area(matrix_world=matrix)
    if light.node_tree and getattr(light, "use_nodes", True) and len(light.node_tree.nodes) > 2:
        notes.add("nodes of lamps are left out", thing.name)
    if light.type == "AREA":
        if light.spread < math.pi - 1e-3:
            notes.add("lamps with a spread shine to all sides", thing.name)
        mesh = _flat(light, scale)
        _shine(plain, thing.name, mesh, rigid, color, power / (math.pi * _area(mesh)))
    elif light.type == "POINT" and light.shadow_soft_size > 0.0:
        mesh = _sphere(light.shadow_soft_size)
        _shine(plain, thing.name, mesh, rigid, color, power / (math.pi * _area(mesh)))
    else:
        if light.type == "SPOT" and light.shadow_soft_size > 0.0:
            notes.add("spots have no size: their shadows are sharp", thing.name)
        if light.type == "SUN" and light.angle > 0.01:
            notes.add("suns have no size: their shadows are sharp", thing.name)
        put(plain, thing.name, _punctual(light, color, power), rigid)


def _color(light):
    color = Vector(light.color)
    if getattr(light, "use_temperature", False):
        color *= Vector(light.temperature_color)
    return color


def _punctual(light, color, power):
    """A lamp that the exporter writes as it is: without nodes, temperature and exposure."""
    new = bpy.data.lights.new(light.name, light.type)
    new.color, new.energy = color, power
    if light.type == "SPOT":
        new.spot_size, new.spot_blend = light.spot_size, light.spot_blend
    return new


def _flat(light, scale):
    """The polygon of an area lamp; it shines along −z."""
    across, up = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    across, up = across * abs(scale.x) / 2.0, up * abs(scale.y) / 2.0
    if light.shape in {"DISK", "ELLIPSE"}:
        turns = [2.0 * math.pi * side / SIDES for side in range(SIDES)]
        corners = [(math.cos(turn), math.sin(turn)) for turn in turns]
    else:
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    mesh = bpy.data.meshes.new(light.name)
    # Clockwise as seen from above, so that the front is below.
    points = [(x * across, y * up, 0.0) for x, y in reversed(corners)]
    mesh.from_pydata(points, [], [range(len(points))])
    return mesh


def _sphere(radius):
    mesh = bpy.data.meshes.new("lamp")
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=SUBDIVISIONS, radius=radius)
    shape.to_mesh(mesh)
    shape.free()
    return mesh


def _area(mesh):
    return max(sum(face.area for face in mesh.polygons), 1e-12)


def _shine(plain, name, mesh, matrix, color, radiance):
    """An object whose front has this radiance, and reflects nothing."""
    brightest = max(color)
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # Blender 5 gives every material its nodes.
        material.use_nodes = True
    material.use_backface_culling = True
    node = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    node.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    node.inputs["Specular IOR Level"].default_value = 0.0
    node.inputs["Roughness"].default_value = 1.0
    node.inputs["Emission Color"].default_value = (*(color / brightest if brightest > 0.0 else color), 1.0)
    node.inputs["Emission Strength"].default_value = radiance * brightest
    mesh.materials.append(material)
    put(plain, name, mesh, matrix)
