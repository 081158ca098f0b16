//! Tests of the tracer against brute force, against its other variants, and against its surfaces.

use std::sync::Arc;

use glam::{Affine3A, DAffine3, DVec3, Quat, Vec3};

use super::{Apex, Glass, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::error::Location;
use crate::math::Ray;
use crate::math::elementary::powf;
use crate::math::motion::Track;
use crate::rng::{Purpose, Stream};
use crate::scene::{Alpha, AlphaMode, Material, MeshData, MeshShape, SceneBuilder, Surface, has_normal};

pub(super) type Corners = [Vec3; 3];

pub(super) fn mesh(triangles: &[Corners]) -> MeshData {
    MeshData {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..MeshData::default()
    }
}

/// A scene with one mesh of the given opacity, placed at each of `places`.
pub(super) fn tracer(data: MeshData, places: &[Affine3A], opacity: f32) -> Tracer {
    tracer_of([(data, opacity)], places)
}

/// A scene with several meshes, each with its opacity and placed at each of `places`.
fn tracer_of(meshes: impl IntoIterator<Item = (MeshData, f32)>, places: &[Affine3A]) -> Tracer {
    let mut b = SceneBuilder::new("test", Location::default());
    for (number, (data, opacity)) in meshes.into_iter().enumerate() {
        let surface = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let mut material = Material::new(format!("m{number}"), surface);
        if opacity < 1.0 {
            material.alpha = Some(Alpha { value: opacity.into(), mode: AlphaMode::Blend });
        }
        let material = b.add_material(material).unwrap();
        let mesh = b.add_mesh(data, material).unwrap();
        for &p in places {
            b.add_instance(mesh, p).unwrap();
        }
    }
    Tracer::new(Arc::new(b.build().unwrap()))
}

fn soup(stream: &mut Stream, count: usize, size: f32) -> Vec<Corners> {
    (0..count)
        .map(|_| {
            let center = point(stream, 1.0);
            [0; 3].map(|_| center + point(stream, size))
        })
        .collect()
}

pub(super) fn point(s: &mut Stream, size: f32) -> Vec3 {
    (Vec3::from(s.uniform_3()) - 0.5) * (2.0 * size)
}

pub(super) fn visible(t: &Tracer, apex: Apex, targets: &[Vec3]) -> Vec<f32> {
    let mut batch = SegmentBatch::default();
    batch.push_fan(apex, targets.iter().copied());
    let mut out = Vec::new();
    t.visibility(&batch, &mut out);
    out
}

/// Parameter at which the line `o + t d` meets a triangle, computed in `f64`, and the relative
/// distance of the intersection from the nearest edge.
fn meets_exactly(o: DVec3, d: DVec3, t: &Corners) -> Option<(f64, f64)> {
    let v = t.map(Vec3::as_dvec3);
    let (a, b, c) = (v[0] - o, v[1] - o, v[2] - o);
    let w = [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))];
    let sum: f64 = w.iter().sum();
    let inside = w.iter().all(|x| *x >= 0.0) || w.iter().all(|x| *x <= 0.0);
    let n = (v[1] - v[0]).cross(v[2] - v[0]);
    let margin = w.iter().fold(f64::INFINITY, |m, x| m.min((x / sum).abs()));
    inside.then(|| (a.dot(n) / d.dot(n), margin))
}

/// Returns true if a segment is blocked in exact geometry; `None` if an intersection is close to an
/// edge or to an end of the segment.
fn blocked_exactly(o: Vec3, x: Vec3, t_max: f64, triangles: &[Corners]) -> Option<bool> {
    let (o, d) = (o.as_dvec3(), if t_max.is_finite() { x.as_dvec3() - o.as_dvec3() } else { x.as_dvec3() });
    let mut blocked = false;
    for t in triangles {
        if let Some((at, margin)) = meets_exactly(o, d, t) {
            if margin < 1e-4 || at.abs() < 1e-4 || (at - t_max).abs() < 1e-4 {
                return None;
            }
            blocked |= at > 0.0 && at < t_max;
        }
    }
    Some(blocked)
}

#[test]
fn visibility_agrees_with_brute_force() {
    let mut s = Stream::new(1, Purpose::Test, 0);
    let triangles = soup(&mut s, 300, 0.25);
    let t = tracer(mesh(&triangles), &[Affine3A::IDENTITY], 1.0);
    let mut judged = [0; 2];
    for round in 0..400 {
        let infinite = round % 4 == 3;
        let apex = point(&mut s, 1.2);
        let targets: Vec<Vec3> = (0..20).map(|_| point(&mut s, 1.2)).collect();
        let fan = if infinite { Apex::Direction(apex) } else { Apex::Point(apex) };
        for (x, v) in targets.iter().zip(visible(&t, fan, &targets)) {
            let exact = if infinite {
                blocked_exactly(*x, apex, f64::INFINITY, &triangles)
            } else {
                blocked_exactly(apex, *x, 1.0, &triangles)
            };
            if let Some(blocked) = exact {
                judged[usize::from(blocked)] += 1;
                assert_eq!(v, if blocked { 0.0 } else { 1.0 }, "{fan:?} to {x:?}");
            }
        }
    }
    assert!(judged[0] > 500 && judged[1] > 500, "both answers occur: {judged:?}");
}

#[test]
fn closest_hits_agree_with_brute_force() {
    let mut s = Stream::new(2, Purpose::Test, 0);
    let triangles = soup(&mut s, 300, 0.25);
    let t = tracer(mesh(&triangles), &[Affine3A::IDENTITY], 1.0);
    let mut hits = 0;
    for _ in 0..3000 {
        let ray = Ray::new(point(&mut s, 1.2), point(&mut s, 1.0));
        let exact = triangles
            .iter()
            .enumerate()
            .filter_map(|(i, c)| {
                meets_exactly(ray.origin.as_dvec3(), ray.direction.as_dvec3(), c).map(|h| (h, i))
            })
            .filter(|((at, _), _)| *at > 0.0)
            .min_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let found = t.closest_hit(&ray, 0);
        match (exact, found) {
            (Some(((at, margin), i)), Some(hit)) if margin > 1e-4 && at > 1e-4 => {
                hits += 1;
                assert_eq!(hit.triangle as usize, i);
                assert!((f64::from(hit.t) - at).abs() < 1e-3 * at);
                let p: Vec3 = triangles[i].iter().zip(hit.barycentric).map(|(&v, b)| v * b).sum();
                assert!((p - ray.at(hit.t)).length() < 1e-3);
            }
            (None, Some(hit)) => panic!("a hit where nothing is: {hit:?}"),
            (Some(((_, margin), _)), None) => assert!(margin < 1e-4, "missed"),
            _ => {}
        }
    }
    assert!(hits > 500);
}

/// Segments are traced in packets, alone, and grouped differently, with partly transparent
/// surfaces. All give the same bits.
#[test]
fn grouping_does_not_change_a_bit() {
    let mut s = Stream::new(3, Purpose::Test, 0);
    let far = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(0.3, 0.1, -0.2));
    // The mesh has enough triangles to be shared by its instances instead of copied.
    let data = mesh(&soup(&mut s, 70_000, 0.02));
    let t = tracer(data, &[Affine3A::IDENTITY, far], 0.37);
    assert_eq!(t.size().shared_trees, 1);
    let mut partly = 0;
    for round in 0..240 {
        let apex = point(&mut s, 1.2);
        let fan = if round % 3 == 2 { Apex::Direction(apex) } else { Apex::Point(apex) };
        // Targets that are far apart are traversed one by one, targets that are close to each other
        // together.
        let spread = [1.2, 0.3, 0.02][round % 4 % 3];
        let center = point(&mut s, 1.2 - spread);
        let mut targets: Vec<Vec3> = (0..37).map(|_| center + point(&mut s, spread)).collect();
        // A target that is far away has a larger rounding error, which must not affect the others.
        targets[9] = apex + (center - apex) * 1e5;
        let together = visible(&t, fan, &targets);
        let alone: Vec<f32> = targets.iter().map(|x| visible(&t, fan, &[*x])[0]).collect();
        let shifted = visible(&t, fan, &targets[5..]);
        assert_eq!(together, alone);
        assert_eq!(together, visible(&t.plain(), fan, &targets), "without vector instructions");
        assert_eq!(together[5..], shifted);
        partly += together.iter().filter(|v| **v > 0.0 && **v < 1.0).count();
    }
    assert!(partly > 200, "{partly}");
}

/// Earlier segments were blocked elsewhere, in this scene and in another one. The answers are the
/// same as those of a tracer that remembers no occluders.
#[test]
fn what_was_asked_before_does_not_matter() {
    let mut s = Stream::new(8, Purpose::Test, 0);
    // Half of the triangles are partly transparent, so that a leaf can block one segment and not
    // its neighbour.
    let triangles = soup(&mut s, 400, 0.3);
    let (solid, pane) = (mesh(&triangles[..200]), mesh(&triangles[200..]));
    let mixed = tracer_of([(solid, 1.0), (pane, 0.3)], &[Affine3A::IDENTITY]);
    let other = tracer(mesh(&triangles[..50]), &[Affine3A::IDENTITY], 1.0);
    let mut answers = [0; 3];
    for round in 0..600 {
        let apex = point(&mut s, 1.2);
        let fan = if round % 3 == 2 { Apex::Direction(apex) } else { Apex::Point(apex) };
        let center = point(&mut s, 1.2);
        let spread = [0.5, 0.05, 0.001][round % 7 % 3];
        // Fans of three targets are traversed one by one.
        for _ in 0..8 {
            let targets: Vec<Vec3> = (0..3).map(|_| center + point(&mut s, spread)).collect();
            let remembered = visible(&mixed, fan, &targets);
            assert_eq!(remembered, visible(&mixed.plain(), fan, &targets));
            if round % 5 == 0 {
                assert_eq!(visible(&other, fan, &targets), visible(&other.plain(), fan, &targets));
            }
            for v in remembered {
                answers[if v <= 0.0 { 0 } else { 1 + usize::from(v < 1.0) }] += 1;
            }
        }
    }
    assert!(answers.iter().all(|&count| count > 1000), "all answers occur: {answers:?}");
}

#[test]
fn threads_do_not_change_the_tree() {
    let mut s = Stream::new(4, Purpose::Test, 0);
    let triangles = soup(&mut s, 20_000, 0.03);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tracer(mesh(&triangles), &[Affine3A::IDENTITY], 0.5))
    };
    let (one, many) = (build(1), build(4));
    for _ in 0..50 {
        let fan = Apex::Point(point(&mut s, 1.2));
        let targets: Vec<Vec3> = (0..32).map(|_| point(&mut s, 1.2)).collect();
        assert_eq!(visible(&one, fan, &targets), visible(&many, fan, &targets));
    }
}

/// Planes of slivers and tiny triangles at random positions and rotations, baked or as an instance.
/// A segment that starts on the plane and leaves it is never blocked by the plane, however grazing
/// it is.
#[test]
fn no_surface_blocks_what_starts_on_it() {
    let mut s = Stream::new(5, Purpose::Test, 0);
    for round in 0..60 {
        let scale = powf(10.0, 8.0 * s.uniform() - 4.0);
        let away = if round % 3 == 0 { 0.0 } else { powf(10.0, 4.0 * s.uniform()) };
        let center = point(&mut s, scale * away);
        let turn = Quat::from_scaled_axis(point(&mut s, 3.0));
        // Columns alternate between widths of up to 1 : 500, which makes adjacent slivers.
        let grid = 24;
        let x_at = |i: usize| (i / 2) as f32 + if i % 2 == 1 { 0.996 } else { 0.0 };
        let at = |i: usize, j: usize| {
            let flat = Vec3::new(x_at(i) - 6.0, j as f32 / 2.0 - 6.0, 0.0) * (scale / 12.0);
            center + turn * flat
        };
        let mut triangles = Vec::new();
        for i in 0..grid {
            for j in 0..grid {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let place = if round % 2 == 0 {
            Affine3A::IDENTITY
        } else {
            Affine3A::from_scale_rotation_translation(
                Vec3::new(0.5, 2.0, 1.3),
                Quat::from_scaled_axis(point(&mut s, 3.0)),
                point(&mut s, scale),
            )
        };
        // The additional places are far away. They only make the mesh a shared one.
        let mut places = vec![place];
        if round % 4 == 1 {
            places
                .extend((0..60).map(|k| {
                    Affine3A::from_translation(Vec3::splat((9.0 * scale) * (k + 2) as f32)) * place
                }));
        }
        let t = tracer(mesh(&triangles), &places, 1.0);
        assert_eq!(t.size().shared_trees > 0, round % 4 == 1);
        let scene = t.scene();
        let kept = scene.meshes()[0].triangles().len() as u64;
        assert!(kept > 300, "round {round}: rounding left {kept} usable triangles");
        for _ in 0..400 {
            let triangle = s.below(kept) as u32;
            let b = crate::warp::triangle(s.uniform_2());
            let p = scene.surface_point(crate::scene::InstanceId::at(0), triangle, b);
            let n = p.geometric_normal;
            let tangent = crate::math::Frame::about(n)
                .to_world(crate::warp::sphere(s.uniform_2()) * Vec3::new(1.0, 1.0, 0.0));
            // Elevations above the true plane down to 10⁻⁶ rad.
            let direction = tangent.normalize_or(n) + n * powf(10.0, -6.0 * s.uniform());
            let start = p.leave(direction);
            let corners = scene.world_corners(crate::scene::InstanceId::at(0), triangle);
            let baked = scene.instances()[0].is_baked();
            if baked && !has_normal(&corners) {
                continue;
            }
            let end = start + direction * (scale * 3.0);
            // The true surface in f64: the world corners, or the object's corners under the exact
            // transform.
            let d = if baked {
                corners.map(Vec3::as_dvec3)
            } else {
                let m = scene.instances()[0].to_world.as_daffine3();
                scene.meshes()[0].corners(triangle).map(|v| m.transform_point3(v.as_dvec3()))
            };
            let true_normal = (d[1] - d[0]).cross(d[2] - d[0]);
            let side = |q: Vec3| (q.as_dvec3() - d[0]).dot(true_normal);
            let towards = n.as_dvec3().dot(true_normal) * f64::from(direction.dot(n));
            assert!(side(start) * towards > 0.0, "round {round}: on the wrong side of its own plane");
            if baked && side(end) * side(start) > 0.0 {
                let own = tracer(mesh(&[corners]), &[Affine3A::IDENTITY], 1.0);
                assert_eq!(
                    visible(&own, Apex::Point(start), &[end; 2]),
                    [1.0; 2],
                    "round {round}: own triangle"
                );
                assert!(own.closest_hit(&Ray::new(start, end - start), 0).is_none());
            }
            // Far from the origin, rounding bends the plane by more than the width of a sliver.
            if away > 10.0 {
                continue;
            }
            let steep = direction + n * 0.3;
            let start = p.leave(steep);
            let end = start + steep * (scale * 3.0);
            assert_eq!(visible(&t, Apex::Point(start), &[end])[0], 1.0, "round {round}: neighbours");
            assert_eq!(
                visible(&t, Apex::Point(end), &[start; 3])[2],
                1.0,
                "round {round}: seen from the other end"
            );
            assert_eq!(visible(&t, Apex::Direction(steep), &[start])[0], 1.0, "round {round}: to infinity");
            assert!(t.closest_hit(&Ray::new(start, steep), 0).is_none(), "round {round}: ray");
        }
    }
}

/// Segments and rays from inside a closed sphere are all blocked, even at edges.
#[test]
fn closed_surfaces_do_not_leak() {
    let mut s = Stream::new(6, Purpose::Test, 0);
    let (rows, columns) = (24u32, 48u32);
    let at = |i: u32, j: u32| {
        let theta = std::f64::consts::PI * f64::from(i) / f64::from(rows);
        let phi = 2.0 * std::f64::consts::PI * f64::from(j % columns) / f64::from(columns);
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()).as_vec3() * 3.0
            + Vec3::new(100.0, -50.0, 7.0)
    };
    let mut corners = Vec::new();
    let mut positions = Vec::new();
    for i in 0..=rows {
        for j in 0..columns {
            positions.push(if i == 0 {
                at(0, 0)
            } else if i == rows {
                at(rows, 0)
            } else {
                at(i, j)
            });
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let k = |i: u32, j: u32| i * columns + j % columns;
            corners.push([k(i, j), k(i + 1, j), k(i + 1, j + 1)]);
            corners.push([k(i, j), k(i + 1, j + 1), k(i, j + 1)]);
        }
    }
    let t = tracer(
        MeshData { positions: positions.clone(), triangles: corners, ..MeshData::default() },
        &[Affine3A::IDENTITY],
        1.0,
    );
    let center = Vec3::new(100.0, -50.0, 7.0);
    for round in 0..3000 {
        let inside = center + point(&mut s, 1.0);
        let aim = if round % 2 == 0 {
            // On an edge, away from its end points.
            let k = s.below(u64::from(rows * columns)) as usize;
            positions[k].lerp(positions[k + 1], 0.1 + 0.8 * s.uniform())
        } else {
            center + crate::warp::sphere(s.uniform_2()) * 3.0
        };
        let direction = aim - inside;
        let far = inside + direction * 2.0;
        assert_eq!(visible(&t, Apex::Point(inside), &[far, far])[0], 0.0, "round {round}");
        assert_eq!(visible(&t, Apex::Point(far), &[inside])[0], 0.0, "round {round}");
        assert_eq!(visible(&t, Apex::Direction(direction), &[inside, inside])[1], 0.0, "round {round}");
        assert!(t.closest_hit(&Ray::new(inside, direction), 0).is_some(), "round {round}");
    }
}

#[test]
fn instances_are_where_their_transforms_say() {
    let mut s = Stream::new(7, Purpose::Test, 0);
    let triangles = soup(&mut s, 70_000, 0.01);
    let places: Vec<Affine3A> = (0..3)
        .map(|k| {
            Affine3A::from_scale_rotation_translation(
                Vec3::new(1.0, if k == 1 { -1.5 } else { 1.5 }, 0.8),
                Quat::from_scaled_axis(point(&mut s, 3.0)),
                point(&mut s, 1.0),
            )
        })
        .collect();
    let shared = tracer(mesh(&triangles), &places, 1.0);
    assert_eq!(shared.size().triangles, 70_000, "one copy");
    let copies: Vec<Corners> =
        places.iter().flat_map(|m| triangles.iter().map(|t| t.map(|v| m.transform_point3(v)))).collect();
    let flat = tracer(mesh(&copies), &[Affine3A::IDENTITY], 1.0);
    let (mut differ, mut blocked) = (0, 0);
    for _ in 0..200 {
        let apex = point(&mut s, 2.0);
        let targets: Vec<Vec3> = (0..16).map(|_| point(&mut s, 2.0)).collect();
        let (a, b) =
            (visible(&shared, Apex::Point(apex), &targets), visible(&flat, Apex::Point(apex), &targets));
        differ += a.iter().zip(&b).filter(|(a, b)| a != b).count();
        blocked += b.iter().filter(|v| **v == 0.0).count();
        let ray = Ray::new(apex, targets[0] - apex);
        let (a, b) = (shared.closest_hit(&ray, 0), flat.closest_hit(&ray, 0));
        if let (Some(a), Some(b)) = (a, b) {
            assert!((a.t - b.t).abs() < 1e-4 || a.triangle != b.triangle % 70_000);
        }
    }
    // The transform rounds the ends by about 1e-7, and the edges are 1e-2 long. Only segments that
    // pass that close to an edge may differ: far less than one in a hundred.
    assert!(differ <= 16 && blocked > 500, "{differ} of 3200 differ, {blocked} blocked");
}

#[test]
fn transparency_multiplies_and_rays_see_it_with_its_probability() {
    let wall = |x: f32| [Vec3::new(x, -9.0, -9.0), Vec3::new(x, 9.0, -9.0), Vec3::new(x, 0.0, 18.0)];
    let t = tracer(mesh(&[wall(1.0), wall(2.0)]), &[Affine3A::IDENTITY], 0.25);
    let v = visible(&t, Apex::Point(Vec3::ZERO), &[Vec3::X * 3.0, Vec3::X * 1.5, Vec3::X * 0.5]);
    assert_eq!(v, [0.5625, 0.75, 1.0]);
    let n = 4000;
    let hits: Vec<_> = (0..n).filter_map(|k| t.closest_hit(&Ray::new(Vec3::ZERO, Vec3::X), k)).collect();
    let first = hits.iter().filter(|h| h.t < 1.5).count() as f64 / n as f64;
    let any = hits.len() as f64 / n as f64;
    // Standard errors 0.0068 and 0.0078.
    assert!((first - 0.25).abs() < 0.035 && (any - 0.4375).abs() < 0.04, "{first} {any}");
}

#[test]
fn scenes_of_few_triangles_or_none_work() {
    let mut s = Stream::new(8, Purpose::Test, 0);
    for count in [0, 1, 2, 3, 4, 5, 6, 9] {
        let triangles = soup(&mut s, count, 1.0);
        let t = tracer(mesh(&triangles), &[Affine3A::IDENTITY], 1.0);
        for _ in 0..300 {
            let (a, b) = (point(&mut s, 2.0), point(&mut s, 2.0));
            if let Some(blocked) = blocked_exactly(a, b, 1.0, &triangles) {
                assert_eq!(visible(&t, Apex::Point(a), &[b])[0] == 0.0, blocked, "{count} triangles");
            }
        }
    }
    // A thousand copies of one triangle cannot be split into smaller boxes.
    let same = vec![soup(&mut s, 1, 1.0)[0]; 1000];
    let t = tracer(mesh(&same), &[Affine3A::IDENTITY], 1.0);
    let c = same[0].iter().sum::<Vec3>() / 3.0;
    let n = (same[0][1] - same[0][0]).cross(same[0][2] - same[0][0]);
    assert_eq!(visible(&t, Apex::Point(c + n), &[c - n])[0], 0.0);
}

/// The transmittance of glass follows the Fresnel equations at the angle of the segment in world
/// space, regardless of the placement of the mesh. It is zero for solid glass with
/// `Glass::SolidStops`.
#[test]
fn glass_lets_pass_straight_what_it_does_not_reflect() {
    let normal = crate::bsdf::fresnel::dielectric(1.0, 1.5);
    let oblique = crate::bsdf::fresnel::dielectric(0.5, 1.5);
    let square = || {
        let v = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]].map(Vec3::from);
        MeshData { positions: v.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshData::default() }
    };
    let solid = Surface::Glass {
        ior: 1.5,
        reflectance: Rgb::WHITE,
        transmittance: Rgb::gray(0.9),
        facets: 0.0.into(),
    };
    let pane = Surface::ThinGlass {
        ior: 1.5,
        reflectance: Rgb::WHITE.into(),
        transmittance: Rgb::gray(0.9).into(),
        facets: 0.0.into(),
    };
    let two_faces = |f: f32| (1.0 - f) / (1.0 + f);
    for (surface, passes) in [(solid, 1.0 - normal), (pane, two_faces(normal))] {
        // First a single placement. Then many placements, so that the mesh is shared; the instance
        // is stretched, which must not change the angle in world space.
        for shared in [false, true] {
            let mut b = SceneBuilder::new("test", Location::default());
            let material = b.add_material(Material::new("g", surface)).unwrap();
            let mesh = b.add_mesh(square(), material).unwrap();
            let here = Affine3A::from_scale(Vec3::new(0.5, 2.0, 7.0));
            b.add_instance(mesh, if shared { here } else { Affine3A::IDENTITY }).unwrap();
            if shared {
                for i in 0..40_000 {
                    b.add_instance(mesh, Affine3A::from_translation(Vec3::Z * (100.0 + i as f32))).unwrap();
                }
            }
            let t = Tracer::new(Arc::new(b.build().unwrap()));
            assert_eq!(t.size().shared_trees, u64::from(shared));
            // Not on the diagonal, where the segment would meet both triangles.
            let place = Vec3::new(0.3, -0.2, 0.0);
            let aside = Vec3::X * 3f32.sqrt();
            let targets = [place - Vec3::Z, place + aside - Vec3::Z];
            let apex = [place + Vec3::Z, place - aside + Vec3::Z].map(Apex::Point);
            let straight = visible(&t, apex[0], &targets[..1])[0];
            assert!((straight - 0.9 * passes).abs() < 1e-5, "{surface:?}, shared {shared}: {straight}");
            let tilted = visible(&t, apex[1], &targets[1..])[0];
            let expected = 0.9 * if passes == 1.0 - normal { 1.0 - oblique } else { two_faces(oblique) };
            assert!(
                (tilted - expected).abs() < 1e-5,
                "{surface:?}, shared {shared}: {tilted} for {expected}"
            );
            let mut stopped = SegmentBatch::new(Glass::SolidStops);
            stopped.push_fan(apex[0], targets[..1].iter().copied());
            let mut out = Vec::new();
            t.visibility(&stopped, &mut out);
            let solid = matches!(surface, Surface::Glass { .. });
            assert_eq!(out[0], if solid { 0.0 } else { straight });
            // Rays always hit glass, as it has no holes.
            assert!(t.closest_hit(&Ray::new(Vec3::Z, Vec3::NEG_Z), 5).is_some());
        }
    }
}

/// Static triangles, and soups that rotate and move while the shutter is open. Each soup is stored
/// with its triangles at the opening and at the closing of the shutter and with its track. Every
/// second soup deforms, and every fourth one only deforms.
struct MovingSoups {
    tracer: Tracer,
    standing: Vec<Corners>,
    movers: Vec<([Vec<Corners>; 2], Track)>,
}

impl MovingSoups {
    /// All triangles at a time, given as a share of the time that the shutter is open.
    fn at(&self, share: f32) -> Vec<Corners> {
        let moved = self.movers.iter().flat_map(|([open, close], track)| {
            let map = track.at(3.0 + f64::from(share)).as_affine3a();
            let corners = move |(a, b): (&Corners, &Corners)| {
                [0, 1, 2].map(|k| map.transform_point3(a[k].lerp(b[k], share)))
            };
            open.iter().zip(close).map(corners)
        });
        self.standing.iter().copied().chain(moved).collect()
    }
}

fn moving_soups(stream: &mut Stream, opacity: f32) -> MovingSoups {
    let mut b = SceneBuilder::new("test", Location::default());
    let mut material = Material::new("m", Surface::Lambert { reflectance: Rgb::gray(0.5).into() });
    if opacity < 1.0 {
        material.alpha = Some(Alpha { value: opacity.into(), mode: AlphaMode::Blend });
    }
    let material = b.add_material(material).unwrap();
    let standing = soup(stream, 40, 0.25);
    let still = b.add_mesh(mesh(&standing), material).unwrap();
    b.add_instance(still, Affine3A::IDENTITY).unwrap();
    let mut movers = Vec::new();
    for number in 0..12 {
        let triangles = soup(stream, 12, 0.2);
        let mut closing = triangles.clone();
        if number % 2 == 1 {
            closing.iter_mut().flatten().for_each(|v| *v += point(stream, 0.4));
        }
        let shape = MeshShape { positions: closing.concat(), ..MeshShape::default() };
        let mesh = b.add_deforming_mesh(mesh(&triangles), shape, [3.0, 4.0], material).unwrap();
        let mut end = |seconds: f64| {
            let turn = Quat::from_vec4(point(stream, 1.0).extend(0.6).normalize());
            let map = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), turn, point(stream, 0.8));
            let linear = map.matrix3.as_dmat3();
            (seconds, DAffine3 { matrix3: linear, translation: map.translation.as_dvec3() })
        };
        let (first, second) = (end(3.0), end(4.0));
        let track = if number % 4 == 1 {
            b.add_instance(mesh, first.1.as_affine3a()).unwrap().unwrap();
            Track::new([first]).unwrap()
        } else {
            let track = Track::new([first, second]).unwrap();
            b.add_moving_instance(mesh, track.clone(), [3.0, 4.0]).unwrap().unwrap();
            track
        };
        movers.push(([triangles, closing], track));
    }
    MovingSoups { tracer: Tracer::new(Arc::new(b.build().unwrap())), standing, movers }
}

/// At many random times, rays and segments meet static and moving geometry where it is at that
/// time. Code without vector instructions gives the same answers.
#[test]
fn what_moves_is_met_where_it_is_at_the_time_of_the_ray() {
    let mut s = Stream::new(31, Purpose::Test, 0);
    let soups = moving_soups(&mut s, 1.0);
    let (t, plain) = (&soups.tracer, soups.tracer.plain());
    let mut judged = [0; 4];
    for _ in 0..90 {
        let share = s.uniform();
        let all = soups.at(share);
        for _ in 0..200 {
            let ray = Ray::new(point(&mut s, 1.5), point(&mut s, 1.0));
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let hits: Vec<(f64, f64)> =
                all.iter().filter_map(|c| meets_exactly(o, d, c)).filter(|(at, _)| *at > -1e-4).collect();
            // Skips rays that pass near an edge or meet a surface near their start.
            if hits.iter().any(|&(at, margin)| margin < 1e-4 || at < 1e-4) {
                continue;
            }
            let exact = hits.iter().map(|(at, _)| *at).fold(f64::INFINITY, f64::min);
            let found = t.closest_hit_at(&ray, 0, share);
            assert_eq!(found, plain.closest_hit_at(&ray, 0, share));
            assert_eq!(found.is_some(), exact.is_finite(), "{ray:?} at {share}");
            if let Some(hit) = found {
                assert!((f64::from(hit.t) - exact).abs() < 1e-4 * (1.0 + exact), "{hit:?} for {exact}");
                let p = t.scene().surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
                assert!((p.position - ray.at(hit.t)).length() < 1e-5, "the surface is where it was met");
                let deforms = t.scene().mesh_of(hit.instance).deforms().is_some();
                let kind = usize::from(t.scene().motion_of(hit.instance).is_some()) + usize::from(deforms);
                judged[kind] += 1;
            }
        }
        for infinite in [false, true] {
            let apex = point(&mut s, 1.5);
            let targets: Vec<Vec3> = (0..20).map(|_| point(&mut s, 1.5)).collect();
            let mut batch = SegmentBatch::default();
            batch.push_fan(Apex::Point(Vec3::splat(9.0)), [Vec3::splat(8.0)]);
            let fan = if infinite { Apex::Direction(apex) } else { Apex::Point(apex) };
            batch.push_fan(fan, targets.iter().copied());
            let (mut found, mut other) = (Vec::new(), Vec::new());
            t.visibility_at(&batch, share, &mut found);
            plain.visibility_at(&batch, share, &mut other);
            assert_eq!(found, other);
            assert_eq!(found[0], 1.0);
            for (x, v) in targets.iter().zip(&found[1..]) {
                let exact = if infinite {
                    blocked_exactly(*x, apex, f64::INFINITY, &all)
                } else {
                    blocked_exactly(apex, *x, 1.0, &all)
                };
                if let Some(blocked) = exact {
                    judged[3] += usize::from(blocked);
                    assert_eq!(*v, if blocked { 0.0 } else { 1.0 }, "{fan:?} to {x:?} at {share}");
                }
            }
        }
    }
    assert!(judged.iter().all(|count| *count > 200), "all answers occur: {judged:?}");
}

/// Each surface along a segment transmits half of the light, whether static or moving.
#[test]
fn what_moves_lets_light_pass_by_its_opacity() {
    let mut s = Stream::new(32, Purpose::Test, 0);
    let [opaque, half] =
        [1.0, 0.5].map(|opacity| moving_soups(&mut Stream::new(33, Purpose::Test, 0), opacity));
    let mut met = 0;
    for _ in 0..3000 {
        let share = s.uniform();
        let (o, x) = (point(&mut s, 1.5), point(&mut s, 1.5));
        let all = half.at(share);
        let (o64, d) = (o.as_dvec3(), x.as_dvec3() - o.as_dvec3());
        let hits: Vec<_> = all.iter().filter_map(|c| meets_exactly(o64, d, c)).collect();
        if hits.iter().any(|&(at, margin)| margin < 1e-4 || at.abs() < 1e-4 || (at - 1.0).abs() < 1e-4) {
            continue;
        }
        let count = hits.iter().filter(|(at, _)| *at > 0.0 && *at < 1.0).count();
        let mut batch = SegmentBatch::default();
        batch.push_fan(Apex::Point(o), [x]);
        let mut found = Vec::new();
        half.tracer.visibility_at(&batch, share, &mut found);
        assert_eq!(found, [0.5_f32.powi(count as i32)]);
        opaque.tracer.visibility_at(&batch, share, &mut found);
        assert_eq!(found, [if count == 0 { 1.0 } else { 0.0 }]);
        met += usize::from(count > 1);
    }
    assert!(met > 50, "several are met: {met}");
}

/// A pane is stretched by its instance or by deformation. Its slope changes, and with it its
/// reflectance.
#[test]
fn a_pane_that_is_stretched_lets_light_pass_as_it_does_then() {
    let map = |x: f64| DAffine3::from_scale(DVec3::new(x, 1.0, 1.0));
    let track = Track::new([(3.0, map(0.2)), (4.0, map(4.0))]).unwrap();
    let pane = |at: Option<f64>, deforms: bool| {
        let mut b = SceneBuilder::new("test", Location::default());
        let (reflectance, transmittance) = (Rgb::WHITE.into(), Rgb::WHITE.into());
        let glass = Surface::ThinGlass { ior: 1.5, reflectance, transmittance, facets: 0.0.into() };
        let material = b.add_material(Material::new("pane", glass)).unwrap();
        let corners = [Vec3::new(-9.0, -9.0, -9.0), Vec3::new(9.0, -9.0, 9.0), Vec3::new(0.0, 9.0, 0.0)];
        if deforms {
            let [open, close] = [0.2, 4.0].map(|x| corners.map(|v| Vec3::new(x * v.x, v.y, v.z)));
            let closing = MeshShape { positions: close.to_vec(), ..MeshShape::default() };
            let mesh = b.add_deforming_mesh(mesh(&[open]), closing, [3.0, 4.0], material).unwrap();
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
            return Tracer::new(Arc::new(b.build().unwrap()));
        }
        let mesh = b.add_mesh(mesh(&[corners]), material).unwrap();
        match at {
            None => b.add_moving_instance(mesh, track.clone(), [3.0, 4.0]).unwrap(),
            Some(at) => b.add_instance(mesh, track.at(at).as_affine3a()).unwrap(),
        };
        Tracer::new(Arc::new(b.build().unwrap()))
    };
    let mut batch = SegmentBatch::default();
    batch.push_fan(Apex::Point(Vec3::new(0.0, 0.0, 1.0)), [Vec3::new(0.0, 0.0, -1.0)]);
    for deforms in [false, true] {
        let moving = pane(None, deforms);
        let mut passes = Vec::new();
        for share in [0.0, 0.3, 0.9_f32] {
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            moving.visibility_at(&batch, share, &mut found);
            pane(Some(3.0 + f64::from(share)), false).visibility(&batch, &mut expected);
            assert!((found[0] - expected[0]).abs() < 1e-5, "{share}: {found:?} for {expected:?}");
            passes.push(found[0]);
        }
        assert!(passes[2] - passes[0] > 0.1, "steep, it reflects more: {passes:?}");
    }
}
