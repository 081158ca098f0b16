//! Rows as a table for people: as Markdown, aligned so that it reads as plain text, or as a sheet
//! for a page.

use std::fmt::Write;

use super::Row;
use crate::report::{Sheet, count, percent_of_error, percent_of_share, percent_of_tolerance};

/// Quantity that a column shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Name of the method that was run.
    Method,
    /// Group of the pixels, or "all".
    Group,
    /// Number of trials: pixels times seeds.
    Trials,
    /// Number of VPLs in the sum.
    Vpls,
    /// Number of gather points a pixel.
    Gather,
    /// Relative tolerance for judging the method.
    Error,
    /// Relative error that the method received.
    MethodError,
    /// Confidence that the method received.
    Confidence,
    /// Share of the trials within the tolerance, with its interval.
    Within,
    /// Share of the claims that cover the truth, with its interval.
    Claims,
    /// Median of the relative errors.
    Median,
    /// Relative error that 95 % of the trials do not exceed.
    P95,
    /// Largest relative error of a trial.
    Worst,
    /// Share of the trials that ran out of budget.
    Budget,
    /// Mean number of rays a pixel.
    Rays,
    /// Mean number of pairs a pixel.
    Pairs,
    /// Seconds of the whole cell.
    Seconds,
}

impl Column {
    /// Text of the column's head.
    fn head(self) -> &'static str {
        match self {
            Self::Method => "method",
            Self::Group => "pixels",
            Self::Trials => "trials",
            Self::Vpls => "VPLs",
            Self::Gather => "gather points",
            Self::Error => "error",
            Self::MethodError => "method's error",
            Self::Confidence => "confidence",
            Self::Within => "within the error",
            Self::Claims => "claims kept",
            Self::Median => "median",
            Self::P95 => "95th percentile",
            Self::Worst => "worst",
            Self::Budget => "out of budget",
            Self::Rays => "rays/pixel",
            Self::Pairs => "pairs/pixel",
            Self::Seconds => "seconds",
        }
    }

    /// Text of a row in the column.
    fn cell(self, row: &Row) -> String {
        match self {
            Self::Method => row.method.to_owned(),
            Self::Group => row.group.unwrap_or("all").to_owned(),
            Self::Trials => count(row.pixels * row.seeds),
            Self::Vpls => count(row.vpls),
            Self::Gather => row.gather.to_string(),
            Self::Error => percent_of_tolerance(row.error),
            Self::MethodError => percent_of_error(row.method_error),
            Self::Confidence => row.confidence.map_or_else(none, percent_of_tolerance),
            Self::Within => share(row.within_tolerance, row.low, row.high),
            Self::Claims => match (row.claims_kept, row.claims_low, row.claims_high) {
                (Some(kept), Some(low), Some(high)) => share(kept, low, high),
                _ => none(),
            },
            Self::Median => percent_of_error(row.median),
            Self::P95 => percent_of_error(row.p95),
            Self::Worst => percent_of_error(row.worst),
            Self::Budget => {
                // Rounded up, so that 0 % means none.
                let trials = (row.pixels * row.seeds).max(1) as f64;
                format!("{:.1} %", (row.budget_hit as f64 / trials * 1000.0).ceil() / 10.0)
            }
            Self::Rays => count(row.rays_per_pixel.round() as u64),
            Self::Pairs => count(row.pairs_per_pixel.round() as u64),
            Self::Seconds => format!("{:.2}", row.seconds),
        }
    }
}

fn none() -> String {
    "-".to_owned()
}

fn share(share: f64, low: f64, high: f64) -> String {
    let [share, low, high] = [share, low, high].map(percent_of_share);
    format!("{share} ({} to {high})", low.trim_end_matches(" %"))
}

/// Heads and cells, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    lines: Vec<Vec<String>>,
}

impl Table {
    /// Returns a table of the given columns.
    pub fn new(rows: &[Row], columns: &[Column]) -> Self {
        let head = columns.iter().map(|column| column.head().to_owned()).collect();
        let cells = rows.iter().map(|row| columns.iter().map(|column| column.cell(row)).collect());
        Self { lines: std::iter::once(head).chain(cells).collect() }
    }

    /// Table as Markdown: the first column is aligned left, all others right.
    pub fn markdown(&self) -> String {
        let columns = self.lines[0].len();
        let width = |column: usize| {
            self.lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0).max(3)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut out = String::new();
        for (number, line) in self.lines.iter().enumerate() {
            for (i, (cell, width)) in line.iter().zip(&widths).enumerate() {
                let _ =
                    if i == 0 { write!(out, "| {cell:width$} ") } else { write!(out, "| {cell:>width$} ") };
            }
            out.push_str("|\n");
            if number == 0 {
                for (i, width) in widths.iter().enumerate() {
                    let dashes = "-".repeat(width + 1);
                    let _ = if i == 0 { write!(out, "|{dashes}-") } else { write!(out, "|{dashes}:") };
                }
                out.push_str("|\n");
            }
        }
        out
    }

    /// Table for a page.
    pub fn sheet(&self) -> Sheet {
        Sheet { head: self.lines[0].clone(), lines: self.lines[1..].to_vec() }
    }
}
