"""Panels: what is asked of a render, what was said of it, and those of Blender that hold for this engine too."""

import textwrap

import bpy

from . import engine

ENGINE = engine.TashikaRenderEngine.bl_idname
#: Letters of a line of the statement.
WIDTH = 60
#: Panels that hold for all engines, but not for this one.
NOT_OURS = {"VIEWLAYER_PT_layer_passes", "VIEWLAYER_PT_filter", "DATA_PT_light"}
#: Panels of another engine that show what is carried over.
OF_OTHERS = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "NODE_DATA_PT_EEVEE_light",
}


class RenderPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class TASHIKA_PT_claim(RenderPanel, bpy.types.Panel):
    bl_label = "Claim"

    def draw(self, context):
        settings = context.scene.tashika
        column = self.layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        column.prop(settings, "claim")
        if settings.claim == "PIXELS":
            column.prop(settings, "tolerance")
            column.prop(settings, "confidence")
        else:
            column.prop(settings, "time_limit")
        column.prop(settings, "seed")


class TASHIKA_PT_result(RenderPanel, bpy.types.Panel):
    bl_label = "What Is Known of the Picture"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.name in engine.statements

    def draw(self, context):
        for line in textwrap.wrap(engine.statements[context.scene.name], WIDTH):
            self.layout.label(text=line)


class TASHIKA_PT_film(RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(context.scene.render, "film_transparent", text="Transparent")


_CLASSES = (TASHIKA_PT_claim, TASHIKA_PT_result, TASHIKA_PT_film)


def _of_blender():
    """Blender's own panels that hold for this engine."""
    for panel in bpy.types.Panel.__subclasses__():
        for_all = "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())
        if panel.__name__ in OF_OTHERS or (for_all and panel.__name__ not in NOT_OURS):
            yield panel


def register():
    for panel in _CLASSES:
        bpy.utils.register_class(panel)
    for panel in _of_blender():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in _of_blender():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for panel in reversed(_CLASSES):
        bpy.utils.unregister_class(panel)
