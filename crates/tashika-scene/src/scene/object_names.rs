//! Names of the objects and lights of a scene. An object of the file corresponds to one or several
//! instances.
//!
//! A name is stored once for all instances that are added consecutively. An object of many meshes,
//! or with a million placements, therefore costs the memory of one name.
//!
//! # Held to this by
//! The tests below; `object_names` of the suite, for the names that file readers pass on.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::{InstanceId, Scene, SceneBuilder};

/// Names, each with the index of its first instance or light, in rising order of the indices. An
/// empty name means that the instances or lights have no name.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectNames(Vec<(u32, String)>);

/// Number of unnamed objects of each kind.
#[derive(Debug, Default)]
pub(super) struct Numbered(BTreeMap<String, u32>);

impl ObjectNames {
    fn begin(&mut self, first: u32, name: String) {
        if let Some(last) = self.0.last_mut().filter(|last| last.0 == first) {
            last.1 = name;
        } else if self.0.last().map_or("", |last| &last.1) != name {
            self.0.push((first, name));
        }
    }

    fn of(&self, instance: u32) -> Option<&str> {
        let after = self.0.partition_point(|(first, _)| *first <= instance);
        let (_, name) = self.0.get(after.checked_sub(1)?)?;
        Some(name.as_str()).filter(|name| !name.is_empty())
    }
}

impl SceneBuilder {
    /// Sets the object name of all instances that are added until the next call. Objects with equal
    /// names are the same object. Instances that are added after a call with an empty name, or
    /// before the first call, have the names of their meshes.
    pub fn begin_object(&mut self, name: impl Into<String>) {
        let first = self.scene.instances.len() as u32;
        self.scene.object_names.begin(first, name.into());
    }

    /// Like [`Self::begin_object`], for an object without a name in its file. Its name is its kind
    /// and a number that no other object of this kind has, from 1.
    pub fn begin_unnamed_object(&mut self, kind: &str) {
        let number = self.numbered.0.entry(kind.to_owned()).or_default();
        *number += 1;
        let name = format!("{kind} {number}");
        self.begin_object(name);
    }

    /// Sets the name of all emitters without surface that are added until the next call; if it is
    /// empty, they are named by their number.
    pub fn begin_light(&mut self, name: impl Into<String>) {
        let first = self.scene.emitters.len() as u32;
        self.scene.light_names.begin(first, name.into());
    }
}

impl Scene {
    /// Name of the object that an instance belongs to: its name in the file, else that of its mesh.
    pub fn object_name(&self, instance: InstanceId) -> &str {
        let of_mesh = || match self.mesh_of(instance).name() {
            "" => "unnamed",
            name => name,
        };
        self.object_names.of(instance.0).unwrap_or_else(of_mesh)
    }

    /// Name of an emitter without surface, by its index in the scene: its name in the file, else
    /// `light` and its number, from 1.
    pub fn light_name(&self, emitter: usize) -> Cow<'_, str> {
        let named = self.light_names.of(emitter as u32).map(Cow::Borrowed);
        named.unwrap_or_else(|| format!("light {}", emitter + 1).into())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use crate::color::Rgb;
    use crate::error::Location;
    use crate::scene::{Material, MeshData, SceneBuilder, Surface};

    #[test]
    fn instances_are_called_as_their_object_or_their_mesh() {
        let mut b = SceneBuilder::new("s", Location::default());
        let surface = Surface::Lambert { reflectance: Rgb::BLACK.into() };
        let material = b.add_material(Material::new("m", surface)).unwrap();
        let mesh = |b: &mut SceneBuilder, name: &str| {
            let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
            let data =
                MeshData { name: name.into(), positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
            b.add_mesh(data, material).unwrap()
        };
        let (cup, bare) = (mesh(&mut b, "cup"), mesh(&mut b, ""));
        let place = |b: &mut SceneBuilder, mesh| b.add_instance(mesh, Affine3A::IDENTITY).unwrap().unwrap();
        let mut expected = vec![(place(&mut b, cup), "cup"), (place(&mut b, bare), "unnamed")];
        b.begin_object("nothing of it");
        b.begin_object("table");
        expected.extend([(place(&mut b, bare), "table"), (place(&mut b, cup), "table")]);
        for name in ["sphere 1", "sphere 2"] {
            b.begin_unnamed_object("sphere");
            expected.push((place(&mut b, bare), name));
        }
        b.begin_unnamed_object("cube");
        expected.push((place(&mut b, bare), "cube 1"));
        b.begin_object("");
        expected.push((place(&mut b, cup), "cup"));
        let scene = b.build().unwrap();
        for (instance, name) in expected {
            assert_eq!(scene.object_name(instance), name, "{instance:?}");
        }
    }
}
