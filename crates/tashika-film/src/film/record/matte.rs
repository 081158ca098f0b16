//! Cryptomatte: the share of a pixel that each object or material covers, in planes that
//! compositing programs select by name.
//!
//! The layout is that of the Cryptomatte specification, version 1.2.0 (Friedman and Jones 2015). A
//! name becomes a number, which is the MurmurHash3 (32 bits, seed 0) of its UTF-8 bytes. If these
//! bits are those of a zero, a denormal, an infinity or a NaN (an exponent of 0 or 255), the lowest
//! bit of the exponent is flipped. The number is stored as the `f32` of these bits. A layer of `2n`
//! ranks is `n` planes `LAYER00`, `LAYER01`, … of four channels, each two ranks:
//!
//! ```text
//! R = number, G = share of the pixel        of rank 2k        shares fall from rank to rank
//! B = number, A = share of the pixel        of rank 2k + 1    a rank that is not needed is 0, 0
//! ```
//!
//! The metadata under `cryptomatte/KEY/` describe a layer, where `KEY` is the first seven
//! hexadecimal digits of the hash of the layer's name: `name`, `hash`, `conversion`, and
//! `manifest`, a JSON object that maps each name to its number in eight hexadecimal digits.
//!
//! # Held to this by
//! The tests below, with published values of the hash and numbers of the specification's example;
//! `readers.py`, which reads a film with the reference implementation of OpenEXR.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::planes;
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, Plane, PlaneSpec, Samples};

/// Prefix of the metadata names that describe planes of mattes. In OpenEXR these attributes have
/// the same names, without a further prefix.
pub const CRYPTOMATTE: &str = "cryptomatte/";

/// Kind of thing that a matte distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteOf {
    /// Objects of the scene, by their names.
    Objects,
    /// Materials of the scene, by their names.
    Materials,
}

impl MatteOf {
    /// All kinds, in the order of their planes.
    pub const ALL: [Self; 2] = [Self::Objects, Self::Materials];

    /// Name of the layer, by which programs select it.
    pub const fn layer(self) -> &'static str {
        match self {
            Self::Objects => "CryptoObject",
            Self::Materials => "CryptoMaterial",
        }
    }

    /// Plane with the number of the thing that covers most of each pixel.
    const fn numbers(self) -> PlaneSpec {
        match self {
            Self::Objects => planes::OBJECT_ID,
            Self::Materials => planes::MATERIAL_ID,
        }
    }
}

/// Names of the things that a matte distinguishes, and their numbers.
#[derive(Clone, Debug)]
pub struct Matte {
    of: MatteOf,
    numbers: Vec<u32>,
    manifest: BTreeMap<String, String>,
}

impl Matte {
    /// Default number of ranks: enough for pixels in which two or three edges meet.
    pub const RANKS: u32 = 6;
    /// Largest number of ranks of a pixel.
    pub const MOST_RANKS: u32 = 32;

    /// Returns the number of ranks, if it is allowed.
    ///
    /// # Errors
    /// [`Error::Option`] naming `cryptomatte` if it is not from 1 to [`Self::MOST_RANKS`].
    pub fn ranks(asked: u64) -> Result<u32> {
        let ranks = u32::try_from(asked).ok().filter(|ranks| (1..=Self::MOST_RANKS).contains(ranks));
        ranks.ok_or_else(|| Error::option("cryptomatte", asked, format!("1 to {} ranks", Self::MOST_RANKS)))
    }

    /// A matte of things with these names, in their order; things of equal names are one.
    pub fn new<'n>(of: MatteOf, names: impl IntoIterator<Item = &'n str>) -> Self {
        let mut manifest = BTreeMap::new();
        let mut number = |name: &str| {
            let number = matte_id(name);
            if !manifest.contains_key(name) {
                manifest.insert(name.to_owned(), format!("{number:08x}"));
            }
            number
        };
        let numbers = names.into_iter().map(&mut number).collect();
        Self { of, numbers, manifest }
    }

    /// Writes the ranks of a pixel, two samples each, from the largest share to the smallest, equal
    /// shares in the order of their numbers. Things beyond the last rank are omitted.
    ///
    /// * `met`: indices of the things that samples of the pixel met, in any order.
    /// * `samples`: number of all samples of the pixel.
    ///
    /// # Panics
    /// If an index has no thing.
    pub fn rank(&self, met: &[usize], samples: u32, ranks: &mut [f32]) {
        let mut numbers: Vec<u32> = met.iter().map(|thing| self.numbers[*thing]).collect();
        numbers.sort_unstable();
        let mut counted: Vec<(u32, usize)> =
            numbers.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect();
        counted.sort_by_key(|(_, count)| Reverse(*count));
        ranks.fill(0.0);
        for (rank, (number, count)) in ranks.chunks_exact_mut(2).zip(counted) {
            rank.copy_from_slice(&[f32::from_bits(number), count as f32 / samples as f32]);
        }
    }

    /// Adds the planes of this matte to a film, and their description to its metadata.
    ///
    /// * `ranks`: ranks of all pixels of the window, row by row, as [`rank`](Self::rank) writes
    ///   them; an even number of ranks per pixel.
    ///
    /// # Panics
    /// If the film has such planes, or the pixels have no ranks or an odd number of them.
    pub fn add_to(&self, film: &mut Film, ranks: &[f32]) {
        let window = film.window();
        let of_pixel = ranks.len() / window.area() as usize;
        assert!(of_pixel > 0 && of_pixel.is_multiple_of(4), "{of_pixel} samples of a pixel's ranks");
        let pixels = || ranks.chunks_exact(of_pixel);
        film.add_plane(&self.of.numbers(), Samples::U32(pixels().map(|ranks| ranks[0].to_bits()).collect()));
        for layer in 0..of_pixel / 4 {
            let samples = pixels().flat_map(|ranks| &ranks[4 * layer..4 * layer + 4]).copied().collect();
            let name = format!("{}{layer:02}", self.of.layer());
            let doc = "numbers of what covers a pixel, as floating point, and the shares that it covers";
            let channels = ["R", "G", "B", "A"].map(str::to_owned).to_vec();
            let words = [name, "1".to_owned(), doc.to_owned()];
            film.take_plane(Plane::from_samples(words, channels, window, Samples::F32(samples)));
        }
        self.describe(film.metadata_mut());
    }

    fn describe(&self, metadata: &mut Metadata) {
        let layer = self.of.layer();
        let key = &format!("{:08x}", murmur3(layer.as_bytes()))[..7];
        let manifest = serde_json::to_string(&self.manifest).expect("words by words");
        for (name, value) in [
            ("name", layer),
            ("hash", "MurmurHash3_32"),
            ("conversion", "uint32_to_float32"),
            ("manifest", &manifest),
        ] {
            metadata.set(format!("{CRYPTOMATTE}{key}/{name}"), value);
        }
    }
}

/// Returns the number of a name in planes of mattes: its hash, adjusted to the bits of a normal
/// floating-point number, neither zero nor denormal, infinite or NaN.
///
/// ```
/// assert_eq!(tashika_film::film::matte_id("bunny"), 0x13851a76);
/// ```
pub fn matte_id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    if matches!(hash >> 23 & 0xff, 0 | 0xff) { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3 (Appleby), the variant of 32 bits for x86, seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let little_endian = |bytes: &[u8]| bytes.iter().rev().fold(0, |k, byte| k << 8 | u32::from(*byte));
    let (blocks, tail) = bytes.split_at(bytes.len() / 4 * 4);
    let mut hash = blocks.chunks_exact(4).fold(0_u32, |hash, block| {
        (hash ^ scrambled(little_endian(block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    hash ^= scrambled(little_endian(tail));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Window;

    /// Published values of the hash: from its author's test program and from other implementations.
    #[test]
    fn the_hash_is_the_published_one() {
        for (text, expected) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("bunny", 0x1385_1a76),
            ("default", 0x42c9_679f),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), expected, "{text:?}");
        }
    }

    #[test]
    fn numbers_are_finite_and_normal_whatever_the_hash() {
        let rendered = "/GAFFERBOT/C_torso_GRP/C_head_GRP/C_head_CPT/C_head001_REN";
        assert_eq!(matte_id(rendered), 4_226_998_693, "as another renderer has it");
        assert_eq!(f32::from_bits(matte_id(rendered)), -2.522_224_9e36);
        // The hashes have the exponents 0, 0 and 255, whose lowest bit is flipped.
        for name in ["", "object85", "object878"] {
            let (hash, number) = (murmur3(name.as_bytes()), matte_id(name));
            assert!(!f32::from_bits(hash).is_normal(), "{name:?} {hash:08x}");
            assert_eq!(number ^ hash, 0x0080_0000);
        }
        assert!((0..100_000).all(|k| f32::from_bits(matte_id(&format!("object{k}"))).is_normal()));
    }

    #[test]
    fn ranks_are_pairs_of_channels_and_names_are_in_the_manifest() {
        let size = [2, 1];
        let mut film = Film::new(size, Window::full(size), &[planes::RADIANCE]).unwrap();
        let matte = Matte::new(MatteOf::Materials, ["oak", "tin \"\u{fc}\"", "oak", "ash", "elm", "fir"]);
        let [oak, tin, ash, elm, fir] = ["oak", "tin \"\u{fc}\"", "ash", "elm", "fir"].map(matte_id);
        let mut ranks = [7.0; 16];
        matte.rank(&[1, 1], 2, &mut ranks[..8]);
        // Both oaks are one; ash, elm and fir have equal shares, and the smallest number is first.
        matte.rank(&[5, 1, 0, 4, 2, 1, 2, 1, 3], 16, &mut ranks[8..]);
        matte.add_to(&mut film, &ranks);
        let at = |plane: &str, x| film.plane(plane).unwrap().f32_at(x, 0).to_vec();
        let float = f32::from_bits;
        assert_eq!(at("CryptoMaterial00", 0), [float(tin), 1.0, 0.0, 0.0]);
        assert_eq!(at("CryptoMaterial00", 1), [float(oak), 0.1875, float(tin), 0.1875]);
        let smallest = [ash, elm, fir].into_iter().min().unwrap();
        assert_eq!(at("CryptoMaterial01", 1)[..2], [float(smallest), 0.0625]);
        assert_eq!(at("CryptoMaterial01", 0), [0.0; 4]);
        assert!(film.plane("CryptoMaterial02").is_none());
        assert_eq!(film.plane(planes::MATERIAL_ID).unwrap().u32_samples().unwrap(), [tin, oak]);
        let said =
            |name: &str| film.metadata().text(format!("cryptomatte/be359d6/{name}")).unwrap().to_owned();
        assert_eq!(
            ["name", "hash", "conversion"].map(said),
            ["CryptoMaterial", "MurmurHash3_32", "uint32_to_float32"]
        );
        let expected = format!("\"oak\":\"{oak:08x}\",\"tin \\\"\u{fc}\\\"\":\"{tin:08x}\"}}");
        assert!(said("manifest").ends_with(&expected), "{}", said("manifest"));
    }
}
