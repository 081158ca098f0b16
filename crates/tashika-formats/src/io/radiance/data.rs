//! Data files: numbers on a grid.
//!
//! ```text
//! file   = dimensions  axis…  values
//! axis   = first last count  |  0 0 count place…
//! ```
//!
//! The values of the last axis follow each other. Between its places, a grid is linear along each
//! axis. Beyond them it goes on as the last interval does, for the length of that interval, and is
//! 0 from there on. (Radiance lets it fade more slowly.)
//!
//! Source: the Radiance reference manual, "Data files". Held to this by the tests below.

use crate::error::{Error, Location, Result};
use crate::io::{SceneFiles, text};

use super::words;

/// Most axes of a grid.
const MAX_AXES: usize = 4;

/// Values at the places of a grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// Places along each axis, rising or falling.
    axes: Vec<Vec<f64>>,
    values: Vec<f64>,
}

impl Grid {
    /// Reads the file `name` with `axes` axes; `at` refers to it.
    ///
    /// # Errors
    /// As [`SceneFiles::read`]; [`Error::Invalid`] for a file that is no grid.
    pub(super) fn read(name: &str, axes: usize, files: &SceneFiles, at: &Location) -> Result<Self> {
        let bytes = files.read(name, at)?;
        let bytes = text::decoded(&bytes);
        let file = files.beside(name);
        let numbers = words::numbers(&text::utf8_or_latin1(&bytes), &file)?;
        Self::new(&numbers, axes)
            .map_err(|(found, expected)| Error::invalid(Location::file(file), found, expected))
    }

    fn new(numbers: &[f64], axes: usize) -> Result<Self, (String, String)> {
        let mut rest = numbers;
        let mut take = |count: usize| -> Result<&[f64], (String, String)> {
            if count > rest.len() {
                let found = format!("{} numbers, {} of which are left", numbers.len(), rest.len());
                return Err((found, format!("{count} more")));
            }
            let (taken, left) = rest.split_at(count);
            rest = left;
            Ok(taken)
        };
        let found = take(1)?[0];
        if found != axes as f64 || !(1..=MAX_AXES).contains(&axes) {
            return Err((
                format!("data of {found} axes"),
                format!("as many as coordinates: {axes}, 1 to {MAX_AXES}"),
            ));
        }
        let mut places: Vec<Vec<f64>> = Vec::new();
        for _ in 0..axes {
            let [first, last, count] = take(3)?.try_into().unwrap_or([0.0; 3]);
            if count.fract() != 0.0 || !(2.0..=1e6).contains(&count) {
                return Err((format!("an axis of {count} places"), "2 to 1000000".to_owned()));
            }
            let n = count as usize;
            let axis: Vec<f64> = if first == last {
                take(n)?.to_vec()
            } else {
                (0..n).map(|i| first + (last - first) * i as f64 / (count - 1.0)).collect()
            };
            let rises = axis[1] > axis[0];
            if axis.windows(2).any(|pair| pair[0] == pair[1] || (pair[1] > pair[0]) != rises) {
                return Err((
                    "places of an axis that neither rise nor fall".to_owned(),
                    "one of them".to_owned(),
                ));
            }
            places.push(axis);
        }
        let count = places.iter().map(Vec::len).fold(1, usize::saturating_mul);
        let values = take(count)?.to_vec();
        Ok(Self { axes: places, values })
    }

    /// Value at a place with one number for each axis, at least 0.
    pub(super) fn at(&self, place: &[f64]) -> f64 {
        self.along(&self.values, &self.axes, place).max(0.0)
    }

    fn along(&self, values: &[f64], axes: &[Vec<f64>], place: &[f64]) -> f64 {
        let ([axis, axes @ ..], [x, place @ ..]) = (axes, place) else { return values[0] };
        let rises = axis[1] > axis[0];
        let next = axis.partition_point(|a| if rises { *a <= *x } else { *a >= *x });
        let low = next.saturating_sub(1).min(axis.len() - 2);
        let t = (x - axis[low]) / (axis[low + 1] - axis[low]);
        if !(-1.0..=2.0).contains(&t) {
            return 0.0;
        }
        let step = values.len() / axis.len();
        let of = |k: usize| self.along(&values[k * step..(k + 1) * step], axes, place);
        let (a, b) = (of(low), of(low + 1));
        a + (b - a) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_linear_between_their_places_and_end() {
        let grid =
            Grid::new(&[2., 0., 90., 2., 0., 0., 3., 0., 20., 90., 1., 2., 3., 5., 6., 7.], 2).unwrap();
        for (place, value) in [
            ([0.0, 0.0], 1.0),
            ([0.0, 10.0], 1.5),
            ([0.0, 55.0], 2.5),
            ([90.0, 90.0], 7.0),
            ([45.0, 20.0], 4.0),
            ([0.0, 125.0], 3.5),
            ([0.0, 161.0], 0.0),
            ([-90.0, 0.0], 0.0),
        ] {
            assert!((grid.at(&place) - value).abs() < 1e-12, "{place:?}: {}", grid.at(&place));
        }
        let falling = Grid::new(&[1., 90., 0., 2., 1., 3.], 1).unwrap();
        assert_eq!(falling.at(&[30.0]), 1.0 + 2.0 * 60.0 / 90.0);
    }

    #[test]
    fn damaged_grids_are_refused() {
        for (numbers, found) in [
            (&[][..], "0 numbers"),
            (&[3., 0., 1., 2.], "data of 3 axes"),
            (&[1., 0., 1., 1e9], "an axis of 1000000000 places"),
            (&[1., 0., 0., 2., 5., 5., 1., 1.], "neither rise nor fall"),
            (&[1., 0., 1., 1e6, 1.], "5 numbers, 1 of which"),
        ] {
            assert!(Grid::new(numbers, 1).unwrap_err().0.contains(found), "{numbers:?}");
        }
    }
}
