//! Measurements: exact sums of single pixels, and shares of pixels at which methods meet their
//! tolerance.

use std::sync::Arc;
use std::time::Instant;

use pyo3::prelude::*;
use tashika::experiment::{Cell, Ground, Group, Grouping, Pixels, Pool, Row, Subject, Watch as Listener};
use tashika::film::Window;
use tashika::integrator::{ControlOptions, SumMethod};
use tashika::render::render_pixels;
use tashika::renderer::{Prepared, Renderer};
use tashika::request::{Framing, Request};
use tashika::scene::Camera;
use tashika::tree::LightSet;

use crate::arrays::vectors;
use crate::attended::{Watch, attended};
use crate::errors::{option, raised};
use crate::json::from_json;
use crate::scene::Scene;
use crate::vpls;
use crate::words;

/// The exact many-light sums of some pixels, (x, y) from the top left: radiance, float32 of shape
/// (n, 3), in the order of the pixels.
///
/// Each is the value of that pixel by `render(method="exact")`; see there for the arguments.
///
/// ```python
/// >>> tashika.exact(tashika.builtin("tiny"), [(3, 2), (4, 5)], size=(8, 6), vpls=200).shape
/// (2, 3)
/// ```
#[pyfunction]
#[pyo3(signature = (
    scene, pixels, *, camera=None, size=None, vpls=None, gather=None, clamp=None, instants=None, seed=1, threads=0, filter=None,
    progress=None
))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn exact<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    pixels: Vec<[u32; 2]>,
    camera: Option<&str>,
    size: Option<[u32; 2]>,
    vpls: Option<&Bound<'py, PyAny>>,
    gather: Option<u64>,
    clamp: Option<&Bound<'py, PyAny>>,
    instants: Option<u64>,
    seed: u64,
    threads: usize,
    filter: Option<&str>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get();
    let camera = scene.camera(camera)?;
    let sum = Sum::of(vpls, clamp, instants, gather, filter, seed)?;
    let framing = Framing { size, crop: None };
    framing.of(camera).map_err(raised)?;
    let rendered = attended(py, threads, progress, |watch| {
        let prepared = sum.renderer(scene, camera).framing(framing).prepare()?;
        let exact = prepared.integrator()?;
        render_pixels(&prepared.setting(), exact.as_ref(), &pixels, &|p| watch.tell(p), watch.cancel())
    })?;
    let plane = &rendered.film.planes()[0];
    vectors(
        py,
        pixels.iter().map(|&[x, y]| <[f32; 3]>::try_from(plane.f32_at(x, y)).expect("three channels")),
    )
}

/// Shares of random pixels at which methods meet their tolerance, and at which their intervals
/// hold, judged by the exact sums of these pixels. The result is a list of rows as dicts, as
/// `tashika coverage --json` writes them; infinite errors are None.
///
/// There is one row for each combination of `methods` (default: all), `errors` and, for methods
/// with intervals, `confidences`. With `by`, a list of "brightness" and "material", there are also
/// rows for the pixels of each group. Each pixel is rendered `seeds` times. `pixels=None` measures
/// all pixels. The other arguments are those of `render`.
///
/// ```python
/// >>> rows = tashika.coverage(
/// ...     tashika.builtin("tiny"), methods=["tashika"], confidences=[0.95], pixels=10, size=(8, 6), vpls=200
/// ... )
/// >>> [(row["method"], row["error"], row["pixels"]) for row in rows]
/// [('tashika', 0.02, 10)]
/// ```
#[pyfunction]
#[pyo3(signature = (
    scene, *, methods=None, errors=vec![0.02], confidences=vec![0.5, 0.8, 0.9, 0.95, 0.99], pixels=Some(200), seeds=1, by=Vec::new(),
    camera=None, size=None, vpls=None, gather=None, clamp=None, instants=None, seed=1, threads=0, max_pairs=None, filter=None,
    progress=None
))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn coverage<'py>(
    py: Python<'py>,
    scene: &Bound<'py, Scene>,
    methods: Option<Vec<String>>,
    errors: Vec<f64>,
    confidences: Vec<f64>,
    pixels: Option<u64>,
    seeds: u64,
    by: Vec<String>,
    camera: Option<&str>,
    size: Option<[u32; 2]>,
    vpls: Option<&Bound<'py, PyAny>>,
    gather: Option<u64>,
    clamp: Option<&Bound<'py, PyAny>>,
    instants: Option<u64>,
    seed: u64,
    threads: usize,
    max_pairs: Option<u64>,
    filter: Option<&str>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get();
    let cells = cells(methods, &errors, &confidences, seeds, max_pairs)?;
    let by: Vec<Grouping> =
        by.iter().map(|name| words::named("by", name, &Grouping::ALL)).collect::<PyResult<_>>()?;
    let camera = scene.camera(camera)?;
    let framing = Framing { size, crop: None };
    let size = framing.of(camera).map_err(raised)?.size;
    let chosen = Pixels::of(Window::full(size), pixels, seed).map_err(raised)?;
    let sum = Sum::of(vpls, clamp, instants, gather, filter, seed)?;
    let measured = attended(py, threads, progress, |watch| {
        let prepared = sum.renderer(scene, camera).framing(framing).prepare()?;
        measure(&prepared, &chosen, &cells, &by, watch)
    })?;
    from_json(py, &measured)
}

/// Request for exact sums: lights that are given or traced, and gather points.
struct Sum {
    given: Option<Arc<LightSet>>,
    request: Request,
}

impl Sum {
    fn of(
        vpls: Option<&Bound<'_, PyAny>>,
        clamp: Option<&Bound<'_, PyAny>>,
        instants: Option<u64>,
        gather: Option<u64>,
        filter: Option<&str>,
        seed: u64,
    ) -> PyResult<Self> {
        let (given, of_lights) = vpls::said(vpls, clamp, instants)?;
        let filter = filter.map(words::filter).transpose()?;
        let method = SumMethod::Exact.into();
        let request = Request { method, gather, filter, seed, ..of_lights };
        request.validate().map_err(raised)?;
        Ok(Self { given: given.map(|set| set.get().shared()), request })
    }

    fn renderer<'s>(&self, scene: &'s Scene, camera: &Camera) -> Renderer<'s> {
        let renderer = scene.renderer(camera, &self.request);
        self.given.iter().cloned().fold(renderer, Renderer::lights)
    }
}

fn cells(
    methods: Option<Vec<String>>,
    errors: &[f64],
    confidences: &[f64],
    seeds: u64,
    max_pairs: Option<u64>,
) -> PyResult<Vec<Cell>> {
    if seeds == 0 {
        return Err(option("seeds", 0, "1 or more"));
    }
    let methods = match methods {
        None => words::all_measured(),
        Some(names) => names.iter().map(|name| words::measured(name)).collect::<PyResult<_>>()?,
    };
    let options = ControlOptions { max_pairs, ..ControlOptions::default() };
    let common = Cell { method: SumMethod::Exact, options, tolerance: 0.0, seeds };
    let told = errors.iter().map(|error| ControlOptions { error: *error, ..options });
    let told = told
        .chain(confidences.iter().map(|confidence| ControlOptions { confidence: *confidence, ..options }));
    told.into_iter().try_for_each(|options| options.validate()).map_err(raised)?;
    Ok(Cell::grid(&methods, errors, confidences, &common))
}

/// Rows of all cells; fewer if the measurement was cancelled.
fn measure(
    prepared: &Prepared<'_>,
    pixels: &Pixels,
    cells: &[Cell],
    by: &[Grouping],
    watch: &Watch,
) -> tashika::error::Result<Vec<Row>> {
    let (setting, exact) = (prepared.setting(), prepared.integrator()?);
    let lights = prepared.job().light_set()?;
    let progress = |p: &_| watch.tell(p);
    let exact = pixels.render(&setting, exact.as_ref(), &progress, watch.cancel())?;
    let mut rows = Vec::new();
    if !exact.complete {
        return Ok(rows);
    }
    let groups: Vec<Group> = by.iter().flat_map(|grouping| grouping.groups(&exact.film, &setting)).collect();
    let ground = Ground { setting, lights, pixels, reference: &exact.film, groups: &groups };
    let all = Subject {
        scene: setting.tracer.scene().name().to_owned(),
        vpls: lights.set().len() as u64,
        gather: setting.view.gather.points,
        pixels: pixels.count(),
        group: None,
    };
    let some = groups.iter().map(|g| Subject { pixels: g.pixels, group: Some(g.name), ..all.clone() });
    let subjects: Vec<Subject> = std::iter::once(all.clone()).chain(some).collect();
    let begun = Instant::now();
    let clock = || begun.elapsed().as_secs_f64();
    for cell in cells {
        let listener = Listener { progress: &progress, cancel: watch.cancel(), clock: &clock };
        let Some((pools, seconds)) = ground.run(cell, &listener)? else { break };
        let row = |(subject, pool): (&Subject, &Pool)| Row::new(subject, cell.into(), pool, seconds);
        rows.extend(subjects.iter().zip(&pools).map(row));
    }
    Ok(rows)
}
