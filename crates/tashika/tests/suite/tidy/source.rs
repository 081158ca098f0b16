//! Rust source as far as the rules of `tidy` look at it: words, paths and comments, each with its
//! line.
//!
//! A lexer separates code from comments, characters and lifetimes; nothing is parsed beyond paths,
//! `use` trees, inline modules and the extent of items under `#[cfg(test)]`. Source that compiles
//! is assumed. Unknown constructs panic, so that no code goes unseen.

/// A word, `::`, or any other sign that is not blank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Token {
    /// A name or keyword; raw names without their `r#`.
    Word(String),
    /// The separator of a path.
    Separator,
    /// A sign; `0` stands for a number.
    Sign(char),
    /// Content of a string between its quotes, as written.
    Text(String),
}

/// A token and its line, from 1.
pub type Placed = (Token, usize);

/// A file, or a snippet, as tokens and comments.
#[derive(Debug, Default)]
pub struct Lexed {
    /// The code.
    pub tokens: Vec<Placed>,
    /// Each line of each comment, with its marks.
    pub comments: Vec<(String, usize)>,
}

/// A path as written, `use` trees expanded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// Segments of the path; a glob is `*`.
    pub segments: Vec<String>,
    /// Names of the inline modules around it, outermost first.
    pub inside: Vec<String>,
    /// True if it follows `use`, or `extern crate`.
    pub imported: bool,
    /// Line of the last segment.
    pub line: usize,
}

impl Path {
    /// The path from the crate's root, if it begins with `crate`, `self` or `super`; `module` is
    /// that of the file.
    pub fn absolute(&self, module: &[String]) -> Option<Vec<String>> {
        let mut place: Vec<String> = module.iter().chain(&self.inside).cloned().collect();
        let mut rest = &self.segments[..];
        match rest[0].as_str() {
            "crate" => place.clear(),
            "self" if rest.len() > 1 => {}
            "super" => {
                place.pop();
            }
            _ => return None,
        }
        rest = &rest[1..];
        while let [first, tail @ ..] = rest {
            match first.as_str() {
                "super" => {
                    place.pop();
                }
                "self" => {}
                _ => break,
            }
            rest = tail;
        }
        place.extend(rest.iter().filter(|s| *s != "self").cloned());
        Some(place)
    }
}

impl Token {
    /// Returns true if it is that word.
    pub fn is(&self, word: &str) -> bool {
        matches!(self, Self::Word(w) if w == word)
    }

    fn word(&self) -> Option<&str> {
        match self {
            Self::Word(w) => Some(w),
            Self::Separator | Self::Sign(_) | Self::Text(_) => None,
        }
    }
}

/// Keywords that stand in front of paths without being part of them: `impl ::a::B`.
const KEYWORDS: [&str; 17] = [
    "as", "async", "await", "break", "dyn", "else", "for", "if", "impl", "in", "let", "match", "move", "mut",
    "ref", "return", "where",
];

/// Splits `text` into tokens and comments.
pub fn lex(text: &str) -> Lexed {
    let chars: Vec<char> = text.chars().collect();
    let mut lexed = Lexed::default();
    let (mut i, mut line) = (0, 1);
    while i < chars.len() {
        let start = i;
        let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
        match (chars[i], at(i + 1)) {
            ('/', '/') => i = end_of_line(&chars, i),
            ('/', '*') => i = end_of_block_comment(&chars, i),
            ('"', _) => {
                i = end_of_quoted(&chars, i + 1, '"');
                lexed.tokens.push((Token::Text(chars[start + 1..i - 1].iter().collect()), line));
            }
            ('\'', '\\') => i = end_of_quoted(&chars, i + 1, '\''),
            // A lifetime has no closing quote behind its first letter.
            ('\'', _) if at(i + 2) == '\'' => i += 3,
            ('\'', _) => i = end_of_word(&chars, i + 1),
            (c, _) if c.is_ascii_digit() => {
                i = end_of_number(&chars, i);
                lexed.tokens.push((Token::Sign('0'), line));
            }
            (c, _) if is_letter(c) => {
                i = end_of_word(&chars, i);
                let word: String = chars[start..i].iter().collect();
                let prefix = matches!(word.as_str(), "r" | "b" | "br" | "c" | "cr");
                match at(i) {
                    '"' | '#' if prefix && word.contains('r') && is_raw_string(&chars, i) => {
                        i = end_of_raw_string(&chars, i);
                    }
                    '"' if prefix => i = end_of_quoted(&chars, i + 1, '"'),
                    '\'' if word == "b" => i = end_of_quoted(&chars, i + 1, '\''),
                    '#' if word == "r" => i += 1,
                    _ => lexed.tokens.push((Token::Word(word), line)),
                }
            }
            (':', ':') => {
                lexed.tokens.push((Token::Separator, line));
                i += 2;
            }
            (c, _) => {
                if !c.is_whitespace() {
                    lexed.tokens.push((Token::Sign(c), line));
                }
                i += 1;
            }
        }
        let piece: String = chars[start..i].iter().collect();
        if piece.starts_with("//") || piece.starts_with("/*") {
            lexed.comments.extend((line..).zip(piece.lines()).map(|(line, text)| (text.to_owned(), line)));
        }
        line += piece.matches('\n').count();
    }
    lexed
}

fn is_letter(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

fn end_of_word(chars: &[char], from: usize) -> usize {
    from + chars[from..].iter().take_while(|c| is_letter(**c) || c.is_numeric()).count()
}

/// `1_000`, `0x1f`, `1.5e-3`; in `0..n` and `1.max(2)` the point is not part of it.
fn end_of_number(chars: &[char], from: usize) -> usize {
    let mut i = end_of_word(chars, from);
    if chars.get(i) == Some(&'.') && chars.get(i + 1).is_some_and(char::is_ascii_digit) {
        i = end_of_word(chars, i + 1);
    }
    if matches!(chars[i - 1], 'e' | 'E') && matches!(chars.get(i), Some('-' | '+')) && chars[from + 1] != 'x'
    {
        i = end_of_word(chars, i + 1);
    }
    i
}

fn end_of_line(chars: &[char], from: usize) -> usize {
    from + chars[from..].iter().take_while(|c| **c != '\n').count()
}

fn end_of_block_comment(chars: &[char], from: usize) -> usize {
    let (mut i, mut depth) = (from, 0);
    while i + 1 < chars.len() {
        match (chars[i], chars[i + 1]) {
            ('/', '*') => (depth, i) = (depth + 1, i + 2),
            ('*', '/') => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            return i;
        }
    }
    panic!("a comment without end")
}

/// Position after the closing `quote` of a text that begins at `from`.
fn end_of_quoted(chars: &[char], from: usize, quote: char) -> usize {
    let mut i = from;
    while chars[i] != quote {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Returns true if `##"` with any number of `#` begins at `from`.
fn is_raw_string(chars: &[char], from: usize) -> bool {
    chars[from..].iter().find(|c| **c != '#') == Some(&'"')
}

fn end_of_raw_string(chars: &[char], from: usize) -> usize {
    let hashes = chars[from..].iter().take_while(|c| **c == '#').count();
    let mut i = from + hashes + 1;
    while !(chars[i] == '"' && chars[i + 1..].iter().take_while(|c| **c == '#').count() >= hashes) {
        i += 1;
    }
    i + 1 + hashes
}

/// The code that is there when no test is built.
pub fn without_tests(tokens: &[Placed]) -> Vec<Placed> {
    let mut kept = Vec::with_capacity(tokens.len());
    let mut i = 0;
    while i < tokens.len() {
        let is_test =
            |at: usize| ["cfg", "(", "test", ")"].iter().zip(&tokens[at..]).all(|(s, t)| shows(&t.0, s));
        if shows(&tokens[i].0, "#") && i + 2 < tokens.len() && shows(&tokens[i + 1].0, "[") && is_test(i + 2)
        {
            i = end_of_item(tokens, i);
        } else {
            kept.push(tokens[i].clone());
            i += 1;
        }
    }
    kept
}

fn shows(token: &Token, text: &str) -> bool {
    match token {
        Token::Word(w) => w == text,
        Token::Separator => text == "::",
        Token::Sign(c) => text.chars().eq([*c]),
        Token::Text(_) => false,
    }
}

/// Position after the item at `from`, which begins with attributes.
fn end_of_item(tokens: &[Placed], from: usize) -> usize {
    const ITEMS: [&str; 13] = [
        "pub", "mod", "use", "fn", "impl", "const", "static", "struct", "enum", "trait", "type", "let",
        "unsafe",
    ];
    let mut i = from;
    while shows(&tokens[i].0, "#") {
        i = closing(tokens, i + 1) + 1;
    }
    let (token, line) = &tokens[i];
    let known = token.word().is_some_and(|w| ITEMS.contains(&w));
    assert!(known, "line {line}: #[cfg(test)] on something that tidy does not understand: {token:?}");
    let is_use = token.is("use");
    loop {
        match &tokens[i].0 {
            Token::Sign(';') => return i + 1,
            Token::Sign('{') if is_use => i = closing(tokens, i) + 1,
            Token::Sign('{') => return closing(tokens, i) + 1,
            Token::Sign('(' | '[') => i = closing(tokens, i) + 1,
            _ => i += 1,
        }
    }
}

/// Position of the bracket that closes the one at `from`.
fn closing(tokens: &[Placed], from: usize) -> usize {
    let mut depth = 0;
    for (i, (token, _)) in tokens.iter().enumerate().skip(from) {
        match token {
            Token::Sign('(' | '[' | '{') => depth += 1,
            Token::Sign(')' | ']' | '}') => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i;
        }
    }
    panic!("line {}: a bracket without end", tokens[from].1)
}

/// All paths of more than one segment, and all that are imported, in order.
pub fn paths(tokens: &[Placed]) -> Vec<Path> {
    let mut found = Vec::new();
    // Inline modules around the place, each with the position of its closing brace.
    let mut inside: Vec<(String, usize)> = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        inside.retain(|(_, end)| i < *end);
        let next = tokens.get(i + 1).map(|t| &t.0);
        match &tokens[i].0 {
            // A visibility names a place, but uses nothing there.
            Token::Word(w) if w == "pub" && next == Some(&Token::Sign('(')) => i = closing(tokens, i + 1) + 1,
            Token::Word(w) if w == "mod" => {
                if let (Some(Token::Word(name)), Some((Token::Sign('{'), _))) = (next, tokens.get(i + 2)) {
                    inside.push((name.clone(), closing(tokens, i + 2)));
                }
                i += 2;
            }
            Token::Word(w) if KEYWORDS.contains(&w.as_str()) => i += 1,
            Token::Word(w) => {
                let import = w == "use" || w == "extern" && next.is_some_and(|t| t.is("crate"));
                let start = if import { i + if w == "use" { 1 } else { 2 } } else { i };
                let modules: Vec<String> = inside.iter().map(|(name, _)| name.clone()).collect();
                let mut tree = Vec::new();
                i = expand(tokens, start, &[], import, &mut tree).max(i + 1);
                found.extend(tree.into_iter().map(|(segments, line)| Path {
                    segments,
                    inside: modules.clone(),
                    imported: import,
                    line,
                }));
            }
            Token::Separator | Token::Sign(_) | Token::Text(_) => i += 1,
        }
    }
    // `impl Trait + use<'a>` imports nothing.
    found.retain(|p| p.segments.len() > 1 || p.imported && !p.segments.is_empty());
    found
}

/// Expands the path or `use` tree at `from` behind `prefix`; returns the position behind it.
fn expand(
    tokens: &[Placed],
    from: usize,
    prefix: &[String],
    import: bool,
    out: &mut Vec<(Vec<String>, usize)>,
) -> usize {
    let mut segments = prefix.to_vec();
    // A leading `::` makes the next segment a crate.
    let mut i = from + usize::from(tokens[from].0 == Token::Separator);
    loop {
        let (token, line) = &tokens[i];
        match token {
            Token::Word(w) => segments.push(w.clone()),
            Token::Sign('*')
                if i > 0 && matches!(tokens[i - 1].0, Token::Separator | Token::Sign('{' | ',')) =>
            {
                segments.push("*".to_owned());
            }
            Token::Sign('{') => {
                let end = closing(tokens, i);
                i += 1;
                while i < end {
                    i = expand(tokens, i, &segments, import, out);
                    let (token, line) = &tokens[i];
                    assert!(shows(token, ",") || i == end, "line {line}: tidy does not understand this list");
                    i += usize::from(i < end);
                }
                return end + 1;
            }
            // The generic arguments of `Vec::<f32>` are paths of their own.
            Token::Separator | Token::Sign(_) | Token::Text(_) => {
                out.push((segments, *line));
                return i;
            }
        }
        if tokens.get(i + 1).is_none_or(|t| t.0 != Token::Separator) {
            out.push((segments, *line));
            i += 1;
            // A renamed import.
            let renamed = import && tokens.get(i).is_some_and(|t| t.0.is("as"));
            return if renamed { i + 2 } else { i };
        }
        i += 2;
    }
}

/// Names of the modules that live in files of their own.
pub fn file_modules(tokens: &[Placed]) -> Vec<String> {
    let declared = tokens.windows(3).filter(|w| w[0].0.is("mod") && shows(&w[2].0, ";"));
    declared.filter_map(|w| w[1].0.word().map(str::to_owned)).collect()
}

mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        paths(&without_tests(&lex(text).tokens)).into_iter().map(|p| p.segments.join("::")).collect()
    }

    #[test]
    fn groups_of_imports_are_expanded_over_lines() {
        let text =
            "use crate::{\n    accel,\n    film::{self, Window as W},\n    io::*,\n};\nuse exr as e;\n";
        assert_eq!(
            found(text),
            ["crate::accel", "crate::film::self", "crate::film::Window", "crate::io::*", "exr"]
        );
        let lines: Vec<usize> = paths(&lex(text).tokens).iter().map(|p| p.line).collect();
        assert_eq!(lines, [2, 3, 3, 4, 6]);
        assert_eq!(found("use {crate::a as x, ::b::c}; extern crate d;"), ["crate::a", "b::c", "d"]);
        assert_eq!(found("fn f() -> impl T + use<'a> { x as crate::e::F }"), ["crate::e::F"]);
    }

    #[test]
    fn paths_are_found_wherever_they_stand() {
        assert_eq!(
            found("fn f(x: &crate::a::B) -> c::D { super::super::e::g::<crate::h::I>(x) }"),
            ["crate::a::B", "c::D", "super::super::e::g", "crate::h::I"]
        );
        assert_eq!(found("impl<T: crate::a::B> X for <Y as ::c::Z>::W {}"), ["crate::a::B", "c::Z"]);
        assert_eq!(found("macro_rules! m { () => { $crate::a::b!() } }"), ["crate::a::b"]);
        assert_eq!(found("#[derive(serde::Serialize)] struct S;"), ["serde::Serialize"]);
        assert!(found("pub(crate) x: f32, pub(in crate::io) y: [u8; 3]").is_empty());
    }

    #[test]
    fn what_is_not_code_names_nothing() {
        let text = r####"
            //! crate::a
            /* crate::b /* nested */ crate::c */
            const T: (&str, &[u8], char, char) = ("crate::d \" crate::e", b"crate::f", '"', '\'');
            const R: &str = r##"crate::g "# crate::h"##;
            fn f<'a>(x: &'a str) -> &'a crate::i::J { 'b: loop { break 'b; } }
        "####;
        assert_eq!(found(text), ["crate::i::J"]);
        let comments = lex(text).comments;
        assert_eq!((comments.len(), comments[0].1, comments[1].1), (2, 2, 3));
    }

    #[test]
    fn numbers_end_where_they_should() {
        for text in ["0..a::b", "1.5e-3 a::b", "0x1e-a::b", "1.max(a::b)", "2f32.a::b", "t.0.a::b"] {
            assert_eq!(found(text).last().map(String::as_str), Some("a::b"), "{text}");
        }
    }

    #[test]
    fn tests_are_left_out_and_nothing_else() {
        let text = "
            #[cfg(test)] use crate::{a, b::c};
            use crate::d::e;
            #[cfg(test)] #[allow(dead_code)] pub fn f(x: [u8; 3]) -> u8 { crate::g::h() }
            #[cfg(unix)] use crate::i::j;
            #[cfg(test)] mod tests;
            #[cfg(test)] mod more { use crate::k::l; mod deep { use crate::m::n; } }
            mod own;
        ";
        assert_eq!(found(text), ["crate::d::e", "crate::i::j"]);
        assert_eq!(file_modules(&without_tests(&lex(text).tokens)), ["own"]);
        assert_eq!(file_modules(&lex(text).tokens), ["tests", "own"]);
    }

    #[test]
    fn relative_paths_lead_to_their_module() {
        let text = "use super::super::accel::Ray; mod inner { use super::x; use self::y::z; } use crate::{self as c};";
        let module = ["io".to_owned(), "obj".to_owned(), "map".to_owned()];
        let absolute: Vec<String> = paths(&lex(text).tokens)
            .iter()
            .filter_map(|p| p.absolute(&module))
            .map(|p| p.join("::"))
            .collect();
        assert_eq!(absolute, ["io::accel::Ray", "io::obj::map::x", "io::obj::map::inner::y::z", ""]);
    }
}
