//! Materials of the room.
//!
//! Reflectances are at most 0.8, so that paths end and no surface is whiter than paint.

use crate::bsdf::ConductorFresnel;
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::builtin::stage::Stage;
use crate::scene::{CoatBase, ColorInput, MaterialId, Surface, TextureId};

/// Refractive index of varnish and plastic.
const COAT_IOR: f32 = 1.5;

/// Materials that several objects share.
pub struct Palette {
    /// Grain of all wooden surfaces; multiplies their colour.
    pub grain: TextureId,
    /// Matte paint of three walls.
    pub wall: MaterialId,
    /// Matte paint of the coloured wall.
    pub accent: MaterialId,
    /// Matte white of the ceiling.
    pub ceiling: MaterialId,
    /// Painted wood: window, skirting, shelves.
    pub paint: MaterialId,
    /// Dark varnished wood.
    pub walnut: MaterialId,
    /// Light oiled wood.
    pub ash: MaterialId,
    /// Rough brass: frames, rods, handles.
    pub brass: MaterialId,
    /// Black lacquer with a sharp lobe.
    pub black: MaterialId,
    /// White porcelain: cups, bowl, radio.
    pub porcelain: MaterialId,
    /// Paper of books and pictures.
    pub paper: MaterialId,
}

impl Palette {
    /// Adds the shared materials to a scene.
    pub fn new(stage: &mut Stage, grain: TextureId) -> Result<Self> {
        Ok(Self {
            grain,
            wall: stage.material("wall", matte(Rgb::new(0.70, 0.67, 0.61)))?,
            accent: stage.material("accent wall", matte(Rgb::new(0.56, 0.20, 0.11)))?,
            ceiling: stage.material("ceiling", matte(Rgb::gray(0.78)))?,
            paint: stage.material("paint", glossy(Rgb::new(0.70, 0.69, 0.66), 0.06, 60.0))?,
            walnut: stage.material("walnut", varnished(Rgb::new(0.30, 0.16, 0.09), grain, 0.12))?,
            ash: stage.material("ash", varnished(Rgb::new(0.72, 0.52, 0.33), grain, 0.25))?,
            brass: stage.material("brass", metal(BRASS, 0.18))?,
            black: stage.material("black lacquer", glossy(Rgb::gray(0.02), 0.25, 300.0))?,
            porcelain: stage.material("porcelain", coated(Rgb::new(0.74, 0.73, 0.70), 0.05))?,
            paper: stage.material("paper", matte(Rgb::new(0.74, 0.70, 0.60)))?,
        })
    }
}

/// Reflectance of brass at normal incidence; a value common in graphics, not measured.
const BRASS: ConductorFresnel = ConductorFresnel::Schlick { f0: Rgb::new(0.80, 0.62, 0.33) };

/// Gold: `η` and `k` at wavelengths near those of the sRGB primaries (about 0.61, 0.55 and 0.46
/// µm), rounded from Johnson, Christy 1972, Phys. Rev. B 6, 4370.
pub const GOLD: ConductorFresnel =
    ConductorFresnel::Exact { eta: Rgb::new(0.21, 0.42, 1.36), k: Rgb::new(3.27, 2.35, 1.85) };

/// Creates an ideal diffuse surface.
pub fn matte(color: impl Into<ColorInput>) -> Surface {
    Surface::Lambert { reflectance: color.into() }
}

/// Creates a diffuse surface with a Phong lobe that reflects the share `specular` of all colours.
pub fn glossy(color: impl Into<ColorInput>, specular: f32, exponent: f32) -> Surface {
    Surface::Phong { diffuse: color.into(), specular: Rgb::gray(specular).into(), exponent }
}

/// Creates a diffuse surface under a dielectric coat of GGX roughness `alpha`.
pub fn coated(color: impl Into<ColorInput>, alpha: f32) -> Surface {
    Surface::Coated {
        reflectance: color.into(),
        base: CoatBase::Saturating,
        specular: Rgb::WHITE.into(),
        ior: COAT_IOR,
        facets: alpha.into(),
    }
}

/// Creates coloured wood under varnish of GGX roughness `alpha`.
pub fn varnished(color: Rgb, grain: TextureId, alpha: f32) -> Surface {
    coated(tinted(color, grain), alpha)
}

/// Creates rough metal of GGX roughness `alpha`.
pub fn metal(fresnel: ConductorFresnel, alpha: f32) -> Surface {
    Surface::Conductor { fresnel, specular: Rgb::WHITE.into(), facets: alpha.into() }
}

/// Multiplies a texture by a colour.
pub fn tinted(factor: Rgb, texture: TextureId) -> ColorInput {
    ColorInput { factor, texture: Some(texture) }
}
