//! The built-in scenes: size, validity, closedness and reproducibility.

use glam::{Vec2, Vec3};

use super::room::{DEPTH, HEIGHT, WALL, WIDTH, WINDOW};
use super::{room, tiny};
use crate::bsdf::{Bsdf, ConductorFresnel};
use crate::math::Aabb;
use crate::rng::{Purpose, Stream};
use crate::scene::{Instance, Mesh, Scene, Surface};
use crate::warp;

/// Every instance with its mesh.
fn placed(scene: &Scene) -> impl Iterator<Item = (&Instance, &Mesh)> {
    scene.instances().iter().map(|i| (i, &scene.meshes()[i.mesh.index()]))
}

/// World corners of all triangles of meshes whose name satisfies `wanted`, counter-clockwise seen
/// from their front.
fn triangles(scene: &Scene, wanted: impl Fn(&str) -> bool) -> Vec<[Vec3; 3]> {
    let mut all = Vec::new();
    for (instance, mesh) in placed(scene).filter(|(_, mesh)| wanted(mesh.name())) {
        for t in 0..mesh.triangles().len() as u32 {
            let [a, b, c] = mesh.corners(t).map(|v| instance.to_world.transform_point3(v));
            all.push(if instance.mirrored { [a, c, b] } else { [a, b, c] });
        }
    }
    all
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize()
}

fn centroid([a, b, c]: [Vec3; 3]) -> Vec3 {
    (a + b + c) / 3.0
}

#[test]
fn the_room_is_large_and_nothing_of_it_needed_repair() {
    let scene = room();
    assert_eq!(scene.name(), "room");
    assert!((100_000..250_000).contains(&scene.stored_triangles()), "{}", scene.stored_triangles());
    assert!(
        scene.instanced_triangles() > scene.stored_triangles() + 50_000,
        "things that repeat are instances"
    );
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
    assert!(scene.instances().iter().any(|i| i.mirrored), "one curtain is the other's mirror image");
}

#[test]
fn the_tiny_scene_is_tiny() {
    let scene = tiny();
    assert_eq!((scene.name(), scene.instanced_triangles()), ("tiny", 36));
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
    assert_eq!(scene.cameras().len(), 1);
    assert_eq!(scene.camera("main").expect("a camera").resolution, Some([32, 32]));
    assert!(scene.materials().iter().any(|m| matches!(m.surface, Surface::Phong { .. })));
}

#[test]
fn two_builds_are_equal() {
    for build in [room, tiny] {
        let (a, b) = (build(), build());
        assert_eq!(a.meshes().len(), b.meshes().len());
        for (m, n) in a.meshes().iter().zip(b.meshes()) {
            assert_eq!(
                (m.positions(), m.normals(), m.uvs()),
                (n.positions(), n.normals(), n.uvs()),
                "{}",
                m.name()
            );
            assert_eq!((m.triangles(), m.material), (n.triangles(), n.material), "{}", m.name());
        }
        assert!(
            a.instances()
                .iter()
                .map(|i| (i.mesh, i.to_world))
                .eq(b.instances().iter().map(|i| (i.mesh, i.to_world)))
        );
        assert_eq!(a.materials(), b.materials());
        assert_eq!((a.emitters(), a.cameras()), (b.emitters(), b.cameras()));
    }
}

/// The front of every triangle is the side of its vertex normals, so that one-sided emission and
/// the front of glass agree with shading.
#[test]
fn normals_agree_with_the_winding() {
    for scene in [room(), tiny()] {
        for mesh in scene.meshes() {
            for t in mesh.triangles() {
                let face = normal(t.map(|i| mesh.positions()[i as usize]));
                let shading: Vec3 = t.iter().map(|&i| mesh.normals()[i as usize]).sum();
                assert!(face.dot(shading) > 0.0, "{}", mesh.name());
            }
        }
    }
}

#[test]
fn everything_but_the_daylight_is_inside_the_room() {
    let scene = room();
    // Covers the rounding of coordinates of a few metres.
    let slack = Vec3::splat(1e-5);
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let inside = Aabb { lo: -slack, hi: Vec3::new(WIDTH, HEIGHT, DEPTH) + slack };
    let window = Aabb { lo: Vec3::new(-WALL, lo_y, lo_z) - slack, hi: Vec3::new(0.0, hi_y, hi_z) + slack };
    for (instance, mesh) in placed(&scene).filter(|(_, m)| !["sky", "facade"].contains(&m.name())) {
        for &i in mesh.triangles().iter().flatten() {
            let p = instance.to_world.transform_point3(mesh.positions()[i as usize]);
            assert!(inside.contains(p) || window.contains(p), "{} at {p}", mesh.name());
        }
    }
}

/// Rays from the camera and from the lamp, in random directions, leave the room only through the
/// window. All others hit the front of its shell.
#[test]
fn the_room_is_closed_but_for_the_window() {
    let scene = room();
    let shell =
        triangles(&scene, |name| ["accent wall", "ceiling", "walls", "screed", "reveal"].contains(&name));
    let mut stream = Stream::new(0, Purpose::Test, 0);
    let lamp = centroid(triangles(&scene, |name| name == "bulb")[0]);
    let mut left = 0;
    for origin in [scene.cameras()[0].position(), lamp] {
        for _ in 0..4000 {
            let direction = warp::sphere(stream.uniform_2());
            let nearest = shell
                .iter()
                .filter_map(|&t| {
                    let along = normal(t).dot(direction);
                    let distance = (t[0] - origin).dot(normal(t)) / along;
                    let p = origin + direction * distance;
                    let edges = [0, 1, 2].map(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(normal(t)));
                    (distance > 0.0 && edges.iter().all(|&e| e > -1e-6)).then_some((distance, along))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match nearest {
                Some((_, along)) => assert!(along < 0.0, "the shell faces inwards"),
                None => {
                    let p = origin + direction * ((-WALL - origin.x) / direction.x);
                    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
                    assert!((lo_y..=hi_y).contains(&p.y) && (lo_z..=hi_z).contains(&p.z), "leaves at {p}");
                    left += 1;
                }
            }
        }
    }
    assert!(left > 50, "the window is open: {left}");
}

#[test]
fn emitters_face_the_room() {
    let scene = room();
    let window = Vec3::new(0.0, 1.6, 2.0);
    for t in triangles(&scene, |name| name == "sky") {
        assert!(normal(t).dot(window - centroid(t)) > 0.0 && centroid(t).x < -WALL);
    }
    let bulb = triangles(&scene, |name| name == "bulb");
    let center = Aabb::of_points(bulb.iter().flatten().copied()).center();
    assert!(bulb.iter().all(|&t| normal(t).dot(centroid(t) - center) > 0.0));
    assert!(triangles(&tiny(), |name| name == "light").iter().all(|&t| normal(t).y < -0.999));
    let names =
        |s: &Scene| s.area_emitters().map(|(i, _)| s.mesh_of(i).name().to_owned()).collect::<Vec<_>>();
    assert_eq!(
        (names(&room()), names(&tiny())),
        (vec!["sky".into(), "bulb".into()], vec!["light".to_owned()])
    );
}

#[test]
fn materials_are_valid_and_not_too_white() {
    for scene in [room(), tiny()] {
        for material in scene.materials() {
            for uv in [Vec2::ZERO, Vec2::new(0.3, 0.7), Vec2::new(0.5, 0.05)] {
                let bsdf = scene.part_of(material, uv, 1.0, 0.5).bsdf;
                assert_eq!(bsdf.validate(), Ok(()), "{}", material.name);
                let metal_or_glass = matches!(bsdf, Bsdf::Conductor(_) | Bsdf::Glass(_));
                assert!(metal_or_glass || bsdf.albedo().max_channel() <= 0.8, "{}: {bsdf:?}", material.name);
            }
        }
    }
}

#[test]
fn the_room_shows_each_kind_of_gloss() {
    let scene = room();
    let count =
        |wanted: &dyn Fn(&Surface) -> bool| scene.materials().iter().filter(|m| wanted(&m.surface)).count();
    for n in [5.0, 20.0, 80.0, 300.0, 1000.0] {
        assert!(
            count(&|s| matches!(s, Surface::Phong { exponent, .. } if *exponent == n)) > 0,
            "exponent {n}"
        );
    }
    let exact = |s: &Surface| matches!(s, Surface::Conductor { fresnel: ConductorFresnel::Exact { .. }, .. });
    assert_eq!(count(&exact), 1);
    assert_eq!(count(&|s| matches!(s, Surface::Mirror { .. })), 1);
    assert_eq!(count(&|s| matches!(s, Surface::Glass { .. })), 1);
    assert!(count(&|s| matches!(s, Surface::Coated { .. })) > 3);
}

#[test]
fn cameras_stand_free_inside_the_room() {
    let scene = room();
    let names: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["main", "close"]);
    assert_eq!(scene.cameras()[0].resolution, Some([640, 360]));
    let walls = Aabb { lo: Vec3::ZERO, hi: Vec3::new(WIDTH, HEIGHT, DEPTH) };
    for camera in scene.cameras() {
        let eye = camera.position();
        assert!(walls.contains(eye));
        for (instance, mesh) in placed(&scene) {
            let nearest =
                mesh.positions().iter().map(|&p| instance.to_world.transform_point3(p).distance(eye));
            assert!(
                nearest.fold(f32::INFINITY, f32::min) > 0.2,
                "{} is in front of {}",
                mesh.name(),
                camera.name
            );
        }
    }
}
