//! Assembly of a scene, with all checks on which later code relies.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3, Vec3};

use super::faces::Faces;
use super::mesh::MeshRepairs;
use super::motion::inverse;
use super::object_names::{Numbered, ObjectNames};
use super::origin::Places;
use super::{
    AimedMap, Beam, Camera, Emitter, Environment, FloatInput, Image, ImageId, Instance, InstanceId,
    IntensityMap, Material, MaterialId, Mesh, MeshData, MeshId, Note, NoteKind, Notes, Placement, Scene,
    Surface, Texture, TextureId, TurnedAway, check, deformation,
};
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::Aabb;
use crate::math::elementary::powf;

/// Collects the parts of a [`Scene`].
///
/// Parts refer to each other by the ids that the `add_*` methods return, so they are added bottom
/// up: images, textures, materials, meshes, instances.
#[derive(Debug)]
pub struct SceneBuilder {
    pub(super) scene: Scene,
    pub(super) origin: Location,
    /// Number of texels below zero of each image.
    pub(super) below_zero: Vec<u64>,
    /// Number of nodes that one lookup visits, for each texture.
    texture_costs: Vec<u32>,
    /// Number of materials that each material consists of.
    material_costs: Vec<u32>,
    pub(super) numbered: Numbered,
    pub(super) places: Places,
    /// Largest number of instances.
    most_instances: usize,
}

impl SceneBuilder {
    /// Creates an empty scene. `name` is for reports; notes and errors name `origin` as their
    /// location.
    pub fn new(name: impl Into<String>, origin: Location) -> Self {
        let scene = Scene {
            name: name.into(),
            meshes: Vec::new(),
            instances: Vec::new(),
            faces: Faces::default(),
            motions: Vec::new(),
            object_names: ObjectNames::default(),
            materials: Vec::new(),
            glassy: Vec::new(),
            refracts: false,
            brushed: Vec::new(),
            images: Vec::new(),
            textures: Vec::new(),
            tile_sets: Vec::new(),
            emitters: Vec::new(),
            light_names: ObjectNames::default(),
            intensity_maps: Vec::new(),
            environment: None,
            cameras: Vec::new(),
            media: Vec::new(),
            has_media: false,
            has_interfaces: false,
            bounds: Aabb::EMPTY,
            origin: DVec3::ZERO,
            triangles_without_area: 0,
            notes: Notes::default(),
            digest: None,
            changes: Vec::new(),
            has_default_light: false,
            is_dark_now: false,
            turned_away: TurnedAway::default(),
            animated: None,
            time: None,
        };
        Self::of(scene, origin)
    }

    /// Wraps a finished scene so that lights can be added.
    pub(super) fn of(scene: Scene, origin: Location) -> Self {
        Self {
            scene,
            origin,
            below_zero: Vec::new(),
            texture_costs: Vec::new(),
            material_costs: Vec::new(),
            numbered: Numbered::default(),
            places: Places::default(),
            most_instances: usize::MAX,
        }
    }

    /// Returns the scene without the checks and additions of [`Self::build`].
    pub(super) fn into_scene(self) -> Scene {
        self.scene
    }

    /// Adds a note on the treatment of the input.
    pub fn note(&mut self, kind: NoteKind, message: impl Into<String>, at: Location) {
        self.scene.notes.push(kind, message, at);
    }

    /// Notes added so far, to which more can be added.
    pub fn notes_mut(&mut self) -> &mut Notes {
        &mut self.scene.notes
    }

    /// Records that something in the file moves from one time to another (finite, s).
    pub fn add_animated_seconds(&mut self, [from, to]: [f64; 2]) {
        let [first, last] = self.scene.animated.unwrap_or([from, to]);
        self.scene.animated = Some([first.min(from), last.max(to)]);
    }

    /// Records that the file has lights that may be off at the time of the scene.
    /// [`Scene::with_default_light`] then adds no light if anything in the scene moves.
    pub fn set_dark_now(&mut self) {
        self.scene.is_dark_now = true;
    }

    /// Adds notes made elsewhere.
    pub fn extend_notes(&mut self, notes: impl IntoIterator<Item = Note>) {
        for n in notes {
            self.scene.notes.push_many(n.kind, n.message, n.first, n.count);
        }
    }

    /// Adds an image of `width · height > 0` texels, which must be finite. If the image is used as
    /// a colour, values below zero count as 0, and [`Self::build`] adds a note.
    pub fn add_image(&mut self, image: Image) -> Result<ImageId> {
        check::image(&image)
            .map_err(|wrong| wrong.error(self.origin.clone().item(format!("image {}", image.name))))?;
        self.below_zero.push(image.texels_below_zero());
        self.scene.images.push(image);
        Ok(ImageId(self.scene.images.len() as u32 - 1))
    }

    /// Adds a texture. Its operands, images and tiles must have been added before, and a lookup
    /// must not visit more than [`MAX_TEXTURE_COST`] nodes.
    pub fn add_texture(&mut self, texture: Texture) -> Result<TextureId> {
        let at = || self.origin.clone().item(format!("texture {}", self.scene.textures.len()));
        check::texture(&texture, &self.scene).map_err(|wrong| wrong.error(at()))?;
        let mut cost = 1u32;
        for operand in texture.operands() {
            let Some(c) = self.texture_costs.get(operand.index()) else {
                return Err(Error::invalid(
                    at(),
                    format!("texture {}", operand.index()),
                    "a texture of this scene",
                ));
            };
            cost = cost.saturating_add(*c);
        }
        if cost > MAX_TEXTURE_COST {
            let found = format!("a texture made of {cost} textures");
            return Err(Error::invalid(at(), found, format!("at most {MAX_TEXTURE_COST}")));
        }
        self.texture_costs.push(cost);
        self.scene.textures.push(texture);
        Ok(TextureId(self.scene.textures.len() as u32 - 1))
    }

    /// Returns `input` to the power `exponent`; adds a texture for the power if `input` is
    /// textured.
    pub fn power(&mut self, input: FloatInput, exponent: f32) -> Result<FloatInput> {
        let power = |(base, channel)| Ok((self.add_texture(Texture::Power { base, exponent })?, channel));
        Ok(FloatInput {
            factor: powf(input.factor, exponent),
            texture: input.texture.map(power).transpose()?,
        })
    }

    /// Adds a material; factors must be finite and not negative, indices of refraction above 1, and
    /// the materials of a mix and the base of a coat must have been added before.
    pub fn add_material(&mut self, material: Material) -> Result<MaterialId> {
        check::material(&material, &self.scene)
            .map_err(|wrong| wrong.error(self.origin.clone().item(format!("material {}", material.name))))?;
        let is_glass =
            matches!(material.surface, Surface::Glass { .. } | Surface::ThinGlass { .. } | Surface::Boundary);
        let glassy = is_glass || material.others().any(|m| self.scene.glassy[m.index()]);
        let cost = 1 + material.others().map(|m| self.material_costs[m.index()]).sum::<u32>();
        if cost > MAX_MIXED {
            let at = self.origin.clone().item(format!("material {}", material.name));
            let found = format!("a mix of {cost} materials");
            return Err(Error::invalid(at, found, format!("at most {MAX_MIXED}")));
        }
        self.scene.glassy.push(glassy);
        self.scene.refracts |= matches!(material.surface, Surface::Glass { .. });
        self.scene.brushed.push(self.is_brushed(&material.surface));
        self.material_costs.push(cost);
        self.scene.materials.push(material);
        Ok(MaterialId(self.scene.materials.len() as u32 - 1))
    }

    /// Returns true if the facets of a surface, or of a part of a mix, have a tangent.
    pub fn is_brushed(&self, surface: &Surface) -> bool {
        match surface {
            Surface::Mix { first, second, .. } => {
                [first, second].into_iter().any(|part| self.scene.brushed[part.index()])
            }
            Surface::Sheen { base, .. } | Surface::Clearcoat { base, .. } => self.scene.brushed[base.index()],
            surface => surface.is_brushed(),
        }
    }

    /// Adds a mesh.
    ///
    /// Wrong indices and attribute counts are errors. Triangles that cannot be rendered are
    /// omitted; those that are not finite are noted.
    pub fn add_mesh(&mut self, mut data: MeshData, material: MaterialId) -> Result<MeshId> {
        self.check_mesh(&data, material)?;
        self.localize(&mut data, None);
        let (name, origin) = (data.name.clone(), data.origin);
        let (mesh, repairs) = Mesh::repair(data, material);
        Ok(self.push_mesh(mesh, repairs, (&name, origin)))
    }

    /// Checks indices and counts.
    pub(super) fn check_mesh(&self, data: &MeshData, material: MaterialId) -> Result<()> {
        let at = self.origin.clone().item(format!("mesh {}", data.name));
        let vertices = data.positions.len();
        if let Some(i) = data.triangles.iter().flatten().find(|&&i| i as usize >= vertices) {
            return Err(Error::invalid(
                at,
                format!("vertex index {i}"),
                format!("an index below {vertices}"),
            ));
        }
        for (attribute, count) in [("normals", data.normals.len()), ("texture coordinates", data.uvs.len())] {
            if count != 0 && count != vertices {
                return Err(Error::invalid(
                    at,
                    format!("{count} {attribute} for {vertices} vertices"),
                    "none, or one a vertex",
                ));
            }
        }
        if material.index() >= self.scene.materials.len() {
            return Err(Error::invalid(
                at,
                format!("material {}", material.index()),
                "a material of this scene",
            ));
        }
        Ok(())
    }

    /// Adds a mesh with a name and an origin, and notes of its repairs.
    pub(super) fn push_mesh(
        &mut self,
        mesh: Mesh,
        repairs: MeshRepairs,
        (name, origin): (&str, DVec3),
    ) -> MeshId {
        let at = self.origin.clone().item(format!("mesh {name}"));
        let MeshRepairs { not_finite, degenerate, normals, uvs } = repairs;
        let repaired = NoteKind::Repaired;
        let notes = &mut self.scene.notes;
        notes.push_many(
            repaired,
            "triangles with vertices that are not finite: left out",
            at.clone(),
            not_finite,
        );
        notes.push_many(
            repaired,
            "vertex normals without direction: the face's is used",
            at.clone(),
            normals,
        );
        notes.push_many(repaired, "texture coordinates that are not finite: set to 0", at, uvs);
        self.scene.triangles_without_area += degenerate;
        self.scene.meshes.push(mesh);
        self.places.meshes.push(origin);
        MeshId(self.scene.meshes.len() as u32 - 1)
    }

    /// Sets the largest number of instances. The limit is needed because nested groups of objects
    /// can multiply to far more instances than a file has bytes.
    pub fn set_most_instances(&mut self, most: usize) {
        self.most_instances = most;
    }

    /// Places a mesh. An instance whose transform is not finite or cannot be inverted is omitted
    /// and noted.
    pub fn add_instance(&mut self, mesh: MeshId, to_world: impl Placement) -> Result<Option<InstanceId>> {
        let to_world = to_world.in_double();
        if let Some(shutter) = self.scene.meshes.get(mesh.index()).and_then(Mesh::deforms)
            && let Some(track) = deformation::standing(to_world)
        {
            return self.add_moving_instance(mesh, track, shutter);
        }
        self.place(mesh, to_world)
    }

    /// Adds an instance of a mesh with a constant transform. For a moving instance, this is the
    /// transform in the middle of its motion.
    pub(super) fn place(&mut self, mesh: MeshId, exact: DAffine3) -> Result<Option<InstanceId>> {
        let at = self.origin.clone().item(format!("instance {}", self.scene.instances.len()));
        if mesh.index() >= self.scene.meshes.len() {
            return Err(Error::invalid(at, format!("mesh {}", mesh.index()), "a mesh of this scene"));
        }
        let most = self.most_instances;
        if self.scene.instances.len() >= most {
            let expected = format!("at most {most} for a scene whose files are as small as these");
            return Err(Error::invalid(at, "one more instance", expected));
        }
        let to_world = exact.as_affine3a();
        let to_object = inverse(&to_world);
        if !to_world.is_finite() || !to_object.is_finite() {
            self.note(NoteKind::Repaired, "instances with a transform that cannot be inverted: left out", at);
            return Ok(None);
        }
        let mirrored = to_world.matrix3.determinant() < 0.0;
        let (baked, motion) = (false, None);
        self.places.instances.push(exact);
        self.scene.instances.push(Instance { mesh, to_world, to_object, mirrored, baked, motion });
        Ok(Some(InstanceId(self.scene.instances.len() as u32 - 1)))
    }

    /// Adds an emitter without surface; black ones are ignored.
    pub fn add_emitter(&mut self, emitter: Emitter) -> Result<()> {
        let place = emitter.position().unwrap_or(Vec3::ZERO).as_dvec3();
        self.add_emitter_at(emitter, place)
    }

    /// Adds an emitter at a position in double precision (m); the position that `emitter` contains
    /// is ignored.
    pub fn add_emitter_at(&mut self, mut emitter: Emitter, place: DVec3) -> Result<()> {
        emitter.move_to(place.as_vec3());
        let color = emitter.color();
        let geometry = match emitter {
            Emitter::Point { position, .. } => position.is_finite(),
            Emitter::Spot { position, axis, falloff, .. } => {
                position.is_finite()
                    && axis.is_normalized()
                    && (-1.0..falloff.cos_inner).contains(&falloff.cos_outer)
                    && falloff.cos_inner <= 1.0
            }
            Emitter::Image { position, axis, beam, .. } => {
                position.is_finite()
                    && axis.is_normalized()
                    && (beam.map as usize) < self.scene.intensity_maps.len()
                    && beam.cos_outer <= self.scene.intensity_maps[beam.map as usize].map().cos_outer()
            }
            Emitter::Directional { direction, .. } => direction.is_normalized(),
        };
        if !color.is_valid() || !geometry {
            return Err(Error::invalid(
                self.origin.clone().item(format!("emitter {}", self.scene.emitters.len())),
                format!("{emitter:?}"),
                "finite positions, unit directions, colours of at least 0, an inner cone inside the outer",
            ));
        }
        if !color.is_black() {
            self.scene.emitters.push(emitter);
            self.places.emitters.push(place);
        }
        Ok(())
    }

    /// Adds an emitter with an intensity map, turned by the rotation (or reflection) `to_world`.
    /// Its intensity is `intensity` (W·sr⁻¹) where the map has 1.
    ///
    /// # Errors
    /// Texels or positions that are not finite; colours that are negative or not finite.
    pub fn add_image_light(
        &mut self,
        map: &Arc<IntensityMap>,
        position: impl Into<DVec3>,
        intensity: Rgb,
        to_world: Mat3,
    ) -> Result<()> {
        check::image(map.image()).map_err(|wrong| {
            wrong.error(self.origin.clone().item(format!("emitter {}", self.scene.emitters.len())))
        })?;
        let aimed = AimedMap::new(Arc::clone(map), to_world);
        let beam = Beam { map: self.scene.intensity_maps.len() as u32, cos_outer: map.cos_outer() };
        let axis = aimed.axis();
        self.scene.intensity_maps.push(aimed);
        let place = position.into();
        let intensity = intensity * map.brightest();
        self.add_emitter_at(Emitter::Image { position: place.as_vec3(), axis, intensity, beam }, place)
    }

    /// Sets the rule for shading normals that face away from the viewer.
    pub fn set_turned_away(&mut self, rule: TurnedAway) {
        self.scene.turned_away = rule;
    }

    /// Sets the environment seen behind all surfaces; radiances must be finite. Texels below zero
    /// count as 0.
    pub fn set_environment(&mut self, environment: Environment) -> Result<()> {
        if !environment.is_valid() {
            let at = self.origin.clone().item("environment");
            return Err(Error::invalid(
                at,
                "a radiance that is negative or not finite",
                "radiances of at least 0",
            ));
        }
        self.scene.environment = (!environment.is_black()).then_some(environment);
        Ok(())
    }

    /// Adds a camera; the first one is the default.
    pub fn add_camera(&mut self, camera: Camera) -> Result<()> {
        let to_world = camera.to_world;
        self.add_camera_at(camera, to_world)
    }

    /// Adds a camera with a pose in double precision; the pose that a static `camera` contains is
    /// ignored. The pose of a moving camera is that of its motion.
    pub fn add_camera_at(&mut self, mut camera: Camera, to_world: impl Placement) -> Result<()> {
        let to_world = to_world.in_double();
        if camera.motion.is_none() {
            camera.to_world = to_world.as_affine3a();
        }
        if !camera.is_valid() {
            return Err(Error::invalid(
                self.origin.clone().item(format!("camera {}", camera.name)),
                format!("{camera:?}"),
                "a finite, invertible transform, a field of view between 0° and 180° (of a fisheye to 360°) or a height above 0, a finite shift, a lens radius of at least 0, a focus distance above 0 and 3 to 100 blades",
            ));
        }
        self.scene.check_camera(&camera)?;
        self.scene.cameras.push(camera);
        self.places.cameras.push(to_world);
        Ok(())
    }

    /// Returns the world box of all instances added so far, at all times (m), in single precision.
    pub fn bounds(&self) -> Aabb {
        self.scene.instances.iter().fold(Aabb::EMPTY, |all, i| all.union(self.scene.box_of(i)))
    }

    /// Returns the scene. A scene without a camera gets one that sees all of it, with a note. A
    /// scene without light is dark: see [`Scene::with_default_light`].
    pub fn build(mut self) -> Result<Scene> {
        self.settle();
        let bounds = self.bounds();
        let fits = bounds.size().is_finite() && bounds.diagonal() < MAX_EXTENT;
        if !(bounds.is_empty() || fits) {
            return Err(Error::invalid(
                self.origin,
                format!("scene bounds from {:?} to {:?}", bounds.lo.to_array(), bounds.hi.to_array()),
                format!("a scene of less than {MAX_EXTENT:e} m"),
            ));
        }
        self.scene.bounds =
            if bounds.is_empty() { Aabb { lo: Vec3::splat(-0.5), hi: Vec3::splat(0.5) } } else { bounds };
        if bounds.is_empty() {
            let at = self.origin.clone();
            self.note(NoteKind::Defaulted, "no triangle to render: the image shows the background only", at);
        }
        if self.scene.cameras.is_empty() {
            let at = self.origin.clone();
            self.note(NoteKind::Defaulted, "no camera: one that sees the whole scene is used", at);
            let camera = Camera::overview(self.scene.bounds);
            self.add_camera(camera)?;
        }
        self.note_missing_tiles();
        self.note_colors_below_zero();
        self.scene.count_media();
        self.bake();
        Ok(self.scene)
    }

    /// Selects the instances whose corners are stored in world space: static instances of meshes
    /// whose copies take little memory.
    fn bake(&mut self) {
        let s = &mut self.scene;
        let mut uses = vec![0u64; s.meshes.len()];
        for i in s.instances.iter().filter(|i| i.motion.is_none()) {
            uses[i.mesh.index()] += 1;
        }
        // Meshes that add the fewest triangles come first, so that as many meshes as possible are
        // baked.
        let added = |mesh: usize| uses[mesh].saturating_sub(1) * s.meshes[mesh].triangles.len() as u64;
        let mut order: Vec<usize> = (0..s.meshes.len()).collect();
        order.sort_by_key(|&mesh| (added(mesh), mesh));
        let mut total = 0u64;
        let mut baked = vec![false; s.meshes.len()];
        for mesh in order {
            total = total.saturating_add(added(mesh));
            baked[mesh] = added(mesh) <= BAKED_TRIANGLES && total <= ALL_BAKED_TRIANGLES;
        }
        for i in &mut s.instances {
            i.baked = i.motion.is_none() && baked[i.mesh.index()];
        }
        s.faces = Faces::new(&s.instances, &s.meshes);
    }
}

/// Largest number of triangles that the copies of a baked mesh, beyond the first, may add (4 MB in
/// the tracer).
const BAKED_TRIANGLES: u64 = 1 << 16;

/// Largest number of triangles that baking may add to a scene.
const ALL_BAKED_TRIANGLES: u64 = 1 << 20;

/// Largest number of materials that a mix may consist of, itself included.
const MAX_MIXED: u32 = 256;

/// Largest number of nodes that a lookup of a texture may visit.
pub const MAX_TEXTURE_COST: u32 = 256;

/// Largest diagonal (m) at which products of four lengths still fit into `f32`.
const MAX_EXTENT: f32 = 1e9;

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::scene::Projection;

    fn wall(size: Vec3) -> SceneBuilder {
        let mut b = SceneBuilder::new("s", Location::file("s.obj"));
        let material = Material::new("m", Surface::Lambert { reflectance: Rgb::gray(0.5).into() });
        let material = b.add_material(material).unwrap();
        let positions = vec![Vec3::ZERO, Vec3::new(size.x, 0.0, 0.0), size];
        let data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        let mesh = b.add_mesh(data, material).unwrap();
        b.add_instance(mesh, Affine3A::from_translation(Vec3::splat(7.0) * size)).unwrap();
        b
    }

    #[test]
    fn a_scene_without_camera_gets_one_and_says_so_and_without_light_is_dark() {
        let scene = wall(Vec3::new(3.0, 0.2, 0.1)).build().unwrap();
        assert!(scene.environment().is_none() && scene.emitters().is_empty());
        let said: Vec<String> = scene.notes().iter().map(|n| n.message).collect();
        assert!(said.len() == 1 && said[0].contains("no camera"));
        assert_eq!(scene.cameras()[0].shows, Some(scene.bounds()));
        assert!(!scene.has_light() && !scene.has_default_light());
        let lit = scene.with_default_light(Location::default());
        assert!(lit.has_light() && lit.has_default_light());
        assert!(lit.notes().iter().any(|note| note.message.contains("no light")));
    }

    #[test]
    fn wrong_parts_are_refused_with_what_is_allowed() {
        let mut b = wall(Vec3::ONE);
        let message = |e: Error| e.to_string();
        let bad =
            MeshData { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 3]], ..MeshData::default() };
        let said = message(b.add_mesh(bad, MaterialId(0)).unwrap_err());
        assert!(said.contains("vertex index 3") && said.contains("below 3"), "{said}");
        let glass = Surface::Glass {
            ior: 0.5,
            reflectance: Rgb::WHITE,
            transmittance: Rgb::WHITE,
            facets: 0.0.into(),
        };
        let said = message(b.add_material(Material::new("g", glass)).unwrap_err());
        assert!(said.contains("material g: ior = 0.5; expected 1.0001 to 5"), "{said}");
        let said = message(
            b.add_camera(Camera {
                projection: Projection::Perspective { vertical_fov: 4.0 },
                ..Camera::overview(b.bounds())
            })
            .unwrap_err(),
        );
        assert!(said.contains("field of view between"), "{said}");
        let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
        assert!(b.add_instance(MeshId(0), flat).unwrap().is_none(), "left out, with a note");
        assert!(b.add_instance(MeshId(9), Affine3A::IDENTITY).is_err());
        b.set_most_instances(2);
        assert!(b.add_instance(MeshId(0), Affine3A::IDENTITY).is_ok());
        let said = message(b.add_instance(MeshId(0), Affine3A::IDENTITY).unwrap_err());
        assert!(said.contains("instance 2: one more instance; expected at most 2 for"), "{said}");
    }

    #[test]
    fn scenes_too_large_for_single_precision_are_refused() {
        let said = wall(Vec3::splat(2e9)).build().unwrap_err().to_string();
        assert!(said.contains("scene bounds"), "{said}");
    }
}
