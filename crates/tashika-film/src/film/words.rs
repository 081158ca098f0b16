//! Counts, shares and errors as text for people.

/// Formats a count with its digits in groups of three.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Formats a share of a count with one decimal, rounded down, so that 100 % means all.
pub fn percent_of_share(share: f64) -> String {
    // The factor is one step above 1, so that a product rounded to just below a whole number still
    // counts as that number.
    format!("{:.1} %", (share * 1000.0 * (1.0 + f64::EPSILON)).floor() / 10.0)
}

/// Formats a relative error with three digits.
pub fn percent_of_error(error: f64) -> String {
    let percent = 100.0 * error;
    match percent.abs() {
        p if p.is_infinite() => "infinite".to_owned(),
        p if p >= 99.95 => format!("{percent:.0} %"),
        p if p >= 9.995 => format!("{percent:.1} %"),
        p if p >= 0.9995 => format!("{percent:.2} %"),
        p if p >= 0.0005 => format!("{percent:.3} %"),
        0.0 => "0 %".to_owned(),
        _ => "below 0.001 %".to_owned(),
    }
}

/// Formats a tolerance as it was typed, with no more digits than it has.
pub fn percent_of_tolerance(tolerance: f64) -> String {
    let digits = format!("{:.6}", 100.0 * tolerance);
    format!("{} %", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Returns the scope of a claim about a truth, given the truth's name in the metadata of a film.
pub fn about_truth(truth: &str) -> &'static str {
    match truth {
        "vpl" => {
            "the sum over these VPLs, clamped; not what other VPLs would give, nor what VPLs do not carry"
        }
        "clamped" => "what VPLs give on average, clamped; not what they do not carry",
        _ => "light transport",
    }
}

/// Returns a short description of a truth, given its name in the metadata of a film.
pub fn truth_in_short(truth: &str) -> &'static str {
    match truth {
        "vpl" => "the sum over its VPLs",
        "clamped" => "what VPLs give on average",
        _ => "light transport",
    }
}

/// Returns the message about `pixels` pixels whose unsampled light is too much for a claim.
pub fn about_light_not_found(pixels: u64) -> String {
    format!(
        "light was not found for {}: it comes over mirrors or through glass, or from lamps smaller than a pixel; nothing is claimed there",
        count(pixels)
    )
}

/// Returns the message about `pixels` pixels whose radiance is infinite or not a number.
pub fn about_not_finite(pixels: u64) -> String {
    let (are, they) = if pixels == 1 { ("pixel is", "it claims") } else { ("pixels are", "they claim") };
    format!("{} {are} not finite, out of range of the arithmetic: {they} nothing", count(pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_from_the_right() {
        assert_eq!([0, 999, 1000, 1_234_567].map(count), ["0", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn all_is_said_of_all_only() {
        let said = [1.0, 0.999_99, 0.29, 0.873_4, 0.0].map(percent_of_share);
        assert_eq!(said, ["100.0 %", "99.9 %", "29.0 %", "87.3 %", "0.0 %"]);
    }

    #[test]
    fn errors_have_three_digits() {
        let said = [0.0, 1e-7, 0.000_123_4, 0.012_345, 0.1, 0.9999, 1.354, f64::INFINITY, -0.005];
        assert_eq!(
            said.map(percent_of_error),
            ["0 %", "below 0.001 %", "0.012 %", "1.23 %", "10.0 %", "100 %", "135 %", "infinite", "-0.500 %"]
        );
    }

    #[test]
    fn tolerances_are_said_as_typed() {
        assert_eq!(
            [0.02, 0.07, 0.001, 1.0, 0.125].map(percent_of_tolerance),
            ["2 %", "7 %", "0.1 %", "100 %", "12.5 %"]
        );
    }
}
