//! Format of a scene: pbrt-v3 or pbrt-v4.
//!
//! pbrt-v3 and pbrt-v4 give the same names different meanings: `infinite` maps are
//! latitude-longitude images in one and octahedral squares in the other, `mix` amounts count from
//! opposite ends, roughness is mapped by different functions. No header distinguishes them. The
//! first evidence in the text decides for all files of the scene:
//!
//! | met | format |
//! |---|---|
//! | `Import`, `Attribute`, `ColorSpace`, `Option` | v4 |
//! | `Film` `rgb`, `gbuffer`, `spectral`; `Film` `image` | v4; v3 |
//! | a sampler, integrator or material type that only one format has | that format |
//! | types `color` and `xyz` of parameters | v3 |
//! | `WorldEnd` | v3 |
//!
//! Without any of these, the format is v4. Usually `Film` decides after a few lines.
//!
//! Tested by `suite::pbrt::the_format_is_told_by_what_the_files_use`.

use super::lexer::{Lexer, Token, unescape};
use crate::error::Result;
use crate::io::text::utf8_or_latin1;

/// The format of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    /// pbrt-v3; pbrt-v2 as far as it agrees.
    V3,
    /// pbrt-v4.
    V4,
}

/// Evidence of the format in the text.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Evidence {
    /// The scene is of this format.
    Decisive(Version),
    /// Another file is included here.
    Include(String),
    /// The file has no further evidence.
    None,
}

const ONLY_V3: &[&str] = &[
    // Integrators and samplers.
    "directlighting",
    "whitted",
    "02sequence",
    "lowdiscrepancy",
    "maxmindist",
    "random",
    // Materials.
    "matte",
    "plastic",
    "uber",
    "metal",
    "glass",
    "mirror",
    "translucent",
    "substrate",
    "disney",
    "fourier",
    "kdsubsurface",
];

const ONLY_V4: &[&str] = &[
    "simplepath",
    "simplevolpath",
    "lightpath",
    "randomwalk",
    "function",
    "independent",
    "pmj02bn",
    "paddedsobol",
    "zsobol",
    "diffuse",
    "coateddiffuse",
    "coatedconductor",
    "conductor",
    "dielectric",
    "thindielectric",
    "diffusetransmission",
    "measured",
    "interface",
];

fn of_type(name: &str) -> Option<Version> {
    if ONLY_V3.contains(&name) {
        Some(Version::V3)
    } else if ONLY_V4.contains(&name) {
        Some(Version::V4)
    } else {
        None
    }
}

/// Reads up to the next evidence.
pub(super) fn next_evidence(lexer: &mut Lexer<'_>) -> Result<Evidence> {
    // The directive or declaration whose string comes next.
    let mut expects: &[u8] = b"";
    while let Some(token) = lexer.next()? {
        let decided = match token {
            Token::Word(b"Import" | b"Attribute" | b"ColorSpace" | b"Option") => Some(Version::V4),
            Token::Word(b"WorldEnd") => Some(Version::V3),
            Token::Word(word) => {
                expects = word;
                None
            }
            Token::Quoted(bytes) => match (std::mem::take(&mut expects), &*utf8_or_latin1(bytes)) {
                (b"Include", name) => return Ok(Evidence::Include(unescape(name.as_bytes()))),
                (b"Film", "rgb" | "gbuffer" | "spectral") => Some(Version::V4),
                (b"Film", "image") => Some(Version::V3),
                (b"Sampler" | b"Integrator" | b"SurfaceIntegrator" | b"Material" | b"type", name) => {
                    of_type(name)
                }
                (_, "string type") => {
                    expects = b"type";
                    None
                }
                (_, declaration) if declaration.starts_with("color ") || declaration.starts_with("xyz ") => {
                    Some(Version::V3)
                }
                _ => None,
            },
            Token::Open | Token::Close => None,
        };
        if let Some(version) = decided {
            return Ok(Evidence::Decisive(version));
        }
    }
    Ok(Evidence::None)
}

#[cfg(test)]
mod tests {
    use super::super::place::Source;
    use super::*;

    #[test]
    fn the_first_word_of_only_one_format_decides() {
        for (text, version) in [
            ("Film \"image\" Material \"diffuse\"", Evidence::Decisive(Version::V3)),
            ("Film \"rgb\" WorldEnd", Evidence::Decisive(Version::V4)),
            ("MakeNamedMaterial \"diffuse\" \"string type\" [ \"matte\" ]", Evidence::Decisive(Version::V3)),
            ("MakeNamedMaterial \"matte\" \"string type\" \"dielectric\"", Evidence::Decisive(Version::V4)),
            ("LightSource \"infinite\" \"color L\" [1 1 1]", Evidence::Decisive(Version::V3)),
            ("Camera \"perspective\" WorldBegin WorldEnd", Evidence::Decisive(Version::V3)),
            ("AttributeBegin Include \"a\\\\b.pbrt\" WorldEnd", Evidence::Include("a\\b.pbrt".into())),
            ("Camera \"perspective\" Material \"mix\" # WorldEnd", Evidence::None),
        ] {
            let mut lexer = Lexer::new(text.as_bytes(), Source::new("a.pbrt".as_ref()));
            assert_eq!(next_evidence(&mut lexer).unwrap(), version, "{text}");
        }
    }
}
