//! Plots as SVG that prints well, with the plotted numbers as CSV.
//!
//! Colours are those of Okabe, Ito 2008, which people with colour vision deficiency can
//! distinguish.

use std::fmt::Write;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, ValueFormatter};
use plotters::prelude::*;

use crate::math::elementary::{ln_f64, powf_f64};
use crate::{percent_of_error, percent_of_share};

const SIZE: (u32, u32) = (640, 400);
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(0, 0, 0),
];
/// Largest number of points of a curve; more would not be visible.
const POINTS: usize = 400;
const FONT: &str = "sans-serif";

/// A plot, and its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plot {
    /// Name of the plot's files.
    pub name: String,
    /// Caption, shown above the plot.
    pub caption: String,
    /// The drawing, as an SVG document.
    pub svg: String,
    /// The plotted numbers, as CSV.
    pub csv: String,
}

/// A share with its interval, for [`Plot::measured`].
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Label of the series that the share belongs to.
    pub label: String,
    /// Index of the series' colour, which is the same in other plots.
    pub series: usize,
    /// Position on the x axis.
    pub x: f64,
    /// Share that was measured, 0 to 1.
    pub share: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Errors that plotters can return; drawing to a string never fails.
type Drawn = Result<(), Box<dyn std::error::Error>>;

impl Plot {
    /// Cumulative distribution of each list of errors: the share that is at most x. `mark` is a
    /// tolerance on the x axis.
    pub fn shares(
        name: &str,
        caption: &str,
        x: &str,
        series: &[(String, Vec<f64>)],
        mark: Option<f64>,
    ) -> Self {
        let curves: Vec<(&str, Vec<(f64, f64)>)> =
            series.iter().map(|(label, errors)| (label.as_str(), cumulative(errors))).collect();
        let all = || curves.iter().flat_map(|(_, points)| points.iter().map(|p| p.0));
        let (low, high) = ends(all().chain(mark).filter(|x| *x > 0.0));
        let svg = drawn(|canvas| {
            let mut chart = ChartBuilder::on(canvas)
                .margin(12)
                .x_label_area_size(42)
                .y_label_area_size(58)
                .build_cartesian_2d(Decades { low, high }, 0.0..1.0_f64)?;
            mesh(&mut chart, x, "share of pixels", &percent_of_error, &percent_of_share)?;
            if let Some(mark) = mark {
                let line = LineSeries::new([(mark, 0.0), (mark, 1.0)], BLACK.mix(0.5).stroke_width(1));
                chart.draw_series(line)?;
            }
            for (i, (label, points)) in curves.iter().enumerate() {
                let style = COLORS[i % COLORS.len()].stroke_width(2);
                let shown = points.iter().map(|&(x, y)| (x.max(low), y));
                chart.draw_series(LineSeries::new(shown, style))?.label(*label).legend(swatch(style));
            }
            legend(&mut chart, curves.len())
        });
        let mut csv = "series,error,share\n".to_owned();
        for (label, points) in &curves {
            for (x, y) in points {
                let _ = writeln!(csv, "{},{x},{y}", quoted(label));
            }
        }
        Self { name: name.to_owned(), caption: caption.to_owned(), svg, csv }
    }

    /// Histogram of the values, in bins of equal ratio. `told` formats numbers of the x axis.
    pub fn histogram(
        name: &str,
        caption: &str,
        x: &str,
        values: &[f64],
        told: &dyn Fn(f64) -> String,
    ) -> Self {
        const BINS: usize = 48;
        let (low, high) = ends(values.iter().copied().filter(|v| *v > 0.0));
        let steps = |v: f64| BINS as f64 * ln_f64(v / low) / ln_f64(high / low);
        let mut bins = [0_u64; BINS];
        for v in values.iter().filter(|v| **v > 0.0 && v.is_finite()) {
            bins[steps(*v).clamp(0.0, BINS as f64 - 1.0) as usize] += 1;
        }
        let most = bins.iter().copied().max().unwrap_or(0).max(1) as f64;
        let edge = |i: usize| low * powf_f64(high / low, i as f64 / BINS as f64);
        let svg = drawn(|canvas| {
            let mut chart = ChartBuilder::on(canvas)
                .margin(12)
                .x_label_area_size(42)
                .y_label_area_size(58)
                .build_cartesian_2d(Decades { low, high }, 0.0..most * 1.05)?;
            mesh(&mut chart, x, "pixels", told, &|n| crate::count(n.round() as u64))?;
            let bars = bins.iter().enumerate().map(|(i, &n)| {
                Rectangle::new([(edge(i), 0.0), (edge(i + 1), n as f64)], COLORS[0].mix(0.85).filled())
            });
            chart.draw_series(bars)?;
            Ok(())
        });
        let mut csv = "from,to,pixels\n".to_owned();
        for (i, n) in bins.iter().enumerate() {
            let _ = writeln!(csv, "{},{},{n}", edge(i), edge(i + 1));
        }
        Self { name: name.to_owned(), caption: caption.to_owned(), svg, csv }
    }

    /// Shares with their intervals.
    ///
    /// `x`: label of the axis, and format of its numbers; `promised`: share at which a line is
    /// drawn.
    pub fn measured(
        name: &str,
        caption: &str,
        x: (&str, &dyn Fn(f64) -> String),
        found: &[Measured],
        promised: Option<f64>,
    ) -> Self {
        let labels = distinct(found.iter().map(|m| m.label.as_str()));
        let (low, high) = ends(found.iter().map(|m| m.x));
        let (low, high) = (low / 1.3, high * 1.3);
        let least = found.iter().map(|m| m.low).chain(promised).fold(1.0, f64::min);
        let bottom = (least * 20.0 - 0.5).floor().max(0.0) / 20.0;
        let svg = drawn(|canvas| {
            let mut chart = ChartBuilder::on(canvas)
                .margin(12)
                .x_label_area_size(42)
                .y_label_area_size(58)
                .build_cartesian_2d(Decades { low, high }, bottom..1.0_f64)?;
            mesh(&mut chart, x.0, "share of pixels", x.1, &percent_of_share)?;
            if let Some(promised) = promised {
                let line =
                    LineSeries::new([(low, promised), (high, promised)], BLACK.mix(0.5).stroke_width(1));
                chart.draw_series(line)?;
            }
            for (i, label) in labels.iter().enumerate() {
                let of_label = || found.iter().filter(|m| m.label == **label);
                let color = COLORS[of_label().map(|m| m.series).next().unwrap_or(0) % COLORS.len()];
                // Each series is shifted by its index, so that bars of equal `x` stand side by
                // side.
                let shift = powf_f64(high / low, 0.006 * (i as f64 - (labels.len() - 1) as f64 / 2.0));
                let place = |m: &Measured| m.x * shift;
                let bars = of_label()
                    .map(|m| ErrorBar::new_vertical(place(m), m.low, m.share, m.high, color.filled(), 8));
                chart.draw_series(bars)?;
                let line = LineSeries::new(of_label().map(|m| (place(m), m.share)), color.stroke_width(2));
                chart.draw_series(line)?.label(*label).legend(swatch(color.stroke_width(2)));
            }
            legend(&mut chart, labels.len())
        });
        let mut csv = "series,x,share,low,high\n".to_owned();
        for m in found {
            let _ = writeln!(csv, "{},{},{},{},{}", quoted(&m.label), m.x, m.share, m.low, m.high);
        }
        Self { name: name.to_owned(), caption: caption.to_owned(), svg, csv }
    }

    /// Plot of y over x on logarithmic axes. Each of the `points` is the label of its series, x and
    /// y.
    pub fn growth(name: &str, caption: &str, x: &str, y: &str, points: &[(String, f64, f64)]) -> Self {
        let (left, right) = ends(points.iter().map(|p| p.1));
        let (low, high) = ends(points.iter().map(|p| p.2));
        let labels = distinct(points.iter().map(|p| p.0.as_str()));
        let told = |n: f64| crate::count(n.round() as u64);
        let svg = drawn(|canvas| {
            let mut chart = ChartBuilder::on(canvas)
                .margin(12)
                .x_label_area_size(42)
                .y_label_area_size(72)
                .build_cartesian_2d(
                Decades { low: left, high: right },
                Decades { low: low / 1.3, high: high * 1.3 },
            )?;
            mesh(&mut chart, x, y, &told, &told)?;
            for (i, label) in labels.iter().enumerate() {
                let style = COLORS[i % COLORS.len()].stroke_width(2);
                let line = points.iter().filter(|p| p.0 == **label).map(|p| (p.1, p.2));
                chart.draw_series(LineSeries::new(line, style))?.label(*label).legend(swatch(style));
            }
            legend(&mut chart, labels.len())
        });
        let mut csv = "series,x,y\n".to_owned();
        for (label, x, y) in points {
            let _ = writeln!(csv, "{},{x},{y}", quoted(label));
        }
        Self { name: name.to_owned(), caption: caption.to_owned(), svg, csv }
    }
}

/// A logarithmic axis with ticks at round numbers; both ends are above zero.
struct Decades {
    low: f64,
    high: f64,
}

impl Ranged for Decades {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let share = ln_f64(value / self.low) / ln_f64(self.high / self.low);
        from + (f64::from(to - from) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        let steps: &[f64] = match log10(self.high / self.low) {
            decades if decades > 3.0 => &[1.0],
            decades if decades > 0.8 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        };
        let (first, last) = (log10(self.low).floor() as i32, log10(self.high).ceil() as i32);
        let round =
            (first..=last).flat_map(|k| steps.iter().map(move |step| step * powf_f64(10.0, f64::from(k))));
        let found: Vec<f64> = round.filter(|tick| self.range().contains(tick)).collect();
        // The axis is too short for round numbers.
        if found.len() < 2 { vec![self.low, self.high] } else { found }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

fn log10(x: f64) -> f64 {
    ln_f64(x) / std::f64::consts::LN_10
}

/// Distinct labels in the order of their first occurrence.
fn distinct<'a>(labels: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found = Vec::new();
    for label in labels {
        if !found.contains(&label) {
            found.push(label);
        }
    }
    found
}

type Chart<'a, X, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// Axis of real numbers, with a format for its ticks.
trait Axis: Ranged<ValueType = f64> + ValueFormatter<f64> {}
impl<A: Ranged<ValueType = f64> + ValueFormatter<f64>> Axis for A {}

fn mesh<'a, X: Axis, Y: Axis>(
    chart: &mut Chart<'a, X, Y>,
    x: &str,
    y: &str,
    told_x: &dyn Fn(f64) -> String,
    told_y: &dyn Fn(f64) -> String,
) -> Drawn {
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc(y)
        .x_labels(8)
        .y_labels(6)
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.12))
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .x_label_formatter(&|v| told_x(*v))
        .y_label_formatter(&|v| told_y(*v))
        .draw()?;
    Ok(())
}

fn legend<'a, X: Axis, Y: Axis>(chart: &mut Chart<'a, X, Y>, series: usize) -> Drawn {
    if series > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font((FONT, 13))
            .draw()?;
    }
    Ok(())
}

fn swatch(style: ShapeStyle) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style)
}

fn drawn(draw: impl FnOnce(&Canvas<'_>) -> Drawn) -> String {
    let mut svg = String::new();
    {
        let canvas = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        canvas.fill(&WHITE).expect("text takes all shapes");
        draw(&canvas).expect("finite axes");
        canvas.present().expect("text takes all shapes");
    }
    svg
}

/// Ends of an axis: the smallest and the largest finite value, at most five decades apart; a range
/// around them if they are equal, and 10⁻³ to 1 without values.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low.is_infinite() {
        return (1e-3, 1.0);
    }
    // Numbers more than five decades below the largest are drawn at the edge.
    let low = low.max(high * 1e-5);
    if high > low * 1.01 { (low, high) } else { (low / 2.0, high * 2.0) }
}

/// Points of the cumulative distribution of the numbers that are not NaN. Infinite numbers count
/// towards the shares, but have no points.
fn cumulative(values: &[f64]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    let steps = n.min(POINTS);
    (1..=steps)
        .map(|k| {
            let rank = k * n / steps;
            (sorted[rank - 1], rank as f64 / n as f64)
        })
        .filter(|(x, _)| x.is_finite())
        .collect()
}

/// A cell of CSV, quoted if necessary.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
