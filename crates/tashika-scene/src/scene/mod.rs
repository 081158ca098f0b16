//! The scene: geometry, materials, light sources and cameras.
//!
//! A [`Scene`] is immutable. It is assembled by a [`SceneBuilder`], which validates its input and,
//! where that is safe, repairs it. In a scene that [`SceneBuilder::build`] returns, every number is
//! finite, every index is in range and no triangle is degenerate. Repairs, approximations and
//! additions are recorded as [`Note`]s, which the program reports.
//!
//! Units: lengths in metres, radiance in W·m⁻²·sr⁻¹, intensity in W·sr⁻¹, irradiance in W·m⁻².

mod abilities;
mod below_zero;
mod builder;
pub mod builtin;
mod camera;
mod check;
mod cie_sky;
mod deformation;
mod digest;
mod emitter;
mod environment;
mod environment_blocks;
mod faces;
mod facets;
mod hemisphere;
mod input;
mod intensity_map;
mod lens;
mod light_groups;
mod material;
mod medium;
mod mesh;
mod motion;
mod normal_map;
mod note;
mod object_names;
mod origin;
mod overview;
mod part;
mod perez_sky;
mod projection;
mod relight;
mod sensor;
pub mod sky;
mod sphere_map;
mod sun_position;
mod surface;
mod texels;
mod texture;
mod tiles;
mod variation;
mod volume_grid;

pub use abilities::Abilities;
pub use below_zero::below_zero_message;
pub use builder::{MAX_TEXTURE_COST, SceneBuilder};
pub use camera::{Camera, CameraSample, Seen};
pub use cie_sky::CieSky;
pub use deformation::{MeshShape, between, box_between};
pub use emitter::{Beam, Emitter, Falloff, FalloffShape};
pub use environment::Environment;
pub use environment_blocks::EnvironmentBlocks;
pub use facets::{FacetInput, TangentInput};
pub use hemisphere::hemispherical_irradiance;
pub use input::{ColorInput, FloatInput};
pub use intensity_map::{AimedMap, IntensityMap, Lookup, SlideWeight, Spread};
pub use lens::{Blades, Lens};
pub use light_groups::{LightGrouping, LightGroups, LightId};
pub use material::{Alpha, AlphaMode, Back, CoatBase, Emission, Material, NormalInput, Surface};
pub use medium::{Interface, MAX_EXTINCTION, MAX_OPTICAL_THICKNESS, Medium};
pub use mesh::{Instance, Mesh, MeshData, has_normal};
pub use motion::Motion;
pub use note::{Note, NoteKind, Notes};
pub use origin::Placement;
pub use part::Part;
pub use perez_sky::{PerezSky, SkyCondition};
pub use projection::Projection;
pub use relight::Lamp;
pub use sensor::{Sensor, SensorGrid, SensorPoint, SensorShape};
pub use sphere_map::SphereMap;
pub use sun_position::{CalendarDate, SunPosition};
pub use surface::{SurfacePoint, TurnedAway};
pub use texels::{Image, Pixels, Sampling, Values, Wrap};
pub use texture::{Channel, ImageTexture, Texture, Textures, UvTransform};
pub use tiles::{NO_TILE, TileSet, TiledTexture};
pub use variation::{CellRay, Density, Scattered, Span, Variation, Walk};
pub use volume_grid::{VolumeData, VolumeEdges, VolumeGrid, VolumeSamples, VolumeValues};

use crate::math::{Aabb, DVec3};
use faces::Faces;
use object_names::ObjectNames;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(u32);

        impl $name {
            /// Returns the id of the item at `index` in the scene's list; `index` must be less than
            /// the length of the list.
            #[inline]
            pub const fn at(index: u32) -> Self {
                Self(index)
            }

            /// Position in the scene's list.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// Index of a mesh of a scene.
    MeshId
);
id!(
    /// Index of an instance of a scene.
    InstanceId
);
id!(
    /// Index of a material of a scene.
    MaterialId
);
id!(
    /// Index of an image of a scene.
    ImageId
);
id!(
    /// Index of a texture of a scene.
    TextureId
);
id!(
    /// Index of a set of tiles of a scene.
    TileSetId
);
id!(
    /// Index of a medium of a scene.
    MediumId
);

/// Immutable scene, as [`SceneBuilder::build`] returns it.
#[derive(Debug)]
pub struct Scene {
    name: String,
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    faces: Faces,
    /// Motions of the moving instances.
    motions: Vec<Motion>,
    object_names: ObjectNames,
    materials: Vec<Material>,
    /// True for each material that is glass or a mix with glass.
    glassy: Vec<bool>,
    /// True if any material is solid glass.
    refracts: bool,
    /// True for each material with anisotropic facets, or a mix with such a part.
    brushed: Vec<bool>,
    images: Vec<Image>,
    textures: Vec<Texture>,
    tile_sets: Vec<TileSet>,
    emitters: Vec<Emitter>,
    light_names: ObjectNames,
    intensity_maps: Vec<AimedMap>,
    environment: Option<Environment>,
    cameras: Vec<Camera>,
    media: Vec<Medium>,
    /// True if any medium that is used absorbs or scatters light.
    has_media: bool,
    /// True if any mesh with an instance has an interface.
    has_interfaces: bool,
    bounds: Aabb,
    /// Origin of all coordinates, in the coordinates of the file (m).
    origin: DVec3,
    /// Number of triangles without area that were omitted from the meshes; they would be invisible.
    triangles_without_area: u64,
    notes: Notes,
    digest: Option<u64>,
    /// Changes to the file's lights that the user requested, in the words of the request.
    changes: Vec<String>,
    has_default_light: bool,
    /// True if the file has lights that may be off at the time of the scene.
    is_dark_now: bool,
    turned_away: TurnedAway,
    /// Times of the first and the last motion in the file (s).
    animated: Option<[f64; 2]>,
    /// Time of the scene (s), if one was requested and anything in the file moves.
    time: Option<f64>,
}

impl Scene {
    /// Returns the scene with this digest.
    pub fn with_digest(self, digest: u64) -> Self {
        Self { digest: Some(digest), ..self }
    }

    /// Hash of the files that the scene was loaded from, or of its contents; `None` for built-in
    /// scenes.
    pub fn digest(&self) -> Option<u64> {
        self.digest
    }

    /// Number of triangles without area that were omitted; they would be invisible.
    pub fn triangles_without_area(&self) -> u64 {
        self.triangles_without_area
    }

    /// Interval of time in which anything in the file of the scene moves (s), if anything does.
    pub fn animated_seconds(&self) -> Option<[f64; 2]> {
        self.animated
    }

    /// Returns the scene with `seconds` recorded as its time (s); nothing is moved.
    pub fn with_time(self, seconds: f64) -> Self {
        Self { time: Some(seconds), ..self }
    }

    /// Time of the scene (s), if one was requested and anything in the file moves.
    pub fn time(&self) -> Option<f64> {
        self.time
    }

    /// Name for reports, usually the file's.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All meshes, in the order of their ids.
    #[inline]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// All instances; a mesh without an instance is invisible.
    #[inline]
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Ids of the instances, in order.
    pub fn instance_ids(&self) -> impl ExactSizeIterator<Item = InstanceId> + use<> {
        (0..self.instances.len() as u32).map(InstanceId)
    }

    /// All materials, in the order of their ids.
    #[inline]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// All images, shared by the textures of the materials.
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// Images, sets of tiles, and the textures made of them.
    #[inline]
    pub fn textures(&self) -> Textures<'_> {
        Textures { images: &self.images, nodes: &self.textures, tile_sets: &self.tile_sets }
    }

    /// Intensity maps of the image emitters.
    #[inline]
    pub fn intensity_maps(&self) -> &[AimedMap] {
        &self.intensity_maps
    }

    /// Point, spot, image and directional emitters. Emissive meshes are instances whose material
    /// emits.
    #[inline]
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Environment light, seen where a ray meets no surface, if it emits.
    #[inline]
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref()
    }

    /// All cameras; never empty. The first is the default.
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }

    /// Returns the camera with that name.
    pub fn camera(&self, name: &str) -> Option<&Camera> {
        self.cameras.iter().find(|c| c.name == name)
    }

    /// Returns the world box around all instances, at all times (m, relative to [`Self::origin`]);
    /// a unit box around the origin if there are none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Notes of repairs, approximations, ignored input and additions.
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Returns the scene with additional notes.
    #[must_use]
    pub fn with_notes(mut self, more: &Notes) -> Self {
        for note in more.iter() {
            self.notes.push_many(note.kind, note.message, note.first, note.count);
        }
        self
    }

    /// The mesh of an instance.
    #[inline]
    pub fn mesh_of(&self, instance: InstanceId) -> &Mesh {
        &self.meshes[self.instances[instance.index()].mesh.index()]
    }

    /// The material of an instance.
    #[inline]
    pub fn material_of(&self, instance: InstanceId) -> &Material {
        &self.materials[self.mesh_of(instance).material.index()]
    }

    /// Size of the meshes in memory (bytes).
    pub fn mesh_bytes(&self) -> u64 {
        self.meshes.iter().map(Mesh::bytes).sum::<u64>() + self.faces.bytes()
    }

    /// Number of triangles in memory: those of each mesh count once.
    pub fn stored_triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.triangles().len() as u64).sum()
    }

    /// Number of triangles in the scene: those of each mesh count once per instance.
    pub fn instanced_triangles(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh.index()].triangles().len() as u64).sum()
    }

    /// Instances whose material has an emission, with the emission.
    pub fn area_emitters(&self) -> impl Iterator<Item = (InstanceId, &Emission)> {
        self.instances.iter().enumerate().filter_map(|(i, instance)| {
            let material = &self.materials[self.meshes[instance.mesh.index()].material.index()];
            material.emission.as_ref().map(|e| (InstanceId(i as u32), e))
        })
    }
}
