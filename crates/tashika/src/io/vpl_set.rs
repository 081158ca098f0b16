//! VPL sets as files, so that all methods and machines render the same lights.
//!
//! All numbers are little-endian. The file holds the magic `TASHIKAV`, the version (u32), the
//! length of the provenance (u32), the provenance as JSON, the number of VPLs (u64), and 48 bytes
//! for each VPL, instant by instant. A VPL has position, direction, intensity (3 × f32 each), kind
//! (u32) and two parameters (4 bytes each). The kinds are 0 omni, 1 oriented, 2 spot, 3
//! directional, 4, 5 and 7 spots with other fall-offs, 6 image, 8 in a medium. The parameters of a
//! spot are the cosines of its inner and outer cone (f32); of an image, the number of its map (u32)
//! and the cosine of its cone (f32); in a medium, the asymmetry of the phase function (f32) and
//! zero; of other kinds, zeros. The maps are those of the scene, so a set belongs to the scene in
//! which it was traced. Positions are in the coordinates of the scene's file minus the provenance's
//! `origin`, three numbers (m) that default to zero. The length of the file must be exact. Version
//! 1 is for static scenes. In version 2 the provenance also has `instants`: the share of the time
//! and the number of VPLs of each instant.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::write_file;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::Instants;
use crate::scene::{Beam, Falloff, FalloffShape};
use crate::vpl::{Provenance, Vpl, VplKind, VplSet};

const MAGIC: &[u8; 8] = b"TASHIKAV";
/// Version of a set with one instant, and version of a set with several.
const VERSIONS: [u32; 2] = [1, 2];
const RECORD: usize = 48;
/// Longest provenance that is read (bytes).
const MAX_PROVENANCE: u32 = 1 << 20;

/// Provenance as stored in the file.
#[derive(Serialize, Deserialize)]
struct Head {
    #[serde(flatten)]
    provenance: Provenance,
    /// Share of the time and number of VPLs of each instant; empty if there is only one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    instants: Vec<(f32, u64)>,
}

/// Writes a VPL set. The file appears as a whole or not at all.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written.
pub fn save_vpls(path: &Path, set: &VplSet) -> Result<()> {
    let is_still = set.instants().is_single();
    let of_instants = set.instants().shares().iter().enumerate();
    let head = Head {
        provenance: set.provenance().clone(),
        instants: of_instants
            .filter(|_| !is_still)
            .map(|(instant, share)| (*share, set.at(instant).len() as u64))
            .collect(),
    };
    let provenance = serde_json::to_vec(&head).map_err(|e| Error::io(path, e.into()))?;
    let mut bytes = Vec::with_capacity(24 + provenance.len() + RECORD * set.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSIONS[usize::from(!is_still)].to_le_bytes());
    bytes.extend_from_slice(&(provenance.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&provenance);
    bytes.extend_from_slice(&(set.len() as u64).to_le_bytes());
    for l in set.lights() {
        bytes.extend_from_slice(&record(l));
    }
    write_file(path, &bytes)
}

/// Reads a VPL set.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Invalid`] if it is not a VPL set, has another
/// version, is truncated, or holds numbers that no VPL has.
pub fn load_vpls(path: &Path) -> Result<VplSet> {
    let io = |e| Error::io(path, e);
    let file = File::open(path).map_err(io)?;
    let length = file.metadata().map_err(io)?.len();
    let mut input = BufReader::new(file);
    let at = || Location::file(path);
    let mut head = [0; 16];
    let cut = |what: &str| {
        let what = what.to_owned();
        move |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::UnexpectedEof => Error::invalid(
                at(),
                format!("a truncated file: the file ends in its {what}"),
                "a whole VPL file",
            ),
            _ => Error::io(path, e),
        }
    };
    input.read_exact(&mut head).map_err(cut("header"))?;
    if head[..8] != MAGIC[..] {
        return Err(Error::invalid(at(), "other content", "a VPL file, which begins with TASHIKAV"));
    }
    let word = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
    let (version, provenance_length) = (word(8), word(12));
    if !VERSIONS.contains(&version) {
        let [still, moving] = VERSIONS;
        let expected = format!("version {still} or {moving}");
        return Err(Error::invalid(at(), format!("version {version}"), expected));
    }
    if provenance_length > MAX_PROVENANCE {
        return Err(Error::invalid(
            at(),
            format!("a provenance of {provenance_length} bytes"),
            format!("at most {MAX_PROVENANCE}"),
        ));
    }
    let mut provenance = vec![0; provenance_length as usize];
    input.read_exact(&mut provenance).map_err(cut("provenance"))?;
    let Head { provenance, instants } = serde_json::from_slice(&provenance).map_err(|e| {
        Error::invalid(at(), format!("a provenance that is not understood ({e})"), "that of a VPL file")
    })?;
    if !(provenance.clamp_distance >= 0.0 && provenance.clamp_distance.is_finite()) {
        return Err(Error::invalid(
            at(),
            format!("clamp distance = {}", provenance.clamp_distance),
            "0 or more metres",
        ));
    }
    let mut count = [0; 8];
    input.read_exact(&mut count).map_err(cut("number of VPLs"))?;
    let count = u64::from_le_bytes(count);
    let expected = u128::from(count) * RECORD as u128 + 24 + u128::from(provenance_length);
    if expected != u128::from(length) {
        return Err(Error::invalid(
            at(),
            format!("{length} bytes for {count} VPLs"),
            format!("{expected} bytes"),
        ));
    }
    let mut lights = Vec::with_capacity(count as usize);
    let mut bytes = [0; RECORD];
    for i in 0..count {
        input.read_exact(&mut bytes).map_err(cut("VPLs"))?;
        lights.push(light(&bytes).ok_or_else(|| {
            Error::invalid(
                at().item(format!("VPL {i}")),
                "a position, direction, intensity or kind that no VPL has",
                "finite numbers, unit directions, intensities of at least 0, kinds 0 to 8",
            )
        })?);
    }
    if version == VERSIONS[0] {
        return Ok(VplSet::new(lights, provenance));
    }
    let (shares, counts): (Vec<f32>, Vec<u64>) = instants.into_iter().unzip();
    let at_instants = |instants| VplSet::at_instants(lights, instants, &counts, provenance);
    Instants::new(shares).and_then(at_instants).ok_or_else(|| {
        let expected = format!(
            "1 to {} shares of the time in ascending order, whose numbers of VPLs add up to {count}",
            Instants::MOST
        );
        Error::invalid(at(), "other instants", expected)
    })
}

const SPOT_SHAPES: [FalloffShape; 4] =
    [FalloffShape::Squared, FalloffShape::Smoothstep, FalloffShape::LinearInAngle, FalloffShape::Fourth];

/// Kind of the record of a spot light.
fn spot_code(shape: FalloffShape) -> u32 {
    match shape {
        FalloffShape::Squared => 2,
        FalloffShape::Smoothstep => 4,
        FalloffShape::LinearInAngle => 5,
        FalloffShape::Fourth => 7,
    }
}

fn record(l: &Vpl) -> [u8; RECORD] {
    let (kind, inner, outer) = match l.kind {
        VplKind::Omni => (0u32, 0.0, 0.0),
        VplKind::Oriented => (1, 0.0, 0.0),
        VplKind::Spot(f) => (spot_code(f.shape), f.cos_inner, f.cos_outer),
        // The index of the map is an integer; its bits are stored unchanged.
        VplKind::Image(beam) => (6, f32::from_bits(beam.map), beam.cos_outer),
        VplKind::Directional => (3, 0.0f32, 0.0f32),
        VplKind::Volume(phase) => (8, phase.asymmetry, 0.0),
    };
    let mut bytes = [0; RECORD];
    let numbers =
        l.position.to_array().into_iter().chain(l.direction.to_array()).chain(l.intensity.to_array());
    for (slot, v) in bytes.chunks_exact_mut(4).zip(numbers) {
        slot.copy_from_slice(&v.to_le_bytes());
    }
    bytes[36..40].copy_from_slice(&kind.to_le_bytes());
    bytes[40..44].copy_from_slice(&inner.to_le_bytes());
    bytes[44..48].copy_from_slice(&outer.to_le_bytes());
    bytes
}

/// Reads the VPL of a record; `None` if its values are not those of a valid VPL.
fn light(bytes: &[u8; RECORD]) -> Option<Vpl> {
    let word = |i: usize| [bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]];
    let number = |i: usize| f32::from_le_bytes(word(i));
    let vector = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
    let (position, direction) = (vector(0), vector(3));
    let intensity = Rgb::new(number(6), number(7), number(8));
    let kind = match u32::from_le_bytes(word(9)) {
        0 => VplKind::Omni,
        1 => VplKind::Oriented,
        3 => VplKind::Directional,
        6 => VplKind::Image(Beam { map: u32::from_le_bytes(word(10)), cos_outer: number(11) }),
        8 => VplKind::Volume(HenyeyGreenstein { asymmetry: number(10) }),
        code => {
            let shape = SPOT_SHAPES.into_iter().find(|&shape| spot_code(shape) == code)?;
            VplKind::Spot(Falloff { cos_inner: number(10), cos_outer: number(11), shape })
        }
    };
    let light = Vpl { position, direction, intensity, kind };
    light.is_sound().then_some(light)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set() -> VplSet {
        let light = |kind, direction| Vpl {
            position: Vec3::new(1.0, -2.0, 3.5),
            direction,
            intensity: Rgb::new(0.1, 2.0, 30.0),
            kind,
        };
        let lights = vec![
            light(VplKind::Omni, Vec3::ZERO),
            light(VplKind::Oriented, Vec3::Y),
            light(
                VplKind::Spot(Falloff { cos_inner: 0.9, cos_outer: 0.5, shape: FalloffShape::Squared }),
                Vec3::NEG_Z,
            ),
            light(VplKind::Directional, Vec3::X),
            light(VplKind::Volume(HenyeyGreenstein { asymmetry: -0.25 }), Vec3::Z),
        ];
        VplSet::new(
            lights,
            Provenance { scene: "s".into(), seed: 7, clamp_distance: 0.25, ..Provenance::default() },
        )
    }

    /// The lights of `set`, divided among three instants; the second instant has none.
    fn moving() -> VplSet {
        let (lights, provenance) = (set().lights().to_vec(), set().provenance().clone());
        let instants = Instants::new(vec![0.1, 0.5, 0.75]).unwrap();
        VplSet::at_instants(lights, instants, &[2, 0, 3], provenance).unwrap()
    }

    #[test]
    fn sets_come_back_bit_by_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vpl");
        for (set, version) in [(set(), 1), (moving(), 2)] {
            save_vpls(&path, &set).unwrap();
            assert_eq!(load_vpls(&path).unwrap(), set);
            assert_eq!(std::fs::read(&path).unwrap()[8], version);
        }
    }

    #[test]
    fn instants_that_cannot_be_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vpl");
        save_vpls(&path, &moving()).unwrap();
        let whole = String::from_utf8_lossy(&std::fs::read(&path).unwrap()[16..]).into_owned();
        let found = r#""instants":[[0.1,2],[0.5,0],[0.75,3]]"#;
        assert!(whole.contains(found), "{whole}");
        for wrong in [
            r#""instants":[[0.1,2],[0.5,1],[0.75,3]]"#,
            r#""instants":[[0.9,2],[0.5,0],[0.75,3]]"#,
            r#""instants":[[0.1,2],[0.5,0],[7.75,3]]"#,
            r#""instonts":[[0.1,2],[0.5,0],[0.75,3]]"#,
        ] {
            let bytes = std::fs::read(&path).unwrap();
            let at = bytes.windows(found.len()).position(|window| window == found.as_bytes()).unwrap();
            let damaged = dir.path().join("b.vpl");
            let mut changed = bytes.clone();
            changed[at..at + wrong.len()].copy_from_slice(wrong.as_bytes());
            std::fs::write(&damaged, changed).unwrap();
            let message = load_vpls(&damaged).unwrap_err().to_string();
            assert!(message.contains("other instants") && message.contains("add up to 5"), "{message}");
        }
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vpl");
        save_vpls(&path, &set()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(load_vpls(&path).is_err(), "cut to {length} bytes");
        }
        for i in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[i] ^= 0xff;
            std::fs::write(&path, &bytes).unwrap();
            // Some bytes may hold any value, so a changed file may be valid. Loading must not panic
            // or return numbers that are not finite.
            if let Ok(set) = load_vpls(&path) {
                assert!(
                    set.lights().iter().all(|l| l.position.is_finite() && l.intensity.is_valid()),
                    "byte {i}"
                );
            }
        }
        let mut claims = whole.clone();
        let at = claims.len() - 5 * RECORD - 8;
        claims[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        std::fs::write(&path, &claims).unwrap();
        let message = load_vpls(&path).unwrap_err().to_string();
        assert!(message.contains("18446744073709551615 VPLs"), "{message}");
    }
}
