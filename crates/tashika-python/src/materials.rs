//! Materials from numbers and arrays: constant colours and roughnesses, or images.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::prelude::*;
use tashika::bsdf::ConductorFresnel;
use tashika::color::Rgb;
use tashika::error::Result;
use tashika::scene::{
    self, Channel, CoatBase, ColorInput, Emission, FloatInput, Image, ImageTexture, MaterialId, Pixels,
    SceneBuilder, Surface, Texture, TextureId,
};

use crate::arrays::{Array, Content};
use crate::errors::option;

/// Three numbers, or one for gray.
#[derive(FromPyObject)]
pub enum Color {
    #[pyo3(transparent)]
    Gray(f32),
    #[pyo3(transparent)]
    Channels([f32; 3]),
}

impl Color {
    /// Reads a colour; none if the value is an image, or of another kind.
    pub fn of(value: &Bound<'_, PyAny>) -> Option<Self> {
        let dimensions = value.getattr("ndim").and_then(|n| n.extract::<usize>()).unwrap_or(0);
        // An array of one texel would pass for a number.
        if dimensions > 1 { None } else { value.extract().ok() }
    }
}

impl From<Color> for Rgb {
    fn from(color: Color) -> Self {
        match color {
            Color::Gray(gray) => Self::gray(gray),
            Color::Channels(channels) => channels.into(),
        }
    }
}

/// Values on a surface: constant, or an image's at its texture coordinates.
#[derive(Clone)]
enum Paint {
    Flat(Rgb),
    Image(Arc<Image>),
}

impl Paint {
    /// Reads a colour. Arrays of bytes are sRGB; others are linear, and refused if a number is
    /// below zero.
    fn color(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        match Color::of(value) {
            Some(color) => Ok(Self::Flat(color.into())),
            None => {
                let image = image(name, value, Pixels::Srgb8)?;
                if image.texels_below_zero() > 0 {
                    return Err(option(name, "a colour below zero", "colours of at least 0"));
                }
                Ok(Self::Image(Arc::new(image)))
            }
        }
    }

    /// Reads a number; bytes are shares of 255.
    fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        match Color::of(value) {
            Some(Color::Gray(number)) => Ok(Self::Flat(Rgb::gray(number))),
            _ => Ok(Self::Image(Arc::new(image(name, value, Pixels::Linear8)?))),
        }
    }
}

/// Image of an array of shape (height, width) or (height, width, 3), from the top row; `of_bytes`
/// makes pixels of bytes.
pub fn image(
    name: &str,
    value: &Bound<'_, PyAny>,
    of_bytes: impl Fn(Vec<[u8; 4]>) -> Pixels,
) -> PyResult<Image> {
    let Array { shape, content } = Array::read(name, value)?;
    let expected = "a number, three, or an array of the shape (height, width) or (height, width, 3)";
    let (height, width, channels) = match shape[..] {
        [height, width] if height * width > 0 => (height, width, 1),
        [height, width, 3] if height * width > 0 => (height, width, 3),
        _ => return Err(option(name, format!("an array of the shape {shape:?}"), expected)),
    };
    fn texels<T: Copy>(samples: &[T], channels: usize) -> impl Iterator<Item = [T; 3]> {
        samples.chunks_exact(channels).map(|texel| [0, 1, 2].map(|c| texel[c.min(texel.len() - 1)]))
    }
    let pixels = match content {
        Content::Bytes(bytes) => of_bytes(texels(&bytes, channels).map(|[r, g, b]| [r, g, b, 255]).collect()),
        Content::Floats(floats) => Pixels::Float(texels(&floats, channels).collect()),
    };
    let side = |n: usize| u32::try_from(n).map_err(|_| option(name, n, "at most 4294967295 texels a side"));
    Ok(Image { name: name.to_owned(), width: side(width)?, height: side(height)?, pixels })
}

/// Adds paints to a scene, each image once.
pub struct Palette<'b> {
    builder: &'b mut SceneBuilder,
    /// Textures by the address of their image.
    known: BTreeMap<usize, TextureId>,
}

impl<'b> Palette<'b> {
    /// Palette that adds to the scene of `builder`.
    pub fn new(builder: &'b mut SceneBuilder) -> Self {
        Self { builder, known: BTreeMap::new() }
    }

    /// The scene that paints are added to.
    pub fn builder(&mut self) -> &mut SceneBuilder {
        self.builder
    }

    /// Adds a material, and its images.
    pub fn add(&mut self, name: &str, material: &Material) -> Result<MaterialId> {
        let surface = (material.surface)(self)?;
        let emission = match &material.emission {
            Some((radiance, two_sided)) => {
                Some(Emission { radiance: self.color(radiance)?, two_sided: *two_sided })
            }
            None => None,
        };
        self.builder.add_material(scene::Material { emission, ..scene::Material::new(name, surface) })
    }

    fn color(&mut self, paint: &Paint) -> Result<ColorInput> {
        Ok(match paint {
            Paint::Flat(color) => (*color).into(),
            Paint::Image(image) => ColorInput { factor: Rgb::WHITE, texture: Some(self.texture(image)?) },
        })
    }

    fn number(&mut self, paint: &Paint) -> Result<FloatInput> {
        Ok(match paint {
            Paint::Flat(color) => color.r.into(),
            Paint::Image(image) => {
                FloatInput { factor: 1.0, texture: Some((self.texture(image)?, Channel::R)) }
            }
        })
    }

    fn texture(&mut self, image: &Arc<Image>) -> Result<TextureId> {
        let address = Arc::as_ptr(image).addr();
        if let Some(known) = self.known.get(&address) {
            return Ok(*known);
        }
        let id = self.builder.add_image(Image::clone(image))?;
        let texture = self.builder.add_texture(Texture::Image(ImageTexture::new(id)))?;
        self.known.insert(address, texture);
        Ok(texture)
    }
}

/// Makes a surface, adding its images to a scene.
type Recipe = Arc<dyn Fn(&mut Palette<'_>) -> Result<Surface> + Send + Sync>;

/// Material of a mesh, made by `Material.diffuse` and the like.
///
/// Colours are linear Rec. 709: one number for gray, three numbers, or an image. An image is an
/// array of shape (height, width, 3), or (height, width) for gray; it repeats, and is read at the
/// texture coordinates of the mesh. Arrays of `uint8` are read as sRGB, as pictures are stored,
/// others as linear. Roughness may be an array of shape (height, width) too. Arrays are copied.
///
/// ```python
/// >>> tashika.Material.diffuse(0.8), tashika.Material.diffuse(0).emitting((5, 5, 4))
/// (<tashika.Material lambert>, <tashika.Material lambert, emitting>)
/// >>> import numpy as np
/// >>> tashika.Material.conductor((0.9, 0.7, 0.3), alpha=np.linspace(0.1, 0.4, 256)[None, :])
/// <tashika.Material conductor>
/// ```
#[pyclass(frozen, module = "tashika")]
#[derive(Clone)]
pub struct Material {
    kind: &'static str,
    surface: Recipe,
    /// Emitted radiance, and true if both sides emit it.
    emission: Option<(Paint, bool)>,
}

impl Material {
    fn of(
        kind: &'static str,
        surface: impl Fn(&mut Palette<'_>) -> Result<Surface> + Send + Sync + 'static,
    ) -> Self {
        Self { kind, surface: Arc::new(surface), emission: None }
    }
}

#[pymethods]
impl Material {
    /// Ideal diffuse (Lambertian) reflection; `reflectance` is from 0 to 1.
    #[staticmethod]
    fn diffuse(reflectance: &Bound<'_, PyAny>) -> PyResult<Self> {
        let reflectance = Paint::color("reflectance", reflectance)?;
        Ok(Self::of("lambert", move |palette| {
            Ok(Surface::Lambert { reflectance: palette.color(&reflectance)? })
        }))
    }

    /// Diffuse plus a modified Phong lobe of that exponent around the mirror direction.
    #[staticmethod]
    fn phong(diffuse: &Bound<'_, PyAny>, specular: &Bound<'_, PyAny>, exponent: f32) -> PyResult<Self> {
        let (diffuse, specular) = (Paint::color("diffuse", diffuse)?, Paint::color("specular", specular)?);
        Ok(Self::of("phong", move |palette| {
            let (diffuse, specular) = (palette.color(&diffuse)?, palette.color(&specular)?);
            Ok(Surface::Phong { diffuse, specular, exponent })
        }))
    }

    /// Metal with GGX microfacets of roughness `alpha` (0: smooth). `f0` is the reflectance at
    /// normal incidence, a constant colour.
    #[staticmethod]
    fn conductor(f0: Color, alpha: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (f0, alpha) = (f0.into(), Paint::number("alpha", alpha)?);
        Ok(Self::of("conductor", move |palette| {
            Ok(Surface::Conductor {
                fresnel: ConductorFresnel::Schlick { f0 },
                specular: Rgb::WHITE.into(),
                facets: palette.number(&alpha)?.into(),
            })
        }))
    }

    /// A dielectric coat of refractive index `ior` and GGX roughness `alpha` (0: smooth; default:
    /// 0.1) over a diffuse base.
    #[staticmethod]
    #[pyo3(signature = (reflectance, *, ior=1.5, alpha=None))]
    fn coated(reflectance: &Bound<'_, PyAny>, ior: f32, alpha: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let reflectance = Paint::color("reflectance", reflectance)?;
        let rough = Paint::Flat(Rgb::gray(0.1));
        let alpha = alpha.map_or(Ok(rough), |alpha| Paint::number("alpha", alpha))?;
        Ok(Self::of("coated", move |palette| {
            Ok(Surface::Coated {
                reflectance: palette.color(&reflectance)?,
                base: CoatBase::default(),
                specular: Rgb::WHITE.into(),
                ior,
                facets: palette.number(&alpha)?.into(),
            })
        }))
    }

    /// Perfect mirror; `reflectance` is from 0 to 1.
    #[staticmethod]
    fn mirror(reflectance: &Bound<'_, PyAny>) -> PyResult<Self> {
        let reflectance = Paint::color("reflectance", reflectance)?;
        Ok(Self::of("mirror", move |palette| {
            Ok(Surface::Mirror { reflectance: palette.color(&reflectance)? })
        }))
    }

    /// Smooth solid glass of refractive index `ior`, without absorption.
    #[staticmethod]
    #[pyo3(signature = (*, ior=1.5))]
    fn glass(ior: f32) -> Self {
        Self::of("glass", move |_| {
            Ok(Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() })
        })
    }

    /// The boundary of a medium and nothing else: light passes unchanged.
    #[staticmethod]
    fn boundary() -> Self {
        Self::of("boundary", |_| Ok(Surface::Boundary))
    }

    /// This material, emitting the given radiance (W/m²/sr), a colour, on the side from which its
    /// triangles run counter-clockwise, or on both sides.
    #[pyo3(signature = (radiance, *, two_sided=false))]
    fn emitting(&self, radiance: &Bound<'_, PyAny>, two_sided: bool) -> PyResult<Self> {
        let radiance = Paint::color("radiance", radiance)?;
        Ok(Self { emission: Some((radiance, two_sided)), ..self.clone() })
    }

    fn __repr__(&self) -> String {
        let emits = if self.emission.is_some() { ", emitting" } else { "" };
        format!("<tashika.Material {}{emits}>", self.kind)
    }
}
