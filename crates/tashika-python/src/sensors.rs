//! Illuminance at sensors: `tashika.sensors`.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tashika::film::Tally;
use tashika::io::{LoadOptions, load_sensor_points};
use tashika::math::DVec3;
use tashika::request::Request;
use tashika::scene::{SensorPoint, SensorShape};
use tashika::sensors::{GridSummary, Photometry, SensorGridRequest, SensorRequest, SensorSet};

use crate::arrays::{array, wide_rows, wide_vectors};
use crate::attended::attended;
use crate::errors::{option, raised};
use crate::json::from_json;
use crate::scene::Scene;
use crate::{vpls, words};

/// Shapes of sensors, by name.
const SHAPES: [(&str, SensorShape); 3] =
    [("plane", SensorShape::Plane), ("cylinder", SensorShape::Cylinder), ("sphere", SensorShape::Sphere)];

/// Measures illuminance at sensors, each with an interval; other Python threads run meanwhile.
///
/// The result is a dict of arrays, in the order of the sensors: "position" and "normal" (n, 3),
/// "illuminance" and "half_width" (lx; NaN where nothing is claimed), "irradiance" by channel (n,
/// 3; W/m²), "rays"; lists "name", "claim" and "stop"; "tally", the numbers of sensors by claim;
/// and "summary" with the mean, the extremes and the uniformity of all sensors with their intervals
/// (None if no sensor was measured).
///
/// - `points`: an array (n, 6) of positions (m) and normals, the name of a file (.pts or .csv), or
///   None with `grid`: "OBJECT:SPACING[,height=H][,up=z]" or
///   "X0,Y0,Z0..X1,Y1,Z1:SPACING[,height=H]". `shape` of the sensors of an array: "plane",
///   "cylinder" or "sphere".
/// - `photometry`: "scene" (1 lm/W), "cie" (683 lm/W) or "radiance" (179 lm/W, its weights).
/// - `error` (0.05), `absolute` in lux, `confidence` (0.95), `claim` ("calibrated" or "certified"),
///   `method`, `vpls`, `clamp`, `max_pairs`, `paths`, `seed`, `threads` and `progress` are those of
///   `render`. With `jointly`, the intervals of all sensors hold together.
///
/// ```python
/// >>> desk = [[0, 0.2, 0, 0, 1, 0], [0.1, 0.2, 0, 0, 1, 0]]
/// >>> found = tashika.sensors(tashika.builtin("tiny"), desk, error=0.1, vpls=20000)
/// >>> found["illuminance"].shape, found["claim"]
/// ((2,), ['calibrated', 'calibrated'])
/// ```
#[pyfunction]
#[pyo3(signature = (
    scene, points=None, *, grid=None, shape="plane", photometry="scene", error=None, absolute=None, confidence=None,
    claim=None, jointly=false, method="tashika", vpls=None, clamp=None, max_pairs=None, paths=None, seed=1, threads=0,
    progress=None
))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn sensors<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    points: Option<&Bound<'py, PyAny>>,
    grid: Option<&str>,
    shape: &str,
    photometry: &str,
    error: Option<f64>,
    absolute: Option<f64>,
    confidence: Option<f64>,
    claim: Option<&str>,
    jointly: bool,
    method: &str,
    vpls: Option<u64>,
    clamp: Option<&Bound<'py, PyAny>>,
    max_pairs: Option<u64>,
    paths: Option<u64>,
    seed: u64,
    threads: usize,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let scene = scene.get();
    let points = match (points, grid) {
        (Some(points), None) => given(points, shape)?,
        (None, Some(text)) => {
            let grid: SensorGridRequest = text.parse().map_err(raised)?;
            grid.points(scene.tracer()).map_err(raised)?
        }
        _ => return Err(option("points", "neither or both", "either points or a grid")),
    };
    let photometry: Photometry = photometry.parse().map_err(raised)?;
    let (_, of_lights) = vpls::said(None, clamp, None)?;
    let request = Request {
        method: words::method(method)?,
        claim: claim.map(words::claim).transpose()?,
        error,
        absolute,
        confidence,
        max_pairs,
        paths,
        vpls,
        seed,
        ..of_lights
    };
    let asked = SensorRequest { request, photometry, jointly };
    let set = SensorSet::new(scene.tracer().scene(), points).map_err(raised)?;
    let request = asked.of(set.points().len()).map_err(raised)?;
    let rendered = attended(py, threads, progress, |watch| {
        let renderer = scene.renderer(set.camera(), &request).sensors(&set).observer(watch);
        renderer.render()
    })?;
    let readings = set.readings(&rendered.film, photometry);
    let mut tally = Tally::default();
    readings.iter().for_each(|reading| tally.count(reading.claim, reading.stop));
    let count = [readings.len()];
    let numbers = |of: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..readings.len()).map(of).collect();
        array(py, values.into_iter(), &count)
    };
    let of_points = set.points();
    let found = PyDict::new(py);
    found.set_item("name", of_points.iter().map(|point| point.name.as_str()).collect::<Vec<_>>())?;
    found.set_item("position", wide_vectors(py, of_points.iter().map(|p| p.position.to_array()))?)?;
    found.set_item("normal", wide_vectors(py, of_points.iter().map(|p| p.normal.to_array()))?)?;
    found.set_item("illuminance", numbers(&|k| readings[k].illuminance)?)?;
    found.set_item("half_width", numbers(&|k| readings[k].half_width.unwrap_or(f64::NAN))?)?;
    found.set_item("irradiance", wide_vectors(py, readings.iter().map(|reading| reading.irradiance))?)?;
    found.set_item("rays", numbers(&|k| readings[k].rays as f64)?)?;
    found.set_item("claim", readings.iter().map(|r| r.claim.code().name).collect::<Vec<_>>())?;
    found.set_item("stop", readings.iter().map(|r| r.stop.code().name).collect::<Vec<_>>())?;
    found.set_item("tally", from_json(py, &tally)?)?;
    let summary = GridSummary::of(&readings, asked.confidence(), jointly);
    found.set_item("summary", from_json(py, &summary)?)?;
    Ok(found)
}

/// Sensors of an array, or of a file.
fn given(points: &Bound<'_, PyAny>, shape: &str) -> PyResult<Vec<SensorPoint>> {
    if let Ok(path) = points.extract::<PathBuf>() {
        return load_sensor_points(&path, &LoadOptions::default()).map_err(raised);
    }
    let known = SHAPES.iter().find(|(name, _)| *name == shape);
    let shape = known.ok_or_else(|| option("shape", shape, SHAPES.map(|(name, _)| name).join(", ")))?.1;
    let rows = wide_rows::<6>("points", points)?;
    let point = |[x, y, z, nx, ny, nz]: [f64; 6]| {
        let plane = SensorPoint::plane(DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
        SensorPoint { shape, ..plane }
    };
    Ok(rows.into_iter().map(point).collect())
}
