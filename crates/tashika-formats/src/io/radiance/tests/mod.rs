//! Tests of the reader, by small files.

mod geometry;
mod lighting;
mod rows;
mod syntax;

use std::fs;
use std::path::Path;

use super::definitions::{Definition, Definitions};
use super::transforms::Similarity;
use super::words::{self, Statement};
use crate::error::{Location, Result};
use crate::io::{LoadOptions, load_scene};
use crate::math::Vec3;
use crate::scene::{InstanceId, NoteKind, Scene};

/// A grey wall, for scenes whose surfaces need a material.
pub(super) const GREY: &str = "void plastic grey 0 0 5 .5 .5 .5 0 0\n";

/// The definition that a text consists of.
pub(super) fn definition(text: &str) -> Definition {
    let statements = words::parse(text, Path::new("a.rad")).unwrap();
    let [Statement::Primitive(primitive)] = &statements[..] else { panic!("{statements:?}") };
    let mut definitions = Definitions::default();
    let at = Location::line("a.rad", primitive.line);
    definitions.define(primitive, &Similarity::IDENTITY, &at).unwrap();
    definitions.last().clone()
}

/// Loads `scene.rad` from a folder with these files.
fn load(files: &[(&str, &str)]) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    load_scene(&folder.path().join("scene.rad"), &LoadOptions::default())
}

/// The scene of a text.
fn scene(text: &str) -> Scene {
    load(&[("scene.rad", text)]).unwrap()
}

/// The scene of a text after the grey material.
fn grey_scene(text: &str) -> Scene {
    scene(&format!("{GREY}{text}"))
}

/// Message of the error of a scene.
fn error(files: &[(&str, &str)]) -> String {
    load(files).unwrap_err().to_string()
}

/// Notes that are no defaults.
fn notes(scene: &Scene) -> Vec<(NoteKind, String)> {
    let notes = scene.notes().iter().filter(|note| note.kind != NoteKind::Defaulted);
    notes.map(|note| (note.kind, note.message)).collect()
}

/// Centre, unit normal and area (m, m²) of every triangle of an object.
fn triangles(scene: &Scene, name: &str) -> Vec<(Vec3, Vec3, f32)> {
    let mut all = Vec::new();
    let ids: Vec<InstanceId> = scene.instance_ids().filter(|id| scene.object_name(*id) == name).collect();
    assert!(!ids.is_empty(), "no object {name}");
    for id in ids {
        for t in 0..scene.mesh_of(id).triangles().len() as u32 {
            let [a, b, c] = scene.world_corners(id, t);
            let point = scene.surface_point(id, t, [1.0 / 3.0; 3]);
            all.push((point.position, point.geometric_normal, 0.5 * (b - a).cross(c - a).length()));
        }
    }
    all
}

/// Area of an object (m²).
fn area(scene: &Scene, name: &str) -> f32 {
    triangles(scene, name).iter().map(|t| t.2).sum()
}

/// Names of all objects, in the order of their instances.
fn names(scene: &Scene) -> Vec<String> {
    scene.instance_ids().map(|id| scene.object_name(id).to_owned()).collect()
}
