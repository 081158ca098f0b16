//! Replacement of `$name` in attributes.
//!
//! Tested below.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// Longest attribute after replacement by defaults (bytes).
pub(super) const MAX_ATTRIBUTE: usize = 1 << 20;

/// Reason why a name cannot be replaced.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Unreplaced {
    /// The name has no default.
    Missing(String),
    /// With the default the text is longer than [`MAX_ATTRIBUTE`].
    TooLong(String),
}

/// Returns `text` with its `$name`s replaced, or the first name that cannot be replaced.
pub(super) fn substitute<'t>(
    text: &'t str,
    defaults: &BTreeMap<String, String>,
) -> Result<Cow<'t, str>, Unreplaced> {
    if !text.contains('$') {
        return Ok(text.into());
    }
    let mut replaced = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('$') {
        replaced.push_str(before);
        let (name, braced_rest) = match after.strip_prefix('{').and_then(|inner| inner.split_once('}')) {
            Some((name, rest)) => (name, Some(rest)),
            None => {
                let end = after.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(after.len());
                (&after[..end], None)
            }
        };
        // Without braces a name may end in the middle of a word: the longest known name is taken.
        let shortest = if braced_rest.is_some() { name.len() } else { 1 };
        let ends = (shortest..=name.len()).rev().filter(|&end| name.is_char_boundary(end));
        let known = ends.filter_map(|end| Some((end, defaults.get(&name[..end])?))).next();
        let (end, value) = known.ok_or_else(|| Unreplaced::Missing(name.to_owned()))?;
        replaced.push_str(value);
        if replaced.len() > MAX_ATTRIBUTE {
            return Err(Unreplaced::TooLong(name[..end].to_owned()));
        }
        rest = braced_rest.unwrap_or(&after[end..]);
    }
    replaced.push_str(rest);
    Ok(replaced.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_would_be_too_long_names_the_default_that_makes_it_so() {
        let half = "x".repeat(MAX_ATTRIBUTE / 2);
        let defaults = BTreeMap::from([("half".to_owned(), half)]);
        assert_eq!(substitute("$half$half", &defaults).unwrap().len(), MAX_ATTRIBUTE);
        let refused = Err(Unreplaced::TooLong("half".to_owned()));
        assert_eq!(substitute("$half$half$halfs", &defaults), refused);
        assert_eq!(substitute("a${half}$half", &defaults), refused);
    }

    #[test]
    fn defaults_are_replaced_everywhere_in_a_text() {
        let defaults =
            BTreeMap::from([("spp".to_owned(), "64".to_owned()), ("sp".to_owned(), "x".to_owned())]);
        for (text, expected) in
            [("$spp", "64"), ("a$spp/$sp", "a64/x"), ("${sp}p", "xp"), ("$sppq", "64q"), ("none", "none")]
        {
            assert_eq!(substitute(text, &defaults).unwrap(), expected, "{text}");
        }
        for (text, missing) in [("$q", "q"), ("${spq}", "spq"), ("1$", ""), ("${", "")] {
            assert_eq!(substitute(text, &defaults), Err(Unreplaced::Missing(missing.to_owned())), "{text}");
        }
    }
}
