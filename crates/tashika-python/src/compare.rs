//! An image against a reference, in numbers and pictures.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tashika::film::Tone;
use tashika::io::write_file;
use tashika::report::{
    self, Claims, CompareFacts, Intervals, Named, Tolerance, ToleranceFrom, Verdict, compare_page,
    error_image, summary,
};

use crate::arrays::array;
use crate::errors::{option, raised};
use crate::image::{Image, ending};
use crate::json::from_json;
use crate::notebook;

/// Errors of an image against a reference. Shares are in 0 to 1, errors relative; the names are
/// those of `tashika compare --json`.
#[pyclass(frozen, module = "tashika")]
pub struct Comparison {
    found: report::Comparison,
    error_from: ToleranceFrom,
    image: Py<Image>,
    reference: Py<Image>,
}

#[pymethods]
impl Comparison {
    /// Tolerance, relative.
    #[getter]
    fn error(&self) -> f64 {
        self.found.tolerance.relative
    }

    /// Origin of the tolerance: "asked" (an argument), "image" (the error that the image was
    /// rendered to), or "default".
    #[getter]
    fn error_from(&self) -> &'static str {
        self.error_from.name()
    }

    /// Tolerance for dark pixels (W/m²/sr).
    #[getter]
    fn absolute(&self) -> f64 {
        self.found.tolerance.absolute
    }

    /// Number of pixels that have an error; all shares are of these pixels.
    #[getter]
    pub(crate) fn pixels(&self) -> u64 {
        self.found.pixels
    }

    /// Number of `pixels` at which the image is not finite: outside of any tolerance, and in no
    /// mean.
    #[getter]
    fn failed(&self) -> u64 {
        self.found.failed
    }

    /// Share of the pixels within the tolerance.
    #[getter]
    pub(crate) fn within_tolerance(&self) -> f64 {
        self.found.within_share()
    }

    /// Mean of the finite errors.
    #[getter]
    fn mean(&self) -> f64 {
        self.found.mean
    }

    /// Error that half of the pixels do not exceed.
    #[getter]
    fn median(&self) -> f64 {
        self.found.median
    }

    /// Error that 95 % of the pixels do not exceed.
    #[getter]
    fn p95(&self) -> f64 {
        self.found.p95
    }

    /// Largest error.
    #[getter]
    fn worst(&self) -> f64 {
        self.found.worst
    }

    /// Pixel of the largest error, (x, y) in the full image.
    #[getter]
    fn worst_at(&self) -> (u32, u32) {
        self.found.worst_at.into()
    }

    /// Mean luminance over that of the reference, less one.
    #[getter]
    fn bias(&self) -> f64 {
        self.found.bias
    }

    /// Relative error of the reference that half of its pixels do not exceed, at 99.9 %; None if
    /// the reference does not state its error, or is exact.
    #[getter]
    fn reference_error(&self) -> Option<f64> {
        self.found.own_error
    }

    /// Mean distance over the mean reference.
    #[getter]
    fn relative_l1(&self) -> f64 {
        self.found.relative_l1
    }

    /// Root mean squared error of linear RGB (W/m²/sr); this and the other measures are None if all
    /// pixels failed.
    #[getter]
    fn rmse(&self) -> Option<f64> {
        self.found.measures.map(|m| m.rmse)
    }

    /// Mean of the squared errors of linear RGB, each over the squared reference plus 0.01.
    #[getter]
    fn relmse(&self) -> Option<f64> {
        self.found.measures.map(|m| m.relmse)
    }

    /// Peak signal-to-noise ratio (dB) of the sRGB pictures, whose samples are clamped to 0 to 1.
    #[getter]
    fn psnr(&self) -> Option<f64> {
        self.found.measures.map(|m| m.psnr)
    }

    /// Structural similarity of the sRGB pictures' luma; None also for images of fewer than 11
    /// pixels a side.
    #[getter]
    fn ssim(&self) -> Option<f64> {
        self.found.measures.and_then(|m| m.ssim)
    }

    /// LDR-FLIP of the sRGB pictures, at 67 pixels per degree.
    #[getter]
    fn flip(&self) -> Option<f64> {
        self.found.measures.map(|m| m.flip)
    }

    /// Exposure (stops) of both sRGB pictures: the reference's own.
    #[getter]
    fn exposure_stops(&self) -> Option<f64> {
        self.found.measures.map(|m| m.exposure_stops)
    }

    /// Number of pixels whose error is infinite: they are lit, but black in the reference.
    #[getter]
    fn infinite(&self) -> u64 {
        self.found.infinite
    }

    /// Pixels that have no error: "not_rendered" and "not_finite".
    #[getter]
    fn left_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let left_out = PyDict::new(py);
        left_out.set_item("not_rendered", self.found.not_rendered)?;
        left_out.set_item("not_finite", self.found.not_finite)?;
        Ok(left_out)
    }

    /// Share of the claims that are certainly true; None without claims.
    #[getter]
    fn claims_kept(&self) -> Option<f64> {
        self.found.claims.as_ref().and_then(Claims::share)
    }

    /// Claims, as a dict; None if the image makes none. Counts that allow for the error of the
    /// reference: "kept" (certainly true), "broken" (certainly false), "undecidable", and "of", the
    /// total. "inside" counts the intervals that contain the reference itself, "consistent" those
    /// that agree with the reference if the errors of both images are normal. "low" and "high" are
    /// the bounds of the share of true claims at "confidence"; "promised" is the promised share.
    /// "verdict" is "kept", "not_kept", "reference_too_noisy" or "too_few_pixels"; it is None if
    /// nothing is promised, or if the reference estimates another truth. "same_truth" is True if
    /// the reference has the same VPLs and gather points.
    #[getter]
    pub(crate) fn claims<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(found) = &self.found.claims else { return Ok(None) };
        let claims = PyDict::new(py);
        claims.set_item("kept", found.kept)?;
        claims.set_item("broken", found.broken)?;
        claims.set_item("undecidable", found.undecidable())?;
        claims.set_item("of", found.of)?;
        claims.set_item("inside", found.inside)?;
        claims.set_item("consistent", found.consistent)?;
        claims.set_item("low", found.interval.low)?;
        claims.set_item("high", found.interval.high)?;
        claims.set_item("confidence", Claims::CONFIDENCE)?;
        claims.set_item("promised", found.promised)?;
        claims.set_item("verdict", found.verdict().map(Verdict::name))?;
        claims.set_item("same_truth", found.same_truth())?;
        Ok(Some(claims))
    }

    /// Claim about the picture as a whole, as a dict; None if there is none. "claim" is
    /// `Image.picture_claim`. "within" counts the pixels within the claimed error of the reference,
    /// "outside" those that exceed it whatever the error of the reference; "of" is the number of
    /// judged pixels. "held" is True if the claim is confirmed, "open" if the reference is too
    /// noisy for a verdict.
    #[getter]
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(found) = &self.found.picture else { return Ok(None) };
        let picture = PyDict::new(py);
        picture.set_item("claim", from_json(py, &found.claim)?)?;
        picture.set_item("within", found.within)?;
        picture.set_item("outside", found.outside)?;
        picture.set_item("of", found.of)?;
        picture.set_item("held", found.held())?;
        picture.set_item("open", found.verdict().is_none())?;
        Ok(Some(picture))
    }

    /// Comparison of the intervals of both images, as a dict. "claimed_in_both" counts the pixels
    /// with a claim in both images. "disjoint" counts those among them whose intervals do not
    /// overlap, so that at least one of the two is wrong. "share" is the disjoint share, "low" and
    /// "high" are the ends of its interval at "confidence". None if no pixel is claimed in both, or
    /// if the images are about different truths.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(found) = &self.found.intervals else { return Ok(None) };
        let intervals = PyDict::new(py);
        intervals.set_item("claimed_in_both", found.claimed_in_both)?;
        intervals.set_item("disjoint", found.disjoint)?;
        intervals.set_item("share", found.share())?;
        intervals.set_item("low", found.interval.low)?;
        intervals.set_item("high", found.interval.high)?;
        intervals.set_item("confidence", Intervals::CONFIDENCE)?;
        Ok(Some(intervals))
    }

    /// Error of each pixel, float64 of shape (height, width); NaN for pixels without an error.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let window = self.found.window;
        array(py, self.found.errors.iter().copied(), &[window.height as usize, window.width as usize])
    }

    /// Writes the picture of the error (`.png`), or a page with both images (`.html`). `tonemap` is
    /// the tone mapping that the page begins with, as that of `Image.save`.
    #[pyo3(signature = (path, *, tonemap="natural"))]
    fn save(&self, py: Python<'_>, path: PathBuf, tonemap: &str) -> PyResult<()> {
        let tone: Tone = tonemap.parse().map_err(raised)?;
        let (found, image, reference) = (&self.found, self.image.get(), self.reference.get());
        py.detach(|| match ending(&path).as_str() {
            "png" => Some(write_file(&path, &error_image(found).png())),
            "html" => {
                let facts = CompareFacts { tolerance_from: self.error_from, command: None, tone };
                let page = compare_page(found, named(image), named(reference), &facts);
                Some(write_file(&path, page.as_bytes()))
            }
            _ => None,
        })
        .ok_or_else(|| option("path", path.display(), "a file name ending in .png or .html"))?
        .map_err(raised)
    }

    fn __repr__(&self) -> String {
        format!("<tashika.Comparison: {}>", self.line())
    }

    fn _repr_html_(&self) -> String {
        notebook::html(&self.line(), &[error_image(&self.found).png()])
    }
}

impl Comparison {
    fn line(&self) -> String {
        let rows = summary(&self.found);
        let rows =
            rows.iter().filter(|(label, _)| ["within", "worst", "claims", "intervals"].contains(label));
        rows.map(|(label, text)| format!("{label} {text}")).collect::<Vec<_>>().join("; ")
    }
}

fn named(image: &Image) -> Named<'_> {
    Named { name: image.name(), film: image.film() }
}

/// Compares an image with a reference of the same size. Errors are distances of luminance, relative
/// to the reference, or to `absolute` over `error` where that is more. By default, `error` is the
/// error that the image was rendered to, or 2 % if there is none. In the former case the default of
/// `absolute` is the absolute tolerance of the image, otherwise 0.
///
/// ```python
/// >>> scene = tashika.builtin("tiny")
/// >>> lights = tashika.vpls(scene, count=200)
/// >>> exact = tashika.render(scene, size=(8, 6), vpls=lights, method="exact")
/// >>> ours = tashika.compare(tashika.render(scene, size=(8, 6), vpls=lights), exact, error=0.02)
/// >>> ours.within_tolerance > 0.9, ours.errors.shape
/// (True, (6, 8))
/// ```
#[pyfunction]
#[pyo3(signature = (image, reference, error=None, absolute=None))]
pub fn compare(
    py: Python<'_>,
    image: &Bound<'_, Image>,
    reference: &Bound<'_, Image>,
    error: Option<f64>,
    absolute: Option<f64>,
) -> PyResult<Comparison> {
    let (tolerance, error_from) = Tolerance::asked_or_of(error, absolute, image.get().film());
    let (of, by) = (named(image.get()), named(reference.get()));
    let found = py.detach(|| report::compare(of, by, &tolerance)).map_err(raised)?;
    Ok(Comparison { found, error_from, image: image.clone().unbind(), reference: reference.clone().unbind() })
}
