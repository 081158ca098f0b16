//! Layers from the sections of a file.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::layer::{Layer, Metadata, PrimSpec, Property, Specifier, Stored};
use super::super::value::{Text, Value};
use super::bytes::Read;
use super::{Binary, Rep, Sections, values};

/// Types of specs.
const ATTRIBUTE: i64 = 1;
const PRIM: i64 = 6;
const PSEUDO_ROOT: i64 = 7;
const RELATIONSHIP: i64 = 8;
const VARIANT: i64 = 10;

/// Types of values that change with time.
const TIME_SAMPLES: u64 = 46;
const SPLINE: u64 = 59;

/// Builds the layer without the bytes of the file, which the caller adds.
pub(super) fn layer(binary: &Binary, sections: &Sections, name: &Path) -> Read<Layer> {
    let mut layer = Layer {
        name: name.to_owned(),
        prims: vec![PrimSpec::default()],
        metadata: Metadata::default(),
        binary: None,
    };
    let mut building = Building { binary, sections, by_path: BTreeMap::new(), orders: Vec::new() };
    building.by_path.insert("/".into(), 0);
    // Prims and variants are made first, so that properties can be attached to them by path.
    for &[path, set, kind] in &sections.specs {
        let path = binary.path(u32::try_from(path).unwrap_or(u32::MAX))?;
        match kind {
            PSEUDO_ROOT => building.root(&mut layer, set)?,
            PRIM | VARIANT => building.prim(&mut layer, &path, set)?,
            _ => {}
        }
    }
    building.link(&mut layer);
    for &[path, set, kind] in &sections.specs {
        if matches!(kind, ATTRIBUTE | RELATIONSHIP) {
            let path = binary.path(u32::try_from(path).unwrap_or(u32::MAX))?;
            building.property(&mut layer, &path, set)?;
        }
    }
    Ok(layer)
}

struct Building<'a> {
    binary: &'a Binary,
    sections: &'a Sections,
    by_path: BTreeMap<Text, u32>,
    /// Prims, each with the names of its children in the order of the file.
    orders: Vec<(u32, Vec<Text>)>,
}

impl Building<'_> {
    /// Returns the names and values of the fields of a set.
    fn fields(&self, set: i64) -> Read<Vec<(Text, Rep)>> {
        let start = usize::try_from(set).ok().filter(|&s| s <= self.sections.field_sets.len());
        let start = start.ok_or_else(|| format!("set {set} of fields"))?;
        let mut fields = Vec::new();
        for &index in &self.sections.field_sets[start..] {
            if index == i64::from(u32::MAX) {
                break;
            }
            let field = usize::try_from(index).ok().and_then(|i| self.sections.fields.get(i));
            let (name, rep) = *field.ok_or_else(|| format!("field {index}"))?;
            fields.push((self.binary.token(name)?, rep));
        }
        Ok(fields)
    }

    fn root(&mut self, layer: &mut Layer, set: i64) -> Read<()> {
        for (name, rep) in self.fields(set)? {
            match &*name {
                "primChildren" => self.order(0, rep)?,
                "subLayerOffsets" => {
                    let offsets = self.binary.value(rep)?;
                    let pairs = offsets.array::<2>().unwrap_or_default();
                    layer.metadata.has_offsets = pairs.iter().any(|pair| *pair != [0.0, 1.0]);
                }
                "layerRelocates" => layer.metadata.has_relocates = true,
                "defaultPrim" | "metersPerUnit" | "upAxis" | "timeCodesPerSecond" | "framesPerSecond"
                | "subLayers" => layer.metadata.set(&name, &self.binary.value(rep)?),
                _ => {}
            }
        }
        Ok(())
    }

    fn order(&mut self, prim: u32, rep: Rep) -> Read<()> {
        if let Some(names) = self.binary.value(rep)?.texts() {
            self.orders.push((prim, names.to_vec()));
        }
        Ok(())
    }

    fn prim(&mut self, layer: &mut Layer, path: &Text, set: i64) -> Read<()> {
        let mut prim = PrimSpec::default();
        let index = layer.prims.len() as u32;
        for (name, rep) in self.fields(set)? {
            match &*name {
                "primChildren" => self.order(index, rep)?,
                "specifier" => {
                    prim.specifier = match self.binary.value(rep)?.number() {
                        Some(0.0) => Specifier::Def,
                        Some(2.0) => Specifier::Class,
                        _ => Specifier::Over,
                    };
                }
                "typeName" | "active" | "instanceable" | "apiSchemas" | "references" | "payload"
                | "inheritPaths" | "specializes" | "variantSelection" | "inactiveIds" | "clips"
                | "clipSets" => {
                    prim.set(&name, &self.binary.value(rep)?);
                }
                _ => {}
            }
        }
        layer.push(prim);
        self.by_path.insert(path.clone(), index);
        Ok(())
    }

    /// Links prims to the prims above them, and variants to their sets.
    fn link(&mut self, layer: &mut Layer) {
        let ordered: BTreeMap<u32, BTreeMap<&str, usize>> = self
            .orders
            .iter()
            .map(|(prim, names)| (*prim, names.iter().enumerate().map(|(i, name)| (&**name, i)).collect()))
            .collect();
        for (path, &index) in &self.by_path {
            if let Some((owner, variant)) = path.strip_suffix('}').and_then(|p| p.rsplit_once('{')) {
                if let (Some(&owner), Some((set, name))) = (self.by_path.get(owner), variant.split_once('='))
                {
                    let sets = &mut layer.prims[owner as usize].variants;
                    sets.entry(set.into()).or_default().insert(name.into(), index);
                }
                continue;
            }
            let Some((owner, name)) = parent(path) else { continue };
            if let Some(&owner) = self.by_path.get(owner) {
                layer.prims[owner as usize].add_child(&name.into(), index);
            }
        }
        for (index, order) in ordered {
            let place = |name: &Text| order.get(&**name).copied().unwrap_or(usize::MAX);
            layer.prims[index as usize].children.sort_by_key(|(name, _)| place(name));
        }
    }

    fn property(&self, layer: &mut Layer, path: &Text, set: i64) -> Read<()> {
        let Some((owner, name)) = path.rsplit_once('.') else { return Ok(()) };
        let owner = if owner.is_empty() { "/" } else { owner };
        let Some(&owner) = self.by_path.get(owner) else { return Ok(()) };
        let mut property = Property::default();
        for (field, rep) in self.fields(set)? {
            let kind = rep.0 >> 48 & 0xff;
            match &*field {
                "default" => property.value = Some(Stored::In(rep)),
                "timeSamples" if kind == TIME_SAMPLES => {
                    let samples = values::samples(self.binary, rep)?;
                    property.is_held = samples.iter().any(|(_, rep)| values::is_whole(*rep));
                    property.samples =
                        samples.into_iter().map(|(time, rep)| (time, Stored::In(rep))).collect();
                }
                "custom" => property.is_custom = self.binary.value(rep)?.number() == Some(1.0),
                "spline" => property.has_spline = kind == SPLINE,
                "targetPaths" | "connectionPaths" => {
                    if let Value::Paths(paths) = self.binary.value(rep)? {
                        if &*field == "targetPaths" {
                            property.targets = paths;
                        } else {
                            property.connections = paths;
                        }
                    }
                }
                "interpolation" | "elementSize" | "colorSpace" | "bindMaterialAs" => {
                    property.set(&field, &self.binary.value(rep)?);
                }
                _ => {}
            }
        }
        layer.prims[owner as usize].properties.insert(name.into(), property);
        Ok(())
    }
}

/// Splits the path of a prim into the path of its parent and its name: `/A` and `B` of `/A/B`,
/// `/A{v=x}` and `B` of `/A{v=x}B`.
fn parent(path: &str) -> Option<(&str, &str)> {
    let start = path.rfind(['/', '}'])? + 1;
    let name = path.get(start..).filter(|name| !name.is_empty())?;
    let owner = match path.as_bytes()[start - 1] {
        b'/' if start == 1 => "/",
        b'/' => &path[..start - 1],
        _ => &path[..start],
    };
    Some((owner, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_from_the_prims_and_variants_above() {
        assert_eq!(parent("/A"), Some(("/", "A")));
        assert_eq!(parent("/A/B"), Some(("/A", "B")));
        assert_eq!(parent("/A{v=x}B"), Some(("/A{v=x}", "B")));
        assert_eq!(parent("/A{v=x}B/C"), Some(("/A{v=x}B", "C")));
        assert_eq!((parent("/"), parent("")), (None, None));
    }
}
