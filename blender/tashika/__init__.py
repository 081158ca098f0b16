"""The renderer tashika as a render engine of Blender.

Three processes make a picture. Blender writes the scene that is to be rendered to a file (`engine`); a second Blender, without a
window, takes it apart as renders see it and writes it as glTF (`export`); the program `tashika` renders that (`program`), and its
OpenEXR file becomes the result (`exr`). So nothing that is open is touched, and cancelling is ending a process.
"""

from . import engine, panels, preferences, settings

_PARTS = (preferences, settings, engine, panels)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
