//! USD scenes: `.usda` (text), `.usdc` (binary), `.usd` (either) and `.usdz`
//! (archives).[^usd2016][^aousd2025]
//!
//! [`FEATURES`] lists the features of the format and their support; notes and errors quote its
//! rows.
//!
//! | module | purpose |
//! |---|---|
//! | [`text`], [`binary`], [`package`] | bytes into layers |
//! | [`value`], [`layer`] | contents of a layer |
//! | [`layers`], [`sites`], [`compose`], [`prim`] | layers into prims, and their values |
//! | [`work`] | limits on the work and the memory of a scene |
//! | [`walk`], [`xform`], [`bindings`] | prims to render, with transforms and materials |
//! | [`meshes`], [`primvars`], [`shapes`], [`instancer`] | geometry |
//! | [`materials`], [`network`], [`textures`] | materials |
//! | [`cameras`], [`lights`] | cameras and lights |
//! | [`features`], [`properties`], [`unread`] | the table of features, and notes from it |
//!
//! # Guarantee
//! No file makes the loader panic. Allocations are bounded by the bytes of the files and by
//! [`LoadOptions`](super::LoadOptions). Unreadable content is an error that names file, line or
//! prim, value and expectation; a missing file is noted, see [`load_scene`](super::load_scene).
//!
//! # Held to this by
//! The test modules `usd`, `usd_*` and `damaged_usd`.
//!
//! [^aousd2025]: Alliance for OpenUSD. "AOUSD Core Specification 1.0." 2025.
//! [^usd2016]: Pixar Animation Studios. "Universal Scene Description." 2016: documentation of its
//!     schemas.

mod binary;
mod bindings;
mod cameras;
mod compose;
mod coordinates;
mod features;
mod inputs;
mod instancer;
mod layer;
mod layers;
mod lights;
mod materials;
mod materialx;
mod meshes;
mod models;
mod network;
mod nodes;
mod package;
mod prim;
mod primvars;
mod properties;
mod shapes;
mod sites;
mod text;
mod textures;
mod unread;
mod value;
mod walk;
mod work;
mod xform;
mod xml;

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use self::compose::Composer;
use self::layers::{LayerId, Layers};
use self::materials::Materials;
use self::meshes::MeshKey;
use self::primvars::MeansOf;
use self::textures::Packed;
use self::value::Text;
use self::walk::{Placed, State};
use self::work::Allowance;
use super::SceneFiles;
use super::assets::ImageCache;
use super::lights::Surroundings;
use super::limits::Budget;
use super::notes::Named;
use crate::error::{Error, Location, Result};
use crate::scene::{MaterialId, MeshId, Scene, SceneBuilder};

pub(super) use self::features::FEATURES;

/// Metres per unit, if the stage states none: a unit is a centimetre.
const METERS_PER_UNIT: f64 = 0.01;

/// Time codes per second, if the stage states none.
const CODES_PER_SECOND: f64 = 24.0;

/// A scene being read.
struct Stage<'f> {
    composer: Composer<'f>,
    builder: SceneBuilder,
    origin: Location,
    /// Time code at which the scene is read, if one is given.
    time: Option<f64>,
    codes_per_second: f64,
    meters_per_unit: f64,
    is_z_up: bool,
    /// Transform from the stage's units and axes to metres and `+y` up.
    to_world: DAffine3,
    images: ImageCache<'f>,
    packed: Packed,
    materials: Materials,
    meshes: BTreeMap<MeshKey, Vec<MeshId>>,
    shapes: BTreeMap<(String, MaterialId), MeshId>,
    /// Meshes of the prototypes of point instancers, by path.
    prototypes: BTreeMap<Text, Rc<Vec<Placed>>>,
    shown: MeansOf,
    surroundings: Surroundings,
    camera_names: BTreeSet<String>,
    named: Named,
    /// Prims of layers whose properties were checked.
    looked_at: BTreeSet<(LayerId, u32)>,
    value_budget: Allowance,
    geometry_budget: Allowance,
    image_budget: Budget,
}

/// Reads a USD scene.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let origin = Location::file(files.path());
    let mut builder = SceneBuilder::new(files.name(), origin.clone());
    let layers = Layers::open(files, &mut builder)?;
    let metadata = &layers.layer(layers.stack(0)[0]).metadata;
    let codes_per_second = metadata.time_codes_per_second.or(metadata.frames_per_second);
    let codes_per_second = positive("timeCodesPerSecond", codes_per_second, CODES_PER_SECOND, &origin)?;
    let meters_per_unit = positive("metersPerUnit", metadata.meters_per_unit, METERS_PER_UNIT, &origin)?;
    let is_z_up = metadata.up_axis.as_ref().is_some_and(|axis| &**axis == "Z");
    let upright = if is_z_up { DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y) } else { DMat3::IDENTITY };
    let to_world = DAffine3::from_mat3(upright * DMat3::from_diagonal(DVec3::splat(meters_per_unit)));
    let limit = files.options().max_file_bytes;
    let mut stage = Stage {
        composer: Composer::new(layers),
        builder,
        origin,
        time: files.options().time().map(|seconds| seconds * codes_per_second),
        codes_per_second,
        meters_per_unit,
        is_z_up,
        to_world,
        images: ImageCache::new(files),
        packed: Packed::new(),
        materials: Materials::default(),
        meshes: BTreeMap::new(),
        shapes: BTreeMap::new(),
        prototypes: BTreeMap::new(),
        shown: MeansOf::new(),
        surroundings: Surroundings::default(),
        camera_names: BTreeSet::new(),
        named: Named::new(features::MAX_UNKNOWN),
        looked_at: BTreeSet::new(),
        value_budget: Allowance::of_values(limit),
        geometry_budget: Allowance::of_geometry(limit),
        image_budget: Budget::new(limit, "images"),
    };
    let root = stage.composer.root();
    stage.walk(&root, &State::new(to_world), &mut Vec::new())?;
    if stage.surroundings.hides_constant() {
        // A dome light without a texture is ignored if another dome light has a texture.
        let at = stage.origin.clone();
        features::met("light", "second DomeLight texture", at, &mut stage.builder)?;
    }
    std::mem::take(&mut stage.surroundings).finish(&mut stage.builder)?;
    stage.builder.build()
}

/// A field of the stage that must be above 0; `fallback` if it is absent.
fn positive(name: &str, said: Option<f64>, fallback: f64, origin: &Location) -> Result<f64> {
    match said {
        None => Ok(fallback),
        Some(number) if number > 0.0 && number.is_finite() => Ok(number),
        Some(number) => {
            Err(Error::invalid(origin.clone().item(name), format!("{number}"), "a finite number above 0"))
        }
    }
}
