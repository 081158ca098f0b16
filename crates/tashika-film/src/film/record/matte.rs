//! Cryptomatte: how much of a pixel each object, or each material, covers, in planes that
//! compositing programs select by name.
//!
//! The layout is that of the Cryptomatte specification, version 1.2.0, after Friedman and Jones
//! 2015. A name becomes a number, its MurmurHash3 (of 32 bits, seed 0) of the UTF-8 bytes; if the
//! bits of that were those of a zero, a denormal, an infinity or no number at all (an exponent of 0
//! or 255) the lowest bit of the exponent is turned over. The number is stored as the `f32` of these
//! bits. A layer of `2n` ranks is `n` planes `LAYER00`, `LAYER01`, … of four channels, each two
//! ranks:
//!
//! ```text
//! R = number, G = share of the pixel        of rank 2k        shares fall from rank to rank
//! B = number, A = share of the pixel        of rank 2k + 1    a rank that is not needed is 0, 0
//! ```
//!
//! What a film of these planes is about is in its metadata under `cryptomatte/KEY/`, with the first
//! seven hexadecimal digits of the layer's own hash for a key: `name`, `hash`, `conversion`, and
//! `manifest`, a JSON object of each name's number in eight hexadecimal digits.
//!
//! # Held to this by
//! The tests below, with published values of the hash and numbers of the specification's example;
//! `readers.py`, which reads a film by the reference implementation of OpenEXR.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::planes;
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, Plane, PlaneSpec, Samples};

/// Before the names of the metadata that say what planes of mattes are about; in OpenEXR they are the
/// attributes of these very names.
pub const CRYPTOMATTE: &str = "cryptomatte/";

/// What is told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteOf {
    /// Objects of a scene.
    Objects,
    /// Materials.
    Materials,
}

impl MatteOf {
    /// All, in the order of their planes.
    pub const ALL: [Self; 2] = [Self::Objects, Self::Materials];

    /// The name of the layer, by which programs ask for it.
    pub const fn layer(self) -> &'static str {
        match self {
            Self::Objects => "CryptoObject",
            Self::Materials => "CryptoMaterial",
        }
    }

    /// The plane of the numbers alone, of what covers most of a pixel.
    const fn numbers(self) -> PlaneSpec {
        match self {
            Self::Objects => planes::OBJECT_ID,
            Self::Materials => planes::MATERIAL_ID,
        }
    }
}

/// The names of what is told apart, and their numbers.
#[derive(Clone, Debug)]
pub struct Matte {
    of: MatteOf,
    numbers: Vec<u32>,
    manifest: BTreeMap<String, String>,
}

impl Matte {
    /// Ranks of a pixel, unless others are asked for: what two or three edges meet in is told apart.
    pub const RANKS: u32 = 6;
    /// Most ranks of a pixel.
    pub const MOST_RANKS: u32 = 32;

    /// So many ranks as were asked for, if there can be as many.
    ///
    /// # Errors
    /// [`Error::Option`] naming `cryptomatte` if not.
    pub fn ranks(asked: u64) -> Result<u32> {
        let ranks = u32::try_from(asked).ok().filter(|ranks| (1..=Self::MOST_RANKS).contains(ranks));
        ranks.ok_or_else(|| Error::option("cryptomatte", asked, format!("1 to {} ranks", Self::MOST_RANKS)))
    }

    /// Of things of these names, in their order; those of the same name are one.
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

    /// Sets the ranks of a pixel, two samples each: what covers it, the largest share first, of equal
    /// ones the smaller number. What there are no ranks for is left out.
    ///
    /// * `met`: the things that samples of the pixel have met, of `samples` in all; in any order.
    ///
    /// # Panics
    /// If there is no thing at one of the places.
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

    /// Adds to a film the planes of this matte, and what they are about.
    ///
    /// * `ranks`: of each pixel of the window in its order, as [`rank`](Self::rank) sets them; those of
    ///   a pixel are an even number.
    ///
    /// # Panics
    /// If the film has such planes, or `ranks` are not as many a pixel, and an even number.
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

/// The number by which planes of mattes know a name: its hash, as the bits of a floating-point number
/// that is neither zero nor denormal, infinite or none.
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

    /// Published values of the hash: of its author's test program and of other implementations.
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
        // Of hashes whose exponents are 0, 0 and 255 the lowest bit of these is turned over.
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
        // Both oaks are one; elm and fir are as large, and the smaller number is first.
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
