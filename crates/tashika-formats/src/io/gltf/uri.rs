//! Bytes that a URI in a glTF file stands for, in the URI itself or in a file.
//!
//! Input: the URI as written. Output: bytes. `data:` URIs[^rfc2397] carry base64[^rfc4648] or
//! percent-encoded bytes[^rfc3986]; base64 may have line breaks, as in mail. Every other URI is a
//! path relative to the scene file, percent-encoded as in glTF (section 2.8), or plain as some
//! exporters write it.
//!
//! # Limits
//! Nothing is fetched from a network.
//!
//! # Held to this by
//! The tests below.
//!
//! [^rfc2397]: Masinter. "The 'data' URL scheme." RFC 2397, 1998.
//! [^rfc3986]: Berners-Lee, Fielding, Masinter. "Uniform Resource Identifier: Generic Syntax."
//!     RFC 3986, 2005, section 2.1.
//! [^rfc4648]: Josefsson. "The Base16, Base32, and Base64 Data Encodings." RFC 4648, 2006,
//!     section 4.

use std::io::ErrorKind;

use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::notes::shown;

/// Bytes that `uri`, which stands at `at`, refers to.
pub(super) fn fetch(files: &SceneFiles, uri: &str, at: &Location) -> Result<Vec<u8>> {
    if let Some(data) = data_part(uri) {
        return decode_data(data, at);
    }
    if let Some(scheme) = scheme(uri) {
        let what = format!("reading from {:?}", shown(scheme));
        return Err(Error::unsupported(
            at.clone(),
            what,
            "put the file beside the scene and refer to it by its name",
        ));
    }
    let decoded = String::from_utf8(percent_decode(uri)).unwrap_or_else(|_| uri.to_owned());
    match files.read(&decoded, at) {
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound && decoded != uri => {
            files.read(uri, at)
        }
        result => result,
    }
}

/// Returns true if the URI contains its bytes.
pub(super) fn is_data(uri: &str) -> bool {
    data_part(uri).is_some()
}

/// Text after `data:`.
fn data_part(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("data:").then_some(rest)
}

/// Scheme of a URI, such as `http` of `http://…`; drive letters are not schemes.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let known = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
    (scheme.len() > 1 && scheme.chars().all(known)).then_some(scheme)
}

/// The bytes of `[type][;base64],payload`.
fn decode_data(data: &str, at: &Location) -> Result<Vec<u8>> {
    let invalid = |found: &str, expected| Err(Error::invalid(at.clone(), found, expected));
    let Some((header, payload)) = data.split_once(',') else {
        return invalid("a data: URI without a comma", "data:[type][;base64],bytes");
    };
    let bytes = percent_decode(payload);
    if !header.to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    let solid: Vec<u8> = bytes.into_iter().filter(|b| !b.is_ascii_whitespace()).collect();
    match base64(&solid) {
        Some(decoded) => Ok(decoded),
        None => invalid("a data: URI with damaged base64", "groups of four of A-Z, a-z, 0-9, + and /"),
    }
}

/// Replaces `%xx` by the byte it stands for; a `%` that starts no such group stays.
fn percent_decode(text: &str) -> Vec<u8> {
    let mut rest = text.as_bytes();
    let mut bytes = Vec::with_capacity(rest.len());
    let digit = |c: u8| char::from(c).to_digit(16);
    while let [first, tail @ ..] = rest {
        if let (b'%', [high, low, after @ ..]) = (first, tail)
            && let (Some(high), Some(low)) = (digit(*high), digit(*low))
        {
            bytes.push((high * 16 + low) as u8);
            rest = after;
        } else {
            bytes.push(*first);
            rest = tail;
        }
    }
    bytes
}

/// Bytes of base64 text, padded or not; nothing if a character or the length is wrong.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let end = text.iter().rposition(|&c| c != b'=').map_or(0, |last| last + 1);
    if text.len() - end > 2 {
        return None;
    }
    let mut bytes = Vec::with_capacity(end / 4 * 3 + 2);
    for group in text[..end].chunks(4) {
        let mut bits = 0_u32;
        for &c in group {
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        // Each character has six bits. Bits beyond the last whole byte are padding.
        let whole = match group.len() {
            4 => 3,
            3 => 2,
            2 => 1,
            _ => return None,
        };
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=whole]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_follows_the_vectors_of_its_rfc() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zm8", "fo"),
        ] {
            assert_eq!(base64(text.as_bytes()).unwrap(), bytes.as_bytes(), "{text}");
        }
        assert_eq!(base64(b"++//").unwrap(), [0xfb, 0xef, 0xff]);
        for damaged in ["Z", "Zm9vY", "Zm 9", "Zm9v====", "Zm-v", "=Zm9", "Z\u{e9}"] {
            assert_eq!(base64(damaged.as_bytes()), None, "{damaged}");
        }
    }

    #[test]
    fn data_uris_carry_base64_or_percent_encoded_bytes() {
        let at = Location::default();
        let decode = |uri| decode_data(data_part(uri).unwrap(), &at);
        assert_eq!(decode("data:application/octet-stream;base64,Zm9v").unwrap(), b"foo");
        assert_eq!(decode("DATA:;BASE64,Zg%3D%3D").unwrap(), b"f");
        // Line breaks as in mail and in files of some exporters.
        assert_eq!(decode("data:;base64,Zm9v\r\n Ym\nFy%0A").unwrap(), b"foobar");
        assert_eq!(decode("data:,a%20b%zz%").unwrap(), b"a b%zz%");
        assert!(decode("data:text/plain").is_err());
        assert!(decode("data:;base64,***").is_err());
        assert!(!is_data("dat") && !is_data("data.bin"));
    }

    #[test]
    fn names_may_be_percent_encoded_or_plain_and_networks_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a b.bin", "50%25.bin", "s.gltf"] {
            std::fs::write(folder.path().join(name), name).unwrap();
        }
        let files =
            SceneFiles::open(&folder.path().join("s.gltf"), &crate::io::LoadOptions::default()).unwrap();
        let at = Location::default();
        for uri in ["a%20b.bin", "a b.bin"] {
            assert_eq!(fetch(&files, uri, &at).unwrap(), b"a b.bin");
        }
        assert_eq!(fetch(&files, "50%25.bin", &at).unwrap(), b"50%25.bin", "decoded it is not there");
        assert!(matches!(fetch(&files, "https://example.org/a.bin", &at), Err(Error::Unsupported { .. })));
        assert!(matches!(fetch(&files, "%2e%2e/secret", &at), Err(Error::Outside { .. })));
    }
}
