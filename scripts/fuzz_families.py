"""Families of growing files for `fuzz_program.py --scale`: a construct repeated, nested or doubled.

Each is (target, name, bytes for a size, sizes).
"""

import json
import struct

MANY = [1000, 8000, 30000]
DEEP = [50, 1000, 20000]
CHAIN = [10, 24, 60, 400]

QUAD = '"point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]'


def text(make):
    return lambda n: make(n).encode()


def scene(inside):
    return f'<scene version="3.0.0">{inside}</scene>'


def usda(inside):
    return "#usda 1.0\n" + inside


def usd_mesh(name, more=""):
    points = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]"
    return f'def Mesh "{name}" {{\n{points}\n{more}}}\n'


def gltf(**parts):
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    import base64

    uri = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    document.update(parts)
    return json.dumps(document)


def mtlx(inside):
    return f'<?xml version="1.0"?><materialx version="1.38">{inside}<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial></materialx>'


def chain_mtlx(n):
    nodes = '<standard_surface name="S" type="surfaceshader"><input name="base_color" type="color3" nodename="n0"/></standard_surface>'
    for i in range(n):
        nodes += f'<multiply name="n{i}" type="color3"><input name="in1" type="color3" nodename="n{i + 1}"/><input name="in2" type="color3" nodename="n{i + 1}"/></multiply>'
    return mtlx(nodes)


def gz(n):
    import gzip

    return gzip.compress(b"# " + b"x" * n + b"\nWorldBegin\n")


def ply(n, kind):
    head = f"ply\nformat ascii 1.0\nelement vertex {n if kind == 'points' else 3}\nproperty float x\nproperty float y\nproperty float z\n"
    points = "".join(f"{i % 7} {i % 11} {i % 13}\n" for i in range(n)) if kind == "points" else "0 0 0\n1 0 0\n0 1 0\n"
    if kind == "points":
        face = f"{n} " + " ".join(map(str, range(n))) + "\n"
        return (head + "element face 1\nproperty list int int vertex_indices\nend_header\n" + points + face).encode()
    if kind == "properties":
        properties = "".join(f"property float p{i}\n" for i in range(n))
        return (head + properties + "element face 0\nproperty list int int vertex_indices\nend_header\n").encode()
    if kind == "elements":
        elements = "".join(f"element e{i} 0\nproperty float p\n" for i in range(n))
        return (head + elements + "element face 1\nproperty list int int vertex_indices\nend_header\n" + points + "3 0 1 2\n").encode()
    return (head + f"element face {n}\nproperty list int int vertex_indices\nend_header\n" + points + "3 0 1 2\n" * n).encode()


def pbrt_textures(n, kind):
    lines = ['Texture "t0" "spectrum" "constant" "rgb value" [.5 .5 .5]']
    for i in range(1, n):
        lines.append(f'Texture "t{i}" "spectrum" "{kind}" "texture tex1" "t{i - 1}" "texture tex2" "t{i - 1}"')
    return "WorldBegin\n" + "\n".join(lines) + f'\nMaterial "diffuse" "texture reflectance" "t{n - 1}" Shape "trianglemesh" {QUAD}\n'


def pbrt_mixes(n):
    lines = ['MakeNamedMaterial "m0" "string type" "diffuse"', 'MakeNamedMaterial "m1" "string type" "diffuse"']
    for i in range(2, n):
        lines.append(f'MakeNamedMaterial "m{i}" "string type" "mix" "string materials" ["m{i - 1}" "m{i - 2}"]')
    return "WorldBegin\n" + "\n".join(lines) + f'\nNamedMaterial "m{n - 1}" Shape "trianglemesh" {QUAD}\n'


def mitsuba_refs(n):
    lines = ['<bsdf type="diffuse" id="b0"/>']
    for i in range(1, n):
        lines.append(f'<bsdf type="blendbsdf" id="b{i}"><float name="weight" value=".5"/><ref id="b{i - 1}"/><ref id="b{i - 1}"/></bsdf>')
    return scene("\n".join(lines) + f'<shape type="sphere"><ref id="b{n - 1}"/></shape>')


def mitsuba_groups(n):
    shapes = '<shape type="rectangle"/>' * n
    return scene(f'<shape type="shapegroup" id="g">{shapes}</shape>' + '<shape type="instance"><ref id="g"/></shape>' * n)


def pbrt_objects(n):
    shape = f'Shape "trianglemesh" {QUAD}\n'
    return 'WorldBegin\nObjectBegin "o"\n' + shape * n + "ObjectEnd\n" + 'ObjectInstance "o"\n' * (10 * n)


def gltf_product(n):
    primitives = [{"attributes": {"POSITION": 0}}] * n
    return gltf(meshes=[{"primitives": primitives}], nodes=[{"mesh": 0}] * (5 * n), scenes=[{"nodes": list(range(5 * n))}])


def usd_references(n):
    prims = usd_mesh("p0")
    for i in range(1, n):
        prims += f'def Xform "p{i}" {{\ndef "a" ( references = </p{i - 1}> ) {{}}\ndef "b" ( references = </p{i - 1}> ) {{}}\n}}\n'
    return usda(prims)


FAMILIES = [
    ("mitsuba", "namespaces", text(lambda n: '<scene version="3.0.0" ' + " ".join(f'xmlns:n{i}="u{i}"' for i in range(n)) + ">" + "".join(f'<n{i}:x xmlns:m{i}="v"/>' for i in range(n)) + "</scene>"), [1000, 6000, 20000]),
    ("mitsuba", "attributes", text(lambda n: scene("<shape " + " ".join(f'a{i}=""' for i in range(n)) + "/>")), [1000, 30000, 300000]),
    ("mitsuba", "defaults that double", text(lambda n: scene('<default name="a0" value="xx"/>' + "".join(f'<default name="a{i}" value="$a{i - 1}$a{i - 1}"/>' for i in range(1, n)))), CHAIN),
    ("mitsuba", "long default many times", text(lambda n: scene(f'<default name="a" value="{"x" * 10 * n}"/>' + '<shape type="$a"/>' * n)), MANY),
    ("mitsuba", "blends that double", text(mitsuba_refs), CHAIN),
    ("mitsuba", "groups x instances", text(mitsuba_groups), [100, 1000, 5000]),
    ("mitsuba", "ids", text(lambda n: scene("".join(f'<bsdf type="diffuse" id="i{i}"/>' for i in range(n)))), MANY),
    ("mitsuba", "shapes", text(lambda n: scene('<shape type="rectangle"/>' * n)), MANY),
    ("mitsuba", "deep elements", text(lambda n: scene('<shape type="sphere">' * n + "</shape>" * n)), DEEP),
    ("mitsuba", "parameters", text(lambda n: scene('<shape type="sphere">' + "".join(f'<float name="p{i}" value="1"/>' for i in range(n)) + "</shape>")), MANY),
    ("mitsuba", "unknown elements", text(lambda n: scene("".join(f"<u{i}/>" for i in range(n)))), MANY),
    ("mitsuba", "unknown plugins", text(lambda n: scene("".join(f'<bsdf type="u{i}"/>' for i in range(n)))), MANY),
    ("mitsuba", "transforms", text(lambda n: scene('<shape type="sphere"><transform name="to_world">' + '<scale value="1.1"/>' * n + "</transform></shape>")), MANY),
    ("mitsuba", "keys", text(lambda n: scene('<shape type="sphere"><animation name="to_world">' + "".join(f'<transform time="{i}"><translate x="{i}"/></transform>' for i in range(n)) + "</animation></shape>")), MANY),
    ("mitsuba", "one long line of a spectrum", text(lambda n: scene('<bsdf type="diffuse"><spectrum name="reflectance" value="' + ", ".join(f"{400 + i * 0.001}:0.5" for i in range(n)) + '"/></bsdf>')), MANY),
    ("mitsuba", "comments", text(lambda n: scene("<!-- x -->" * n)), MANY),
    ("mitsuba", "a comment without end", text(lambda n: scene("<!- <" * n)), MANY),
    ("mitsuba", "sensors", text(lambda n: scene("".join(f'<sensor type="perspective" id="c"><film type="hdrfilm"/></sensor>' for i in range(n)))), MANY),
    ("mtlx", "attributes", text(lambda n: mtlx("<a " + " ".join(f'a{i}=""' for i in range(n)) + "/>")), [1000, 30000, 300000]),
    ("mtlx", "nodes that double", text(chain_mtlx), CHAIN),
    ("mtlx", "long name", text(lambda n: mtlx("").replace('"M"', f'"{"M" * n}"').replace("/>", "/>" + '<input name="x" nodename="y"/>' * n)), MANY),
    ("mtlx", "nodes", text(lambda n: mtlx("".join(f'<constant name="n{i}" type="color3"><input name="value" value="1,1,1" type="color3"/></constant>' for i in range(n)))), MANY),
    ("mtlx", "materials", text(lambda n: mtlx("".join(f'<surfacematerial name="a{i}" type="material"><input name="surfaceshader" nodename="S"/></surfacematerial>' for i in range(n)))), MANY),
    ("mtlx", "deep graphs", text(lambda n: mtlx("".join(f'<nodegraph name="g{i}">' for i in range(n)) + "</nodegraph>" * n)), DEEP),
    ("pbrt", "textures that double", text(lambda n: pbrt_textures(n, "scale")), CHAIN),
    ("pbrt", "mix textures that double", text(lambda n: pbrt_textures(n, "mix")), CHAIN),
    ("pbrt", "mixes of mixes", text(pbrt_mixes), CHAIN),
    ("pbrt", "objects x instances", text(pbrt_objects), [100, 400, 2000]),
    ("pbrt", "attributes in each other", text(lambda n: "WorldBegin\n" + "AttributeBegin\n" * n + "AttributeEnd\n" * n), MANY),
    ("pbrt", "attributes and named things", text(lambda n: "WorldBegin\n" + "".join(f'AttributeBegin CoordinateSystem "c{i}"\nAttribute "shape" "float a{i}" 1\n' for i in range(n))), MANY),
    ("pbrt", "shapes", text(lambda n: "WorldBegin\n" + f'Shape "trianglemesh" {QUAD}\n' * n), MANY),
    ("pbrt", "parameters", text(lambda n: 'WorldBegin\nShape "sphere" ' + " ".join(f'"float p{i}" 1' for i in range(n))), MANY),
    ("pbrt", "media", text(lambda n: "WorldBegin\n" + "".join(f'MakeNamedMedium "m{i}" "string type" "homogeneous"\n' for i in range(n)) + 'Shape "sphere"'), MANY),
    ("pbrt", "materials", text(lambda n: "WorldBegin\n" + f'Material "diffuse"\nShape "trianglemesh" {QUAD}\n' * n), MANY),
    ("pbrt", "lights", text(lambda n: "WorldBegin\n" + 'LightSource "infinite"\nLightSource "point"\n' * n), MANY),
    ("pbrt", "polygon of a curve", text(lambda n: "WorldBegin\n" + 'Shape "curve" "point3 P" [0 0 0 1 0 0 2 1 0 3 0 0]\n' * n), MANY),
    ("pbrt", "unknown directives", text(lambda n: "WorldBegin\n" + "".join(f'Option "u{i}" 1\n' for i in range(n))), MANY),
    ("pbrt", "spheres", text(lambda n: "WorldBegin\n" + 'Shape "sphere" "float radius" 2\n' * n), [100, 1000, 5000]),
    ("pbrt", "motion", text(lambda n: "TransformTimes 0 1\nWorldBegin\n" + "AttributeBegin\nActiveTransform EndTime\nTranslate 1 0 0\nActiveTransform All\n" * n + 'Shape "sphere"'), MANY),
    ("pbrt", "includes itself", text(lambda n: "WorldBegin\n" + 'Include "scene.pbrt"\n' * n), MANY),
    ("pbrt", "subdivision", text(lambda n: 'WorldBegin\nShape "loopsubdiv" "integer levels" 10 "point3 P" [' + "0 0 0 1 0 0 0 1 0 " * n + '] "integer indices" [' + " ".join(str(i) for i in range(3 * n)) + "]"), [10, 1000, 8000]),
    ("obj", "a polygon", text(lambda n: "".join(f"v {i % 7} {i % 11} {i % 13}\n" for i in range(n)) + "f " + " ".join(str(i + 1) for i in range(n))), [1000, 8000, 30000]),
    ("obj", "polygons", text(lambda n: "".join(f"v {i % 7} {i % 11} {i % 13}\n" for i in range(1000)) + ("f " + " ".join(str(i + 1) for i in range(1000)) + "\n") * (n // 200)), MANY),
    ("obj", "groups", text(lambda n: "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"g a{i} b{i}\no c{i}\ns {i}\nf 1 2 3\n" for i in range(n))), MANY),
    ("obj", "materials that are not there", text(lambda n: "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"usemtl a{i}\nf 1 2 3\n" for i in range(n))), MANY),
    ("obj", "libraries", text(lambda n: "mtllib " + " ".join(f"a{i}.mtl" for i in range(n)) + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), MANY),
    ("obj", "unknown statements", text(lambda n: "".join(f"u{i} 1\n" for i in range(n))), MANY),
    ("obj", "continued lines", text(lambda n: "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 " + "\\\n" * n), MANY),
    ("obj", "smoothing", text(lambda n: "v 0 0 0\nv 1 0 0\nv 0 1 0\ns 1\n" + "f 1 2 3\n" * n), MANY),
    ("obj", "a fan about a vertex", text(lambda n: "v 0 0 0\n" + "".join(f"v 1 {i} 0\n" for i in range(n)) + "s 1\n" + "".join(f"f 1 {i + 2} {i + 3}\n" for i in range(n - 1))), MANY),
    ("mtl", "materials", text(lambda n: "".join(f"newmtl a{i}\nKd 1 1 1\n" for i in range(n))), MANY),
    ("mtl", "maps", text(lambda n: "".join(f"newmtl a{i}\nmap_Kd f{i}.png\n" for i in range(n)) + "newmtl a\nmap_Kd x.png\n"), MANY),
    ("mtl", "options", text(lambda n: "newmtl a\nmap_Kd " + "-s 1 1 1 " * n + "x.png"), MANY),
    ("ply", "a polygon", lambda n: ply(n, "points"), MANY),
    ("ply", "properties", lambda n: ply(n, "properties"), MANY),
    ("ply", "elements", lambda n: ply(n, "elements"), MANY),
    ("ply", "faces", lambda n: ply(n, "faces"), MANY),
    ("gltf", "nodes", text(lambda n: gltf(nodes=[{"mesh": 0}] * n, scenes=[{"nodes": list(range(n))}])), MANY),
    ("gltf", "nodes in each other", text(lambda n: gltf(nodes=[{"children": [i + 1]} for i in range(n)] + [{"mesh": 0}])), DEEP),
    ("gltf", "primitives x nodes", text(gltf_product), [100, 400, 2000]),
    ("gltf", "scenes", text(lambda n: gltf(scenes=[{"nodes": [0] * n}] * 10)), MANY),
    ("gltf", "accessors", text(lambda n: gltf(accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}] * n)), MANY),
    ("gltf", "sparse of a billion", text(lambda n: gltf(accessors=[{"componentType": 5126, "count": 10 ** min(9, n), "type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}}])), [3, 6, 9]),
    ("gltf", "materials", text(lambda n: gltf(materials=[{"pbrMetallicRoughness": {}}] * n)), MANY),
    ("gltf", "images", text(lambda n: gltf(images=[{"uri": f"f{i}.png"} for i in range(n)], textures=[{"source": i} for i in range(n)])), MANY),
    ("gltf", "animations", text(lambda n: gltf(animations=[{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}] * n, "samplers": [{"input": 0, "output": 0}]}])), MANY),
    ("gltf", "skins", text(lambda n: gltf(skins=[{"joints": [0] * n}] * 10, nodes=[{"mesh": 0, "skin": i % 10} for i in range(10)])), MANY),
    ("gltf", "morph targets", text(lambda n: gltf(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * n}]}])), MANY),
    ("gltf", "deep extras", text(lambda n: gltf(extras="X").replace('"X"', "[" * n + "]" * n)), DEEP),
    ("gltf", "extensions", text(lambda n: gltf(extensionsUsed=[f"E{i}" for i in range(n)])), MANY),
    ("usda", "prims", text(lambda n: usda("".join(f'def "p{i}" {{}}\n' for i in range(n)))), MANY),
    ("usda", "meshes", text(lambda n: usda("".join(usd_mesh(f"p{i}") for i in range(n)))), [1000, 6000]),
    ("usda", "prims in each other", text(lambda n: usda('def "p" {\n' * n + "}\n" * n)), DEEP),
    ("usda", "references that double", text(usd_references), [6, 12, 24, 60]),
    ("usda", "references", text(lambda n: usda(usd_mesh("a") + "".join(f'def "p{i}" ( references = </a> ) {{}}\n' for i in range(n)))), [1000, 6000]),
    ("usda", "properties", text(lambda n: usda('def Mesh "p" {\n' + "".join(f"float a{i} = 1\n" for i in range(n)) + "}")), MANY),
    ("usda", "deep lists", text(lambda n: usda('def "p" {\ncustom float x = ' + "[" * n + "]" * n + "\n}")), DEEP),
    ("usda", "deep dictionaries", text(lambda n: usda("(\ncustomLayerData = {\n" + "dictionary d = {\n" * n + "}\n" * n + "}\n)\n")), DEEP),
    ("usda", "variants", text(lambda n: usda('def "p" ( variants = { string v = "a" }\nprepend variantSets = "v" ) {\nvariantSet "v" = {\n' + "".join(f'"a{i}" {{}}\n' for i in range(n)) + "}\n}")), MANY),
    ("usda", "instancer", text(lambda n: usda('def PointInstancer "p" {\nrel prototypes = </p/a>\nint[] protoIndices = [' + ", ".join("0" for _ in range(n)) + "]\npoint3f[] positions = [" + ", ".join("(0, 0, 0)" for _ in range(n)) + "]\n" + usd_mesh("a") + "}")), MANY),
    ("usda", "a polygon", text(lambda n: usda(f'def Mesh "m" {{\nint[] faceVertexCounts = [{n}]\nint[] faceVertexIndices = [{", ".join(map(str, range(n)))}]\npoint3f[] points = [{", ".join(f"({i % 7}, {i % 11}, {i % 13})" for i in range(n))}]\n}}')), MANY),
    ("usda", "long name x children", text(lambda n: usda(f'def "{"a" * n}" {{\n' + "".join(f'def "b{i}" {{}}\n' for i in range(n // 4)) + "}")), MANY),
    ("usda", "subsets", text(lambda n: usda(usd_mesh("m", "".join(f'def GeomSubset "s{i}" {{ int[] indices = [0] }}\n' for i in range(n))))), MANY),
    ("light", "angles", text(lambda n: f"IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 {n} 1 1 1 0 0 0\n1 1 1\n" + " ".join(str(180 * i / n) for i in range(n)) + "\n0\n" + "1 " * n), MANY),
]
