"""The world: a constant colour, or an image by latitude and longitude, as the environment of the program; glTF carries neither."""

import math
from pathlib import Path

import numpy

from .words import CannotBeRendered

#: The middle of an image is along +x here and north there, which is Blender's +y.
MIDDLE = -90.0


def options(world, folder, notes):
    """The options of the program; without a world all is black around the scene, not what the program takes for a scene without light."""
    if world is None:
        return _constant((0.0, 0.0, 0.0), folder)
    tree = world.node_tree if getattr(world, "use_nodes", True) else None
    if tree is None:
        return _constant(world.color, folder)
    background = _background(tree)
    if background is None:
        notes.add(
            "of worlds only a Background of a colour or an Environment Texture is known: it is black",
            world.name,
        )
        return _constant((0.0, 0.0, 0.0), folder)
    strength = background.inputs["Strength"]
    if strength.is_linked:
        notes.add("the strength of the world is not constant: its value counts", world.name)
    color = background.inputs["Color"]
    image = _image(color.links[0].from_node) if color.is_linked else None
    if image is not None:
        if not image[0].has_data and not image[0].pixels:
            raise CannotBeRendered(f"the image {image[0].name} of the world cannot be read")
        path, turn = _file(image[0], folder, notes), image[1]
        return ["--environment", f"{path},scale={strength.default_value:.9g},rotate={turn:.9g}"]
    if color.is_linked:
        notes.add("what the colour of the world is made from is not known: its colour counts", world.name)
    return _constant([c * strength.default_value for c in color.default_value[:3]], folder)


def _background(tree):
    output = tree.get_output_node("ALL") or tree.get_output_node("CYCLES")
    surface = output.inputs["Surface"] if output else None
    node = surface.links[0].from_node if surface is not None and surface.is_linked else None
    return node if node is not None and node.type == "BACKGROUND" else None


def _image(node):
    """The image of an environment texture and how far it is turned counterclockwise as seen from above; none if it is not as simple."""
    if node.type != "TEX_ENVIRONMENT" or node.image is None or node.projection != "EQUIRECTANGULAR":
        return None
    turn = 0.0
    vector = node.inputs["Vector"]
    source = vector.links[0].from_node if vector.is_linked else None
    if source is not None and source.type == "MAPPING":
        # A point that is turned looks up what is further round: the image turns the other way.
        turn = _about_z(source)
        if turn is None:
            return None
        turn *= 1.0 if source.vector_type == "TEXTURE" else -1.0
        before = source.inputs["Vector"]
        source = before.links[0].from_node if before.is_linked else None
    if source is not None and source.type != "TEX_COORD":
        return None
    turn = MIDDLE + math.degrees(turn)
    return node.image, math.remainder(turn, 360.0)


def _about_z(mapping):
    """The angle, if the mapping turns about the vertical and does nothing else."""
    rotation, location = mapping.inputs["Rotation"], mapping.inputs.get("Location")
    scale = mapping.inputs["Scale"]
    linked = any(i.is_linked for i in (rotation, scale, location) if i is not None)
    moved = (
        location is not None and mapping.vector_type in {"POINT", "TEXTURE"} and any(location.default_value)
    )
    if linked or moved or any(abs(s - 1.0) > 1e-6 for s in scale.default_value):
        return None
    x, y, z = rotation.default_value
    return z if x == 0.0 and y == 0.0 else None


def _file(image, folder, notes):
    """The image as a file in the folder, linear: Blender knows where it is and what its colours mean."""
    width, height = image.size
    samples = numpy.empty(width * height * 4, dtype=numpy.float32)
    image.pixels.foreach_get(samples)
    colors = samples.reshape(-1, 4)[:, :3]
    space = image.colorspace_settings.name
    # Floating point is linear as soon as it is read.
    if not image.is_float and space == "sRGB":
        colors = numpy.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    elif not image.is_float and space != "Non-Color":
        notes.add("colours of the world's image are taken as linear", image.name)
    return _pfm(Path(folder) / "environment.pfm", width, height, numpy.maximum(colors, 0.0))


def _constant(color, folder):
    """A colour as an image of two pixels."""
    path = _pfm(Path(folder) / "environment.pfm", 2, 1, numpy.array([color, color]))
    return ["--environment", str(path)]


def _pfm(path, width, height, colors):
    """Writes colours, lines from the bottom."""
    with open(path, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1.0\n".encode())
        colors.astype("<f4").tofile(file)
    return path
