//! Images: named planes as NumPy arrays, with provenance; files and notebooks.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};
use tashika::experiment::OtherSet;
use tashika::film::{Film, PictureClaim, Plane, RenderFilm, Samples, Value, keys};
use tashika::io::{Exposure, ExrLayout, ToneMap, encode_png, read_exr, write_exr_as, write_file, write_png};
use tashika::render::Merger;
use tashika::renderer::finish_merged;
use tashika::report::{RenderFacts, Tolerance, half_width_image, headline, render_page};

use crate::arrays::array;
use crate::compare::compare;
use crate::denoiser;
use crate::errors::{option, raised};
use crate::json::from_json;
use crate::notebook;

/// Name of the unnamed plane in Python.
const MAIN: &str = "radiance";

/// An image: a mapping from names of planes to read-only NumPy arrays.
///
/// "radiance" is the main plane, float32 of shape (height, width, 3) in W/m²/sr, linear Rec. 709.
/// Planes of one channel have the shape (height, width): "half_width" and "standard_error" of the
/// error metric, "claim" and "stop" as uint32 codes, "pairs", "rays", "depth" and so on; `planes`
/// describes each. Rows go down from the top. An array is made at its first use, and stored.
///
/// ```python
/// >>> image = tashika.render(tashika.builtin("tiny"), size=(8, 6), vpls=200, error=0.5)
/// >>> image.size, image["half_width"].shape, image["claim"].dtype
/// ((8, 6), (6, 8), dtype('uint32'))
/// >>> sorted(image)[:4]
/// ['albedo', 'claim', 'coverage', 'depth']
/// ```
#[pyclass(frozen, mapping, module = "tashika")]
pub struct Image {
    film: Film,
    /// File or method, for messages and titles.
    name: PathBuf,
    /// Effect of another set of lights, if it was measured.
    other_set: Option<OtherSet>,
    arrays: Mutex<BTreeMap<String, Py<PyAny>>>,
}

impl Image {
    /// Wraps a rendered film.
    pub(crate) fn new(film: Film) -> Self {
        let name = film.metadata().text(keys::METHOD).unwrap_or("image").into();
        Self::named(film, name)
    }

    fn named(film: Film, name: PathBuf) -> Self {
        Self { film, name, other_set: None, arrays: Mutex::default() }
    }

    /// Adds the effect of another set of lights.
    pub(crate) fn beside(self, other_set: Option<OtherSet>) -> Self {
        Self { other_set, ..self }
    }

    /// Claim of the image, in a sentence.
    fn headline(&self) -> String {
        let other_set = self.other_set.map_or_else(String::new, |other| {
            format!("; the promise is about the sum over these VPLs: {}", other.words())
        });
        headline(&self.film) + &other_set
    }

    pub(crate) fn film(&self) -> &Film {
        &self.film
    }

    /// File or method, for messages.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// Key of a plane: that of the main plane is [`MAIN`], unless another plane has that name.
    fn key<'a>(&self, plane: &'a Plane) -> &'a str {
        if plane.name().is_empty() && self.film.plane(MAIN).is_none() { MAIN } else { plane.name() }
    }

    fn keys_in_order(&self) -> Vec<&str> {
        self.film.planes().iter().map(|plane| self.key(plane)).collect()
    }

    fn array_of<'py>(&self, py: Python<'py>, plane: &Plane) -> PyResult<Bound<'py, PyAny>> {
        let window = self.film.window();
        let channels = plane.channels().len();
        let mut shape = vec![window.height as usize, window.width as usize];
        if channels > 1 {
            shape.push(channels);
        }
        match plane.samples() {
            Samples::F32(samples) => array(py, samples.iter().copied(), &shape),
            Samples::U32(samples) => array(py, samples.iter().copied(), &shape),
        }
    }

    /// Tolerance that the image was rendered to.
    fn tolerance(&self) -> Tolerance {
        Tolerance::of(&self.film).unwrap_or_default()
    }
}

#[pymethods]
impl Image {
    /// Width and height of the full image (pixels).
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.film.size().into()
    }

    /// The part of the image that the arrays hold: (x, y, width, height) in pixels from the top
    /// left.
    #[getter]
    fn window(&self) -> (u32, u32, u32, u32) {
        let window = self.film.window();
        (window.x, window.y, window.width, window.height)
    }

    /// True if every requested pixel was rendered; pixels of other `tiles` are 0 in the plane
    /// "stop".
    #[getter]
    fn complete(&self) -> bool {
        self.film.metadata().bool(keys::COMPLETE).unwrap_or(true)
    }

    /// Number of pixels by claim: a dict with a count for each kind of claim ("none", "exact",
    /// "published", "calibrated", "certified", "audited", of pixels within their budget) and for
    /// "out_of_budget", "wider" (of these, the pixels with an interval), "not_found", "not_finite"
    /// (infinite or not a number, with no claim) and "not_rendered".
    #[getter]
    fn tally<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &RenderFilm::of(&self.film).tally())
    }

    /// Claim about the picture as a whole, or None: a dict with "error", "share", "assurance",
    /// "audited" and "outside" (pixels), "upper_outside" (upper bound of the share that is
    /// outside), "reached", "population", "looks" and "passes".
    #[getter]
    fn picture_claim<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        PictureClaim::of(self.film.metadata()).map(|claim| from_json(py, &claim)).transpose()
    }

    /// Record of how the image was made: names and values, sorted.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let metadata = PyDict::new(py);
        for (name, value) in self.film.metadata().iter() {
            match value {
                Value::Text(text) => metadata.set_item(name, text)?,
                Value::Int(number) => metadata.set_item(name, number)?,
                Value::Float(number) => metadata.set_item(name, number)?,
                Value::Bool(yes) => metadata.set_item(name, yes)?,
            }
        }
        Ok(metadata)
    }

    /// Description of the planes: by name, a dict of "channels", "unit" and "doc".
    #[getter]
    fn planes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let planes = PyDict::new(py);
        for plane in self.film.planes() {
            let facts = PyDict::new(py);
            facts.set_item("channels", plane.channels())?;
            facts.set_item("unit", plane.unit())?;
            facts.set_item("doc", plane.doc())?;
            planes.set_item(self.key(plane), facts)?;
        }
        Ok(planes)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut planes = self.film.planes().iter();
        let Some(plane) = planes.find(|plane| self.key(plane) == name) else {
            let message = format!("{name}; the planes are {}", self.keys_in_order().join(", "));
            return Err(PyKeyError::new_err(message));
        };
        let known = || self.arrays.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(array) = known().get(name) {
            return Ok(array.bind(py).clone());
        }
        // Not under the lock: making an array runs Python, which may switch threads.
        let array = self.array_of(py, plane)?;
        Ok(known().entry(name.to_owned()).or_insert(array.unbind()).bind(py).clone())
    }

    fn __len__(&self) -> usize {
        self.film.planes().len()
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<String>().is_ok_and(|name| self.keys_in_order().contains(&name.as_str()))
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.keys(py)?.try_iter()
    }

    /// Names of the planes.
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, self.keys_in_order())
    }

    /// The arrays, in the order of the names.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.keys_in_order().into_iter().map(|name| self.__getitem__(py, name)).collect()
    }

    /// Names and arrays.
    fn items<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let item = |name: &str| Ok((name.to_owned(), self.__getitem__(py, name)?));
        self.keys_in_order().into_iter().map(item).collect()
    }

    /// Array of the plane with that name, or `default`.
    #[pyo3(signature = (name, default=None))]
    fn get<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        if self.keys_in_order().contains(&name) { self.__getitem__(py, name).map(Some) } else { Ok(default) }
    }

    /// Coverage against a reference, as a dict. "within" is the share of the pixels whose error is
    /// at most `error` (by default, the error that this image was rendered to). "claims" is
    /// `Comparison.claims`, the judgement of this image's claims; None without claims.
    ///
    /// ```python
    /// >>> scene = tashika.builtin("tiny")
    /// >>> lights = tashika.vpls(scene, count=200)
    /// >>> exact = tashika.render(scene, size=(8, 6), vpls=lights, method="exact")
    /// >>> tashika.render(scene, size=(8, 6), vpls=lights).coverage(exact)["within"] > 0.9
    /// True
    /// ```
    #[pyo3(signature = (reference, error=None))]
    fn coverage<'py>(
        slf: &Bound<'py, Self>,
        reference: &Bound<'py, Self>,
        error: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let own = slf.get().tolerance();
        let error = error.unwrap_or(own.relative);
        let comparison = compare(slf.py(), slf, reference, Some(error), Some(own.absolute))?;
        let found = PyDict::new(slf.py());
        found.set_item("error", error)?;
        found.set_item("pixels", comparison.pixels())?;
        found.set_item("within", comparison.within_tolerance())?;
        found.set_item("claims", comparison.claims(slf.py())?)?;
        Ok(found)
    }

    /// Writes the image, whole or not at all, in the format of its ending: `.exr` has everything,
    /// `.png` is a picture, `.html` an interactive page.
    ///
    /// `tonemap` is "natural", "linear", "filmic", "aces" or "agx": the tone mapping of a picture,
    /// and the one that a page begins with. `exposure` is that of a picture, in stops; by default,
    /// and at the beginning of a page, the log-average becomes middle gray. An OpenEXR file stores
    /// neither.
    ///
    /// `exr` is the layout of an OpenEXR file, words with commas between them: "parts", one for
    /// each plane; "tiles" of 64×64 pixels; and a compression, "none", "rle", "zips", "zip" or
    /// "piz".
    #[pyo3(signature = (path, exr="zip", *, tonemap="natural", exposure=None))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        exr: &str,
        tonemap: &str,
        exposure: Option<f32>,
    ) -> PyResult<()> {
        let film = &self.film;
        let layout: ExrLayout = exr.parse().map_err(raised)?;
        let exposure = exposure.map_or(Exposure::Auto, Exposure::Stops);
        let tone_map = ToneMap { exposure, tone: tonemap.parse().map_err(raised)? };
        tone_map.validate().map_err(raised)?;
        py.detach(|| match ending(&path).as_str() {
            "exr" => Some(write_exr_as(&path, film, &layout)),
            "png" => Some(write_png(&path, film, &tone_map).map(drop)),
            "html" => {
                let name = path.display().to_string();
                let facts = RenderFacts { name, tone: tone_map.tone, ..RenderFacts::default() };
                Some(write_file(&path, render_page(film, &facts).as_bytes()))
            }
            _ => None,
        })
        .ok_or_else(|| option("path", path.display(), "a file name ending in .exr, .png or .html"))?
        .map_err(raised)
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.film.size();
        format!("<tashika.Image {width}x{height}: {}>", self.headline())
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let (picture, _) = encode_png(self.name(), &self.film, &ToneMap::default()).map_err(raised)?;
        let own = half_width_image(&self.film, &self.tolerance());
        let pictures: Vec<Vec<u8>> = std::iter::once(picture).chain(own.map(|own| own.png())).collect();
        Ok(notebook::html(&self.headline(), &pictures))
    }
}

/// Ending of a file name, in lower case.
pub fn ending(path: &Path) -> String {
    path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// Reads an OpenEXR image, of this program or of another. Raises `FileError` or `InputError`.
#[pyfunction]
pub fn read(py: Python<'_>, path: PathBuf) -> PyResult<Image> {
    let film = py.detach(|| read_exr(&path)).map_err(raised)?;
    Ok(Image::named(film, path))
}

/// Joins parts of an image that were rendered with `tiles`. All shares together give the image that
/// one machine renders, bit by bit.
///
/// `parts` is any iterable. Each part is requested when the preceding one has been joined, so that
/// a generator that reads files needs memory for one part at a time. If a share occurs twice, its
/// two parts must be equal. Pixels that no part has are zero, and `complete` is then false. Raises
/// `InputError`, naming the part, for parts of different renders.
///
/// Parts of an audited picture claim nothing. If no part is missing, the joined picture is
/// reconstructed and audited; its claim is `picture_claim`. `denoiser` (default: "own") must be the
/// one that the parts were rendered for.
///
/// ```python
/// >>> scene = tashika.builtin("tiny")
/// >>> parts = (tashika.render(scene, size=(40, 30), vpls=200, truth="vpl", tiles=(number, 2)) for number in (1, 2))
/// >>> tashika.merge(parts).complete
/// True
/// ```
#[pyfunction]
#[pyo3(signature = (parts, *, denoiser=None))]
pub fn merge(py: Python<'_>, parts: &Bound<'_, PyAny>, denoiser: Option<PathBuf>) -> PyResult<Image> {
    let mut merger: Option<Merger> = None;
    for (number, part) in (1..).zip(parts.try_iter()?) {
        let part = part?.cast_into::<Image>()?;
        let part = part.get();
        let name = PathBuf::from(format!("part {number} ({})", part.name.display()));
        let joined = py.detach(|| match merger.as_mut() {
            Some(merger) => merger.add(&name, &part.film),
            None => Merger::new(&name, &part.film).map(|new| merger = Some(new)),
        });
        joined.map_err(raised)?;
    }
    let merger = merger.ok_or_else(|| option("parts", 0, "at least one image"))?;
    let mut merged = merger.finish().map_err(raised)?;
    let smoother = denoiser.map(|name| denoiser::of(py, &name, 0)).transpose()?.flatten();
    py.detach(|| finish_merged(&mut merged, smoother.as_deref())).map_err(raised)?;
    Ok(Image::new(merged.film))
}
