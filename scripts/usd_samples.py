"""Small USD files in all encodings, written by Pixar's own library, and its reading of them.

    pip install usd-core
    python3 scripts/usd_samples.py crates/tashika/tests/suite/usd

The suite's `usd` reads the files and compares with `composed.json`: points of meshes in the world,
materials that are bound, and lights, as `pxr` computes them.
"""

import json
import math
import random
import struct
import sys
import zlib
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdUtils, Vt


def png(path, texels):
    """An image of 8 bits a channel, rows from the top."""
    rows = b"".join(b"\0" + bytes(v for texel in row for v in texel) for row in texels)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(texels[0]), len(texels), 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def preview(stage, path, **inputs):
    """A material with one UsdPreviewSurface."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path + "/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for name, value in inputs.items():
        kind = Sdf.ValueTypeNames.Color3f if isinstance(value, tuple) else Sdf.ValueTypeNames.Float
        shader.CreateInput(name, kind).Set(value)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material, shader


def textured(stage, path, file):
    """The material of `preview`, with a texture for its colour."""
    material, shader = preview(stage, path, roughness=0.5)
    reader = UsdShade.Shader.Define(stage, path + "/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    texture = UsdShade.Shader.Define(stage, path + "/Texture")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
    texture.CreateInput("wrapS", Sdf.ValueTypeNames.Token).Set("repeat")
    texture.CreateInput("wrapT", Sdf.ValueTypeNames.Token).Set("repeat")
    texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    return material


def bind(prim, material, strong=False):
    UsdShade.MaterialBindingAPI.Apply(prim)
    strength = UsdShade.Tokens.strongerThanDescendants if strong else UsdShade.Tokens.fallbackStrength
    UsdShade.MaterialBindingAPI(prim).Bind(material, strength)


def quad(stage, path, corners, uvs=None):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(corners)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    if uvs:
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
        primvar.Set(uvs)
    return mesh


def simple(folder):
    """The scene that the suite has as glTF, too: a textured quad, a wall, a point light and a
    camera."""
    png(folder / "chess.png", [[(255, 128, 0), (0, 64, 255)], [(32, 200, 32), (250, 250, 250)]])
    stage = Usd.Stage.CreateNew(str(folder / "simple.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    world = UsdGeom.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(world.GetPrim())
    floor = quad(
        stage,
        "/World/Floor",
        [(-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)],
        [(0, 0), (1, 0), (1, 1), (0, 1)],
    )
    bind(floor.GetPrim(), textured(stage, "/World/Looks/Chess", "./chess.png"))
    wall = quad(stage, "/World/Wall", [(-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)])
    bind(wall.GetPrim(), preview(stage, "/World/Looks/Metal", diffuseColor=(0.9, 0.6, 0.3), metallic=1.0, roughness=0.5)[0])
    light = UsdLux.SphereLight.Define(stage, "/World/Lamp")
    light.CreateTreatAsPointAttr(True)
    light.CreateNormalizeAttr(True)
    light.CreateIntensityAttr(40.0)
    light.AddTranslateOp().Set((0.5, 2.5, 0.5))
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set((0, 1.2, 5))
    camera.CreateVerticalApertureAttr(24.0)
    camera.CreateHorizontalApertureAttr(32.0)
    camera.CreateFocalLengthAttr(30.0)
    stage.Save()
    stage.GetRootLayer().Export(str(folder / "simple.usdc"))
    UsdUtils.CreateNewUsdzPackage(str(folder / "simple.usda"), str(folder / "simple.usdz"))
    # With the binary encoding inside.
    UsdUtils.CreateNewUsdzPackage(str(folder / "simple.usdc"), str(folder / "packed.usdz"))


def values(folder):
    """Every type of value that the loader reads, small and large, in both encodings."""
    stage = Usd.Stage.CreateNew(str(folder / "values.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = stage.DefinePrim("/Values", "Scope")
    random.seed(1)
    T = Sdf.ValueTypeNames
    whole = [random.randrange(-300000, 300000) for _ in range(50)]
    few = [random.choice([0.25, -1.5, 3.0, 7.125]) for _ in range(200)]
    for name, kind, value in [
        ("bool", T.Bool, True),
        ("int", T.Int, -7),
        ("uint", T.UInt, 4000000000),
        ("int64", T.Int64, 1 << 40),
        ("half", T.Half, 0.333251953125),
        ("float", T.Float, 0.1),
        ("double", T.Double, 0.1),
        ("doubleSmall", T.Double, 0.5),
        ("token", T.Token, "word"),
        ("string", T.String, 'a "text"\nof two lines'),
        ("asset", T.Asset, "file.png"),
        ("vec2f", T.Float2, (1, -2)),
        ("vec2h", T.Half2, Gf.Vec2h(0.5, -2)),
        ("vec3f", T.Float3, (1, -2, 3)),
        ("vec3fLong", T.Float3, (0.1, -2, 3)),
        ("vec3d", T.Double3, (0.1, -2, 3)),
        ("vec4i", T.Int4, Gf.Vec4i(1, -2, 3, 400)),
        ("quatf", T.Quatf, Gf.Quatf(0.5, 0.1, 0.2, 0.3)),
        ("quath", T.Quath, Gf.Quath(1, 0, 0, 0)),
        ("matrixSmall", T.Matrix4d, Gf.Matrix4d(2)),
        ("matrix", T.Matrix4d, Gf.Matrix4d(*[i + 0.5 for i in range(16)])),
        ("ints", T.IntArray, Vt.IntArray(whole)),
        ("intsFew", T.IntArray, Vt.IntArray(whole[:5])),
        ("int64s", T.Int64Array, Vt.Int64Array([v << 20 for v in whole])),
        ("uints", T.UIntArray, Vt.UIntArray([4000000000 - i for i in range(20)])),
        ("floatsWhole", T.FloatArray, Vt.FloatArray([float(v) for v in whole])),
        ("floatsFew", T.FloatArray, Vt.FloatArray(few)),
        ("floatsAny", T.FloatArray, Vt.FloatArray([math.sin(i) for i in range(20)])),
        ("doublesWhole", T.DoubleArray, Vt.DoubleArray([float(v) for v in whole])),
        ("vec3fs", T.Float3Array, Vt.Vec3fArray([(i, i * 0.5, -i) for i in range(20)])),
        ("vec2ds", T.Double2Array, Vt.Vec2dArray([(i * 0.1, -i) for i in range(20)])),
        ("quaths", T.QuathArray, Vt.QuathArray([Gf.Quath(0.5, 0.25, 0.125, 1), Gf.Quath(1, 0, 0, 0)])),
        ("tokens", T.TokenArray, ["a", "b", "a"]),
        ("strings", T.StringArray, ["one", "", "two"]),
        ("empty", T.Float3Array, Vt.Vec3fArray()),
    ]:
        prim.CreateAttribute(name, kind).Set(value)
    moving = prim.CreateAttribute("moving", T.Float3)
    for time in (1.0, 2.5, 10.0):
        moving.Set((time, 0.5 * time, -1), time)
    prim.SetCustomDataByKey("nested:deep", {"a": 1, "b": "two"})
    stage.Save()
    stage.GetRootLayer().Export(str(folder / "values.usdc"))


def asset(folder, name):
    """A prim with variants, a payload, a class and instances below it."""
    stage = Usd.Stage.CreateNew(str(folder / name))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    shared = stage.CreateClassPrim("/_class_Chair")
    UsdGeom.Xform(shared).AddScaleOp().Set((1, 1, 1.5))
    root = UsdGeom.Xform.Define(stage, "/Chair")
    stage.SetDefaultPrim(root.GetPrim())
    root.GetPrim().GetInherits().AddInherit("/_class_Chair")
    red, _ = preview(stage, "/Chair/Looks/Red", diffuseColor=(0.8, 0.1, 0.1), roughness=0.3)
    blue, _ = preview(stage, "/Chair/Looks/Blue", diffuseColor=(0.1, 0.1, 0.8), roughness=0.7)
    seat = quad(stage, "/Chair/Seat", [(-10, -10, 20), (10, -10, 20), (10, 10, 20), (-10, 10, 20)])
    back = quad(stage, "/Chair/Back", [(-10, 10, 20), (10, 10, 20), (10, 10, 50), (-10, 10, 50)])
    back.AddRotateXOp().Set(10)
    bind(root.GetPrim(), red)
    sets = root.GetPrim().GetVariantSets()
    shading = sets.AddVariantSet("shading")
    for name, material in (("red", red), ("blue", blue)):
        shading.AddVariant(name)
        shading.SetVariantSelection(name)
        with shading.GetVariantEditContext():
            bind(seat.GetPrim(), material)
    shape = sets.AddVariantSet("shape")
    for name, height in (("low", 20.0), ("high", 35.0)):
        shape.AddVariant(name)
        shape.SetVariantSelection(name)
        with shape.GetVariantEditContext():
            leg = quad(stage, "/Chair/Leg", [(-1, 0, 0), (1, 0, 0), (1, 0, height), (-1, 0, height)])
            leg.AddTranslateOp().Set((0, 0, -1))
    shape.SetVariantSelection("low")
    shading.SetVariantSelection("red")
    stage.Save()


def composed(folder):
    (folder / "parts").mkdir(exist_ok=True)
    asset(folder / "parts", "chair.usdc")
    weak = Usd.Stage.CreateNew(str(folder / "lights.usda"))
    lamp = UsdLux.RectLight.Define(weak, "/World/Lamp")
    lamp.CreateIntensityAttr(3.0)
    lamp.CreateExposureAttr(1.0)
    lamp.CreateWidthAttr(50)
    lamp.CreateHeightAttr(20)
    lamp.AddTranslateOp().Set((0, 0, 200))
    sun = UsdLux.DistantLight.Define(weak, "/World/Sun")
    sun.CreateIntensityAttr(2.0)
    sun.CreateAngleAttr(0.0)
    sun.AddRotateXYZOp().Set((30, 20, 10))
    weak.Save()
    stage = Usd.Stage.CreateNew(str(folder / "composed.usda"))
    stage.GetRootLayer().subLayerPaths.append("./lights.usda")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.Xform.Define(stage, "/World")
    # A stronger opinion about a light of the sublayer.
    stage.OverridePrim("/World/Lamp").CreateAttribute("inputs:color", Sdf.ValueTypeNames.Color3f).Set((1, 0.5, 0.25))
    for i, (shading, shape) in enumerate((("red", "low"), ("blue", "high"), (None, "high"))):
        chair = UsdGeom.Xform.Define(stage, f"/World/Chair_{i}")
        (chair.GetPrim().GetPayloads().AddPayload if i == 1 else chair.GetPrim().GetReferences().AddReference)(
            "./parts/chair.usdc"
        )
        chair.AddTranslateOp().Set((100 * i, 10, 0))
        chair.AddRotateZOp().Set(30 * i)
        if shading:
            chair.GetPrim().GetVariantSet("shading").SetVariantSelection(shading)
        chair.GetPrim().GetVariantSet("shape").SetVariantSelection(shape)
    # Opinions over the referenced prims.
    over = stage.OverridePrim("/World/Chair_2/Back")
    UsdGeom.Mesh(over).CreatePointsAttr([(-10, 10, 20), (10, 10, 20), (10, 10, 90), (-10, 10, 90)])
    green, _ = preview(stage, "/World/Green", diffuseColor=(0.1, 0.8, 0.1), roughness=0.4)
    bind(stage.GetPrimAtPath("/World/Chair_2"), green, strong=True)
    # An instance, and a reference inside the file with an inverse pivot.
    for i in range(2):
        twin = stage.DefinePrim(f"/World/Twin_{i}")
        twin.GetReferences().AddReference("./parts/chair.usdc", "/Chair")
        twin.SetInstanceable(True)
        UsdGeom.Xformable(twin).AddTranslateOp().Set((0, 100 + 50 * i, 0))
    copy = UsdGeom.Xform.Define(stage, "/World/Copy")
    copy.GetPrim().GetReferences().AddInternalReference("/World/Chair_1")
    copy.ClearXformOpOrder()
    copy.AddTranslateOp(opSuffix="move").Set((-100, 0, 0))
    copy.AddTranslateOp(opSuffix="pivot").Set((5, 6, 7))
    copy.AddRotateYXZOp().Set((10, 20, 30))
    copy.AddOrientOp().Set(Gf.Quatf(0.8, 0.1, 0.3, 0.2).GetNormalized())
    copy.AddScaleOp().Set((1, 2, 0.5))
    copy.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    nested(stage)
    points = UsdGeom.PointInstancer.Define(stage, "/World/Points")
    proto = quad(stage, "/World/Points/Quad", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    proto.AddTranslateOp().Set((0, 0, 2))
    points.CreatePrototypesRel().SetTargets([proto.GetPath()])
    points.CreateProtoIndicesAttr([0, 0, 0])
    points.CreatePositionsAttr([(0, 0, 0), (10, 0, 0), (0, 10, 5)])
    points.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0), Gf.Quath(0.5, 0.5, 0.5, 0.5), Gf.Quath(1, 0, 0, 0)])
    points.CreateScalesAttr([(1, 1, 1), (2, 2, 2), (1, 3, 1)])
    reset = UsdGeom.Xform.Define(stage, "/World/Copy/Reset")
    reset.SetResetXformStack(True)
    reset.AddTransformOp().Set(Gf.Matrix4d().SetRotate(Gf.Rotation((1, 2, 3), 40)) * Gf.Matrix4d().SetTranslate((1, 2, 3)))
    quad(stage, "/World/Copy/Reset/Quad", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    hidden = quad(stage, "/World/Hidden", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    hidden.CreateVisibilityAttr("invisible")
    guide = quad(stage, "/World/Guide", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    guide.CreatePurposeAttr("guide")
    stage.Save()
    (folder / "composed.json").write_text(json.dumps(expected(stage), indent=1) + "\n")


def nested(stage):
    """References to prims below others, variants in variants with references, and ignored
    opinions."""
    # A reference to a prim below another: opinions by way of the one above hold, a variant among
    # them.
    part = stage.DefinePrim("/World/Part")
    part.GetReferences().AddReference("./parts/chair.usdc", "/Chair/Leg")
    UsdGeom.Xformable(part).AddTranslateOp(opSuffix="more").Set((0, -50, 0))
    # An instance's own opinions about prims below it are ignored, those about itself are not.
    lone = stage.DefinePrim("/World/Lone")
    lone.GetReferences().AddReference("./parts/chair.usdc")
    UsdGeom.Xformable(lone).AddTranslateOp().Set((0, 0, 70))
    UsdGeom.Mesh(stage.OverridePrim("/World/Lone/Seat")).CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    lone.SetInstanceable(True)
    # A class in the same file, stronger than a reference and weaker than local opinions.
    tall = stage.CreateClassPrim("/_class_Tall")
    UsdGeom.Xform(tall).AddScaleOp().Set((1, 1, 2))
    UsdGeom.Mesh(stage.OverridePrim("/_class_Tall/Seat")).CreatePointsAttr([(0, 0, 1), (9, 0, 1), (9, 9, 1), (0, 9, 1)])
    outer = UsdGeom.Xform.Define(stage, "/World/Outer")
    outer.GetPrim().GetInherits().AddInherit("/_class_Tall")
    first = outer.GetPrim().GetVariantSets().AddVariantSet("first")
    for name in ("none", "some"):
        first.AddVariant(name)
    first.SetVariantSelection("some")
    with first.GetVariantEditContext():
        second = outer.GetPrim().GetVariantSets().AddVariantSet("second")
        for name in ("a", "b"):
            second.AddVariant(name)
        second.SetVariantSelection("b")
        with second.GetVariantEditContext():
            outer.GetPrim().GetReferences().AddReference("./parts/chair.usdc")
            outer.GetPrim().GetVariantSet("shape").SetVariantSelection("high")
    # A copy of a copy, through two prims.
    chain = UsdGeom.Xform.Define(stage, "/World/Chain")
    chain.GetPrim().GetReferences().AddInternalReference("/World/Outer")
    UsdGeom.Xform(stage.OverridePrim("/World/Chain/Back")).AddTranslateOp(opSuffix="late").Set((0, 0, 3))


def expected(stage):
    """Pixar's reading of a stage, in metres with +y up."""
    unit = UsdGeom.GetStageMetersPerUnit(stage)

    def upright(p):
        x, y, z = (c * unit for c in p)
        return [round(c, 9) for c in ((x, z, -y) if UsdGeom.GetStageUpAxis(stage) == "Z" else (x, y, z))]

    cache = UsdGeom.XformCache()
    meshes, lights = [], []
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        image = UsdGeom.Imageable(prim)
        if prim.IsA(UsdGeom.PointInstancer):
            points = UsdGeom.PointInstancer(prim)
            matrices = points.ComputeInstanceTransformsAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default())
            proto = stage.GetPrimAtPath(points.GetPrototypesRel().GetTargets()[0])
            for matrix in matrices:
                to_world = matrix * cache.GetLocalToWorldTransform(prim)
                corners = UsdGeom.Mesh(proto).GetPointsAttr().Get()
                meshes.append(
                    {"path": str(prim.GetPath()), "points": [upright(to_world.Transform(Gf.Vec3d(p))) for p in corners]}
                )
        if prim.IsA(UsdGeom.Mesh) and "/Points/" not in str(prim.GetPath()):
            if image.ComputeVisibility() == "invisible" or image.ComputePurpose() not in ("default", "render"):
                continue
            to_world = cache.GetLocalToWorldTransform(prim)
            corners = UsdGeom.Mesh(prim).GetPointsAttr().Get()
            mesh = {"path": str(prim.GetPath()), "points": [upright(to_world.Transform(Gf.Vec3d(p))) for p in corners]}
            material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
            if material:
                surface = material.ComputeSurfaceSource()[0]
                mesh["color"] = list(surface.GetInput("diffuseColor").Get())
                mesh["roughness"] = surface.GetInput("roughness").Get()
            meshes.append(mesh)
        if prim.HasAPI(UsdLux.LightAPI):
            light = UsdLux.LightAPI(prim)
            strength = light.GetIntensityAttr().Get() * 2 ** light.GetExposureAttr().Get()
            to_world = cache.GetLocalToWorldTransform(prim)
            axis = to_world.TransformDir(Gf.Vec3d(0, 0, -1)).GetNormalized() / unit
            lights.append({
                "path": str(prim.GetPath()),
                "radiance": [c * strength for c in light.GetColorAttr().Get()],
                "axis": upright(axis),
                "position": upright(to_world.ExtractTranslation()),
            })  # fmt: skip
    return {"meshes": meshes, "lights": lights}


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    for old in [*folder.rglob("*.usd?"), *folder.glob("*.json")]:
        old.unlink()
    simple(folder)
    values(folder)
    composed(folder)


if __name__ == "__main__":
    main()
