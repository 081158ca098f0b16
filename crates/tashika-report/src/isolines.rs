//! Isolines of values on a grid, by marching squares.
//!
//! A line is where the bilinear patch between four neighbouring values crosses a level, drawn as
//! straight segments between points on the sides of the square. On a side from `v₀` to `v₁` the
//! point is at the share `(level − v₀) / (v₁ − v₀)`. Of the two ways to connect the points of a
//! saddle, the mean of the four values decides. Squares with a value that is not finite have no
//! line.
//!
//! # Held to this by
//! The tests below.

/// Segment between two points, in steps of the grid from its first value.
pub(super) type Segment = [[f64; 2]; 2];

/// Segments of the line at a level.
///
/// * `size`: numbers of columns and rows.
/// * `value`: value in a column and row.
pub(super) fn isoline(size: [usize; 2], value: &dyn Fn(usize, usize) -> f64, level: f64) -> Vec<Segment> {
    let mut segments = Vec::new();
    for y in 0..size[1].saturating_sub(1) {
        for x in 0..size[0].saturating_sub(1) {
            // Corners clockwise from the top left.
            let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
            let values = corners.map(|[x, y]| value(x, y));
            if values.iter().all(|v| v.is_finite()) {
                square(corners, values, level, &mut segments);
            }
        }
    }
    segments
}

/// Adds the segments inside a square.
fn square(corners: [[usize; 2]; 4], values: [f64; 4], level: f64, segments: &mut Vec<Segment>) {
    let mut crossings: Vec<[f64; 2]> = Vec::with_capacity(4);
    for side in 0..4 {
        let next = (side + 1) % 4;
        let (from, to) = (values[side], values[next]);
        if (from < level) != (to < level) {
            let share = (level - from) / (to - from);
            crossings.push(std::array::from_fn(|k| {
                corners[side][k] as f64 + share * (corners[next][k] as f64 - corners[side][k] as f64)
            }));
        }
    }
    match crossings[..] {
        [a, b] => segments.push([a, b]),
        [top, right, bottom, left] => {
            let middle_is_below = values.iter().sum::<f64>() < 4.0 * level;
            // The first corner is cut off if the middle is on the other side of the level.
            if (values[0] < level) == middle_is_below {
                segments.extend([[top, right], [bottom, left]]);
            } else {
                segments.extend([[top, left], [right, bottom]]);
            }
        }
        _ => {}
    }
}

/// Round numbers above 0 and below `most`, as levels of isolines: 2 to 5 multiples of 1, 2 or 5
/// times a power of ten.
pub(super) fn levels(most: f64) -> Vec<f64> {
    if !(most > 0.0 && most.is_finite()) {
        return Vec::new();
    }
    let mut step = 1.0;
    while step * 10.0 < most {
        step *= 10.0;
    }
    while step >= most {
        step /= 10.0;
        if step == 0.0 {
            return Vec::new();
        }
    }
    // Here `step < most ≤ 10 step`.
    let step = [0.2, 0.5, 1.0, 2.0].map(|factor| factor * step).into_iter().find(|s| 5.0 * s >= most);
    let step = step.unwrap_or(most);
    (1..=5).map(|k| f64::from(k) * step).filter(|level| *level < most).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line of a plane `x + 2 y` is straight: the ends of all segments are on it.
    #[test]
    fn lines_of_a_plane_are_straight() {
        let segments = isoline([5, 4], &|x, y| x as f64 + 2.0 * y as f64, 4.5);
        assert!(segments.len() >= 4, "{segments:?}");
        for [x, y] in segments.iter().flatten() {
            assert!((x + 2.0 * y - 4.5).abs() < 1e-12, "{x} {y}");
        }
        let length: f64 = segments
            .iter()
            .map(|[a, b]| ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt())
            .sum();
        // From (0, 2.25) to (4, 0.25).
        assert!((length - 20f64.sqrt()).abs() < 1e-12, "{length}");
    }

    #[test]
    fn saddles_are_joined_through_the_middle_and_gaps_have_no_line() {
        let saddle = |peak: f64| isoline([2, 2], &move |x, y| if x == y { peak } else { 0.0 }, 1.0);
        // With the middle above the level, the corners below it are cut off; and the other way.
        let ends =
            |segments: &[Segment]| segments.iter().flatten().filter(|p| p[0] > 0.5 && p[1] < 0.5).count();
        assert_eq!((saddle(3.0).len(), ends(&saddle(3.0))), (2, 2));
        assert_eq!((saddle(1.5).len(), ends(&saddle(1.5))), (2, 0));
        assert!(isoline([2, 2], &|x, _| if x == 0 { f64::NAN } else { 2.0 }, 1.0).is_empty());
        assert!(
            isoline([1, 9], &|_, y| y as f64, 1.5).is_empty() && isoline([0, 0], &|_, _| 1.0, 0.5).is_empty()
        );
    }

    #[test]
    fn levels_are_round_numbers() {
        for (most, expected) in [
            (530.0, vec![200.0, 400.0]),
            (1000.0, vec![200.0, 400.0, 600.0, 800.0]),
            (100.0, vec![20.0, 40.0, 60.0, 80.0]),
            (2.4, vec![0.5, 1.0, 1.5, 2.0]),
            (7.0, vec![2.0, 4.0, 6.0]),
            (0.0, vec![]),
            (f64::INFINITY, vec![]),
        ] {
            let found = levels(most);
            let near = found.iter().zip(&expected).all(|(f, e)| (f / e - 1.0).abs() < 1e-9);
            assert!(found.len() == expected.len() && near, "{most}: {found:?}");
        }
        for most in [1e-300, 3e-7, 0.0999, 123.456, 9e9, 1e300] {
            assert!((1..=5).contains(&levels(most).len()), "{most}: {:?}", levels(most));
        }
        assert!(levels(f64::NAN).is_empty() && levels(5e-324).len() <= 5);
    }
}
