//! Paths of the neighbourhood, followed before a pixel begins.
//!
//! A hundred paths of a pixel may all miss the bright one in a thousand; those of its neighbours
//! together do not. The image is divided into cells ([`Grid`]). For each [`Estimator`], [`PATHS`]
//! paths of random pixels of the cell are followed, which no estimate uses. Paths from points that
//! mirror sharply are kept apart from others: a glossy pixel among matt ones is as noisy as other
//! glossy pixels.
//!
//! # Independence
//! Pixels and paths come from streams of their own ([`Purpose::Guidance`]); a cell is a function of
//! the image and its place.

use std::sync::OnceLock;

use super::super::ControlOptions;
use super::estimate::{Common, Estimator, is_near_specular, summed_with};
use crate::compensation::{Caustic, Compensation};
use crate::guidance::{Grid, cell_of, key_of, pixels_of, random_pixel};
use crate::rng::{self, Purpose, Stream};
use crate::stats::{Moments, student_t_two_sided};

/// Number of paths of a cell, for each estimator.
pub(super) const PATHS: u64 = 1024;
/// Fewest paths of a kind whose moments are used.
const FEWEST: u64 = 64;

/// Paths of one estimator from the pixels of a cell.
#[derive(Clone, Debug, Default)]
struct Paths {
    /// Moments of single paths, by part of the error metric: from points that do not mirror
    /// sharply, from those that do, and from all.
    moments: [Vec<Moments>; 3],
    /// Caustic light that single paths found (luminance).
    found: Moments,
    /// Mean expected caustic light, at the first surface and beyond (luminance).
    expected: [f64; 2],
    /// Approximate lower bound on the mean luminance at the first surfaces, from light paths.
    by_light_paths: f64,
    /// True if a camera sample met emission.
    sees_emission: bool,
    /// Number of paths that began at a surface.
    met: u64,
    rays: u64,
}

/// Share of the expected caustic light below which paths are taken to miss it.
pub(super) const MIN_SAMPLED_SHARE: f64 = 0.5;

/// Rays of full paths that take as long as the smallest sum over VPLs: some hundred pairs over the
/// gather points, with their bounds and lists. Measured.
const SMALLEST_SUM_IN_RAYS: f64 = 8192.0;

/// Paths of a cell, for one clamp distance.
#[derive(Debug)]
pub(super) struct Nearby {
    place: [u32; 2],
    key: u64,
    compensation: Paths,
    /// Full paths, followed when a pixel first needs them.
    whole: OnceLock<Paths>,
}

impl Nearby {
    /// Moments of compensation paths, from points of the same kind if there are enough of them:
    /// those that mirror sharply, or those that do not.
    pub(super) fn compensation(&self, is_near_specular: bool) -> &[Moments] {
        let [matt, glossy, all] = &self.compensation.moments;
        let of_kind = if is_near_specular { glossy } else { matt };
        if of_kind.first().is_some_and(|moments| moments.count() >= FEWEST) { of_kind } else { all }
    }

    /// Unsampled caustic light: its share of all caustic light, and the caustic light expected
    /// beyond the first surface (luminance, W·m⁻²·sr⁻¹); none if paths find it.
    pub(super) fn not_found(&self) -> Option<(f64, f64)> {
        let Paths { found, expected, .. } = &self.compensation;
        let there: f64 = expected.iter().sum();
        let most_found = found.mean() + 2.0 * found.standard_error();
        (most_found < MIN_SAMPLED_SHARE * there).then(|| (1.0 - found.mean() / there, expected[1]))
    }

    /// Returns true if full paths found much less light than light paths did.
    pub(super) fn is_light_undersampled(&self, common: &Common<'_>) -> bool {
        let whole = self.paths_of_all(common);
        let most_found = |of_path: &Moments| of_path.mean() + 2.0 * of_path.standard_error();
        whole.moments[2]
            .first()
            .is_some_and(|of_path| most_found(of_path) < MIN_SAMPLED_SHARE * whole.by_light_paths)
    }

    /// Returns true if the camera sees emission here, directly or over specular surfaces.
    pub(super) fn sees_emission(&self) -> bool {
        self.compensation.sees_emission
    }

    /// Moments of full paths, by part of the error metric.
    pub(super) fn whole(&self, common: &Common<'_>) -> &[Moments] {
        &self.paths_of_all(common).moments[2]
    }

    /// Returns true if full paths have less variance than compensation paths for the same rays:
    /// then VPLs are of no use. Full paths that found no light decide nothing, as VPLs may carry
    /// light that paths rarely find.
    pub(super) fn are_vpls_in_vain(&self, common: &Common<'_>) -> bool {
        let for_a_ray = |paths: &Paths| {
            paths.moments[2].first().map_or(0.0, |of_path| of_path.variance() * paths.rays as f64)
        };
        let [whole, compensation] = [self.paths_of_all(common), &self.compensation].map(for_a_ray);
        whole > 0.0 && whole < compensation
    }

    /// Returns true if full paths are predicted to meet the tolerance with less work than any sum
    /// over VPLs takes, as where light comes straight from the sky. Where paths vary so little,
    /// those of the neighbourhood give the mean luminance to a few per cent.
    pub(super) fn are_full_paths_cheaper(&self, common: &Common<'_>, options: &ControlOptions) -> bool {
        let whole = self.paths_of_all(common);
        let Some(of_path) = whole.moments[2].first().filter(|of_path| of_path.mean() > 0.0) else {
            return false;
        };
        let tolerance = options.tolerance_of(of_path.mean());
        let errors = student_t_two_sided(options.confidence, PATHS as f64 - 1.0);
        let paths = of_path.variance() * (errors / tolerance) * (errors / tolerance);
        paths * whole.rays as f64 / (PATHS as f64) < SMALLEST_SUM_IN_RAYS
    }

    /// Returns true if any camera sample here met no surface.
    pub(super) fn has_missed_samples(&self) -> bool {
        self.compensation.met < PATHS
    }

    /// Approximate luminance of the surfaces here (W·m⁻²·sr⁻¹); zero if no path began at one.
    pub(super) fn importance_brightness(&self, common: &Common<'_>) -> f64 {
        let whole = self.paths_of_all(common);
        let mean = whole.moments[2].first().map_or(0.0, Moments::mean);
        if whole.met == 0 { 0.0 } else { mean * PATHS as f64 / whole.met as f64 }
    }

    fn paths_of_all(&self, common: &Common<'_>) -> &Paths {
        self.whole.get_or_init(|| follow(Estimator::Paths, self.place, common, 0.0, self.key))
    }

    /// Rays of the cell's paths by an estimator, divided among its pixels.
    pub(super) fn rays_per_pixel(&self, estimator: Estimator) -> u64 {
        let rays = match estimator {
            Estimator::Vpls => self.compensation.rays,
            Estimator::Paths => self.whole.get().map_or(0, |paths| paths.rays),
        };
        rays.div_ceil(u64::from(Cells::SIDE * Cells::SIDE))
    }
}

/// The cells of an image, each with its paths.
pub(super) type Cells = Grid<Nearby>;

/// Returns the paths of the cell of a pixel, for one clamp distance.
pub(super) fn about<'c>(
    cells: &'c Cells,
    pixel: [u32; 2],
    common: &Common<'_>,
    clamp_distance: f32,
    seed: u64,
) -> &'c Nearby {
    let place = cell_of(pixel);
    cells.at(place, || {
        let key = key_of(place, seed);
        let compensation = follow(Estimator::Vpls, place, common, clamp_distance, key);
        Nearby { place, key, compensation, whole: OnceLock::new() }
    })
}

fn follow(
    estimator: Estimator,
    place: [u32; 2],
    common: &Common<'_>,
    clamp_distance: f32,
    key: u64,
) -> Paths {
    let window = pixels_of(place, common.setting.view.size);
    let key = rng::key(key, Purpose::Guidance, 1 + estimator as u64);
    let mut stream = Stream::new(key, Purpose::Guidance, 0);
    let parts = common.controlled.parts();
    let mut compensation = Compensation::new(common.lit(estimator, clamp_distance));
    let mut found = Moments::default();
    let mut expected = [0.0; 2];
    let mut by_light_paths = 0.0;
    let mut sees_emission = false;
    let mut met = 0;
    let mut moments = [(); 3].map(|()| vec![Moments::default(); parts.len()]);
    for path in 0..PATHS {
        let pixel = random_pixel(&window, &mut stream);
        let key = rng::key(key, Purpose::Guidance, path);
        let seen = common.samples(pixel, 1, key);
        sees_emission |= !seen.background.is_black();
        met += u64::from(!seen.points.is_empty());
        let mut value = if estimator == Estimator::Paths { seen.background } else { Default::default() };
        let (mut kind, mut of_path) = (0, Caustic::default());
        for point in &seen.points {
            let summed = summed_with(point, estimator);
            value +=
                compensation.estimate(point, &summed, key, &mut Stream::new(key, Purpose::Compensation, 0));
            kind = usize::from(is_near_specular(&point.bsdf));
            of_path = compensation.caustic();
        }
        if estimator == Estimator::Paths {
            by_light_paths += common.by_light_paths(&seen) / PATHS as f64;
        }
        found.push(of_path.found);
        expected = [0, 1].map(|k| expected[k] + of_path.expected[k] / PATHS as f64);
        for (number, part) in parts.iter().enumerate() {
            moments[kind][number].push(part.of(value));
            moments[2][number].push(part.of(value));
        }
    }
    Paths { moments, found, expected, by_light_paths, sees_emission, met, rays: PATHS + compensation.rays() }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::super::{Setting, Truth};
    use super::super::GuidedLights;
    use super::*;
    use crate::accel::Tracer;
    use crate::color::{Controlled, Rgb};
    use crate::error::Location;
    use crate::gather::{GatherOptions, View};
    use crate::math::{Affine3A, Vec3};
    use crate::scene::{Camera, Emission, Material, MeshData, SceneBuilder, Surface};
    use crate::vpl::{EmitterSampler, VplOptions};

    /// Calls `look` for a cell of the image that sees a tile on a matt floor below a lamp.
    fn look_at_tile(surface: Surface, look: impl Fn(&Nearby, &Common<'_>)) {
        let mut b = SceneBuilder::new("test", Location::default());
        let mut place = |corner: Vec3, side: f32, material: Material| {
            let positions = [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X];
            let positions = positions.map(|p| corner + side * p).to_vec();
            let data = MeshData { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshData::default() };
            let material = b.add_material(material).unwrap();
            let mesh = b.add_mesh(data, material).unwrap();
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        };
        let matt = |reflectance: f32| Surface::Lambert { reflectance: Rgb::gray(reflectance).into() };
        place(Vec3::new(-5.0, 0.0, -5.0), 10.0, Material::new("floor", matt(0.5)));
        place(Vec3::new(-0.3, 0.01, -0.3), 0.6, Material::new("tile", surface));
        let emission = Some(Emission { radiance: Rgb::gray(50.0).into(), two_sided: true });
        let lamp = Material { emission, ..Material::new("lamp", matt(0.0)) };
        place(Vec3::new(-0.4, 2.0, -0.9), 0.3, lamp);
        let (eye, target) = (Vec3::new(0.0, 2.0, 1.0), Vec3::ZERO);
        b.add_camera(Camera::look_at("main", eye, target, Vec3::Y, 0.5)).unwrap();
        let tracer = Tracer::new(Arc::new(b.build().unwrap()));
        let gather = GatherOptions { points: 16, ..GatherOptions::default() };
        let scene = tracer.scene().clone();
        let view = View { camera: &scene.cameras()[0], size: [Cells::SIDE; 2], gather, seed: 1 };
        let options = VplOptions { count: 10_000, ..VplOptions::default() };
        let lights = GuidedLights::trace(&tracer, &options, Truth::Transport, &view).unwrap();
        let setting = Setting { tracer: &tracer, view };
        let emitters = EmitterSampler::by_use(&tracer, lights.options());
        let controlled = Controlled::default();
        let common =
            Common { setting: &setting, emitters: &emitters, lights: &lights, compensates: true, controlled };
        let cells = Cells::new(view.size);
        let nearby = about(&cells, [3, 5], &common, 0.02, 7);
        look(nearby, &common);
    }

    fn gloss() -> Surface {
        Surface::Plastic {
            diffuse: Rgb::gray(0.1).into(),
            specular: Rgb::WHITE.into(),
            ior: 1.5,
            facets: 0.05.into(),
        }
    }

    /// A glossy tile on a matt floor: the paths of each have moments of their own.
    #[test]
    fn glossy_pixels_are_told_of_glossy_paths() {
        look_at_tile(gloss(), |nearby, _| {
            let [glossy, matt] =
                [true, false].map(|is_near_specular| nearby.compensation(is_near_specular)[0]);
            assert!(glossy.count() >= FEWEST && matt.count() >= FEWEST);
            assert_eq!(glossy.count() + matt.count(), PATHS, "all see the floor");
            let [glossy, matt] = [glossy, matt].map(|moments| moments.variance());
            assert!(glossy > 20.0 * matt, "{glossy} of paths from the tile, {matt} of those from the floor");
        });
    }

    /// Light is unmet where light paths find twice the light that paths of the neighbourhood find,
    /// by the upper end of its interval, and not where they find as much.
    #[test]
    fn light_that_only_light_paths_find_is_unmet() {
        let matt = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        look_at_tile(matt, |nearby, common| {
            assert!(!nearby.is_light_undersampled(common));
            let found = nearby.whole(common)[0];
            let most = found.mean() + 2.0 * found.standard_error();
            for (factor, is_unmet) in [(1.0, false), (1.99, false), (2.01, true)] {
                let mut whole = nearby.whole.get().unwrap().clone();
                whole.by_light_paths = factor * most;
                let compensation = nearby.compensation.clone();
                let other = Nearby { place: [0; 2], key: 0, compensation, whole: OnceLock::from(whole) };
                assert_eq!(other.is_light_undersampled(common), is_unmet, "{factor}");
            }
        });
    }

    /// The number of paths grows with variance over squared tolerance: a few paths estimate a matt
    /// floor under a lamp to a third, but not to a hundredth.
    #[test]
    fn paths_are_cheap_where_little_is_asked_of_what_hardly_varies() {
        let matt = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        look_at_tile(matt, |nearby, common| {
            let is_cheap = |error| {
                nearby.are_full_paths_cheaper(common, &ControlOptions { error, ..ControlOptions::default() })
            };
            assert!(is_cheap(0.5) && !is_cheap(0.01));
        });
    }

    /// VPLs carry the light of matt surfaces. They carry none of a gloss, and full paths that have
    /// to find the gloss find the other light as well.
    #[test]
    fn vpls_are_in_vain_where_gloss_is_most_of_the_light() {
        let matt = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        look_at_tile(matt, |nearby, common| {
            assert!(!nearby.are_vpls_in_vain(common));
            let whole = OnceLock::from(Paths::default());
            let mut moments = Moments::default();
            for value in [0.0, 1.0] {
                moments.push(value);
            }
            let compensation =
                Paths { moments: [(); 3].map(|()| vec![moments]), rays: PATHS, ..Paths::default() };
            let nothing_found = Nearby { place: [0; 2], key: 0, compensation, whole };
            assert!(!nothing_found.are_vpls_in_vain(common), "paths that found nothing tell nothing");
        });
        look_at_tile(gloss(), |nearby, common| assert!(nearby.are_vpls_in_vain(common)));
    }
}
