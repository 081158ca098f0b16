//! Models of surfaces: the functions that each BSDF has, and the table that makes them a family.
//!
//! A new model is a file with an implementation of [`Model`], a row of the table in `bsdf`, and an
//! upper bound in `bounds::lobes` of the crate `tashika-core`, on which cuts and certificates rely.
//!
//! # Held to this by
//! `bsdf::tests`.

use super::{BsdfSample, Lobe, MIN_COSINE};
use crate::color::Rgb;
use crate::math::{Real, Vec3};

/// The scattering of one kind of surface, in the frame of its shading normal.
///
/// In `eval`, `pdf` and `draw`, all directions are above the horizon. A model either has lobes of
/// finite width, by these three, or implements `sample` alone and [is specular](Self::IS_SPECULAR).
pub(super) trait Model {
    /// True if all lobes are specular; rough glass counts as specular.
    const IS_SPECULAR: bool = false;

    /// `f_r(ω_o, ω_i)` (sr⁻¹), for one or several directions `wi`.
    #[inline(always)]
    fn eval<R: Real>(&self, _wo: Vec3, _wi: [R; 3]) -> [R; 3] {
        [R::splat(0.0); 3]
    }

    /// Density with which `draw` returns `wi` (sr⁻¹).
    #[inline]
    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    /// Draws a direction and its lobe; `None` if the surface is black.
    ///
    /// * `u`: uniform in `[0, 1)³`; `u[0]` chooses the lobe, the others the direction.
    fn draw(&self, _wo: Vec3, _u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        None
    }

    /// Draws a direction with its weight, for `wo` on either side; `None` if the path ends.
    #[inline]
    fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let side = 1.0_f32.copysign(wo.z);
        let up = Vec3::new(wo.x, wo.y, wo.z * side);
        let (wi, lobe) = self.draw(up, u)?;
        if wi.z <= MIN_COSINE {
            return None;
        }
        let pdf = self.pdf(up, wi);
        if pdf <= 0.0 {
            return None;
        }
        let weight = Rgb::from(self.eval(up, wi.to_array())) * (wi.z / pdf);
        let wi = Vec3::new(wi.x, wi.y, wi.z * side);
        Some(BsdfSample { wi, weight, pdf, lobe })
    }

    /// Directional albedo of the diffuse part (unitless), for `wo` on either side.
    fn vpl_reflectance(&self, _wo: Vec3) -> Rgb {
        Rgb::BLACK
    }

    /// Multiplies the diffuse part, if there is one.
    fn scale_diffuse(&mut self, _factor: f32) {}

    /// Estimate of the share of uniform illumination that the glossy lobes reflect along `wo`.
    fn importance_gloss(&self, _wo: Vec3) -> f32 {
        self.albedo().map(|a| a.min(1.0)).max_channel()
    }

    /// GGX roughness `α` of the narrowest lobe; `None` if no lobe has a finite width.
    fn roughness(&self) -> Option<f32> {
        None
    }

    /// Approximate overall reflectance, 0 or more.
    fn albedo(&self) -> Rgb;

    /// Checks that all parameters are in range.
    fn validate(&self) -> Result<(), String>;
}

/// Makes the enum [`Bsdf`](super::Bsdf) of a list of models, and the functions that each model
/// implements for itself.
macro_rules! family {
    ($($(#[$doc:meta])* $model:ident,)+) => {
        /// Scattering of light at a surface.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Bsdf {
            $($(#[$doc])* $model($model),)+
        }

        impl Bsdf {
            /// [`Bsdf::eval`] for two directions above the horizon.
            #[inline(always)]
            fn eval_above<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
                match self {
                    $(Self::$model(model) => model.eval(wo, wi),)+
                }
            }

            /// [`Bsdf::pdf`] for two directions above the horizon.
            #[inline]
            fn pdf_above(&self, wo: Vec3, wi: Vec3) -> f32 {
                match self {
                    $(Self::$model(model) => model.pdf(wo, wi),)+
                }
            }

            /// [`Bsdf::sample`] for a direction that does not lie in the surface.
            #[inline]
            fn sample_model(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
                match self {
                    $(Self::$model(model) => model.sample(wo, u),)+
                }
            }

            /// Returns true if the BSDF has specular lobes only; rough glass counts as specular.
            pub fn is_specular(&self) -> bool {
                match self {
                    $(Self::$model(_) => $model::IS_SPECULAR,)+
                }
            }

            /// `ρ(ω_o) = ∫ f_d cos θ_i dω_i`, the directional albedo (unitless) of the diffuse part
            /// `f_d`.
            ///
            /// Light of flux `Φ` that arrives from `wo` is represented by a virtual point light
            /// whose intensity along the normal is `Φ ρ / π`. Zero for surfaces without a diffuse
            /// part.
            pub fn vpl_reflectance(&self, wo: Vec3) -> Rgb {
                match self {
                    $(Self::$model(model) => model.vpl_reflectance(wo),)+
                }
            }

            fn scale_diffuse(&mut self, factor: f32) {
                match self {
                    $(Self::$model(model) => model.scale_diffuse(factor),)+
                }
            }

            /// Estimate of the share of uniform illumination that the glossy lobes reflect along
            /// `ω_o`.
            pub fn importance_gloss(&self, wo: Vec3) -> f32 {
                match self {
                    $(Self::$model(model) => model.importance_gloss(wo),)+
                }
            }

            /// GGX roughness `α` of the narrowest lobe; the geometric mean for brushed facets. A
            /// Phong lobe of exponent `n` counts as `√(2/(n + 2))` (Walter et al. 2007). `None` if
            /// the BSDF has no lobe of finite width.
            pub fn roughness(&self) -> Option<f32> {
                match self {
                    $(Self::$model(model) => model.roughness(),)+
                }
            }

            /// Approximate overall reflectance, each channel in `[0, 1]`, for the albedo image of a
            /// denoiser.
            ///
            /// This is the albedo of a smooth surface of the same kind at normal incidence; for
            /// [`Glass`], reflection and transmission together.
            pub fn albedo(&self) -> Rgb {
                match self {
                    $(Self::$model(model) => model.albedo(),)+
                }
                .map(|a| a.min(1.0))
            }

            /// Checks that all parameters are in range; the error names the parameter, its value,
            /// and the range.
            pub fn validate(&self) -> Result<(), String> {
                match self {
                    $(Self::$model(model) => model.validate(),)+
                }
            }
        }
    };
}

pub(super) use family;
