//! Layers over an opaque surface: sheen, and a clear coat over that.
//!
//! ```text
//! f_r = l_c (l_s f_base + f_s) + f_c          (sr⁻¹)
//! ```
//!
//! with the [`Sheen`] `f_s` and the [`Clearcoat`] `f_c`. Each layer multiplies everything below it
//! by a factor, `l_s` and `l_c`, which depends on the cosine at which the surface is *seen*. Layers
//! with a factor below 1 are not reciprocal: light paths, too, evaluate them with the cosine of the
//! direction towards the viewer.
//!
//! # Limits
//! A VPL represents the diffuse part under a layer with the layer's factor at the cosine of the
//! arriving light, not at that of the viewer.
//!
//! # Held to this by
//! `bsdf::tests`, and the suite's `mitsuba_materials` and `formula_materials`.

use super::{
    Bsdf, Clearcoat, Lambert, Lobe, MetallicRoughness, Model, Principled, Sheen, glossy_probability,
};
use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};

/// An opaque surface with layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    /// Surface below all layers.
    pub base: UnderLayers,
    /// Fibres on the base.
    pub sheen: Sheen,
    /// Coat over base and fibres.
    pub coat: Clearcoat,
}

/// A surface that can have layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnderLayers {
    /// Ideal diffuse reflection.
    Lambert(Lambert),
    /// The core material of glTF 2.0.
    MetallicRoughness(MetallicRoughness),
    /// The principled material of Disney.
    Principled(Principled),
}

impl From<UnderLayers> for Bsdf {
    fn from(base: UnderLayers) -> Self {
        match base {
            UnderLayers::Lambert(b) => Self::Lambert(b),
            UnderLayers::MetallicRoughness(b) => Self::MetallicRoughness(b),
            UnderLayers::Principled(b) => Self::Principled(b),
        }
    }
}

impl UnderLayers {
    /// Returns the surface as one that can have layers; `None` if it cannot.
    pub fn of(bsdf: &Bsdf) -> Option<Self> {
        match *bsdf {
            Bsdf::Lambert(b) => Some(Self::Lambert(b)),
            Bsdf::MetallicRoughness(b) => Some(Self::MetallicRoughness(b)),
            Bsdf::Principled(b) => Some(Self::Principled(b)),
            _ => None,
        }
    }

    fn scale_diffuse(&mut self, factor: f32) {
        match self {
            Self::Lambert(b) => b.scale_diffuse(factor),
            Self::MetallicRoughness(b) => b.scale_diffuse(factor),
            Self::Principled(b) => b.scale_diffuse(factor),
        }
    }

    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        match self {
            Self::Lambert(b) => b.eval(wo, wi),
            Self::MetallicRoughness(b) => b.eval(wo, wi),
            Self::Principled(b) => b.eval(wo, wi),
        }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Lambert(b) => b.pdf(wo, wi),
            Self::MetallicRoughness(b) => b.pdf(wo, wi),
            Self::Principled(b) => b.pdf(wo, wi),
        }
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        match self {
            Self::Lambert(b) => b.draw(wo, u),
            Self::MetallicRoughness(b) => b.draw(wo, u),
            Self::Principled(b) => b.draw(wo, u),
        }
    }
}

impl Model for Layered {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let mut below = self.base.eval(wo, wi);
        if self.sheen.is_there() {
            let (left, white) = (R::splat(self.sheen.left(wo.z)), self.sheen.white(wo, wi));
            let color = self.sheen.color.to_array();
            below = each!(|channel| left * below[channel] + R::splat(color[channel]) * white);
        }
        if self.coat.amount == 0.0 {
            return below;
        }
        let (left, coat) = (R::splat(self.coat.left(wo.z)), self.coat.eval(wo, wi));
        each!(|channel| left * below[channel] + coat)
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let [coat, sheen] = self.probabilities(wo);
        let mut below = self.base.pdf(wo, wi);
        if sheen > 0.0 {
            below = (1.0 - sheen) * below + sheen * Sheen::PDF;
        }
        (1.0 - coat) * below + coat * self.coat.pdf(wo, wi)
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        let [coat, sheen] = self.probabilities(wo);
        let direction = [u[1], u[2]];
        if u[0] < coat {
            return Some((self.coat.draw(wo, direction), Lobe::Glossy));
        }
        let u = rest(u[0], coat);
        if u < sheen {
            return Some((Sheen::draw(direction), Lobe::Glossy));
        }
        self.base.draw(wo, [rest(u, sheen), direction[0], direction[1]])
    }

    /// Albedo of the diffuse part for light at cosine `|ω_o.z|`.
    fn vpl_reflectance(&self, wo: Vec3) -> Rgb {
        Bsdf::from(self.base).vpl_reflectance(wo) * self.left(wo.z.abs())
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.base.scale_diffuse(factor);
    }

    /// Estimate of the albedo of all parts that are not in the diffuse part.
    fn importance_gloss(&self, wo: Vec3) -> f32 {
        let cos_o = wo.z.abs();
        let fibres = self.sheen.albedo(cos_o).max_channel() * self.coat.left(cos_o);
        Bsdf::from(self.base).importance_gloss(wo) * self.left(cos_o) + fibres + self.coat.importance(cos_o)
    }

    /// Roughness of the narrowest lobe.
    fn roughness(&self) -> Option<f32> {
        let coat = (self.coat.amount > 0.0).then_some(self.coat.alpha);
        let sheen = self.sheen.is_there().then_some(self.sheen.roughness);
        Bsdf::from(self.base).roughness().into_iter().chain(coat).chain(sheen).reduce(f32::min)
    }

    fn albedo(&self) -> Rgb {
        let below = Bsdf::from(self.base).albedo() * self.sheen.left(1.0) + self.sheen.albedo(1.0);
        below * self.coat.left(1.0) + Rgb::gray(self.coat.importance(1.0))
    }

    fn validate(&self) -> Result<(), String> {
        self.sheen.validate()?;
        self.coat.validate()?;
        Bsdf::from(self.base).validate()
    }
}

impl Layered {
    /// Returns the surface as a layered one: with its own layers, or, if it has none, with empty
    /// layers. `None` if the surface cannot have layers.
    pub fn over(bsdf: &Bsdf) -> Option<Self> {
        match *bsdf {
            Bsdf::Layered(b) => Some(b),
            _ => UnderLayers::of(bsdf).map(|base| Self { base, sheen: Sheen::NONE, coat: Clearcoat::NONE }),
        }
    }

    /// Factor on the base, seen at the cosine `cos_o`.
    #[inline]
    pub fn left(&self, cos_o: f32) -> f32 {
        self.sheen.left(cos_o) * self.coat.left(cos_o)
    }

    /// Probability of drawing from the coat, and, if the coat is not drawn, of drawing from the
    /// sheen.
    fn probabilities(&self, wo: Vec3) -> [f32; 2] {
        let base = Bsdf::from(self.base);
        let base = base.vpl_reflectance(wo).max_channel() + base.importance_gloss(wo);
        let (base, fibres) = (base * self.sheen.left(wo.z), self.sheen.albedo(wo.z).max_channel());
        let below = (base + fibres) * self.coat.left(wo.z);
        [(self.coat.importance(wo.z), below), (fibres, base)]
            .map(|(layer, below)| glossy_probability(layer, below).unwrap_or(0.0))
    }
}

/// Maps a number `u`, uniform in `[below, 1)`, to `[0, 1)`, so that it can be used again.
fn rest(u: f32, below: f32) -> f32 {
    ((u - below) / (1.0 - below)).min(1.0 - f32::EPSILON / 2.0)
}
