//! Meshes in every encoding, damaged ones, limits.

use std::io::Write;

use glam::{Vec2, Vec3};

use super::*;
use crate::scene::Note;

fn mesh_with_notes(bytes: &[u8]) -> (Result<MeshData>, Notes) {
    let mut notes = Notes::default();
    let mesh = read(bytes, &LoadOptions::default(), &mut notes, &Location::file("a.ply"));
    (mesh, notes)
}

fn mesh(bytes: &[u8]) -> Result<MeshData> {
    let (mesh, notes) = mesh_with_notes(bytes);
    assert!(mesh.is_err() || notes.is_empty());
    mesh
}

fn message(bytes: &[u8]) -> String {
    mesh(bytes).unwrap_err().to_string()
}

const TEXT: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n\
    property float y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\n\
    property uchar red\nproperty float s\nproperty float t\nelement face 2\n\
    property list uchar int vertex_indices\nproperty int group\nend_header\n\
    0 0 5 0 0 1 255 0 0.25\n1 0 5 0 0 1 255 1 0.25\n1 1 5 0 0 1 255 1 1\n0 1 5 0 0 1 0 0 1\n\
    3 0 1 2 7\n4 0 1 2 3 8\n";

/// The mesh of [`TEXT`] as bytes, with other types, an unknown element, and lists among the
/// vertices.
fn binary(big: bool) -> Vec<u8> {
    let name = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!(
        "ply\r\nformat {name} 1.0\r\nobj_info x\r\nelement face 2\r\nproperty list ushort ushort vertex_index\r\n\
        element strange 1\r\nproperty list char double unknown\r\nelement vertex 4\r\nproperty double x\r\n\
        property short y\r\nproperty list uint8 int32 extra\r\nproperty float z\r\nproperty float nx\r\n\
        property float ny\r\nproperty char nz\r\nproperty float u\r\nproperty float v\r\nend_header\r\n"
    )
    .into_bytes();
    let mut put = |number: &[u8]| {
        let mut little = number.to_vec();
        if big {
            little.reverse();
        }
        bytes.extend(little);
    };
    for index in [3_u16, 0, 1, 2, 4, 0, 1, 2, 3] {
        put(&index.to_le_bytes());
    }
    put(&[2]);
    put(&1.5_f64.to_le_bytes());
    put(&2.5_f64.to_le_bytes());
    for (i, [x, y]) in [[0, 0], [1, 0], [1, 1], [0, 1_i16]].into_iter().enumerate() {
        put(&f64::from(x).to_le_bytes());
        put(&y.to_le_bytes());
        put(&[i as u8]);
        (0..i).for_each(|_| put(&7_i32.to_le_bytes()));
        for value in [5.0_f32, 0.0, 0.0] {
            put(&value.to_le_bytes());
        }
        put(&[1]);
        put(&f32::from(x).to_le_bytes());
        put(&(if y == 0 { 0.25_f32 } else { 1.0 }).to_le_bytes());
    }
    bytes
}

fn check(mesh: &MeshData) {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(mesh.positions, corners.map(|[x, y]| Vec3::new(x, y, 5.0)));
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    assert_eq!(mesh.uvs, corners.map(|[x, y]| Vec2::new(x, if y == 0.0 { 0.25 } else { 1.0 })));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
}

#[test]
fn text_and_both_byte_orders_and_compression_give_the_same_mesh() {
    check(&mesh(TEXT.as_bytes()).unwrap());
    check(&mesh(TEXT.replace('\n', "\r\n").as_bytes()).unwrap());
    for big in [false, true] {
        check(&mesh(&binary(big)).unwrap());
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&binary(big)).unwrap();
        check(&mesh(&packed.finish().unwrap()).unwrap());
    }
}

#[test]
fn all_that_is_missing_or_wrong_is_told_with_its_place() {
    let but = |from: &str, to: &str| message(TEXT.replacen(from, to, 1).as_bytes());
    for (text, parts) in [
        (message(b""), &["a.ply: ", "expected a PLY mesh"][..]),
        (message(b"ply\nformat ascii 1.0\nelement"), &["a.ply:3: \"element\"", "expected format"]),
        (message(b"ply\nformat ascii 1.0\n"), &["a.ply:2: the end of the file"]),
        (but("ascii", "utf8"), &["a.ply:2", "utf8"]),
        (but("format ascii 1.0\n", ""), &["a.ply:16", "a line \"format\""]),
        (but("property float y\n", ""), &["a.ply: vertices without"]),
        (but("element vertex 4", "element corner 4"), &["without element \"vertex\""]),
        (but("element vertex 4", "element vertex four"), &["a.ply:4", "a number of rows"]),
        (but("element vertex 4", "element vertex -4"), &["a.ply:4", "a number of rows"]),
        (but("property list uchar", "property list"), &["a.ply:15", "list TYPE TYPE NAME"]),
        (but("vertex_indices", "corners"), &["without a list of vertices"]),
        (but("3 0 1 2 7", "3 0 one 2 7"), &["a.ply:22: face 0: \"one\"", "a number"]),
        (but("3 0 1 2 7", "3 0 1 4 7"), &["a.ply:22: face 0: vertex 4; expected an index from 0 to 3"]),
        (but("3 0 1 2 7", "3 0 1 -1 7"), &["a.ply:22: face 0: vertex -1; expected an index from 0 to 3"]),
        (but("3 0 1 2 7", "3 0 1 1.5 7"), &["vertex 1.5"]),
        (but("3 0 1 2 7", "-3 0 1 2 7"), &["list of length -3"]),
        (but("3 0 1 2 7\n4 0 1 2 3 8", "4000000000 0 1 2 3"), &["the end of the file"]),
        (but(" 3 8\n", ""), &["face 1: the end of the file"]),
    ] {
        for part in parts {
            assert!(text.contains(part), "{text:?} lacks {part:?}");
        }
    }
}

#[test]
fn what_is_cut_off_is_called_truncated() {
    for big in [false, true] {
        let whole = binary(big);
        let end = b"end_header\r\n";
        let body = whole.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        for length in body..whole.len() {
            let said = message(&whole[..length]);
            assert!(said.contains("truncated"), "{length} of {}: {said}", whole.len());
        }
    }
}

#[test]
fn counts_beyond_the_bytes_are_refused_before_memory_is_taken() {
    for count in ["5000000000", "18446744073709551615", "60"] {
        let text = TEXT.replace("vertex 4", &format!("vertex {count}"));
        assert!(message(text.as_bytes()).contains(&format!("{count} rows of element \"vertex\"")));
        let text = TEXT.replace("face 2", &format!("face {count}"));
        assert!(message(text.as_bytes()).contains(&format!("{count} rows of element \"face\"")));
    }
    let empty = "element nothing 18446744073709551615\nelement vertex";
    check(&mesh(TEXT.replacen("element vertex", empty, 1).as_bytes()).unwrap());
}

#[test]
fn every_truncation_and_every_changed_byte_is_survived() {
    for bytes in [TEXT.as_bytes().to_vec(), binary(false), binary(true)] {
        // Every cut must be noticed, except that the last byte of a text, a blank, may be missing.
        for length in 0..bytes.len() - 1 {
            assert!(mesh(&bytes[..length]).is_err(), "{length}");
        }
        for i in 0..bytes.len() {
            for change in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[i] ^= change;
                if let (Ok(mesh), _) = mesh_with_notes(&damaged) {
                    let count = mesh.positions.len() as u32;
                    assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
                    assert!([0, mesh.positions.len()].contains(&mesh.normals.len()));
                }
            }
        }
    }
}

#[test]
fn polygons_are_triangulated_and_odd_ones_noted() {
    let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nelement face 3\nproperty list int int vertex_index\nend_header\n";
    let rows = "0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n5 0 1 2 3 4\n2 0 1\n4 3 2 4 1\n";
    let (result, notes) = mesh_with_notes(format!("{header}{rows}").as_bytes());
    let mesh = result.unwrap();
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        0.5 * (b - a).cross(c - a).z
    };
    // The polygon is a square of area 16 with a dent: the triangle (4, 4), (2, 1), (0, 4) of area
    // 6.
    assert_eq!(mesh.triangles[..3].iter().map(area).sum::<f32>(), 16.0 - 6.0);
    let notes: Vec<String> = notes.iter().map(|n| n.message).collect();
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(notes[0].contains("fewer than three") && notes[1].contains("cross themselves"), "{notes:?}");
}

/// A file of points alone, as scanners write it, and a file with texture coordinates of corners, as
/// MeshLab writes it. Each must give one note.
#[test]
fn points_without_faces_and_coordinates_of_corners_are_noted() {
    let cloud = TEXT.split("element face").next().unwrap().to_owned() + "end_header\n0 0 5 0 0 1 255 0 0\n";
    let (result, notes) = mesh_with_notes(cloud.replace("vertex 4", "vertex 1").as_bytes());
    let mesh = result.unwrap();
    assert!(mesh.triangles.is_empty() && mesh.positions.is_empty());
    let said: Vec<Note> = notes.iter().collect();
    assert!(said.len() == 1 && said[0].message.contains("without faces"), "{said:?}");
    assert_eq!(said[0].kind, NoteKind::Ignored);
    let corners = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
        property list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n";
    let (result, notes) = mesh_with_notes(corners.as_bytes());
    assert_eq!(result.unwrap().triangles, [[0, 1, 2]]);
    let said: Vec<Note> = notes.iter().collect();
    assert!(said.len() == 1 && said[0].message.contains("corners of faces"), "{said:?}");
}

#[test]
fn compressed_files_do_not_unpack_without_limit() {
    let pack = |bytes: &[u8]| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    };
    let bomb = pack(&[b' '; 1 << 20]);
    assert!(message(&bomb).contains(&format!("more than {} bytes when unpacked", 256 * bomb.len())));
    let options = LoadOptions { max_file_bytes: 100, ..LoadOptions::default() };
    let error =
        read(&pack(TEXT.as_bytes()), &options, &mut Notes::default(), &Location::default()).unwrap_err();
    assert!(error.to_string().contains("more than 100 bytes when unpacked"), "{error}");
    let packed = pack(TEXT.as_bytes());
    assert!(message(&packed[..packed.len() - 9]).contains("truncated compression"));
}
