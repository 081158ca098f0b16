//! Content hash of a scene that was not loaded from a file.

use std::fmt::{self, Write};

use super::Scene;

/// 64-bit FNV-1a hash (Fowler, Noll, Vo) of written text.
struct Fnv(u64);

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(())
    }
}

impl Scene {
    /// Returns the scene with a hash of its contents as its [`Self::digest`]. The hashed text is
    /// the `Debug` output. It distinguishes numbers that differ in any bit, and automatically
    /// includes all fields. Scenes that differ have different digests, except by accidental
    /// collisions.
    pub fn with_digest_of_contents(self) -> Self {
        let mut sum = Fnv(0xcbf2_9ce4_8422_2325);
        write!(sum, "{self:?}").expect("the sum takes any text");
        self.with_digest(sum.0)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use crate::color::Rgb;
    use crate::error::Location;
    use crate::scene::{
        ColorInput, Environment, Image, ImageTexture, Material, MeshData, Pixels, SceneBuilder, Surface,
        Texture,
    };

    /// Digest of a textured triangle under a sky.
    fn digest(height: f32, texel: f32, sky: f32) -> u64 {
        let mut builder = SceneBuilder::new("a", Location::file("a"));
        let image = Image { name: "i".into(), width: 1, height: 1, pixels: Pixels::Float(vec![[texel; 3]]) };
        let image = builder.add_image(image).unwrap();
        let texture = builder.add_texture(Texture::Image(ImageTexture::new(image))).unwrap();
        let reflectance = ColorInput { factor: Rgb::WHITE, texture: Some(texture) };
        let material = builder.add_material(Material::new("m", Surface::Lambert { reflectance })).unwrap();
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, height, 0.0)];
        let data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        let mesh = builder.add_mesh(data, material).unwrap();
        builder.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        builder.set_environment(Environment::constant(Rgb::gray(sky))).unwrap();
        builder.build().unwrap().with_digest_of_contents().digest().unwrap()
    }

    #[test]
    fn any_number_of_a_scene_changes_it_by_its_last_bit() {
        let first = digest(1.0, 0.5, 2.0);
        assert_eq!(first, digest(1.0, 0.5, 2.0));
        assert_ne!(first, digest(1.0f32.next_up(), 0.5, 2.0));
        assert_ne!(first, digest(1.0, 0.5f32.next_up(), 2.0));
        assert_ne!(first, digest(1.0, 0.5, 2.0f32.next_up()));
    }
}
