"""What is asked of a render of a scene, and the options of the program that say it."""

import bpy

#: What may be claimed of a picture: identifier, name, description.
CLAIMS = (
    (
        "DRAFT",
        "Whole Picture, Draft",
        "A clean picture, audited: at least 95 % of its pixels are within 10 %, 99 % sure",
    ),
    ("GOOD", "Whole Picture, Good", "The same, within 5 %"),
    (
        "PIXELS",
        "Each Pixel",
        "Each pixel is worked on until it is within the tolerance, as sure as the confidence",
    ),
)


class TashikaSettings(bpy.types.PropertyGroup):
    claim: bpy.props.EnumProperty(
        name="Claim", description="What is to be known about the error", items=CLAIMS
    )
    tolerance: bpy.props.FloatProperty(
        name="Tolerance",
        description="Relative error that a pixel may have. Lower values take longer, by about the square",
        subtype="PERCENTAGE", default=5.0, min=0.1, max=100.0,
    )  # fmt: skip
    confidence: bpy.props.FloatProperty(
        name="Confidence",
        description="How often the interval about a pixel holds at least",
        subtype="PERCENTAGE", default=95.0, min=50.0, max=99.9,
    )  # fmt: skip
    time_limit: bpy.props.IntProperty(
        name="Time Limit",
        description="Seconds that a picture may take, with its audit; what is claimed then is what was reached. 0 is no limit",
        subtype="TIME_ABSOLUTE", default=0, min=0, soft_max=3600,
    )  # fmt: skip
    seed: bpy.props.IntProperty(
        name="Seed",
        description="Seed of all random numbers; the same seed gives the same picture",
        default=1,
        min=0,
    )

    def options(self):
        """The options of the program."""
        if self.claim == "PIXELS":
            # A property holds 32 bits: 0.1 would be asked for as 0.100000001.
            tolerance, confidence = round(self.tolerance, 4), round(self.confidence, 4)
            said = ["--error", f"{tolerance:g}%", "--confidence", f"{confidence:g}%"]
        else:
            said = ["--quality", self.claim.lower()]
            if self.time_limit:
                said += ["--time", f"{self.time_limit}s"]
        return [*said, "--seed", str(self.seed)]


def register():
    bpy.utils.register_class(TashikaSettings)
    bpy.types.Scene.tashika = bpy.props.PointerProperty(type=TashikaSettings)


def unregister():
    del bpy.types.Scene.tashika
    bpy.utils.unregister_class(TashikaSettings)
