//! Materials against the reflectance that their formats define: the rows of the tables
//! `formula_materials.txt` and `mitsuba_materials.txt`, loaded and measured.

use std::sync::OnceLock;

use tashika::color::Rgb;
use tashika::math::elementary::sin_cos;
use tashika::math::{Frame, Vec3};
use tashika::scene::{Material, Scene};

use crate::gltf::Document;
use crate::mitsuba::{load_in, xml};
use crate::{obj, pbrt};

/// Format name of the rows whose numbers come from Mitsuba.
pub const MITSUBA_3: &str = "Mitsuba 3";

/// Largest relative errors of albedos and values of rows without a note that states more.
const ALLOWED: [f64; 2] = [0.01; 2];

/// Largest relative errors for a rough boundary over a base, whose transmittance comes from a
/// table.
const ROUGH_BOUNDARY: [f64; 2] = [0.012, 0.022];

/// Elevations at which the albedos of a row are given (degrees).
const ELEVATIONS: [f32; 3] = [75.0, 40.0, 12.0];
/// Directions at which the values of a row are given: both elevations and the azimuth between them
/// (degrees).
const PAIRS: [[f32; 3]; 3] = [[75.0, 50.0, 150.0], [40.0, 30.0, 100.0], [12.0, 25.0, 170.0]];

/// A row, measured on the scene that its text describes.
pub struct Row {
    /// Name of the format that the text is in.
    pub format: &'static str,
    /// The material as text of its format.
    pub text: &'static str,
    /// Messages of the loader about the material.
    pub notes: Vec<String>,
    /// Relative errors of the worst albedo and of the worst value.
    pub off: [f64; 2],
    /// Found and expected numbers, for messages.
    numbers: String,
}

impl Row {
    /// Describes the row if its errors exceed `allowed` (for albedos and values) or the error that
    /// its notes state.
    pub fn disagreements(&self, allowed: [f64; 2]) -> Option<String> {
        let told = self.notes.iter().filter_map(|note| told(note)).reduce(f64::max);
        let allowed = told.map_or(allowed, |told| [told.max(allowed[0]), f64::INFINITY]);
        let wrong = self.off.iter().zip(allowed).any(|(off, allowed)| *off > allowed);
        wrong.then(|| format!("{:.3?} {} {}{}", self.off, self.format, self.text, self.numbers))
    }
}

/// Permitted errors of a row's albedos and values, if no note states more.
pub fn allowed(row: &Row) -> [f64; 2] {
    let has_boundary = ["roughplastic", "roughcoating"].iter().any(|name| row.text.contains(name));
    if has_boundary { ROUGH_BOUNDARY } else { ALLOWED }
}

/// Error that a note states, as a share of all light that the material reflects and transmits.
pub fn told(note: &str) -> Option<f64> {
    let (_, rest) = note.split_once("up to ")?;
    let (percent, _) = rest.split_once(" % off")?;
    Some(percent.parse::<f64>().ok()? / 100.0)
}

/// All rows of both tables.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let lines = |table: &'static str| table.lines().filter(|row| !row.starts_with('#'));
        let formulas = lines(include_str!("formula_materials.txt")).map(|row| {
            let [format, text, numbers] = row.split(" | ").collect::<Vec<_>>()[..] else { panic!("{row}") };
            measured(format, text, numbers)
        });
        let mitsuba = lines(include_str!("mitsuba_materials.txt")).map(|row| {
            let end = row.rfind('>').unwrap() + 1;
            measured(MITSUBA_3, &row[..end], &row[end..])
        });
        formulas.chain(mitsuba).collect()
    })
}

fn load(format: &str, text: &str) -> Scene {
    let material = if text.starts_with('"') { format!("Material {text}") } else { text.to_owned() };
    match format {
        "pbrt-v3" => pbrt::scene(&format!("{} {material} {} WorldEnd", pbrt::V3, pbrt::TRIANGLE)),
        "pbrt-v4" => pbrt::scene(&format!("{} {material} {}", pbrt::V4, pbrt::TRIANGLE)),
        MITSUBA_3 | "Mitsuba 0.6" => {
            let version = if format == MITSUBA_3 { "3.0.0" } else { "0.6.0" };
            let body = format!("<shape type=\"rectangle\">{text}</shape>");
            load_in(&[("scene.xml", xml(version, &body).as_bytes())]).1.unwrap()
        }
        "glTF" => {
            let mut d = Document::triangle();
            d.json["materials"][0] = serde_json::from_str(text).unwrap();
            d.load().unwrap()
        }
        "MTL" => obj::load_material(&text.replace("; ", "\n"), &[]),
        _ => panic!("{format}"),
    }
}

fn measured(format: &'static str, text: &'static str, numbers: &str) -> Row {
    let scene = load(format, text);
    let expected: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
    assert_eq!(expected.len(), 3 * (ELEVATIONS.len() + PAIRS.len()), "{text}");
    let (albedos, values) = expected.split_at(3 * ELEVATIONS.len());
    let found: Vec<f64> = ELEVATIONS.iter().flat_map(|&at| albedo(&scene, at)).collect();
    let found_values: Vec<f64> = PAIRS.iter().flat_map(|&pair| value(&scene, pair)).collect();
    // NaN marks values that are not compared; `max` ignores it.
    let worst = |found: &[f64], expected: &[f64], noise: f64| {
        let off = |(f, e): (&f64, &f64)| ((f - e).abs() - noise).max(0.0) / e.max(noise);
        found.iter().zip(expected).map(off).fold(0.0, f64::max)
    };
    // Albedos have a noise of drawing; they are given to four decimals.
    let off = [worst(&found, albedos, 0.002), worst(&found_values, values, 1e-6)];
    let numbers = format!("\n    {found:.4?}\n    {albedos:.4?}\n    {found_values:.4?}\n    {values:.4?}");
    let notes = scene.notes().iter().map(|note| note.message.to_owned()).collect();
    Row { format, text, notes, off, numbers }
}

fn direction(elevation: f32, azimuth: f32) -> Vec3 {
    let ((up, across), (y, x)) = (sin_cos(elevation.to_radians()), sin_cos(azimuth.to_radians()));
    Vec3::new(across * x, across * y, up)
}

/// The last material of the scene: parts of a mix are added before the mix.
fn material(scene: &Scene) -> &Material {
    scene.materials().last().unwrap()
}

fn opacity(scene: &Scene) -> f64 {
    material(scene).alpha.map_or(1.0, |alpha| f64::from(alpha.value.factor))
}

/// Directional albedo at an elevation, from a sequence of samples that fills the cube evenly.
fn albedo(scene: &Scene, elevation: f32) -> [f64; 3] {
    const DRAWS: u32 = 1 << 16;
    let outgoing = direction(elevation, 0.0);
    let frame = Frame::about(Vec3::Z);
    let mut sum = [0.0; 3];
    for draw in 0..DRAWS {
        // Powers of the inverse root of x⁵ = x + 1.
        let u = [0.856_674_88, 0.733_891_9, 0.628_706_7, 0.538_597_2];
        let u = u.map(|step: f64| (0.5 + step * f64::from(draw)).fract() as f32);
        let part = scene.part_of(material(scene), Default::default(), outgoing.z, u[0]);
        let sample = part.bsdf.sample(frame.to_local(outgoing), [u[1], u[2], u[3]]);
        let weight = sample.map_or(Rgb::BLACK, |sample| sample.weight) * part.weight;
        for (sum, value) in sum.iter_mut().zip(weight.to_array()) {
            *sum += f64::from(value) / f64::from(DRAWS);
        }
    }
    // Light that passes through holes is included.
    sum.map(|sum| opacity(scene) * sum + 1.0 - opacity(scene))
}

/// The BSDF times the cosine (sr⁻¹). Mixes choose a part by a number; this is the mean over evenly
/// spread numbers.
fn value(scene: &Scene, [elevation, other, azimuth]: [f32; 3]) -> [f64; 3] {
    const CHOICES: u16 = 1000;
    let (one, other) = (direction(elevation, 0.0), direction(other, azimuth));
    let mut sum = [0.0; 3];
    for choice in 0..CHOICES {
        let u = (f32::from(choice) + 0.5) / f32::from(CHOICES);
        let part = scene.part_of(material(scene), Default::default(), one.z, u);
        let value = if part.through { Rgb::BLACK } else { part.bsdf.eval_cos(one, other) * part.weight };
        for (sum, value) in sum.iter_mut().zip(value.to_array()) {
            *sum += f64::from(value) / f64::from(CHOICES);
        }
    }
    sum.map(|sum| opacity(scene) * sum)
}
