//! Words for readings: numbers, intervals and shapes.

use tashika::scene::SensorShape;
use tashika::sensors::{Bounds, GridSummary, Reading};

/// Name of a shape in tables.
pub fn shape(shape: SensorShape) -> &'static str {
    match shape {
        SensorShape::Plane => "plane",
        SensorShape::Cylinder => "cylinder",
        SensorShape::Sphere => "sphere",
    }
}

/// Formats a number with six significant digits.
pub fn digits(value: f64) -> String {
    format!("{value:.5e}").parse::<f64>().unwrap_or(value).to_string()
}

/// Formats a reading with its interval.
pub fn interval_of(reading: &Reading) -> String {
    match reading.half_width {
        Some(half_width) => format!("{} ± {} lx", short(reading.illuminance), short(half_width)),
        None => format!("{} lx, no claim", short(reading.illuminance)),
    }
}

/// Formats a value with its interval.
pub fn bounded(bounds: &Bounds, unit: &str) -> String {
    let value = short(bounds.value);
    match bounds.interval {
        Some([low, high]) => format!("{value}{unit}, between {} and {}{unit}", short(low), short(high)),
        None => format!("{value}{unit}"),
    }
}

/// Formats a number with three significant digits.
pub fn short(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().unwrap_or(value).to_string()
}

/// Labels and values of a summary.
pub fn summary_rows(summary: &GridSummary) -> [(&'static str, String); 4] {
    [
        ("mean", bounded(&summary.mean, " lx")),
        ("smallest", bounded(&summary.min, " lx")),
        ("largest", bounded(&summary.max, " lx")),
        ("uniformity U0", bounded(&summary.uniformity, "")),
    ]
}
