//! Packets for tev, as bytes.
//!
//! The layout of a packet, with all numbers little-endian and without padding, is
//!
//! ```text
//! u32   bytes of the packet, these four among them
//! u8    operation
//! …     what belongs to the operation
//! ```
//!
//! Texts end with a zero byte. Two of tev's operations are used:
//!
//! ```text
//! 4  CreateImage      u8 whether to bring it to front, text name of the image, i32 width, i32 height,
//!                     i32 n, n texts: names of the channels
//! 6  UpdateImageV3    u8 whether to bring it to front, text name of the image, i32 n, n texts: names of the channels,
//!                     i32 x, i32 y, i32 width, i32 height: the part of the image that is new,
//!                     i64 offsets[n], i64 strides[n], f32 samples[…]
//! ```
//!
//! Pixels `p` of the part are numbered row by row from the top left. The sample of channel `c` and
//! pixel `p` is `samples[offsets[c] + p · strides[c]]`. Packets of this program store one channel
//! after the other: `offsets[c] = c · pixels`, and all strides are 1.
//!
//! The source of this layout is the code of tev (`include/tev/Ipc.h` and `src/Ipc.cpp`).
//!
//! # Held to this by
//! The tests below, which compare packets byte by byte; the program's tests in `tests/tev.rs`,
//! whose reader is written from the layout alone.

use tashika::film::{Film, Samples, Window, channel_name};

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;

/// Names of all channels of a film, plane by plane, as in its OpenEXR file.
pub fn channel_names(film: &Film) -> Vec<String> {
    let planes = film.planes().iter();
    planes.flat_map(|p| p.channels().iter().map(|c| channel_name(p.name(), c))).collect()
}

/// Samples of a tile in the order of [`channel_names`], channel after channel; counts and codes
/// become floats.
pub fn samples(film: &Film, tile: Window) -> Vec<f32> {
    let mut samples = Vec::new();
    for plane in film.planes() {
        for channel in 0..plane.channels().len() {
            samples.extend(tile.pixels().map(|(x, y)| match plane.samples() {
                Samples::F32(_) => plane.f32_at(x, y)[channel],
                Samples::U32(_) => plane.u32_at(x, y)[channel] as f32,
            }));
        }
    }
    samples
}

/// Packet that creates an image and brings it to front. Its samples are zero until they are
/// updated.
pub fn create_image(name: &str, size: [u32; 2], channels: &[String]) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, true);
    packet.text(name);
    packet.integers(&size);
    packet.channels(channels);
    packet.finish()
}

/// Packet with the samples of a part of the image, channel after channel.
///
/// # Panics
/// If there is not one sample for each channel and pixel.
pub fn update_image(name: &str, channels: &[String], part: Window, samples: &[f32]) -> Vec<u8> {
    let pixels = part.area();
    assert_eq!(samples.len() as u64, pixels * channels.len() as u64, "a sample for each channel and pixel");
    let mut packet = Packet::new(UPDATE_IMAGE_V3, false);
    packet.text(name);
    packet.channels(channels);
    packet.integers(&[part.x, part.y, part.width, part.height]);
    let offsets = (0..channels.len() as u64).map(|channel| channel * pixels);
    let strides = channels.iter().map(|_| 1);
    packet.0.extend(offsets.chain(strides).flat_map(u64::to_le_bytes));
    packet.0.extend(samples.iter().flat_map(|sample| sample.to_le_bytes()));
    packet.finish()
}

/// A packet that is being put together.
struct Packet(Vec<u8>);

impl Packet {
    fn new(operation: u8, to_front: bool) -> Self {
        Self(vec![0, 0, 0, 0, operation, u8::from(to_front)])
    }

    /// Adds a text without its zero bytes. A zero byte would end the text early, and the rest of
    /// the packet would be misread.
    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    /// Adds sizes and places. All are far below 2³¹, where signed and unsigned numbers have equal
    /// bytes.
    fn integers(&mut self, numbers: &[u32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn channels(&mut self, names: &[String]) {
        self.integers(&[names.len() as u32]);
        for name in names {
            self.text(name);
        }
    }

    fn finish(mut self) -> Vec<u8> {
        let length = u32::try_from(self.0.len()).expect("a tile is a few thousand pixels");
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tashika::film::{PlaneSpec, SampleKind};

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn an_image_is_created_as_the_layout_says() {
        let mut expected = vec![38, 0, 0, 0, 4, 1];
        expected.extend(b"a.exr\0");
        expected.extend([0x80, 2, 0, 0, 0x68, 1, 0, 0, 2, 0, 0, 0]);
        expected.extend(b"R\0claim.id");
        expected.extend([0]);
        expected[0] = expected.len() as u8;
        assert_eq!(create_image("a.exr", [640, 360], &names(&["R", "claim.id"])), expected);
        assert_eq!(create_image("a\0.exr", [640, 360], &names(&["R", "claim.id"])), expected, "one text");
    }

    #[test]
    fn a_part_is_sent_as_the_layout_says() {
        let part = Window { x: 16, y: 300, width: 2, height: 1 };
        let mut expected = vec![0, 0, 0, 0, 6, 0, b'a', 0, 2, 0, 0, 0, b'R', 0, b'n', b'.', b'Y', 0];
        expected.extend([16, 0, 0, 0, 44, 1, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0]);
        for number in [0, 2, 1, 1] {
            expected.extend([number, 0, 0, 0, 0, 0, 0, 0]);
        }
        for sample in [1.0_f32, -0.0, f32::INFINITY, 0.1] {
            expected.extend(sample.to_bits().to_le_bytes());
        }
        expected[0] = expected.len() as u8;
        let sent = update_image("a", &names(&["R", "n.Y"]), part, &[1.0, -0.0, f32::INFINITY, 0.1]);
        assert_eq!(sent, expected);
    }

    #[test]
    fn samples_follow_the_names_of_their_channels() {
        let spec = |name, channels, kind| PlaneSpec { name, channels, unit: "1", kind, doc: "" };
        let specs = [spec("", &["R", "G"], SampleKind::F32), spec("claim", &["id"], SampleKind::U32)];
        let window = Window { x: 4, y: 2, width: 3, height: 3 };
        let mut film = Film::new([9, 9], window, &specs).unwrap();
        for (x, y) in window.pixels() {
            film.plane_mut("").unwrap().set_f32(x, y, &[x as f32, y as f32 + 0.5]);
            film.plane_mut("claim").unwrap().set_u32(x, y, &[10 * x + y]);
        }
        assert_eq!(channel_names(&film), ["R", "G", "claim.id"]);
        let tile = Window { x: 5, y: 3, width: 2, height: 1 };
        assert_eq!(samples(&film, tile), [5.0, 6.0, 3.5, 3.5, 53.0, 63.0]);
    }
}
