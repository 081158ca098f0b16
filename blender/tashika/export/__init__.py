"""A scene of Blender as glTF, in a process of its own.

Blender's exporter goes by the scene as viewports see it, switches the scene of the window, and knows neither instances nor lamps
with a size. Here the scene is first made plain as renders see it: meshes with their modifiers at the level of renders, each instance
an object, lamps with a size as surfaces that shine. That plain scene is exported.
"""
