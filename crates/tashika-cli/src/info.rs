//! `tashika info`.

use std::collections::BTreeMap;

use indicatif::{HumanBytes, HumanCount};
use serde::Serialize;
use tashika::render::with_threads;
use tashika::scene::{Emitter, Material, NoteKind, Scene, Surface};

use crate::exit::{Failure, Outcome};
use crate::plan::InfoPlan;
use crate::progress::Meter;
use crate::summary::{Rows, Triangles, counted, write_json};

/// Everything that is told about a scene.
#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    format: &'static str,
    meshes: usize,
    instances: usize,
    triangles: Triangles,
    materials: Materials,
    images: Images,
    emitters: Emitters,
    environment: Option<EnvironmentReport>,
    cameras: Vec<CameraReport>,
    /// Corners of the box around everything (m).
    bounds: [[f32; 3]; 2],
    notes: Vec<NoteReport>,
}

#[derive(Debug, Default, Serialize)]
struct Materials {
    count: usize,
    /// How many of each kind, kinds that occur only.
    kinds: BTreeMap<&'static str, usize>,
    textured: usize,
    emissive: usize,
    transparent: usize,
}

#[derive(Debug, Serialize)]
struct Images {
    count: usize,
    bytes: u64,
}

#[derive(Debug, Default, Serialize)]
struct Emitters {
    /// Instances whose material emits.
    area: u64,
    area_triangles: u64,
    point: u64,
    spot: u64,
    directional: u64,
}

#[derive(Debug, Serialize)]
struct EnvironmentReport {
    /// Mean radiance, RGB (W·m⁻²·sr⁻¹).
    mean_radiance: [f32; 3],
    /// Size of the map (texels); none if constant.
    resolution: Option<[u32; 2]>,
}

#[derive(Debug, Serialize)]
struct CameraReport {
    name: String,
    resolution: Option<[u32; 2]>,
    vertical_fov_degrees: f32,
}

#[derive(Debug, Serialize)]
struct NoteReport {
    kind: NoteKind,
    message: String,
    /// Where it was met first.
    first: String,
    count: u64,
}

/// Reads a scene and tells about it.
pub fn run(plan: &InfoPlan) -> Result<Outcome, Failure> {
    let meter = Meter::new(plan.common.quiet);
    meter.phase(&format!("reading {}", plan.scene.label()));
    let scene = with_threads(plan.common.threads, || plan.scene.load())?;
    meter.finish();
    let report = report(&scene?, plan.scene.format());
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if !plan.common.quiet {
        rows(&report).print()?;
    }
    Ok(Outcome::Done)
}

fn report(scene: &Scene, format: &'static str) -> Report {
    let bounds = scene.bounds();
    Report {
        scene: scene.name().to_owned(),
        format,
        meshes: scene.meshes().len(),
        instances: scene.instances().len(),
        triangles: Triangles { stored: scene.stored_triangles(), instanced: scene.instanced_triangles() },
        materials: materials(scene.materials()),
        images: Images {
            count: scene.images().len(),
            bytes: scene.images().iter().map(|i| i.bytes() as u64).sum(),
        },
        emitters: emitters(scene),
        environment: scene
            .environment()
            .map(|e| EnvironmentReport { mean_radiance: e.mean().to_array(), resolution: e.resolution() }),
        cameras: scene
            .cameras()
            .iter()
            .map(|c| CameraReport {
                name: c.name.clone(),
                resolution: c.resolution,
                vertical_fov_degrees: c.vertical_fov.to_degrees(),
            })
            .collect(),
        bounds: [bounds.lo.to_array(), bounds.hi.to_array()],
        notes: scene
            .notes()
            .iter()
            .map(|n| NoteReport {
                kind: n.kind,
                message: n.message,
                first: n.first.to_string(),
                count: n.count,
            })
            .collect(),
    }
}

fn materials(all: &[Material]) -> Materials {
    let mut report = Materials { count: all.len(), ..Materials::default() };
    for material in all {
        let (kind, textured) = kind(&material.surface);
        *report.kinds.entry(kind).or_default() += 1;
        let glows = material.emission.as_ref().is_some_and(|e| e.radiance.texture.is_some());
        let cut = material.alpha.as_ref().is_some_and(|a| a.value.texture.is_some());
        report.textured += usize::from(textured || glows || cut);
        report.emissive += usize::from(material.emission.is_some());
        report.transparent += usize::from(material.may_be_transparent());
    }
    report
}

/// Name of the kind, and whether an image takes part.
fn kind(surface: &Surface) -> (&'static str, bool) {
    match surface {
        Surface::Lambert { reflectance } => ("lambert", reflectance.texture.is_some()),
        Surface::Phong { diffuse, specular, .. } => {
            ("phong", diffuse.texture.is_some() || specular.texture.is_some())
        }
        Surface::Conductor { alpha, .. } => ("conductor", alpha.texture.is_some()),
        Surface::Coated { reflectance, specular, alpha, .. } => {
            ("coated", reflectance.texture.is_some() || specular.texture.is_some() || alpha.texture.is_some())
        }
        Surface::MetallicRoughness { base_color, metallic, roughness, .. } => (
            "metallic-roughness",
            base_color.texture.is_some() || metallic.texture.is_some() || roughness.texture.is_some(),
        ),
        Surface::Mirror { reflectance } => ("mirror", reflectance.texture.is_some()),
        Surface::Glass { .. } => ("glass", false),
    }
}

fn emitters(scene: &Scene) -> Emitters {
    let mut report = Emitters::default();
    for (instance, _) in scene.area_emitters() {
        report.area += 1;
        report.area_triangles += scene.mesh_of(instance).triangles().len() as u64;
    }
    for emitter in scene.emitters() {
        *match emitter {
            Emitter::Point { .. } => &mut report.point,
            Emitter::Spot { .. } => &mut report.spot,
            Emitter::Directional { .. } => &mut report.directional,
        } += 1;
    }
    report
}

fn rows(report: &Report) -> Rows {
    let mut rows = Rows::default();
    rows.push("scene", format!("{} ({})", report.scene, report.format));
    let Triangles { stored, instanced } = report.triangles;
    rows.push("triangles", format!("{} stored, {} instanced", HumanCount(stored), HumanCount(instanced)));
    let meshes = counted(report.meshes as u64, "mesh", "meshes");
    rows.push("", format!("{meshes}, {}", counted(report.instances as u64, "instance", "instances")));
    let [low, high] = report.bounds;
    let extent: Vec<String> = low.iter().zip(high).map(|(l, h)| format!("{:.3}", h - l)).collect();
    rows.push("size", format!("{} m, from {low:?} to {high:?}", extent.join(" x ")));
    let m = &report.materials;
    let kinds: Vec<String> = m.kinds.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    rows.push("materials", format!("{}: {}", HumanCount(m.count as u64), kinds.join(", ")));
    rows.push("", format!("{} textured, {} emissive, {} transparent", m.textured, m.emissive, m.transparent));
    rows.push(
        "images",
        format!("{}, {}", HumanCount(report.images.count as u64), HumanBytes(report.images.bytes)),
    );
    let e = &report.emitters;
    let triangles = counted(e.area_triangles, "triangle", "triangles");
    let others = format!("{} point, {} spot, {} directional", e.point, e.spot, e.directional);
    rows.push("emitters", format!("{} area ({triangles}), {others}", HumanCount(e.area)));
    let environment = report.environment.as_ref().map_or("none".to_owned(), |e| {
        let [r, g, b] = e.mean_radiance;
        let map = e.resolution.map_or("constant".to_owned(), |[w, h]| format!("map of {w}x{h}"));
        format!("{map}, mean radiance {r:.4} {g:.4} {b:.4} W/m2/sr")
    });
    rows.push("environment", environment);
    for (i, camera) in report.cameras.iter().enumerate() {
        let size = camera.resolution.map_or("no size given".to_owned(), |[w, h]| format!("{w}x{h}"));
        let label = if i == 0 { "cameras" } else { "" };
        rows.push(label, format!("{}: {size}, {:.1} degrees high", camera.name, camera.vertical_fov_degrees));
    }
    if report.notes.is_empty() {
        rows.push("notes", "none: the scene is rendered as its file says");
    }
    let mut last = None;
    for note in &report.notes {
        let label = match note.kind {
            _ if last == Some(note.kind) => "",
            NoteKind::Repaired => "repaired",
            NoteKind::Approximated => "approximated",
            NoteKind::Ignored => "ignored",
            NoteKind::Defaulted => "defaulted",
        };
        last = Some(note.kind);
        let times =
            if note.count == 1 { String::new() } else { format!(" ({} times)", HumanCount(note.count)) };
        rows.push(label, format!("{}: {}{times}", note.first, note.message));
    }
    rows
}
