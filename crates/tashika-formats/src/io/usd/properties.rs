//! Fates of the properties that schemas define.
//!
//! There are three fates: a property is read; it is noted if its value differs from its fallback;
//! or it has no effect on pictures, for a reason that the table gives
//! ([`FEATURES`](super::FEATURES), kind `no effect`). Types of prims that are ignored as a whole
//! have one row in the table instead.
//!
//! Held to this by the tests below, over all properties of Pixar's own library
//! (`scripts/usd_schemas.py`).

/// Treatment of a property that a schema defines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate {
    Read,
    /// Name of the table's row that has the reason.
    NoEffect(&'static str),
    /// Kind and name of the table's row that has the text of the note, and the value that gives no
    /// note.
    Noted([&'static str; 2], Without),
}

/// Value of a property that gives no note.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Without {
    /// No value, or an empty list.
    Nothing,
    Number(f64),
    Word(&'static str),
}

use self::Fate::{NoEffect, Noted, Read};
use self::Without::{Nothing, Number, Word};

/// Fates by name; a name that ends in `*` is a prefix.
type Fates = &'static [(&'static str, Fate)];

/// Properties of prims of any type.
const ANY: Fates = &[
    ("visibility", Read),
    ("purpose", Read),
    ("renderVisibility", Read),
    ("guideVisibility", NoEffect("guideVisibility")),
    ("proxyVisibility", NoEffect("guideVisibility")),
    ("proxyPrim", NoEffect("proxyPrim")),
    ("extent", NoEffect("extent")),
    ("xformOpOrder", Read),
    ("xformOp:*", Read),
    ("primvars:displayColor", Read),
    ("primvars:displayOpacity", Read),
    ("material:binding:collection*", Noted(["material", "material:binding:collection"], Nothing)),
    ("material:binding", Read),
    ("material:binding:full", Read),
    ("material:binding:*", NoEffect("material:binding:preview")),
    ("velocities", NoEffect("velocities")),
    ("accelerations", NoEffect("velocities")),
    ("angularVelocities", NoEffect("velocities")),
    ("motion:*", NoEffect("motion:blurScale")),
    ("model:drawMode", Noted(["attribute", "model:drawMode"], Word("inherited"))),
    ("model:*", NoEffect("model:applyDrawMode")),
    ("colorSpace:name", Noted(["attribute", "colorSpace:name"], Word("lin_rec709_scene"))),
    ("colorSpaceDefinition:*", NoEffect("colorSpaceDefinition")),
    ("lod:*", Noted(["attribute", "lod:heuristics"], Nothing)),
    ("skel:*", NoEffect("skel:skeleton")),
    ("primvars:skel:*", NoEffect("skel:skeleton")),
    ("collection:lightLink*", Read),
    ("collection:shadowLink*", Read),
    ("collection:*", NoEffect("collection")),
    ("coordSys:*", NoEffect("coordSys")),
    ("lightList*", NoEffect("lightList")),
    ("hydra:*", NoEffect("hydra")),
    ("physics:*", NoEffect("physics")),
    ("drive:*", NoEffect("physics")),
    ("limit:*", NoEffect("physics")),
    ("semantics:*", NoEffect("accessibility")),
    ("accessibility:*", NoEffect("accessibility")),
    ("authorship:*", NoEffect("accessibility")),
    ("ui:*", NoEffect("accessibility")),
];

const MESH: Fates = &[
    ("points", Read),
    ("faceVertexCounts", Read),
    ("faceVertexIndices", Read),
    ("holeIndices", Read),
    ("normals", Read),
    ("orientation", Read),
    ("doubleSided", Read),
    ("subdivisionScheme", Read),
    ("cornerIndices", NoEffect("creaseIndices")),
    ("cornerSharpnesses", NoEffect("creaseIndices")),
    ("creaseIndices", NoEffect("creaseIndices")),
    ("creaseLengths", NoEffect("creaseIndices")),
    ("creaseSharpnesses", NoEffect("creaseIndices")),
    ("faceVaryingLinearInterpolation", NoEffect("creaseIndices")),
    ("interpolateBoundary", NoEffect("creaseIndices")),
    ("triangleSubdivisionRule", NoEffect("creaseIndices")),
    ("light:*", NoEffect("light:shaderId")),
    ("inputs:*", NoEffect("light:shaderId")),
];

const SHAPE: Fates = &[
    ("radius", Read),
    ("height", Read),
    ("size", Read),
    ("width", Read),
    ("length", Read),
    ("axis", Read),
    ("doubleSided", Read),
    ("orientation", Noted(["mesh", "orientation of a shape"], Word("rightHanded"))),
];

const CAMERA: Fates = &[
    ("focalLength", Read),
    ("horizontalAperture", Read),
    ("verticalAperture", Read),
    ("horizontalApertureOffset", Read),
    ("verticalApertureOffset", Read),
    ("fStop", Read),
    ("focusDistance", Read),
    ("projection", Read),
    ("clippingRange", NoEffect("clippingRange")),
    ("stereoRole", NoEffect("stereoRole")),
    ("clippingPlanes", Noted(["camera", "clippingPlanes"], Nothing)),
    ("exposure", Noted(["camera", "exposure"], Number(0.0))),
    ("exposure:fStop", Noted(["camera", "exposure"], Number(1.0))),
    ("exposure:iso", Noted(["camera", "exposure"], Number(100.0))),
    ("exposure:responsivity", Noted(["camera", "exposure"], Number(1.0))),
    ("exposure:time", Noted(["camera", "exposure"], Number(1.0))),
    ("shutter:open", Noted(["camera", "shutter:open"], Number(0.0))),
    ("shutter:close", Noted(["camera", "shutter:open"], Number(0.0))),
    ("backPlate:*", Noted(["camera", "backPlate"], Nothing)),
];

/// Properties of lights, without the prefix `inputs:`, which older files lack.
const LIGHT: Fates = &[
    ("intensity", Read),
    ("exposure", Read),
    ("color", Read),
    ("enableColorTemperature", Read),
    ("colorTemperature", Read),
    ("normalize", Read),
    ("diffuse", Read),
    ("specular", Read),
    ("radius", Read),
    ("width", Read),
    ("height", Read),
    ("length", Read),
    ("angle", Read),
    ("texture:file", Read),
    ("texture:format", Read),
    ("shaping:cone:angle", Read),
    ("shaping:cone:softness", Read),
    ("shaping:focus", Read),
    ("shaping:focusTint", NoEffect("shaping:focusTint")),
    ("shaping:ies:file", Read),
    ("shaping:ies:angleScale", Noted(["light", "inputs:shaping:ies:angleScale"], Number(0.0))),
    ("shaping:ies:normalize", Noted(["light", "inputs:shaping:ies:normalize"], Number(0.0))),
    ("shadow:enable", Noted(["light", "inputs:shadow"], Number(1.0))),
    ("shadow:distance", Noted(["light", "inputs:shadow"], Number(-1.0))),
    ("shadow:falloff", Noted(["light", "inputs:shadow"], Number(-1.0))),
    ("shadow:falloffGamma", NoEffect("shadow:falloffGamma")),
    ("shadow:color", Read),
    ("treatAsPoint", Read),
    ("treatAsLine", Noted(["light", "treatAsLine"], Number(0.0))),
    ("poleAxis", Read),
    ("guideRadius", NoEffect("guideRadius")),
    ("portals", NoEffect("portals")),
    ("light:filters", Read),
    ("light:*", NoEffect("light:shaderId")),
];

const INSTANCER: Fates = &[
    ("prototypes", Read),
    ("protoIndices", Read),
    ("positions", Read),
    ("orientations", Read),
    ("orientationsf", Read),
    ("scales", Read),
    ("ids", Read),
    ("invisibleIds", Read),
];

const SUBSET: Fates = &[("elementType", Read), ("familyName", Read), ("indices", Read)];

/// Returns the fates of a type of prim; none if its properties are not checked.
fn fates(type_name: &str) -> Option<Fates> {
    Some(match type_name {
        "" | "Xform" | "Scope" => &[],
        "Mesh" => MESH,
        "Cube" | "Sphere" | "Cylinder" | "Cone" | "Plane" => SHAPE,
        "Camera" => CAMERA,
        "DistantLight" | "SphereLight" | "RectLight" | "DiskLight" | "CylinderLight" | "DomeLight"
        | "DomeLight_1" => LIGHT,
        "PointInstancer" => INSTANCER,
        "GeomSubset" => SUBSET,
        _ => return None,
    })
}

/// Returns the fate of a property, if a schema has it. The outer option is none if properties of
/// this type of prim are not checked.
pub(super) fn fate(type_name: &str, property: &str) -> Option<Option<Fate>> {
    let own = fates(type_name)?;
    let is_light = type_name.ends_with("Light") || type_name == "DomeLight_1";
    let name = property.strip_prefix("inputs:").filter(|_| is_light).unwrap_or(property);
    let is_of = |pattern: &str| match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    };
    Some(own.iter().chain(ANY).find(|(pattern, _)| is_of(pattern)).map(|(_, fate)| *fate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::features::{Feature, Support};
    use crate::io::usd::FEATURES;

    /// Returns schema, property and fallback of each line of the list.
    fn list() -> impl Iterator<Item = [&'static str; 3]> {
        let lines = include_str!("schemas.txt").lines();
        lines.map(|line| {
            let mut fields = line.split('\t');
            std::array::from_fn(|_| fields.next().unwrap_or_default())
        })
    }

    /// Returns a type of prim whose table includes the properties of a schema.
    fn looked_at_with(schema: &str) -> Option<&str> {
        Some(match schema {
            "LightAPI" | "ShapingAPI" | "ShadowAPI" => "SphereLight",
            "BackPlateAPI" => "Camera",
            "MeshLightAPI" => "Mesh",
            schema if fates(schema).is_some() => schema,
            _ => return None,
        })
    }

    /// Returns true for schemas that have a row of the table as a whole, or that another module
    /// reads.
    fn is_told_elsewhere(schema: &str) -> bool {
        let row = |kind| Feature::find(FEATURES, kind, schema);
        let is_left_out = ["prim", "light"]
            .into_iter()
            .filter_map(row)
            .any(|r| r.support != Support::Full || r.how.starts_with("no effect"));
        // Schemas that `materials` and `network` read, and a schema of another renderer.
        let is_read = ["Material", "Shader", "NodeGraph", "NodeDefAPI", "RiMaterialAPI"];
        is_left_out || is_read.contains(&schema)
    }

    #[test]
    fn each_property_of_each_schema_is_read_or_noted_or_told_to_have_no_effect() {
        let mut unknown = Vec::new();
        for [schema, property, fallback] in list() {
            if is_told_elsewhere(schema) && looked_at_with(schema).is_none() {
                continue;
            }
            if property.is_empty() {
                // A type of prim needs a row; an applied schema is checked with every type of prim.
                let is_type = !schema.ends_with("API");
                if is_type && looked_at_with(schema).is_none() {
                    unknown.push(schema.to_owned());
                }
                continue;
            }
            if schema == "VolumeLightAPI"
                || schema.starts_with("ParticleField")
                || schema.starts_with("Hydra")
            {
                continue;
            }
            match fate(looked_at_with(schema).unwrap_or("Xform"), property).flatten() {
                None => unknown.push(format!("{schema}.{property}")),
                Some(NoEffect(row)) => {
                    assert!(Feature::find(FEATURES, "no effect", row).is_some(), "no row of {row}");
                }
                Some(Noted([kind, row], without)) => {
                    let row = Feature::find(FEATURES, kind, row).unwrap_or_else(|| panic!("no row of {row}"));
                    assert!(row.support != Support::Full, "{row:?} gives no note");
                    let usual = match without {
                        Nothing => continue,
                        Number(number) => fallback.parse() == Ok(number),
                        Word(word) => fallback == format!("{word:?}") || fallback.is_empty(),
                    };
                    assert!(usual, "{schema}.{property}: {fallback} {without:?}");
                }
                Some(Read) => {}
            }
        }
        assert!(unknown.is_empty(), "{unknown:#?}");
        assert!(list().count() > 1000, "the list is there");
    }

    #[test]
    fn what_is_said_to_be_read_is_named_where_it_is_read() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/io/usd");
        let mut sources = String::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("properties.rs") {
                sources += &std::fs::read_to_string(path).unwrap();
            }
        }
        for own in [ANY, MESH, SHAPE, CAMERA, LIGHT, INSTANCER, SUBSET] {
            for (name, fate) in own.iter().filter(|(name, fate)| *fate == Read && !name.ends_with('*')) {
                let name = name.trim_start_matches("primvars:");
                let is_named = ["", "inputs:"].iter().any(|p| sources.contains(&format!("\"{p}{name}")));
                assert!(is_named, "{name}: {fate:?}");
            }
        }
    }

    #[test]
    fn nothing_is_known_of_properties_that_no_schema_has() {
        assert_eq!(fate("Mesh", "holeIndexes"), Some(None));
        assert_eq!(fate("SphereLight", "inputs:radius"), Some(Some(Read)));
        assert_eq!(fate("Strange", "points"), None);
    }
}
