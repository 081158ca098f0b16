//! Many gather points against one light: finds the points that can receive light from it.

use glam::Vec3;

use crate::gather::GatherPoint;
use crate::math::simd::{F32x16, Level, Vectors, Work, each, for_bits};
use crate::vpl::{Vpl, VplKind};

/// Number of points tested at once.
const LANES: usize = 16;

/// Positions and normals of gather points, component by component, in groups of sixteen.
#[derive(Clone, Debug, Default)]
pub struct Receivers {
    groups: Vec<Group>,
    /// Numbers and positions of points in media, which receive light from all sides.
    in_media: Vec<(u32, Vec3)>,
}

/// Three coordinates of each lane.
type Vectors3 = [[f32; LANES]; 3];

#[derive(Clone, Copy, Debug)]
struct Group {
    position: Vectors3,
    geometric_normal: Vectors3,
    shading_normal: Vectors3,
}

impl Receivers {
    /// The geometry of `points`.
    pub fn new(points: &[GatherPoint]) -> Self {
        let groups = points
            .chunks(LANES)
            .map(|chunk| {
                let gathered = |f: fn(&GatherPoint) -> Vec3| {
                    let mut v = [[0.0; LANES]; 3];
                    // Points in media keep zero normals, which face nothing.
                    for (lane, p) in chunk.iter().enumerate().filter(|(_, p)| p.phase.is_none()) {
                        for (axis, component) in v.iter_mut().enumerate() {
                            component[lane] = f(p)[axis];
                        }
                    }
                    v
                };
                Group {
                    position: gathered(|p| p.position),
                    geometric_normal: gathered(|p| p.geometric_normal),
                    shading_normal: gathered(|p| p.frame.n),
                }
            })
            .collect();
        let in_media = (0..).zip(points).filter(|(_, point)| point.phase.is_some());
        Self { groups, in_media: in_media.map(|(number, point)| (number, point.position)).collect() }
    }

    /// Appends in ascending order the numbers of the points that are in front of `light` and see it
    /// from their front. The other points receive nothing, except for rounding at grazing angles.
    pub fn facing(&self, light: &Vpl, out: &mut Vec<u32>) {
        let from = match light.kind {
            VplKind::Directional => {
                Source { position: -light.direction, at_infinity: 1.0, normal: Vec3::ZERO, oriented: false }
            }
            VplKind::Oriented => {
                Source { position: light.position, at_infinity: 0.0, normal: light.direction, oriented: true }
            }
            VplKind::Omni | VplKind::Spot(_) | VplKind::Image(_) | VplKind::Volume(_) => {
                Source { position: light.position, at_infinity: 0.0, normal: Vec3::ZERO, oriented: false }
            }
        };
        let first = out.len();
        Level::best().run(Facing { groups: &self.groups, from, out });
        if !self.in_media.is_empty() {
            let faced =
                |(_, place): &&(u32, Vec3)| !from.oriented || from.normal.dot(*place - from.position) > 0.0;
            out.extend(self.in_media.iter().filter(faced).map(|(number, _)| number));
            out[first..].sort_unstable();
        }
    }
}

/// Position and orientation of a light.
#[derive(Clone, Copy)]
struct Source {
    /// Position, or the direction to the light if it is at infinity.
    position: Vec3,
    /// One for lights at infinity, otherwise zero.
    at_infinity: f32,
    normal: Vec3,
    /// True if the light shines only to the side of its normal.
    oriented: bool,
}

/// [`Receivers::facing`] with its arguments.
struct Facing<'a> {
    groups: &'a [Group],
    from: Source,
    out: &'a mut Vec<u32>,
}

impl Work for Facing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        facing::<V::Sixteen>(self.groups, self.from, self.out);
    }
}

#[inline(always)]
fn facing<F: F32x16>(groups: &[Group], from: Source, out: &mut Vec<u32>) {
    let (zero, finite) = (F::splat(0.0), F::splat(1.0 - from.at_infinity));
    let (position, normal) = (from.position, from.normal);
    for (number, g) in groups.iter().enumerate() {
        let d = each!(|axis| F::splat(position[axis]) - finite * F::load(&g.position[axis]));
        let along = |n: &Vectors3| F::load(&n[0]) * d[0] + F::load(&n[1]) * d[1] + F::load(&n[2]) * d[2];
        let mut faces = F::and(along(&g.geometric_normal).gt(zero), along(&g.shading_normal).gt(zero));
        if from.oriented {
            let lit = F::splat(normal.x) * d[0] + F::splat(normal.y) * d[1] + F::splat(normal.z) * d[2];
            faces = F::and(faces, zero.gt(lit));
        }
        // Lanes beyond the last point have zero normals and never face anything.
        for_bits!(F::bits(faces), below LANES, |lane| {
            out.push((number * LANES + lane) as u32);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::ContributionKernel;
    use super::*;
    use crate::bsdf::{Bsdf, HenyeyGreenstein, Lambert};
    use crate::color::Rgb;
    use crate::math::Frame;
    use crate::media::Scattering;
    use crate::rng::{Purpose, Stream};
    use crate::scene::MediumId;
    use crate::warp;

    fn point(s: &mut Stream) -> GatherPoint {
        let frame = Frame::about(warp::sphere(s.uniform_2()).normalize());
        GatherPoint {
            position: Vec3::from(s.uniform_3()),
            geometric_normal: (frame.n + 0.5 * warp::sphere(s.uniform_2())).normalize(),
            frame,
            wo: warp::cosine_hemisphere(s.uniform_2()),
            bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::gray(0.5) }),
            weight: Rgb::WHITE,
            medium: None,
            phase: None,
            instant: 0,
        }
    }

    /// Mixes points in media with points on surfaces. Points in media are found if and only if they
    /// receive light, and all numbers are in ascending order.
    #[test]
    fn points_in_media_face_every_light() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        let (mut faced, mut turned_away) = (0, 0);
        for round in 0..500 {
            let phase = HenyeyGreenstein { asymmetry: 0.3 };
            let points: Vec<GatherPoint> = (0..s.below(50))
                .map(|k| {
                    let of_surface = point(&mut s);
                    if k % 3 == 0 {
                        return of_surface;
                    }
                    let (place, before) = (of_surface.position, of_surface.frame.n);
                    let at = Scattering { place, before, medium: MediumId::at(0), phase };
                    GatherPoint::in_medium(&at, Rgb::WHITE)
                })
                .collect();
            let kind = [VplKind::Omni, VplKind::Oriented, VplKind::Volume(phase)][round % 3];
            let (position, direction) = (Vec3::from(s.uniform_3()), warp::sphere(s.uniform_2()).normalize());
            let light = Vpl { position, direction, intensity: Rgb::WHITE, kind };
            let mut found = Vec::new();
            Receivers::new(&points).facing(&light, &mut found);
            assert!(found.is_sorted_by(|a, b| a < b));
            let kernel = ContributionKernel::default();
            for (k, point) in (0..).zip(&points) {
                let gives = !kernel.unoccluded(point, &light).is_black();
                // At grazing angles, rounding decides whether a surface is lit.
                assert!(found.contains(&k) == gives || point.phase.is_none(), "point {k} of {round}");
                (faced, turned_away) = (faced + u32::from(gives), turned_away + u32::from(!gives));
            }
        }
        assert!(faced > 3000 && turned_away > 1000, "{faced}, {turned_away}");
    }

    /// Compares the result with three scalar products per point. All instruction sets give the same
    /// result.
    #[test]
    fn those_face_a_light_that_see_its_front() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut found = 0;
        for round in 0..2000 {
            let points: Vec<GatherPoint> = (0..s.below(50)).map(|_| point(&mut s)).collect();
            let (position, direction) = (Vec3::from(s.uniform_3()), warp::sphere(s.uniform_2()));
            let at_infinity = round % 3 == 0;
            let oriented = round % 3 == 1;
            let from = Source {
                position: if at_infinity { -direction } else { position },
                at_infinity: if at_infinity { 1.0 } else { 0.0 },
                normal: if oriented { direction } else { Vec3::ZERO },
                oriented,
            };
            let towards = |p: &GatherPoint| if at_infinity { -direction } else { position - p.position };
            // Where rounding decides, both answers are accepted.
            let certain = |p: &GatherPoint| {
                let cosines = [p.geometric_normal, p.frame.n, direction].map(|n| n.dot(towards(p)));
                cosines.iter().all(|c| c.abs() > 1e-5)
            };
            let faces = |p: &GatherPoint| {
                let d = towards(p);
                let front = p.geometric_normal.dot(d) > 0.0 && p.frame.n.dot(d) > 0.0;
                front && (!oriented || direction.dot(d) < 0.0)
            };
            let receivers = Receivers::new(&points);
            let of = |level: Level| {
                let mut out = Vec::new();
                level.run(Facing { groups: &receivers.groups, from, out: &mut out });
                out
            };
            let plain = of(Level::PORTABLE);
            for (i, p) in points.iter().enumerate() {
                assert!(plain.contains(&(i as u32)) == faces(p) || !certain(p), "point {i} of {round}");
            }
            assert!(plain.is_sorted() && plain.iter().all(|&i| (i as usize) < points.len()));
            found += plain.len();
            for level in Level::all() {
                assert_eq!(of(level), plain, "{level:?}");
            }
        }
        assert!(found > 5000, "{found}");
    }
}
