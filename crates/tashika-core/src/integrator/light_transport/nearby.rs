//! Paths of the neighbourhood, followed before a pixel begins.
//!
//! A hundred paths of a pixel may all miss the bright one in a thousand; those of its neighbours
//! together do not. The image is divided into cells ([`Grid`]). For each [`Estimator`], [`PATHS`]
//! paths of random pixels of the cell are followed, which no estimate uses. Paths from points that
//! mirror sharply are kept apart from others: a glossy pixel among matt ones is as noisy as other
//! glossy pixels.
//!
//! A few full paths may miss the tail of their distribution. Their variance is then too small, full
//! paths seem cheap, and intervals would be too narrow. Before a cell decides for full paths, it
//! therefore follows an eighth of the paths that its pixels are predicted to take.
//!
//! # Independence
//! Pixels and paths come from streams of their own ([`Purpose::Guidance`]); a cell is a function of
//! the image and its place.

use std::ops::Range;
use std::sync::OnceLock;

use super::super::ControlOptions;
use super::estimate::{Common, Estimator, is_near_specular, summed_with};
use crate::compensation::{Caustic, Compensation};
use crate::guidance::{Grid, cell_of, key_of, pixels_of};
use crate::rng::{self, Purpose, Stream};
use crate::stats::{Moments, student_t_two_sided};

/// Number of paths of a cell, for each estimator.
pub(super) const PATHS: u64 = 1024;
/// Share of the predicted full paths of a cell's pixels by which it confirms that they are cheap.
/// Chosen.
const CONFIRMING_SHARE: f64 = 0.125;
/// Most of these paths, with those of the pilot.
const MOST_CONFIRMING: u64 = 1 << 15;
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

impl Paths {
    /// Number of paths.
    fn count(&self) -> f64 {
        self.found.count() as f64
    }

    /// Adds further paths of the same estimator.
    fn merge(&mut self, other: &Self) {
        let share = other.count() / (self.count() + other.count());
        let pooled = |own: f64, others: f64| own + share * (others - own);
        self.expected = [0, 1].map(|k| pooled(self.expected[k], other.expected[k]));
        self.by_light_paths = pooled(self.by_light_paths, other.by_light_paths);
        for (own, others) in self.moments.iter_mut().flatten().zip(other.moments.iter().flatten()) {
            own.merge(others);
        }
        self.found.merge(&other.found);
        self.sees_emission |= other.sees_emission;
        self.met += other.met;
        self.rays += other.rays;
    }

    /// Predicted number of full paths by which a pixel meets its tolerance, if they take less work
    /// than any sum over VPLs and found light.
    fn predicted_cheap(&self, options: &ControlOptions) -> Option<f64> {
        let of_path = self.moments[2].first().filter(|of_path| of_path.mean() > 0.0)?;
        let tolerance = options.tolerance_of(of_path.mean());
        let errors = student_t_two_sided(options.confidence, self.count() - 1.0);
        let paths = of_path.variance() * (errors / tolerance) * (errors / tolerance);
        (paths * self.rays as f64 / self.count() < SMALLEST_SUM_IN_RAYS).then_some(paths)
    }
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
    options: ControlOptions,
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
    /// over VPLs takes, as where light comes straight from the sky.
    pub(super) fn are_full_paths_cheaper(&self, common: &Common<'_>) -> bool {
        self.paths_of_all(common).predicted_cheap(&self.options).is_some()
    }

    /// Returns true if any camera sample here met no surface.
    pub(super) fn has_missed_samples(&self) -> bool {
        self.compensation.met < PATHS
    }

    /// Approximate luminance of the surfaces here (W·m⁻²·sr⁻¹); zero if no path began at one.
    pub(super) fn importance_brightness(&self, common: &Common<'_>) -> f64 {
        let whole = self.paths_of_all(common);
        let mean = whole.moments[2].first().map_or(0.0, Moments::mean);
        if whole.met == 0 { 0.0 } else { mean * whole.count() / whole.met as f64 }
    }

    fn paths_of_all(&self, common: &Common<'_>) -> &Paths {
        self.whole.get_or_init(|| {
            let pixels = pixels_of(self.place, common.setting.view.size).area();
            let follow = |numbers| follow(Estimator::Paths, self.place, common, 0.0, self.key, numbers);
            confirmed(&self.options, pixels, follow)
        })
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
    options: &ControlOptions,
    seed: u64,
) -> &'c Nearby {
    let place = cell_of(pixel);
    cells.at(place, || {
        let key = key_of(place, seed);
        let compensation = follow(Estimator::Vpls, place, common, clamp_distance, key, 0..PATHS);
        Nearby { place, key, options: *options, compensation, whole: OnceLock::new() }
    })
}

/// Follows the paths of a pilot. If they seem cheap, follows more, up to the
/// [share](CONFIRMING_SHARE) of the paths that `pixels` pixels are predicted to take.
///
/// * `follow`: follows the paths of these numbers.
fn confirmed(options: &ControlOptions, pixels: u64, follow: impl Fn(Range<u64>) -> Paths) -> Paths {
    let mut whole = follow(0..PATHS);
    if let Some(paths) = whole.predicted_cheap(options) {
        let wanted = (CONFIRMING_SHARE * paths * pixels as f64) as u64;
        if wanted > PATHS {
            whole.merge(&follow(PATHS..wanted.min(MOST_CONFIRMING)));
        }
    }
    whole
}

/// Follows the paths of these numbers.
fn follow(
    estimator: Estimator,
    place: [u32; 2],
    common: &Common<'_>,
    clamp_distance: f32,
    key: u64,
    numbers: Range<u64>,
) -> Paths {
    let window = pixels_of(place, common.setting.view.size);
    let key = rng::key(key, Purpose::Guidance, 1 + estimator as u64);
    let mut stream = Stream::new(key, Purpose::Guidance, numbers.start);
    let count = numbers.end - numbers.start;
    let parts = common.controlled.parts();
    let mut compensation = Compensation::new(common.lit(estimator, clamp_distance));
    let mut found = Moments::default();
    let mut expected = [0.0; 2];
    let mut by_light_paths = 0.0;
    let mut sees_emission = false;
    let mut met = 0;
    let mut moments = [(); 3].map(|()| vec![Moments::default(); parts.len()]);
    for path in numbers {
        let pixel = common.setting.view.random_pixel(&window, &mut stream);
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
            by_light_paths += common.by_light_paths(&seen) / count as f64;
        }
        found.push(of_path.found);
        expected = [0, 1].map(|k| expected[k] + of_path.expected[k] / count as f64);
        for (number, part) in parts.iter().enumerate() {
            moments[kind][number].push(part.of(value));
            moments[2][number].push(part.of(value));
        }
    }
    Paths { moments, found, expected, by_light_paths, sees_emission, met, rays: count + compensation.rays() }
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

    fn options_of(error: f64) -> ControlOptions {
        ControlOptions { error, ..ControlOptions::default() }
    }

    /// A pilot that missed a tail seems cheap until it is confirmed by more paths: one path in
    /// three thousand carries a seventh of the light.
    #[test]
    fn a_tail_that_a_pilot_missed_is_found_by_more_paths() {
        let follow = |numbers: Range<u64>| {
            let (mut of_path, mut found) = (Moments::default(), Moments::default());
            let rays = 7 * (numbers.end - numbers.start);
            for k in numbers {
                of_path.push(if k % 3000 == 2999 { 20.0 } else { 0.03 * (k % 4) as f64 });
                found.push(0.0);
            }
            Paths { moments: [(); 3].map(|()| vec![of_path]), found, rays, ..Paths::default() }
        };
        let options = options_of(0.2);
        let predicted = follow(0..PATHS).predicted_cheap(&options).expect("the pilot seems cheap");
        let whole = confirmed(&options, 600, follow);
        let expected = (CONFIRMING_SHARE * 600.0 * predicted) as u64;
        assert!(expected > 3000 && (whole.count(), whole.rays) == (expected as f64, 7 * expected));
        assert!(whole.predicted_cheap(&options).is_none());
        // A few pixels take fewer paths than the pilot has; very many do not take more than the
        // most.
        assert_eq!(confirmed(&options, 6, follow).count(), PATHS as f64);
        assert_eq!(confirmed(&options, 1 << 40, follow).count(), MOST_CONFIRMING as f64);
    }

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
        let nearby = about(&cells, [3, 5], &common, 0.02, &options_of(0.05), 7);
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
                let (options, whole) = (options_of(0.05), OnceLock::from(whole));
                let other = Nearby { place: [0; 2], key: 0, options, compensation, whole };
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
            let whole = nearby.paths_of_all(common);
            let is_cheap = |error| whole.predicted_cheap(&options_of(error)).is_some();
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
            let options = options_of(0.05);
            let nothing_found = Nearby { place: [0; 2], key: 0, options, compensation, whole };
            assert!(!nothing_found.are_vpls_in_vain(common), "paths that found nothing tell nothing");
        });
        look_at_tile(gloss(), |nearby, common| assert!(nearby.are_vpls_in_vain(common)));
    }
}
