//! A [`SceneBuilder`] that accepts [`Shape`]s.

use glam::Affine3A;

use super::shapes::Shape;
use crate::color::Rgb;
use crate::error::{Location, Result};
use crate::scene::{
    Camera, ColorInput, Emission, Emitter, Image, ImageTexture, Material, MaterialId, Scene, SceneBuilder,
    Surface, Texture, TextureId,
};

/// Builder of a built-in scene.
pub struct Stage {
    builder: SceneBuilder,
}

impl Stage {
    /// Creates an empty scene.
    pub fn new(name: &str) -> Self {
        Self { builder: SceneBuilder::new(name, Location::file(format!("built-in scene {name}"))) }
    }

    /// Adds a texture of the whole of `image`, repeated.
    pub fn texture(&mut self, image: Image) -> Result<TextureId> {
        let image = self.builder.add_image(image)?;
        self.builder.add_texture(Texture::Image(ImageTexture::new(image)))
    }

    /// Adds a material that only scatters.
    pub fn material(&mut self, name: &str, surface: Surface) -> Result<MaterialId> {
        self.builder.add_material(Material::new(name, surface))
    }

    /// Adds a black surface whose front emits `radiance` (W·m⁻²·sr⁻¹).
    pub fn emissive(&mut self, name: &str, radiance: Rgb) -> Result<MaterialId> {
        let surface = Surface::Lambert { reflectance: Rgb::BLACK.into() };
        let emission = Emission { radiance: ColorInput::from(radiance), two_sided: false };
        self.builder.add_material(Material { emission: Some(emission), ..Material::new(name, surface) })
    }

    /// Adds `shape` without moving it.
    pub fn put(&mut self, name: &str, material: MaterialId, shape: Shape) -> Result<()> {
        self.repeat(name, material, shape, &[Affine3A::IDENTITY])
    }

    /// Adds an instance of `shape` at each of `places`.
    pub fn repeat(
        &mut self,
        name: &str,
        material: MaterialId,
        shape: Shape,
        places: &[Affine3A],
    ) -> Result<()> {
        let mesh = self.builder.add_mesh(shape.into_mesh(name), material)?;
        for &place in places {
            self.builder.add_instance(mesh, place)?;
        }
        Ok(())
    }

    /// Adds a light without a surface.
    pub fn emitter(&mut self, emitter: Emitter) -> Result<()> {
        self.builder.add_emitter(emitter)
    }

    /// Adds a camera; the first is the default.
    pub fn camera(&mut self, camera: Camera) -> Result<()> {
        self.builder.add_camera(camera)
    }

    /// Returns the finished scene.
    pub fn build(self) -> Result<Scene> {
        self.builder.build()
    }
}
