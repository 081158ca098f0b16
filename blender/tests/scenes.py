"""Things to put into scenes."""

import bpy
from mathutils import Vector


def put(scene, name, data, at=(0.0, 0.0, 0.0), towards=None):
    """A new object; a camera or a lamp looks towards a place."""
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.location = at
    if towards is not None:
        thing.rotation_euler = (Vector(towards) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.view_layer.update()
    return thing


def with_nodes(thing):
    """Blender 5 gives every material and world its nodes."""
    if thing.node_tree is None:
        thing.use_nodes = True


def material(name, color=(0.8, 0.8, 0.8), emission=0.0):
    """A diffuse surface, or one that shines."""
    new = bpy.data.materials.new(name)
    with_nodes(new)
    node = new.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (*color, 1.0)
    node.inputs["Roughness"].default_value = 1.0
    node.inputs["Specular IOR Level"].default_value = 0.0
    node.inputs["Emission Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    node.inputs["Emission Strength"].default_value = emission
    return new


def mesh(name, points, faces, of=None):
    new = bpy.data.meshes.new(name)
    new.from_pydata(points, [], faces)
    if of is not None:
        new.materials.append(of)
    return new


def plane(scene, half=10.0, of=None, at=(0.0, 0.0, 0.0)):
    corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
    return put(scene, "plane", mesh("plane", corners, [(0, 1, 2, 3)], of or material("white")), at)


def cube(scene, half=0.5, of=None, at=(0.0, 0.0, 0.0)):
    points = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return put(scene, "cube", mesh("cube", points, faces, of or material("red", (0.8, 0.1, 0.1))), at)


def camera(scene, at, towards, **said):
    data = bpy.data.cameras.new("view")
    for name, value in said.items():
        setattr(data, name, value)
    scene.camera = put(scene, "view", data, at, towards)
    return scene.camera


def lamp(scene, kind, watts, at, towards=(0.0, 0.0, 0.0), **said):
    data = bpy.data.lights.new("lamp", kind)
    data.energy = watts
    for name, value in said.items():
        setattr(data, name, value)
    return put(scene, "lamp", data, at, towards)


def world(scene, color, strength=1.0):
    new = scene.world = bpy.data.worlds.new("world")
    with_nodes(new)
    background = new.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    return new


def cube_on_plane(scene):
    """A red cube on a plane under an area lamp, in weak bluish light."""
    plane(scene)
    cube(scene, at=(0.0, 0.0, 0.5))
    lamp(scene, "AREA", 150.0, (1.5, -1.5, 3.0), shape="RECTANGLE", size=1.0, size_y=0.5)
    world(scene, (0.05, 0.06, 0.1))
    camera(scene, (3.0, -3.0, 2.5), (0.0, 0.0, 0.4), lens=40.0)
