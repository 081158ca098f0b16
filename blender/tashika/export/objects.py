"""Surfaces: every mesh as renders see it, once, and an object for each place where it is seen."""

import bpy
from mathutils import Matrix

from .words import CannotBeRendered

#: Objects that have a mesh, or are made into one.
WITH_MESH = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
#: Objects that are seen and for which there is no mesh.
LEFT_OUT = {
    "CURVES": "hair curves are left out",
    "POINTCLOUD": "point clouds are left out",
    "VOLUME": "volumes are left out",
    "GREASEPENCIL": "grease pencil is left out",
    "GPENCIL": "grease pencil is left out",
}
#: Largest difference of two matrices that are the same, relative to the larger; ten roundings of 32 bits.
ROUNDING = 1e-6


def add(depsgraph, plain, notes):
    """Adds all surfaces to the plain scene."""
    meshes = {}
    for instance in depsgraph.object_instances:
        thing = instance.object
        if not instance.show_self:
            continue
        if thing.type in LEFT_OUT:
            notes.add(LEFT_OUT[thing.type], thing.name)
        if thing.type not in WITH_MESH or thing.data is None:
            continue
        if thing.is_holdout or thing.is_shadow_catcher:
            notes.add("holdouts and shadow catchers are surfaces like others", thing.name)
        materials = tuple(slot.material.original if slot.material else None for slot in thing.material_slots)
        key = (thing.data.as_pointer(), materials)
        if key not in meshes:
            meshes[key] = _mesh(thing, materials, depsgraph, notes)
        if meshes[key]:
            _place(plain, thing.name, meshes[key], instance.matrix_world.copy())
    if not plain.objects:
        raise CannotBeRendered("there is no surface to render")


def _mesh(thing, materials, depsgraph, notes):
    """A copy of the mesh of an evaluated object, with the materials of its slots; none without faces."""
    try:
        mesh = bpy.data.meshes.new_from_object(thing, preserve_all_data_layers=True, depsgraph=depsgraph)
    except RuntimeError:
        return None
    if not mesh or not mesh.polygons:
        return None
    for index, material in enumerate(materials):
        if index < len(mesh.materials):
            mesh.materials[index] = material
        else:
            mesh.materials.append(material)
        if material and not _is_understood(material):
            notes.add(
                "materials without Principled BSDF or Emission become what the glTF exporter makes of them",
                material.name,
            )
    return mesh


def _is_understood(material):
    known = {"BSDF_PRINCIPLED", "EMISSION", "BACKGROUND"}

    def has(tree):
        return any(
            node.type in known or (node.type == "GROUP" and node.node_tree and has(node.node_tree))
            for node in tree.nodes
        )

    return material.node_tree is None or has(material.node_tree)


def _place(plain, name, mesh, matrix):
    """An object of the mesh; where location, rotation and scale cannot say its place, the mesh is moved there."""
    as_said = Matrix.LocRotScale(*matrix.decompose())
    largest = max(abs(x) for row in matrix for x in row)
    off = max(abs(a - b) for said, row in zip(as_said, matrix) for a, b in zip(said, row))
    if off > ROUNDING * largest:
        mesh = mesh.copy()
        mesh.transform(matrix)
        matrix = Matrix()
    put(plain, name, mesh, matrix)


def put(plain, name, data, matrix):
    """A new object in the plain scene."""
    thing = bpy.data.objects.new(name, data)
    plain.collection.objects.link(thing)
    thing.matrix_world = matrix
    return thing
