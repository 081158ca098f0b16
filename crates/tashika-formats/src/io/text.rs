//! Text of files that do not state their encoding: UTF-8, UTF-16 with a byte order mark, or
//! Latin-1.
//!
//! Held to this by the test below.

use std::borrow::Cow;

/// Removes a byte order mark and converts UTF-16 to UTF-8. ASCII characters are single bytes in
/// every result.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, [u8]> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair));
        let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        text.collect::<String>().into_bytes().into()
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => rest.into(),
        _ => bytes.into(),
    }
}

/// Reads bytes as UTF-8 or, failing that, Latin-1, so that a name is the same in both encodings.
pub(super) fn utf8_or_latin1(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_in_all_encodings_is_read() {
        let text = "v 1\nusemtl Wände 🜁";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        for (mark, rest) in [
            (&[0xff, 0xfe][..], &little[..]),
            (&[0xfe, 0xff], &big),
            (&[0xef, 0xbb, 0xbf], text.as_bytes()),
            (&[], text.as_bytes()),
        ] {
            assert_eq!(utf8_or_latin1(&decoded(&[mark, rest].concat())), text);
        }
        assert_eq!(utf8_or_latin1(&decoded(b"W\xe4nde")), "Wände");
    }
}
