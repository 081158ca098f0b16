//! Mitsuba's own mesh files, `.serialized`, of versions 3 and 4.
//!
//! ```text
//! file   = mesh … mesh, offset of each mesh (4 bytes in version 3, else 8), number of meshes (4 bytes)
//! mesh   = 0x041c, version (2 bytes each), zlib stream of
//!          flags (4 bytes), name (version 4: UTF-8, ended by NUL), vertices, triangles (8 bytes each),
//!          positions, normals (flag 1), texture coordinates (flag 2), colours (flag 8), indices (4 bytes)
//! ```
//!
//! All little endian; numbers are `f32`, or `f64` with flag `0x2000`. Flag `0x10` means flat faces.
//!
//! # Guarantee
//! No more bytes are decompressed than the counts need. Counts are refused if the stream is too
//! short for them, or if they need more than [`MAX_BYTES`]; memory grows only with the bytes of the
//! file.
//!
//! Source: [^mitsuba06], plugin `serialized`. Held to this by the tests below and
//! `suite::damaged_mitsuba`.

use std::io::Read;

use flate2::bufread::ZlibDecoder;
use glam::{DVec3, Vec2, Vec3};

use crate::error::{Error, Location, Result};
use crate::scene::MeshData;

const MAGIC: u16 = 0x041c;
const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE: u32 = 0x2000;

/// Most bytes of one mesh.
const MAX_BYTES: u64 = 1 << 33;
/// Largest compression ratio of a deflate stream: 258 bytes from two bits.
const MAX_RATIO: u64 = 1032;
/// Longest name of a mesh (bytes).
const MAX_NAME: usize = 4096;

/// A mesh and its flag of flat faces.
#[derive(Debug)]
pub(super) struct SerializedMesh {
    pub(super) data: MeshData,
    /// True if its faces are flat.
    pub(super) face_normals: bool,
}

/// Reads the mesh of index `shape_index`, from 0.
///
/// # Errors
/// [`Error::Invalid`] if the file is of another format, has no such mesh, or ends too early.
pub(super) fn read(bytes: &[u8], shape_index: i64, at: &Location) -> Result<SerializedMesh> {
    let invalid = |found: String, expected: &str| Error::invalid(at.clone(), found, expected);
    let version = header(bytes, at)?;
    let start = offset(bytes, shape_index, version, at)?;
    let mesh = bytes.get(start..).unwrap_or_default();
    let version = header(mesh, at)?;
    let stream = &mesh[4..];
    let mut numbers = Numbers { decoder: ZlibDecoder::new(stream), double: false, at };
    let flags = u32::from_le_bytes(numbers.array()?);
    numbers.double = flags & DOUBLE != 0;
    let mut data =
        MeshData { name: if version >= 4 { numbers.name()? } else { String::new() }, ..MeshData::default() };
    let vertices = u64::from_le_bytes(numbers.array()?);
    let triangles = u64::from_le_bytes(numbers.array()?);
    let has = |flag: u32| u64::from(flags & flag != 0);
    let number_bytes = if numbers.double { 8 } else { 4 };
    let numbers_per_vertex = 3 + 3 * has(HAS_NORMALS) + 2 * has(HAS_UVS) + 3 * has(HAS_COLORS);
    let needed = (vertices.checked_mul(numbers_per_vertex * number_bytes))
        .zip(triangles.checked_mul(12))
        .and_then(|(v, t)| v.checked_add(t))
        .filter(|&n| {
            n <= MAX_BYTES && n / MAX_RATIO <= stream.len() as u64 && vertices <= u64::from(u32::MAX)
        });
    if needed.is_none() {
        let found = format!("{vertices} vertices and {triangles} triangles in {} bytes", stream.len());
        return Err(invalid(found, "counts that the data can hold"));
    }
    if numbers.double {
        data.place(&numbers.places(vertices)?);
    } else {
        data.positions = numbers.vectors(vertices)?;
    }
    if flags & HAS_NORMALS != 0 {
        data.normals = numbers.vectors(vertices)?;
    }
    if flags & HAS_UVS != 0 {
        let flat = numbers.list(vertices * 2)?;
        data.uvs = flat.as_chunks::<2>().0.iter().map(|&uv| Vec2::from_array(uv)).collect();
    }
    if flags & HAS_COLORS != 0 {
        numbers.list(vertices * 3)?;
    }
    let indices = numbers.bytes(triangles * 12)?;
    let index = |b: [u8; 4]| u32::from_le_bytes(b);
    let flat: Vec<u32> = indices.as_chunks::<4>().0.iter().map(|&b| index(b)).collect();
    if let Some(i) = flat.iter().find(|&&i| u64::from(i) >= vertices) {
        return Err(invalid(format!("vertex index {i}"), &format!("an index below {vertices}")));
    }
    data.triangles = flat.as_chunks::<3>().0.to_vec();
    Ok(SerializedMesh { data, face_normals: flags & FACE_NORMALS != 0 })
}

/// Reads the version after the magic number.
fn header(bytes: &[u8], at: &Location) -> Result<u16> {
    let invalid = |found: String, expected: &str| Error::invalid(at.clone(), found, expected);
    let &[a, b, c, d, ..] = bytes else {
        return Err(invalid(format!("a file of {} bytes", bytes.len()), "a serialized mesh"));
    };
    if u16::from_le_bytes([a, b]) != MAGIC {
        return Err(invalid(format!("a file that begins with {a:02x} {b:02x}"), "a serialized mesh: 1c 04"));
    }
    match u16::from_le_bytes([c, d]) {
        version @ 3..=4 => Ok(version),
        other => Err(invalid(format!("a serialized mesh of version {other}"), "version 3 or 4")),
    }
}

/// Offset of a mesh (bytes), by the table at the end of the file.
fn offset(bytes: &[u8], shape_index: i64, version: u16, at: &Location) -> Result<usize> {
    let invalid = |found: String, expected: &str| Error::invalid(at.clone(), found, expected);
    if shape_index == 0 {
        // The file begins with the first mesh, whose header is also the file's.
        return Ok(0);
    }
    let (table, count) = bytes.split_last_chunk::<4>().unwrap_or((&[], &[0; 4]));
    let count = u64::from(u32::from_le_bytes(*count));
    let index = u64::try_from(shape_index).ok().filter(|&i| i < count);
    let Some(index) = index else {
        return Err(invalid(
            format!("shape_index = {shape_index}"),
            &format!("a number from 0 to below {count}"),
        ));
    };
    let width: usize = if version == 3 { 4 } else { 8 };
    // Entries are counted from the end of the file, where the table is; counts and widths are
    // small.
    let from_end = (count - index) as usize;
    let entry = from_end.checked_mul(width).and_then(|back| table.len().checked_sub(back));
    let entry = entry.and_then(|start| table.get(start..start + width));
    let Some(entry) = entry else {
        return Err(invalid(format!("a table of {count} meshes in {} bytes", bytes.len()), "a longer file"));
    };
    let value = entry.iter().rev().fold(0_u64, |value, &byte| value << 8 | u64::from(byte));
    usize::try_from(value).ok().filter(|&start| start < bytes.len()).ok_or_else(|| {
        invalid(format!("mesh {index} at byte {value}"), &format!("a place below {}", bytes.len()))
    })
}

/// Reader of the decompressed stream.
struct Numbers<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    double: bool,
    at: &'a Location,
}

impl Numbers<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.decoder.read_exact(&mut bytes).map_err(|e| self.ended(&e.to_string()))?;
        Ok(bytes)
    }

    fn name(&mut self) -> Result<String> {
        let mut name = Vec::new();
        loop {
            match self.array::<1>()? {
                [0] => return Ok(String::from_utf8_lossy(&name).into_owned()),
                [byte] => name.push(byte),
            }
            if name.len() > MAX_NAME {
                let found = format!("a name of more than {MAX_NAME} bytes");
                return Err(Error::invalid(self.at.clone(), found, "a shorter one"));
            }
        }
    }

    fn bytes(&mut self, count: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        (&mut self.decoder).take(count).read_to_end(&mut bytes).map_err(|e| self.ended(&e.to_string()))?;
        if bytes.len() as u64 == count { Ok(bytes) } else { Err(self.ended("the data end too early")) }
    }

    fn list(&mut self, count: u64) -> Result<Vec<f32>> {
        if self.double {
            let bytes = self.bytes(count * 8)?;
            return Ok(bytes.as_chunks::<8>().0.iter().map(|&b| f64::from_le_bytes(b) as f32).collect());
        }
        let bytes = self.bytes(count * 4)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|&b| f32::from_le_bytes(b)).collect())
    }

    /// Reads vectors of double precision.
    fn places(&mut self, count: u64) -> Result<Vec<DVec3>> {
        let bytes = self.bytes(count * 24)?;
        let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|&b| f64::from_le_bytes(b)).collect();
        Ok(numbers.as_chunks::<3>().0.iter().map(|&v| DVec3::from_array(v)).collect())
    }

    fn vectors(&mut self, count: u64) -> Result<Vec<Vec3>> {
        let flat = self.list(count * 3)?;
        Ok(flat.as_chunks::<3>().0.iter().map(|&v| Vec3::from_array(v)).collect())
    }

    fn ended(&self, why: &str) -> Error {
        Error::invalid(
            self.at.clone(),
            format!("a serialized mesh that cannot be read ({why})"),
            "a whole zlib stream",
        )
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// One mesh: header and stream.
    fn mesh(version: u16, flags: u32, counts: [u64; 2], shift: f64) -> Vec<u8> {
        let mut raw = flags.to_le_bytes().to_vec();
        if version >= 4 {
            raw.extend_from_slice(b"name\0");
        }
        counts.iter().for_each(|c| raw.extend_from_slice(&c.to_le_bytes()));
        let mut vertex_numbers = 3;
        for (flag, numbers) in [(HAS_NORMALS, 3), (HAS_UVS, 2), (HAS_COLORS, 3)] {
            vertex_numbers += if flags & flag != 0 { numbers } else { 0 };
        }
        for i in 0..3 * vertex_numbers {
            let value = f64::from(i) + shift;
            if flags & DOUBLE != 0 {
                raw.extend_from_slice(&value.to_le_bytes());
            } else {
                raw.extend_from_slice(&(value as f32).to_le_bytes());
            }
        }
        [0_u32, 1, 2].iter().for_each(|i| raw.extend_from_slice(&i.to_le_bytes()));
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&raw).unwrap();
        let mut bytes = MAGIC.to_le_bytes().to_vec();
        bytes.extend_from_slice(&version.to_le_bytes());
        bytes.extend(encoder.finish().unwrap());
        bytes
    }

    fn file(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
        let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
        for mesh in meshes {
            offsets.push(bytes.len() as u64);
            bytes.extend_from_slice(mesh);
        }
        for offset in &offsets {
            let width = if version == 3 { 4 } else { 8 };
            bytes.extend_from_slice(&offset.to_le_bytes()[..width]);
        }
        bytes.extend_from_slice(&(meshes.len() as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn meshes_of_both_versions_and_precisions_are_read_by_their_number() {
        for (version, precision) in [(3, 0x1000), (4, 0x1000), (3, DOUBLE), (4, DOUBLE)] {
            let flags = precision | HAS_NORMALS | HAS_UVS | HAS_COLORS | FACE_NORMALS;
            let meshes = [mesh(version, precision, [3, 1], 0.0), mesh(version, flags, [3, 1], 100.0)];
            let bytes = file(version, &meshes);
            let at = Location::file("m.serialized");
            let first = read(&bytes, 0, &at).unwrap();
            assert_eq!(first.data.positions[1], Vec3::new(3.0, 4.0, 5.0));
            assert!(first.data.normals.is_empty() && !first.face_normals);
            let second = read(&bytes, 1, &at).unwrap();
            assert_eq!(second.data.positions[0].x, 100.0);
            assert_eq!(second.data.normals[0].x, 109.0);
            assert_eq!(second.data.uvs[2], Vec2::new(122.0, 123.0));
            assert_eq!(second.data.triangles, [[0, 1, 2]]);
            assert!(second.face_normals);
            assert_eq!(second.data.name, if version == 4 { "name" } else { "" });
            for wrong in [2, -1, i64::MAX] {
                assert!(read(&bytes, wrong, &at).unwrap_err().to_string().contains("shape_index"));
            }
        }
    }

    #[test]
    fn counts_that_cannot_be_there_are_refused() {
        let at = Location::file("m.serialized");
        for counts in [[u64::MAX, 1], [1 << 40, 1], [3, u64::MAX / 2], [1 << 22, 1], [3, 2], [4, 1]] {
            let bytes = file(4, &[mesh(4, 0x1000, counts, 0.0)]);
            let error = read(&bytes, 0, &at).unwrap_err().to_string();
            assert!(error.contains("counts") || error.contains("too early"), "{counts:?}: {error}");
        }
        let error = read(&file(4, &[mesh(4, 0x1000, [2, 1], 0.0)]), 0, &at).unwrap_err().to_string();
        assert!(error.contains("vertex index"), "{error}");
        assert!(read(b"", 0, &at).is_err() && read(b"\x1c\x04\x09\0", 0, &at).is_err());
        assert!(read(b"\x1c\x04\x04\0", 1, &at).is_err());
    }

    #[test]
    fn damaged_bytes_give_errors() {
        let whole = file(4, &[mesh(4, 0x1000, [3, 1], 0.0), mesh(4, DOUBLE, [3, 1], 0.0)]);
        let at = Location::file("m.serialized");
        for length in 0..whole.len() {
            assert!(read(&whole[..length], 1, &at).is_err(), "{length}");
        }
        for i in 0..whole.len() {
            for bit in 0..8 {
                let mut flipped = whole.clone();
                flipped[i] ^= 1 << bit;
                // A mesh or an error is fine; a panic or a hang is not.
                let _ = (read(&flipped, 0, &at), read(&flipped, 1, &at));
            }
        }
    }
}
