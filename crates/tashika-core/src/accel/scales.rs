//! Tests of triangles of all sizes against exact arithmetic of another library.

use std::cmp::Ordering;

use glam::{Affine3A, DVec3, Quat, Vec3};

use super::tests::{Corners, mesh, point, tracer, visible};
use super::{Apex, Hit, Tracer};
use crate::math::Ray;
use crate::math::elementary::powf;
use crate::rng::{Purpose, Stream};
use crate::scene::{MeshData, has_normal};

/// Sign of `(a − o) · ((b − o) × (c − o))`.
pub(super) fn orientation([a, b, c]: [DVec3; 3], o: DVec3) -> Ordering {
    let [a, b, c, o] = [a, b, c, o].map(|v| robust::Coord3D { x: v.x, y: v.y, z: v.z });
    robust::orient3d(a, b, c, o).total_cmp(&0.0)
}

/// Random power of two, with exponent in `least..most`.
pub(super) fn random_exponent(s: &mut Stream, least: i32, most: i32) -> f32 {
    2f64.powi(least + s.below((most - least) as u64) as i32) as f32
}

/// Returns true if the line meets the closed triangle, in exact geometry; `None` if `o + d` is not
/// exact in double precision.
fn line_meets(o: Vec3, d: Vec3, v: &Corners) -> Option<bool> {
    let (o, d, v) = (o.as_dvec3(), d.as_dvec3(), v.map(Vec3::as_dvec3));
    let second = o + d;
    if second - o != d || second - d != o {
        return None;
    }
    let sides = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| orientation([second, v[i], v[j]], o));
    Some(!(sides.contains(&Ordering::Less) && sides.contains(&Ordering::Greater)))
}

/// Returns true if the two ends of a segment are on opposite sides of the plane of a triangle. If
/// `end` is `None`, the segment is a ray to infinity along `d`; the result is then `None` if
/// `v₀ + d` is not exact in double precision.
fn crosses_plane(o: Vec3, d: Vec3, end: Option<Vec3>, v: &Corners) -> Option<bool> {
    let [v0, v1, v2] = v.map(Vec3::as_dvec3);
    let side = |p: DVec3| orientation([v0, v1, v2], p);
    let end = match end {
        Some(x) => side(x.as_dvec3()),
        None => {
            let ahead = v0 + d.as_dvec3();
            if ahead - v0 != d.as_dvec3() || ahead - d.as_dvec3() != v0 {
                return None;
            }
            side(ahead)
        }
    };
    Some(side(o.as_dvec3()) != Ordering::Equal && side(o.as_dvec3()) == end.reverse())
}

/// Returns true if any triangle blocks the segment, in exact geometry; `None` if doubles cannot
/// decide.
fn is_blocked(o: Vec3, d: Vec3, end: Option<Vec3>, triangles: &[Corners]) -> Option<bool> {
    let mut blocked = false;
    for v in triangles {
        blocked |= line_meets(o, d, v)? && crosses_plane(o, d, end, v)?;
    }
    Some(blocked)
}

/// Compares the tracer with exact geometry. Each segment runs from `o` through one of `aims` to
/// twice its distance; a ray runs along each of them. All are traced in groups and alone. Counts
/// the free and the blocked segments.
fn hold_to_exact(t: &Tracer, triangles: &[Corners], o: Vec3, aims: &[Vec3], counts: &mut [usize; 2]) {
    let targets: Vec<Vec3> = aims.iter().map(|aim| o + (*aim - o) * 2.0).collect();
    let together = visible(t, Apex::Point(o), &targets);
    assert_eq!(together, visible(&t.plain(), Apex::Point(o), &targets), "same bits");
    for (&x, &v) in targets.iter().zip(&together) {
        assert_eq!(visible(t, Apex::Point(o), &[x]), [v], "same bits alone");
        let d = x - o;
        if let Some(blocked) = is_blocked(o, d, Some(x), triangles) {
            assert_eq!(v == 0.0, blocked, "from {o} to {x}, {triangles:?}");
            counts[usize::from(blocked)] += 1;
        }
        let to_infinity = visible(t, Apex::Direction(d), &[o; 5]);
        let alone = visible(t, Apex::Direction(d), &[o]);
        let hit = t.closest_hit(&Ray::new(o, d), 0);
        assert_eq!(hit, t.plain().closest_hit(&Ray::new(o, d), 0), "same bits of rays");
        assert_eq!(to_infinity, [alone[0]; 5]);
        if let Some(blocked) = is_blocked(o, d, None, triangles) {
            assert_eq!((alone[0] == 0.0, hit.is_some()), (blocked, blocked), "{o} along {d}, {triangles:?}");
        }
        if let Some(hit) = hit {
            hold_to_line(o, d, &hit, &triangles[hit.triangle as usize]);
        }
    }
}

/// Checks that the barycentric weights of a hit are in range and describe a point on the line. The
/// tracer computes them in double precision from the start of the ray and rounds them to single
/// precision.
fn hold_to_line(o: Vec3, d: Vec3, hit: &Hit, v: &Corners) {
    assert!(hit.barycentric.iter().all(|b| (0.0..=1.0).contains(b)), "{hit:?}");
    let place: DVec3 = v.iter().zip(hit.barycentric).map(|(v, b)| v.as_dvec3() * f64::from(b)).sum();
    let (o, d) = (o.as_dvec3(), d.as_dvec3().normalize());
    let [e1, e2] = [v[1], v[2]].map(|corner| corner.as_dvec3() - v[0].as_dvec3());
    let n = e1.cross(e2);
    let (sine, cosine) = (n.length() / (e1.length() * e2.length()), n.normalize().dot(d).abs());
    let (size, distance) = (e1.length().max(e2.length()), (v[0].as_dvec3() - o).length());
    // Weights need not sum to one in single precision.
    let farthest = v.iter().map(|v| v.as_dvec3().length()).fold(0.0, f64::max);
    let bound = (4.0 * 2f64.powi(-24)) * farthest.max(size) + 1e-14 * distance / (sine * cosine);
    let off = (place - o).cross(d).length();
    assert!(off <= bound, "{hit:?}: {off:e} off the line, expected at most {bound:e}");
}

/// Random triangle of roughly the given size, at any rotation, in one case of three thin.
fn shape(s: &mut Stream, size: f32) -> Corners {
    let turn = Quat::from_scaled_axis(point(s, 3.0));
    let thin = if s.below(3) == 0 { powf(10.0, -4.0 * s.uniform()) } else { 1.0 };
    [0; 3].map(|_| turn * (point(s, size) * Vec3::new(1.0, thin, 1.0)))
}

/// Points to aim at: the corners of a triangle, points on an edge, and points around its centre.
/// The latter are off by multiples of the triangle's size, by the rounding of the distance, or by
/// much more.
fn aims(s: &mut Stream, v: &Corners, distance: f32, size: f32) -> Vec<Vec3> {
    let center = (v[0] + v[1] + v[2]) / 3.0;
    let mut aims = v.to_vec();
    for around in [0.5 * size, 3.0 * size, 1e-7 * distance, 1e-5 * distance, 0.1 * distance] {
        aims.extend([0; 3].map(|_| center + point(s, around)));
    }
    aims.extend([0; 5].map(|_| v[0].lerp(v[1], s.uniform())));
    aims
}

/// Triangles at scales from 10⁻⁶ to 10⁶, whose sizes are 1 to 10⁻¹⁸ of their distance. Rays beside
/// a triangle miss it, and rays through it meet it. A second, large triangle shares the leaf, so
/// that many more rays reach the leaf than the triangle.
#[test]
fn triangles_of_all_sizes_are_met_where_they_are_and_nowhere_else() {
    let mut s = Stream::new(3, Purpose::Test, 0);
    let (mut counts, mut sizes) = ([0; 2], [0; 19]);
    for round in 0..1500 {
        let distance = random_exponent(&mut s, -20, 20);
        let ratio = powf(10.0, -18.0 * s.uniform());
        let size = distance * ratio;
        // Near the origin coordinates keep all their digits; far from it few remain.
        let place = if round % 2 == 0 { Vec3::ZERO } else { point(&mut s, distance) };
        let v = shape(&mut s, size).map(|corner| place + corner);
        if !has_normal(&v) {
            continue;
        }
        let aside = point(&mut s, distance);
        let other = shape(&mut s, distance).map(|corner| corner + aside);
        let triangles = [v, other];
        let t = tracer(mesh(&triangles), &[Affine3A::IDENTITY], 1.0);
        if t.size().triangles != 2 {
            continue;
        }
        let o = place + point(&mut s, 1.0).normalize() * distance;
        let aims = aims(&mut s, &v, distance, size);
        hold_to_exact(&t, &triangles, o, &aims, &mut counts);
        sizes[(-ratio.log10()) as usize] += 1;
    }
    assert!(counts[0] > 10_000 && counts[1] > 2000, "both answers occur: {counts:?}");
    assert!(sizes[..18].iter().all(|count| *count > 10), "at all sizes: {sizes:?}");
}

/// Body of revolution around the third axis, closed by fans of triangles. `rings` are pairs of
/// radius and height.
fn body(rings: &[(f64, f64)], sides: u32, turn: f64) -> (MeshData, Vec<Corners>) {
    let mut positions: Vec<Vec3> = Vec::new();
    for &(radius, height) in rings {
        positions.extend((0..sides).map(|k| {
            let angle = turn + std::f64::consts::TAU * f64::from(k) / f64::from(sides);
            DVec3::new(radius * angle.cos(), radius * angle.sin(), height).as_vec3()
        }));
    }
    let (bottom, top) = (positions.len() as u32, positions.len() as u32 + 1);
    positions.push(DVec3::new(0.0, 0.0, rings[0].1).as_vec3());
    positions.push(DVec3::new(0.0, 0.0, rings[rings.len() - 1].1).as_vec3());
    let mut triangles = Vec::new();
    for k in 0..sides {
        let next = (k + 1) % sides;
        triangles.push([bottom, next, k]);
        for ring in 0..rings.len() as u32 - 1 {
            let (a, b, c, d) =
                (ring * sides + k, ring * sides + next, (ring + 1) * sides + k, (ring + 1) * sides + next);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
        let last = (rings.len() as u32 - 1) * sides;
        triangles.push([top, last + k, last + next]);
    }
    let corners = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
    (MeshData { positions, triangles, ..MeshData::default() }, corners)
}

/// Cones, double cones and spheres with tiny caps, down to 10⁻¹⁷ of the body. No ray from inside
/// escapes along an edge, through a corner or through the cap. Segments from outside agree with
/// exact geometry.
#[test]
fn bodies_with_tiny_caps_are_closed() {
    let mut s = Stream::new(4, Purpose::Test, 0);
    let mut counts = [0; 2];
    for round in 0..160 {
        let cap = f64::from(powf(10.0, -1.0 - 16.0 * s.uniform()));
        let next = (1e3 * cap).min(0.3);
        let sides = 3 + s.below(14) as u32;
        let turn = f64::from(s.uniform());
        let rings: &[(f64, f64)] = match round % 3 {
            0 => &[(cap, 0.0), (1.0, 1.0)],
            1 => &[(cap, 0.0), (1.0, 1.0), (0.5, 2.0)],
            _ => &[(cap, 0.0), (next, next * next), (0.6, 0.36), (1.0, 1.0), (0.6, 1.8)],
        };
        let (data, corners) = body(rings, sides, turn);
        let count = corners.iter().filter(|v| has_normal(v)).count();
        let t = tracer(data, &[Affine3A::IDENTITY], 1.0);
        assert_eq!(t.size().triangles as usize, count);
        // Triangles without a normal are omitted. The body is closed if each of these has two equal
        // corners.
        let is_closed = corners.iter().all(|v| has_normal(v) || v[0] == v[1] || v[1] == v[2] || v[2] == v[0]);
        let kept: Vec<Corners> = corners.into_iter().filter(has_normal).collect();
        for _ in 0..12 {
            let inside = Vec3::new(0.0, 0.0, 0.9) + point(&mut s, 0.05);
            let v = kept[s.below(count as u64) as usize];
            let size = (v[1] - v[0]).length().min((v[2] - v[0]).length());
            let aims = aims(&mut s, &v, 1.0, size);
            if is_closed {
                for &aim in &aims {
                    let (d, far) = (aim - inside, inside + (aim - inside).normalize() * 4.0);
                    assert_eq!(visible(&t, Apex::Point(inside), &[far; 6]), [0.0; 6], "round {round}");
                    assert_eq!(visible(&t, Apex::Point(far), &[inside]), [0.0], "round {round}");
                    assert_eq!(visible(&t, Apex::Direction(d), &[inside; 2])[0], 0.0, "round {round}");
                    let hit = t.closest_hit(&Ray::new(inside, d), 0).expect("it is closed");
                    assert!(hit.barycentric.iter().all(|b| (0.0..=1.0).contains(b)), "{hit:?}");
                }
            }
            let outside = Vec3::new(0.0, 0.0, 0.5) + crate::warp::sphere(s.uniform_2()) * 3.0;
            hold_to_exact(&t, &kept, outside, &aims, &mut counts);
        }
    }
    assert!(counts.iter().all(|count| *count > 2000), "both answers occur: {counts:?}");
}

/// Triangles of a closed body: a cube in even rounds, a finely divided sphere in odd ones.
fn closed(round: u64, s: &mut Stream) -> Vec<Corners> {
    if round.is_multiple_of(2) {
        let at = |k: usize| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * 2.0 - 1.0;
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        return faces
            .iter()
            .flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]])
            .map(|t| t.map(at))
            .collect();
    }
    let rows = 4 + s.below(40) as u32;
    let rings: Vec<(f64, f64)> = (1..rows)
        .map(|k| (std::f64::consts::PI * f64::from(k) / f64::from(rows)).sin_cos())
        .map(|(sin, cos)| (sin, -cos))
        .collect();
    body(&rings, 2 * rows, 0.1).1
}

/// Rays and shadow rays start on the walls of closed rooms, mostly close to edges and corners. All
/// are blocked. Rooms have random scales, rotations and positions; in half of the rounds there are
/// two instances.
#[test]
fn no_path_leaves_a_closed_room_at_its_edges() {
    let mut s = Stream::new(5, Purpose::Test, 0);
    let mut rays = 0;
    for round in 0..80 {
        let scale = if round < 4 { 1.0 } else { powf(10.0, 9.0 * s.uniform() - 4.0) };
        let turn = if round < 16 { Quat::IDENTITY } else { Quat::from_scaled_axis(point(&mut s, 3.0)) };
        let away = if round % 3 == 0 { powf(10.0, 4.0 * s.uniform()).min(1e4 / scale) } else { 0.0 };
        let center = point(&mut s, scale * away);
        let place = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), turn, center);
        let twice = round / 2 % 2 == 1;
        let mut triangles = closed(round, &mut s);
        let t = if twice {
            let beside = Affine3A::from_translation(Vec3::X * (9.0 * scale)) * place;
            tracer(mesh(&triangles), &[place, beside], 1.0)
        } else {
            triangles.iter_mut().flatten().for_each(|corner| *corner = place.transform_point3(*corner));
            tracer(mesh(&triangles), &[Affine3A::IDENTITY], 1.0)
        };
        let center = (center.as_dvec3() - t.scene().origin()).as_vec3();
        let count = t.scene().meshes()[0].triangles().len() as u64;
        if count < triangles.len() as u64 {
            continue;
        }
        for _ in 0..20_000 {
            let triangle = s.below(count) as u32;
            // Weights down to zero, of one corner or of two corners.
            let mut tiny = || if s.below(8) == 0 { 0.0 } else { powf(10.0, -9.0 * s.uniform()) };
            let (first, second) = (tiny(), tiny());
            let second = if s.below(2) == 0 { second } else { s.uniform() };
            let (first, second) = (0.5 * first, 0.5 * second);
            let mut b = [first, second, 1.0 - first - second];
            b.rotate_left(s.below(3) as usize);
            let p = t.scene().surface_point(crate::scene::InstanceId::at(0), triangle, b);
            let n = p.geometric_normal;
            let inside = if n.dot(center - p.position) < 0.0 { -n } else { n };
            let d = (inside + crate::warp::sphere(s.uniform_2())).normalize_or(inside);
            let start = p.leave(inside);
            rays += 1;
            let told = || {
                format!("round {round}, {twice}, scale {scale:e}, away {away}: {triangle} {b:?} along {d}")
            };
            assert!(t.closest_hit(&Ray::new(start, d), 0).is_some(), "{}", told());
            assert_eq!(visible(&t, Apex::Direction(d), &[start]), [0.0], "{}", told());
            let far = start + d * (4.0 * scale);
            assert_eq!(visible(&t, Apex::Point(far), &[start; 4]), [0.0; 4], "{}", told());
        }
    }
    assert!(rays > 1_000_000, "{rays}");
}
