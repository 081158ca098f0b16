//! Known name that a misspelt name probably stands for.
//!
//! ```text
//! d(a, b) = least number of insertions, deletions, substitutions and swaps of neighbours      (letters)
//! near    ⇔ d ≤ 0, 1, 2                  where the shorter name has below 3, below 6, at least 6 letters
//! ```
//!
//! The distance is that of optimal string alignment: no part is changed twice. Names that differ
//! only in capitals are near. Names that differ only in digits (`tex1`, `tex3`) are not, since
//! digits number things.
//!
//! Source: Damerau 1964. Held to this by the tests below.

/// Longest name that is compared (letters): the work grows with the product of two lengths.
const LONGEST: usize = 64;

/// Returns the `known` name that is nearest to the unknown name `found`, the first one on a tie;
/// `None` if all are too far away.
pub fn nearest_name<'k>(found: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let letters: Vec<char> = found.chars().take(LONGEST + 1).collect();
    let mut best: Option<(usize, &str)> = None;
    for name in known {
        let within = best.map_or(usize::MAX, |(distance, _)| distance.saturating_sub(1));
        if let Some(distance) = near(found, &letters, name).filter(|&distance| distance <= within) {
            best = Some((distance, name));
        }
    }
    best.map(|(_, name)| name)
}

/// Returns the distance of two different names, if it is small enough.
fn near(found: &str, letters: &[char], name: &str) -> Option<usize> {
    let undigit = |text: &str| text.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
    let other: Vec<char> = name.chars().take(LONGEST + 1).collect();
    let limit = match letters.len().min(other.len()) {
        ..3 => 0,
        3..6 => 1,
        6..=LONGEST => 2,
        _ => return None,
    };
    if found.to_lowercase() == name.to_lowercase() {
        return Some(1);
    }
    if letters.len().abs_diff(other.len()) > limit {
        return None;
    }
    Some(distance(letters, &other)).filter(|d| *d <= limit && undigit(found) != undigit(name))
}

/// Returns the distance by optimal string alignment, row by row of the table over prefixes.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let substituted = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = substituted.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(before[j - 2] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(a: &str, b: &str) -> usize {
        let letters = |text: &str| text.chars().collect::<Vec<_>>();
        distance(&letters(a), &letters(b))
    }

    #[test]
    fn distances_are_those_of_optimal_string_alignment() {
        for (a, b, expected) in [
            ("", "", 0),
            ("", "ab", 2),
            ("sphere", "spere", 1),
            ("material", "amterial", 1),
            ("kitten", "sitting", 3),
            // The swapped pair is not changed again; otherwise the distance would be 2.
            ("ca", "abc", 3),
            ("größe", "grösse", 2),
        ] {
            assert_eq!((between(a, b), between(b, a)), (expected, expected), "{a} {b}");
        }
    }

    #[test]
    fn one_or_two_letters_are_a_slip_unless_the_name_is_short_or_numbered() {
        let known = ["sphere", "radius", "fov", "up", "tex1", "L", "roughness"];
        for (found, expected) in [
            ("spere", Some("sphere")),
            ("shpere", Some("sphere")),
            ("SPHERE", Some("sphere")),
            ("radios", Some("radius")),
            ("rougness", Some("roughness")),
            ("roghnes", Some("roughness")),
            ("rghnes", None),
            ("fob", Some("fov")),
            ("us", None),
            ("l", Some("L")),
            ("tex2", None),
            ("tex", None),
            ("cone", None),
            ("", None),
        ] {
            assert_eq!(nearest_name(found, known), expected, "{found}");
        }
        let long = "sphere".repeat(1000);
        assert_eq!(nearest_name(&long, [&long[1..]]), None);
    }

    #[test]
    fn of_several_the_nearest_is_meant_and_then_the_first() {
        assert_eq!(nearest_name("coated", ["coater12", "coatee", "coates"]), Some("coatee"));
    }
}
