"""What holds for this machine: where the program is, and how it is run."""

import bpy

from . import program


class TashikaPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program",
        description="The program tashika; without it, the one that the search path of the system finds",
        subtype="FILE_PATH",
    )
    threads: bpy.props.IntProperty(
        name="Threads",
        description="Threads of the program; 0 is one a core. The picture does not depend on it",
        min=0,
        max=1024,
    )
    keep_files: bpy.props.BoolProperty(
        name="Keep Temporary Files",
        description="Keep the folder with the scene, the OpenEXR file and the page of each render, and say where it is",
    )

    def draw(self, _context):
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "program")
        column.prop(self, "threads")
        column.prop(self, "keep_files")
        try:
            column.label(text=f"Found: {program.find(self.program)}", icon="CHECKMARK")
        except program.Failure as failure:
            for line in str(failure).split("; "):
                column.label(text=line, icon="ERROR")


def of(context):
    """The preferences."""
    return context.preferences.addons[__package__].preferences


def register():
    bpy.utils.register_class(TashikaPreferences)


def unregister():
    bpy.utils.unregister_class(TashikaPreferences)
