//! Command lines. They are read, never run.
//!
//! Accepted are `xform` with its options and files, `cat` with files, and either of them piped into
//! `xform`. Every other command is refused by name.
//!
//! Words are separated by blanks; single and double quotation marks and `\` work as in a shell.
//! Variables, patterns and redirections are refused.
//!
//! Source: manual page xform(1) of Radiance. Held to this by `radiance::tests`.

use super::features::{COMMAND, FEATURES, OTHER_COMMANDS};
use super::transforms::Transforms;
use crate::error::{Error, Location, Result};
use crate::io::features::Feature;
use crate::io::notes::quoted;
use crate::io::{SceneFiles, text};

/// Characters with which a shell would do more than separate words.
const SPECIAL: &[char] = &['$', '`', ';', '&', '<', '>', '(', ')', '*', '?', '[', ']', '{', '}', '~'];

/// Most lines of a file of arguments.
const MAX_LINES: usize = 1 << 20;

/// One call of `xform`: changes of the surfaces that it is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Change {
    pub(super) transforms: Transforms,
    /// Text before each identifier, with a point between.
    pub(super) prefix: Option<String>,
    /// Modifier of all surfaces.
    pub(super) modifier: Option<String>,
    /// True if surfaces face the other way.
    pub(super) inverts: bool,
}

/// Files, and lists of changes of their contents. The first list is applied first; each change of a
/// list makes a copy of its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Command {
    pub(super) files: Vec<String>,
    pub(super) changes: Vec<Vec<Change>>,
}

/// Reads the text of a command.
///
/// # Errors
/// [`Error::Unsupported`] for other commands; [`Error::Invalid`] for options that are none.
pub(super) fn parse(text: &str, files: &SceneFiles, at: &Location) -> Result<Command> {
    let words = words(text, at)?;
    let mut stages = words.split(|word| *word == Word::Pipe).map(|stage| -> Vec<String> {
        stage
            .iter()
            .filter_map(|word| if let Word::Text(text) = word { Some(text.clone()) } else { None })
            .collect()
    });
    let mut command = Command { files: Vec::new(), changes: Vec::new() };
    let first = stages.next().unwrap_or_default();
    match first.first().map(String::as_str) {
        Some("xform") => {
            let (changes, files) = xform(&first[1..], files, at)?;
            command.files = files;
            command.changes.push(changes);
        }
        Some("cat") => command.files = first[1..].to_vec(),
        other => return Err(refused(other.unwrap_or_default(), at)),
    }
    if command.files.is_empty() || command.files.iter().any(|file| file == "-") {
        return Err(Error::invalid(at.clone(), "a command without a file", "the name of a file to read"));
    }
    for stage in stages {
        match stage.first().map(String::as_str) {
            Some("xform") => {
                let (changes, rest) = xform(&stage[1..], files, at)?;
                if let Some(rest) = rest.first() {
                    let found = format!("file {} of an xform that is piped into", quoted(rest));
                    return Err(Error::invalid(at.clone(), found, "options only"));
                }
                command.changes.push(changes);
            }
            other => return Err(refused(other.unwrap_or_default(), at)),
        }
    }
    Ok(command)
}

/// Error of a command that is not accepted, by its row or by that of all others.
fn refused(name: &str, at: &Location) -> Error {
    let full = format!("!{name}");
    let row = Feature::find(FEATURES, COMMAND, &full).or(Feature::find(FEATURES, COMMAND, OTHER_COMMANDS));
    Error::unsupported(at.clone(), format!("command {}", quoted(&full)), row.map_or("", |row| row.how))
}

/// Reads the words after `xform`: the changes, one for each line of a file of arguments, and files.
fn xform(words: &[String], files: &SceneFiles, at: &Location) -> Result<(Vec<Change>, Vec<String>)> {
    let Some(place) = words.iter().position(|word| word == "-f") else {
        let (change, rest) = options(words, at)?;
        return Ok((vec![change], rest.to_vec()));
    };
    let Some(name) = words.get(place + 1) else {
        return Err(Error::invalid(at.clone(), "xform -f at the end", "a file of arguments"));
    };
    let bytes = files.read(name, at)?;
    let bytes = text::decoded(&bytes);
    let lines = text::utf8_or_latin1(&bytes);
    let file = files.beside(name);
    let mut changes = Vec::new();
    for (line, text) in (1..).zip(lines.lines()) {
        let at = Location::line(&file, line);
        if text.trim().is_empty() || text.trim_start().starts_with('#') {
            continue;
        }
        if changes.len() >= MAX_LINES {
            return Err(Error::invalid(at, "one more line", format!("at most {MAX_LINES}")));
        }
        let inserted = self::words(text, &at)?.into_iter().map(|word| match word {
            Word::Text(text) => Ok(text),
            Word::Pipe => Err(Error::invalid(at.clone(), "\"|\"", "options of xform")),
        });
        let mut all = words[..place].to_vec();
        all.extend(inserted.collect::<Result<Vec<String>>>()?);
        all.extend_from_slice(&words[place + 2..]);
        let (mut change, _) = options(&all, &at)?;
        let number = changes.len();
        change.prefix = Some(match change.prefix {
            Some(prefix) => format!("{prefix}.{number}"),
            None => format!("i{number}"),
        });
        changes.push(change);
    }
    let (_, rest) = options(&words[place + 2..], at)?;
    Ok((changes, rest.to_vec()))
}

/// Reads options up to the first word that is none.
fn options<'w>(words: &'w [String], at: &Location) -> Result<(Change, &'w [String])> {
    let mut change = Change::default();
    let mut rest = words;
    while let Some(option) = rest.first().filter(|word| word.starts_with('-')) {
        let value = || match rest.get(1) {
            Some(value) => Ok(value.clone()),
            None => Err(Error::invalid(at.clone(), format!("{option} at the end"), "a name after it")),
        };
        let taken = match option.as_str() {
            "-n" => {
                change.prefix = Some(value()?);
                2
            }
            "-m" => {
                change.modifier = Some(value()?);
                2
            }
            "-I" => {
                change.inverts = true;
                1
            }
            // Commands in the file are always followed.
            "-e" | "-c" => 1,
            _ => change.transforms.option(rest, at)?,
        };
        if taken == 0 {
            let expected = "options -t -rx -ry -rz -s -mx -my -mz -i -a -n -m -I -e -f of xform";
            return Err(Error::invalid(at.clone(), format!("option {}", quoted(option)), expected));
        }
        rest = &rest[taken..];
    }
    Ok((change, rest))
}

#[derive(Clone, Debug, PartialEq)]
enum Word {
    Text(String),
    Pipe,
}

/// Splits a command line as a shell does.
fn words(text: &str, at: &Location) -> Result<Vec<Word>> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match c {
            '\'' | '"' => {
                let word = word.get_or_insert_default();
                loop {
                    match characters.next() {
                        Some(next) if next == c => break,
                        Some('\\') if c == '"' => word.extend(characters.next()),
                        Some(next @ ('$' | '`')) if c == '"' => return Err(special(next, at)),
                        Some(next) => word.push(next),
                        None => {
                            let expected = "a second one that ends the word";
                            return Err(Error::invalid(at.clone(), "a quotation mark", expected));
                        }
                    }
                }
            }
            '\\' => word.get_or_insert_default().extend(characters.next()),
            '#' if word.is_none() => break,
            '|' => {
                words.extend(word.take().map(Word::Text));
                words.push(Word::Pipe);
            }
            c if c.is_whitespace() => words.extend(word.take().map(Word::Text)),
            c if SPECIAL.contains(&c) => return Err(special(c, at)),
            c => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word.map(Word::Text));
    Ok(words)
}

fn special(c: char, at: &Location) -> Error {
    Error::unsupported(
        at.clone(),
        format!("{c:?} in a command"),
        "commands are never run; accepted are xform and cat with the names of files",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_lines_are_split_as_a_shell_splits_them() {
        let of = |text: &str| words(text, &Location::line("a.rad", 1));
        let text = |all: &[&str]| -> Vec<Word> { all.iter().map(|w| Word::Text((*w).to_owned())).collect() };
        assert_eq!(of("xform  -t 1\t2 a.rad # b").unwrap(), text(&["xform", "-t", "1", "2", "a.rad"]));
        assert_eq!(of(r#"'a b'"c \" d" e\ f "" 'x'y"#).unwrap(), text(&["a bc \" d", "e f", "", "xy"]));
        assert_eq!(of("a|b").unwrap()[1], Word::Pipe);
        for bad in ["rm *", "a; b", "$(x)", "\"`x`\"", "a > b", "'a"] {
            assert!(of(bad).unwrap_err().to_string().starts_with("a.rad:1: "), "{bad}");
        }
    }
}
