//! `tashika info`.

use std::collections::BTreeMap;
use std::time::Instant;

use indicatif::{HumanBytes, HumanCount};
use serde::Serialize;
use tashika::scene::{Emitter, Material, NoteKind, Projection, Scattered, Scene, SphereMap};

use crate::exit::{Failure, Outcome};
use crate::notes::{NoteReport, notes};
use crate::plan::InfoPlan;
use crate::progress::{Meter, metered};
use crate::summary::{Rows, Triangles, counted, write_json};

/// Description of a scene, as JSON.
#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    format: &'static str,
    meshes: usize,
    instances: usize,
    triangles: Triangles,
    materials: Materials,
    images: Images,
    memory_bytes: Memory,
    /// Seconds from the start of reading to a checked scene.
    load_seconds: f64,
    emitters: Emitters,
    environment: Option<EnvironmentReport>,
    /// True if emitters and environment are the defaults of a scene without light.
    default_light: bool,
    /// Requested changes to the light of the file.
    changes: Vec<String>,
    /// Times at which the motion in the file begins and ends (s).
    animated_seconds: Option<[f64; 2]>,
    /// Time of the described scene (s), if anything moves and a time was given.
    time_seconds: Option<f64>,
    /// Instances that move while the shutter is open.
    moving_instances: usize,
    /// Times at which the shutter opens and closes (s), if any instances move.
    shutter_seconds: Option<[f64; 2]>,
    cameras: Vec<CameraReport>,
    media: Vec<MediumReport>,
    /// True if any interface or camera names a medium that absorbs or scatters light.
    has_media: bool,
    /// True if any medium scatters light.
    scatters: bool,
    /// Corners of the box around everything (m).
    bounds: [[f64; 3]; 2],
    notes: Vec<NoteReport>,
}

#[derive(Debug, Default, Serialize)]
struct Materials {
    count: usize,
    /// Number of materials of each kind that occurs.
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

/// Memory of the scene (bytes), without the trees that rendering adds.
#[derive(Debug, Serialize)]
struct Memory {
    meshes: u64,
    instances: u64,
    images: u64,
}

#[derive(Debug, Default, Serialize)]
struct Emitters {
    /// Instances whose material emits.
    area: u64,
    area_triangles: u64,
    point: u64,
    spot: u64,
    /// Emitters whose intensity is an image.
    image: u64,
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
    projection: &'static str,
    /// Field of view (degrees) of perspectives and fisheyes, height of the film (m) of orthographic
    /// cameras; none if all directions are seen.
    height: Option<f32>,
    /// Times at which the camera's shutter opens and closes (s), if the camera moves meanwhile.
    shutter_seconds: Option<[f64; 2]>,
    /// Name of the medium around the camera.
    medium: Option<String>,
}

#[derive(Debug, Serialize)]
struct MediumReport {
    name: String,
    /// Coefficient of absorption, RGB (m⁻¹).
    absorption: [f32; 3],
    /// Coefficient of scattering, RGB (m⁻¹).
    scattering: [f32; 3],
    /// Mean cosine of the phase function.
    asymmetry: f32,
    /// Cells along each axis of the grid that multiplies the coefficients, if there is one.
    density_cells: Option<[u32; 3]>,
    /// Cells along each axis of the grid of the albedo or of the scattering coefficient, if there
    /// is one.
    scattering_cells: Option<[u32; 3]>,
}

/// Reads a scene and prints its description.
pub fn run(plan: &InfoPlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &InfoPlan, meter: &Meter) -> Result<Outcome, Failure> {
    meter.phase(&format!("reading {}", plan.scene.label()));
    let started = Instant::now();
    let scene = plan.scene.load()?;
    let seconds = started.elapsed().as_secs_f64();
    meter.finish();
    let report = report(&scene, plan.scene.format(), seconds);
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() {
        rows(&report).print()?;
    }
    Ok(Outcome::Done)
}

fn report(scene: &Scene, format: &'static str, load_seconds: f64) -> Report {
    let bounds = scene.bounds_in_file();
    Report {
        scene: scene.name().to_owned(),
        format,
        meshes: scene.meshes().len(),
        instances: scene.instances().len(),
        triangles: Triangles::of(scene),
        materials: materials(scene.materials()),
        images: Images {
            count: scene.images().len(),
            bytes: scene.images().iter().map(|i| i.bytes() as u64).sum(),
        },
        memory_bytes: Memory {
            meshes: scene.mesh_bytes(),
            instances: size_of_val(scene.instances()) as u64,
            images: scene.images().iter().map(|i| i.bytes() as u64).sum(),
        },
        load_seconds,
        emitters: emitters(scene),
        environment: scene
            .environment()
            .map(|e| EnvironmentReport { mean_radiance: e.mean().to_array(), resolution: e.resolution() }),
        default_light: scene.has_default_light(),
        changes: scene.changes().to_vec(),
        animated_seconds: scene.animated_seconds(),
        time_seconds: scene.time(),
        moving_instances: scene.instance_ids().filter(|&id| scene.motion_of(id).is_some()).count(),
        shutter_seconds: scene.shutter(),
        cameras: scene
            .cameras()
            .iter()
            .map(|c| {
                let (projection, height) = match c.projection {
                    Projection::Perspective { vertical_fov } => {
                        ("perspective", Some(vertical_fov.to_degrees()))
                    }
                    Projection::Orthographic { height } => ("orthographic", Some(height)),
                    Projection::Fisheye { angle } => ("fisheye", Some(angle.to_degrees())),
                    Projection::Spherical { map: SphereMap::LatLong } => ("spherical", None),
                    Projection::Spherical { map: SphereMap::EqualArea } => ("equal-area", None),
                };
                CameraReport {
                    name: c.name.clone(),
                    resolution: c.resolution,
                    projection,
                    height,
                    shutter_seconds: c.motion.as_ref().map(|motion| motion.shutter),
                    medium: c.medium.map(|m| scene.media()[m.index()].name.clone()),
                }
            })
            .collect(),
        media: scene
            .media()
            .iter()
            .map(|m| MediumReport {
                name: m.name.clone(),
                absorption: m.absorption.to_array(),
                scattering: m.scattering.to_array(),
                asymmetry: m.phase.asymmetry,
                density_cells: m.density().map(|density| density.grid().counts()),
                scattering_cells: m.variation.as_ref().and_then(|v| match v.scattered() {
                    Scattered::Evenly => None,
                    Scattered::Albedo(grid) | Scattered::Coefficient(grid) => Some(grid.counts()),
                }),
            })
            .collect(),
        has_media: scene.has_media(),
        scatters: scene.scatters(),
        bounds: bounds.map(|corner| corner.to_array()),
        notes: notes(scene),
    }
}

fn materials(all: &[Material]) -> Materials {
    let mut report = Materials { count: all.len(), ..Materials::default() };
    for material in all {
        *report.kinds.entry(material.surface.kind()).or_default() += 1;
        report.textured += usize::from(material.is_textured());
        report.emissive += usize::from(material.emission.is_some());
        report.transparent += usize::from(material.has_holes() || material.surface.kind().ends_with("glass"));
    }
    report
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
            Emitter::Image { .. } => &mut report.image,
            Emitter::Directional { .. } => &mut report.directional,
        } += 1;
    }
    report
}

fn rows(report: &Report) -> Rows {
    let mut rows = Rows::default();
    rows.push("scene", format!("{} ({})", report.scene, report.format));
    let Triangles { stored, instanced, without_area } = report.triangles;
    let flat = match without_area {
        0 => String::new(),
        count => format!(", {} without area left out", HumanCount(count)),
    };
    let counts = format!("{} stored, {} instanced{flat}", HumanCount(stored), HumanCount(instanced));
    rows.push("triangles", counts);
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
    let memory = &report.memory_bytes;
    rows.push(
        "memory",
        format!(
            "{} meshes, {} instances, {} images; loaded in {:.1} s",
            HumanBytes(memory.meshes),
            HumanBytes(memory.instances),
            HumanBytes(memory.images),
            report.load_seconds
        ),
    );
    let e = &report.emitters;
    let triangles = counted(e.area_triangles, "triangle", "triangles");
    let others =
        format!("{} point, {} spot, {} image, {} directional", e.point, e.spot, e.image, e.directional);
    rows.push("emitters", format!("{} area ({triangles}), {others}", HumanCount(e.area)));
    let environment = report.environment.as_ref().map_or("none".to_owned(), |e| {
        let [r, g, b] = e.mean_radiance;
        let map = e.resolution.map_or("constant".to_owned(), |[w, h]| format!("map of {w}x{h}"));
        format!("{map}, mean radiance {r:.4} {g:.4} {b:.4} W/m2/sr")
    });
    rows.push("environment", environment);
    if report.default_light {
        rows.push("", "the program's own, with its sun: the scene has no light");
    }
    for (i, change) in report.changes.iter().enumerate() {
        rows.push(if i == 0 { "asked for" } else { "" }, change);
    }
    if let Some([from, to]) = report.animated_seconds {
        let shown =
            report.time_seconds.map_or("without a time (--at)".to_owned(), |at| format!("at {at:.3} s"));
        rows.push("moves", format!("from {from:.3} to {to:.3} s; shown {shown}"));
    }
    if let Some([open, close]) = report.shutter_seconds {
        let (moving, all) = (report.moving_instances, report.instances);
        let moving =
            if all == 1 { "the instance".to_owned() } else { format!("{moving} of {all} instances") };
        let meanwhile = format!("{moving}, with the shutter open from {open:.4} to {close:.4} s");
        rows.push("", format!("{meanwhile}: rendered by path tracing, or as a sum over VPLs"));
    }
    for (i, camera) in report.cameras.iter().enumerate() {
        let size = camera.resolution.map_or("no size given".to_owned(), |[w, h]| format!("{w}x{h}"));
        let label = if i == 0 { "cameras" } else { "" };
        let sees = match (camera.projection, camera.height) {
            ("orthographic", Some(height)) => format!("{height:.1} metres high"),
            ("perspective", Some(degrees)) => format!("{degrees:.1} degrees high"),
            (projection, Some(degrees)) => format!("{projection}, {degrees:.1} degrees"),
            (projection, None) => format!("{projection}, all around"),
        };
        let moves = camera.shutter_seconds.map_or(String::new(), |[open, close]| {
            format!(", moves with its shutter open from {open:.4} to {close:.4} s")
        });
        let within = camera.medium.as_ref().map_or(String::new(), |medium| format!(", in {medium}"));
        rows.push(label, format!("{}: {size}, {sees}{moves}{within}", camera.name));
    }
    for (i, medium) in report.media.iter().enumerate() {
        let MediumReport { name, absorption, scattering, asymmetry, density_cells, scattering_cells } =
            medium;
        let grid = |of: &str, cells: &Option<[u32; 3]>| {
            cells.map_or(String::new(), |[x, y, z]| format!(", {of} by a grid of {x}×{y}×{z}"))
        };
        let grids = grid("density", density_cells) + &grid("scattering", scattering_cells);
        let [a, s] = [absorption, scattering].map(|[r, g, b]| format!("{r:.4} {g:.4} {b:.4}"));
        let label = if i == 0 { "media" } else { "" };
        rows.push(label, format!("{name}: absorption {a}, scattering {s} per metre, g = {asymmetry}{grids}"));
    }
    if report.scatters {
        rows.push("", "rendered by path tracing, or by VPLs where the truth is named (--truth)");
    }
    if report.notes.is_empty() {
        rows.push("notes", "none: the scene is rendered as its file says");
    }
    let mut last = None;
    for note in &report.notes {
        let label = match note.kind {
            _ if last == Some(note.kind) => "",
            NoteKind::Missing => "missing",
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
