//! Plans: values at places of a plane, as coloured squares with numbers and isolines.

use std::fmt::Write;

use super::Plot;
use crate::color_scale::ColorScale;
use crate::isolines::{isoline, levels};
use crate::luminance_image::rounded;

/// Width and largest height of the drawing (px), and of its margins.
const WIDTH: f64 = 720.0;
const MAX_HEIGHT: f64 = 900.0;
const MARGIN: f64 = 20.0;
/// Height of the scale below the drawing, with its numbers (px).
const SCALE: f64 = 64.0;
/// Smallest and largest square (px).
const SQUARES: [f64; 2] = [3.0, 64.0];
/// Smallest square that has a number in it (px).
const LEAST_WITH_NUMBER: f64 = 20.0;
/// Shade above which numbers are black.
const LIGHT: f64 = 0.6;
/// Largest distance of a place from a grid, in spacings, for isolines.
const OFF_GRID: f64 = 0.01;
/// Most places of a grid for each place with a value, for isolines.
const SPARSE: usize = 64;

/// A value at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanCell {
    /// Place (m): to the right, and down.
    pub place: [f64; 2],
    /// Value, at least 0; NaN if there is none.
    pub value: f64,
    /// Text that appears under the pointer.
    pub title: String,
}

impl Plot {
    /// Plan of values, coloured from 0 to the largest.
    ///
    /// * `spacing`: distance of neighbouring places (m), the side of a square.
    /// * `unit`: unit of the values.
    /// * `csv`: the values as CSV.
    pub fn plan(
        name: &str,
        caption: &str,
        cells: &[PlanCell],
        spacing: f64,
        unit: &str,
        csv: String,
    ) -> Self {
        Self { name: name.to_owned(), caption: caption.to_owned(), svg: drawn(cells, spacing, unit), csv }
    }
}

fn drawn(cells: &[PlanCell], spacing: f64, unit: &str) -> String {
    let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for cell in cells {
        for k in 0..2 {
            (lo[k], hi[k]) = (lo[k].min(cell.place[k]), hi[k].max(cell.place[k]));
        }
    }
    let size: [f64; 2] = std::array::from_fn(|k| if cells.is_empty() { 0.0 } else { hi[k] - lo[k] });
    let [across, down] = size.map(|side| side / spacing + 1.0);
    let fitting = ((WIDTH - 2.0 * MARGIN) / across).min((MAX_HEIGHT - 2.0 * MARGIN) / down);
    let square = fitting.clamp(SQUARES[0], SQUARES[1]);
    let width = (across * square + 2.0 * MARGIN).max(WIDTH);
    let height = down * square + 2.0 * MARGIN + SCALE;
    let most = cells.iter().map(|cell| cell.value).filter(|value| value.is_finite()).fold(0.0, f64::max);
    let shade = |value: f64| if most > 0.0 { value / most } else { 0.0 * value };
    let scale = ColorScale::new();
    let color = |value: f64| {
        let [r, g, b] = scale.color(shade(value));
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"{:.1}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        (0.36 * square).clamp(7.5, 13.0)
    );
    for PlanCell { place, value, title } in cells {
        let [x, y] = std::array::from_fn(|k| MARGIN + (place[k] - lo[k]) / spacing * square);
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{square:.2}\" height=\"{square:.2}\" fill=\"{}\"><title>{}</title></rect>",
            color(*value),
            escaped(title)
        );
        if square >= LEAST_WITH_NUMBER && value.is_finite() {
            let [x, y] = [x + 0.5 * square, y + 0.5 * square];
            let ink = if shade(*value) > LIGHT { "black" } else { "white" };
            let _ = writeln!(
                svg,
                "<text x=\"{x:.2}\" y=\"{y:.2}\" fill=\"{ink}\" text-anchor=\"middle\" \
                 dominant-baseline=\"central\" pointer-events=\"none\">{}</text>",
                rounded(*value)
            );
        }
    }
    let lines = levels(most);
    draw_isolines(&mut svg, cells, lo, spacing, square, &lines, shade);
    let top = height - SCALE;
    const STEPS: u32 = 64;
    for k in 0..STEPS {
        let share = f64::from(k) / f64::from(STEPS - 1);
        let step = 0.5 * WIDTH / f64::from(STEPS);
        let _ = writeln!(
            svg,
            "<rect x=\"{:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"14\" fill=\"{}\"/>",
            MARGIN + f64::from(k) * step,
            step + 0.5,
            color(share * most)
        );
    }
    for share in [0.0, 0.5, 1.0] {
        let unit = if share == 1.0 { format!(" {}", escaped(unit)) } else { String::new() };
        let _ = writeln!(
            svg,
            "<text x=\"{:.2}\" y=\"{:.2}\" font-size=\"12\" text-anchor=\"{}\">{}{unit}</text>",
            MARGIN + share * 0.5 * WIDTH,
            top + 30.0,
            if share == 0.0 { "start" } else { "middle" },
            rounded(share * most)
        );
    }
    if !lines.is_empty() {
        let numbers: Vec<String> = lines.iter().map(|level| rounded(*level)).collect();
        let _ = writeln!(
            svg,
            "<text x=\"{MARGIN}\" y=\"{:.2}\" font-size=\"12\">isolines at {} {}</text>",
            top + 48.0,
            numbers.join(", "),
            escaped(unit)
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// Draws isolines, if the places are on a grid.
fn draw_isolines(
    svg: &mut String,
    cells: &[PlanCell],
    lo: [f64; 2],
    spacing: f64,
    square: f64,
    lines: &[f64],
    shade: impl Fn(f64) -> f64,
) {
    let Some((columns, values)) = gridded(cells, lo, spacing) else { return };
    let value = |x: usize, y: usize| values[y * columns + x];
    let size = [columns, values.len() / columns];
    for level in lines {
        let ink = if shade(*level) > LIGHT { "black" } else { "white" };
        let mut path = String::new();
        for [from, to] in isoline(size, &value, *level) {
            let [from, to] = [from, to].map(|p| p.map(|v| MARGIN + (v + 0.5) * square));
            let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", from[0], from[1], to[0], to[1]);
        }
        if !path.is_empty() {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.2\" pointer-events=\"none\"/>"
            );
        }
    }
}

/// Values on the grid of the places, row by row, with the number of columns; NaN where there is no
/// value. `None` if some place is off the grid, or most places of the grid are empty.
fn gridded(cells: &[PlanCell], lo: [f64; 2], spacing: f64) -> Option<(usize, Vec<f64>)> {
    let mut places = Vec::with_capacity(cells.len());
    let mut size = [0_usize; 2];
    for cell in cells {
        let mut place = [0_usize; 2];
        for k in 0..2 {
            let steps = (cell.place[k] - lo[k]) / spacing;
            if !((steps - steps.round()).abs() <= OFF_GRID && steps < 1e6) {
                return None;
            }
            place[k] = steps.round() as usize;
            size[k] = size[k].max(place[k] + 1);
        }
        places.push(place);
    }
    let area = size[0] * size[1];
    if area == 0 || area > SPARSE * cells.len() {
        return None;
    }
    let mut values = vec![f64::NAN; area];
    for ([x, y], cell) in places.into_iter().zip(cells) {
        values[y * size[0] + x] = cell.value;
    }
    Some((size[0], values))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each cell has a square with its text, and large squares have their number. Names from files
    /// cannot become markup.
    #[test]
    fn plans_have_a_square_for_each_value() {
        let cell = |x: f64, value: f64, title: &str| PlanCell { place: [x, 0.0], value, title: title.into() };
        let cells = [cell(0.0, 120.0, "a"), cell(0.5, 480.0, "<script>"), cell(1.0, f64::NAN, "c")];
        let svg = Plot::plan("plan", "Plan", &cells, 0.5, "lx", String::new()).svg;
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(svg.contains(">120</text>") && svg.contains(">480</text>") && svg.contains("480 lx"));
        assert!(!svg.contains("<script>") && svg.contains("&lt;script&gt;"));
        let none = Plot::plan("plan", "Plan", &[], 1.0, "lx", String::new()).svg;
        assert!(none.ends_with("</svg>\n") && !none.contains("NaN") && !none.contains("inf"), "{none}");
        // A thousand places across do not make the drawing wider than its squares of 3 px.
        let many: Vec<PlanCell> = (0..1000).map(|k| cell(f64::from(k), 1.0, "")).collect();
        let svg = Plot::plan("plan", "Plan", &many, 1.0, "lx", String::new()).svg;
        assert!(svg.contains("viewBox=\"0 0 3040"), "{}", &svg[..120]);
    }

    /// Isolines of a grid are at round levels between its values; places off a grid have none.
    #[test]
    fn plans_have_isolines() {
        let cell = |x: f64, y: f64| PlanCell { place: [x, y], value: 100.0 * x, title: String::new() };
        let mut cells: Vec<PlanCell> = (0..9).map(|k| cell(f64::from(k % 3), f64::from(k / 3))).collect();
        let drawn = |cells: &[PlanCell]| Plot::plan("plan", "Plan", cells, 1.0, "lx", String::new()).svg;
        let svg = drawn(&cells);
        assert!(svg.contains("isolines at 50.0, 100, 150 lx"), "{svg}");
        assert_eq!(svg.matches("<path").count(), 3);
        // The line of 50 lx is at half the first step: squares are 64 px wide.
        assert!(svg.contains("M84.0 52.0L84.0 116.0") || svg.contains("M84.0 116.0L84.0 52.0"), "{svg}");
        cells[4].place[0] += 0.3;
        assert!(!drawn(&cells).contains("<path"));
    }

    #[test]
    fn numbers_are_rounded_as_people_write_them() {
        let found = [0.0, 0.001234, 1.2345, 12.345, 123.45, 123_456.0].map(rounded);
        assert_eq!(found, ["0", "1e-3", "1.23", "12.3", "123", "123456"]);
    }
}
