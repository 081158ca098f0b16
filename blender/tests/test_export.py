"""The scene as glTF: what renders see of it."""

import json
import struct

import bpy
import pytest
from conftest import folder
from scenes import cube, cube_on_plane, material, plane, put, with_nodes


@pytest.fixture
def gltf(scene, render, asked, tmp_path):
    """Renders the scene; the JSON of its glTF."""
    asked("--method", "path", "--paths", "1")

    def of():
        render(scene)
        data = (folder(tmp_path) / "scene.glb").read_bytes()
        (length,) = struct.unpack_from("<I", data, 12)
        return json.loads(data[20 : 20 + length])

    return of


def vertices(root, mesh):
    (primitive,) = root["meshes"][mesh]["primitives"]
    return root["accessors"][primitive["attributes"]["POSITION"]]["count"]


def named(root, name):
    return [node for node in root["nodes"] if node["name"].split(".")[0] == name]


def test_modifiers_are_those_of_renders(scene, gltf):
    cube_on_plane(scene)
    finer = scene.objects["cube"].modifiers.new("finer", "SUBSURF")
    finer.levels, finer.render_levels = 0, 2
    hidden = cube(scene, at=(0.0, 2.0, 0.0))
    hidden.name, hidden.hide_render = "hidden", True
    unseen = cube(scene, at=(0.0, -2.0, 0.0))
    unseen.name, unseen.hide_viewport = "unseen", True
    root = gltf()
    (node,) = named(root, "cube")
    # A cube cut twice has 96 faces, of four corners each.
    assert vertices(root, node["mesh"]) == 96 * 4
    assert not named(root, "hidden")
    # Renders see what viewports do not.
    assert len(named(root, "unseen")) == 1


def test_instances_share_their_mesh(scene, gltf):
    cube_on_plane(scene)
    group = bpy.data.collections.new("group")
    inner = cube(scene, half=0.1)
    inner.name = "inner"
    scene.collection.objects.unlink(inner)
    group.objects.link(inner)
    for x in (1.0, 2.0, 3.0):
        empty = put(scene, "instance", None, (x, 0.0, 0.0))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    placed = named(gltf(), "inner")
    assert sorted(round(node["translation"][0]) for node in placed) == [1, 2, 3]
    assert len({node["mesh"] for node in placed}) == 1


def test_sheared_things_keep_their_shape(scene, gltf):
    cube_on_plane(scene)
    parent = put(scene, "parent", None)
    parent.scale = (3.0, 1.0, 1.0)
    child = cube(scene)
    child.name = "child"
    child.parent, child.rotation_euler = parent, (0.0, 0.0, 0.5)
    bpy.context.view_layer.update()
    corner = child.matrix_world @ child.data.vertices[7].co
    farthest = max((child.matrix_world @ v.co).x for v in child.data.vertices)
    root = gltf()
    (node,) = named(root, "child")
    assert "matrix" not in node and node.get("scale", [1, 1, 1]) == [1, 1, 1]
    (primitive,) = root["meshes"][node["mesh"]]["primitives"]
    upper = root["accessors"][primitive["attributes"]["POSITION"]]["max"]
    assert upper[0] == pytest.approx(farthest, abs=1e-5)
    assert upper[1] == pytest.approx(corner.z, abs=1e-5)


def test_materials_of_objects_count(scene, gltf):
    """A material of the object's slot, not of its mesh."""
    cube_on_plane(scene)
    slot = scene.objects["cube"].material_slots[0]
    slot.link, slot.material = "OBJECT", material("green", (0.1, 0.8, 0.1))
    root = gltf()
    (node,) = named(root, "cube")
    (primitive,) = root["meshes"][node["mesh"]]["primitives"]
    color = root["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
    assert color[:3] == pytest.approx([0.1, 0.8, 0.1], abs=1e-3)


def test_what_is_left_out_is_told(scene, gltf, tmp_path):
    cube_on_plane(scene)
    put(scene, "smoke", bpy.data.volumes.new("smoke"))
    glassy = bpy.data.materials.new("old glass")
    with_nodes(glassy)
    tree = glassy.node_tree
    tree.nodes.clear()
    glass, output = tree.nodes.new("ShaderNodeBsdfGlass"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(glass.outputs[0], output.inputs["Surface"])
    plane(scene, half=0.1, of=glassy)
    gltf()
    notes = json.loads((folder(tmp_path) / "scene.json").read_text())["notes"]
    assert "volumes are left out: smoke" in notes
    assert any(
        note.startswith("materials without Principled BSDF") and note.endswith(": old glass")
        for note in notes
    )


def test_nothing_that_is_open_changes(scene, gltf):
    cube_on_plane(scene)
    kinds = ("scenes", "objects", "meshes", "materials", "lights", "cameras", "images", "worlds")

    def all_names():
        return {kind: sorted(one.name for one in getattr(bpy.data, kind)) for kind in kinds}

    bpy.context.view_layer.objects.active = scene.objects["cube"]
    before, place = all_names(), scene.objects["cube"].matrix_world.copy()
    gltf()
    after = all_names()
    # Blender's own, for what is rendered.
    after["images"] = [name for name in after["images"] if name not in {"Render Result", "still.exr"}]
    before["images"] = [name for name in before["images"] if name != "Render Result"]
    assert after == before
    assert bpy.context.window.scene == scene
    assert bpy.context.view_layer.objects.active == scene.objects["cube"]
    assert scene.objects["cube"].matrix_world == place
