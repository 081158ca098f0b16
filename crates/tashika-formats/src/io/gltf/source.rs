//! The document with the bytes that it refers to, and memory budgets for the decoded data.
//!
//! Input: a parsed file. Output: byte slices within buffers, which lie within the bytes of the
//! files.
//!
//! # Guarantee
//! * A buffer is read when it is first needed, and once.
//! * Buffers, decoded geometry and decoded images each stay below [`LoadOptions::max_file_bytes`]
//!   in sum. A small file that names the same vertices or the same image a million times thus
//!   cannot fill the memory, while data that may be read as one file always fit.
//!
//! # Held to this by
//! `damaged_gltf::counts_beyond_the_bytes_present_are_refused`,
//! `damaged_gltf::naming_the_same_vertices_many_times_does_not_fill_the_memory`.

use std::borrow::Cow;
use std::cell::OnceCell;

use glam::DVec3;
use gltf::json::{self, Root};

use super::container::{Parsed, WidePlace};
use super::extensions::refuse_compressed;
use super::uri;
use crate::error::{Error, Location, Result};
use crate::io::limits::Budget;
use crate::io::{LoadOptions, SceneFiles};

/// A document and its bytes.
pub(super) struct Source<'a> {
    /// The document; its indices are in range.
    pub root: Root,
    /// Positions of nodes in double precision; empty if no node is far from its parent.
    places: Vec<WidePlace>,
    pub files: &'a SceneFiles,
    binary: Option<&'a [u8]>,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    buffer_budget: Budget,
    /// Budget of vertices, triangles and instances (bytes).
    pub geometry_budget: Budget,
    /// Budget of texels (bytes).
    pub image_budget: Budget,
}

impl<'a> Source<'a> {
    /// A document whose files have not been read yet.
    pub fn new(files: &'a SceneFiles, parsed: Parsed<'a>) -> Self {
        let LoadOptions { max_file_bytes: limit, .. } = *files.options();
        Self {
            buffers: parsed.root.buffers.iter().map(|_| OnceCell::new()).collect(),
            root: parsed.root,
            places: parsed.places,
            files,
            binary: parsed.binary,
            buffer_budget: Budget::new(limit, "buffers"),
            geometry_budget: Budget::new(limit, "geometry"),
            image_budget: Budget::new(limit, "images"),
        }
    }

    /// Options with which the scene is loaded.
    pub fn options(&self) -> &LoadOptions {
        self.files.options()
    }

    /// Returns the position of a node in its parent (m), from its translation and from its matrix.
    pub fn translations(&self, node: usize) -> [Option<DVec3>; 2] {
        let wide = self.places.get(node);
        let of_node = &self.root.nodes[node];
        let own = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let of_matrix = |m: [f32; 16]| own([m[12], m[13], m[14]]);
        [
            wide.and_then(|wide| wide.translation).map(DVec3::from).or(of_node.translation.map(own)),
            wide.and_then(|wide| wide.matrix)
                .map(|m| DVec3::new(m[12], m[13], m[14]))
                .or(of_node.matrix.map(of_matrix)),
        ]
    }

    /// Location of an item in the file.
    pub fn at(&self, item: impl Into<String>) -> Location {
        Location::file(self.files.path()).item(item)
    }

    /// Bytes of a buffer view, and its stride (bytes), if one is given.
    pub fn view(&self, index: json::Index<json::buffer::View>) -> Result<(&[u8], Option<usize>)> {
        let view = &self.root.buffer_views[index.value()];
        let buffer = &self.root.buffers[view.buffer.value()];
        if let Some(extensions) = &view.extensions
            && buffer.uri.is_none()
            && (self.binary.is_none() || view.buffer.value() > 0)
        {
            refuse_compressed(&extensions.others, &self.at(format!("bufferViews[{index}].extensions")))?;
        }
        let buffer = self.buffer(view.buffer.value())?;
        let offset = view.byte_offset.unwrap_or_default().0;
        let end = offset.checked_add(view.byte_length.0).filter(|&end| end <= buffer.len() as u64);
        let Some(end) = end else {
            return Err(Error::invalid(
                self.at(format!("bufferViews[{index}]")),
                format!("{} bytes from byte {offset}", view.byte_length.0),
                format!("them to fit into the {} bytes of buffers[{}]", buffer.len(), view.buffer),
            ));
        };
        // Both fit into `usize` because the buffer's length does.
        Ok((&buffer[offset as usize..end as usize], view.byte_stride.map(|s| s.0)))
    }

    /// Bytes of the file or the `data:` URI `uri`, which stands at `at`.
    pub fn file(&self, uri: &str, at: &Location) -> Result<Cow<'_, [u8]>> {
        uri::fetch(self.files, uri, at).map(Cow::Owned)
    }

    /// The bytes of an image file.
    pub fn image(&self, index: usize) -> Result<Cow<'_, [u8]>> {
        let image = &self.root.images[index];
        match (&image.uri, image.buffer_view) {
            (_, Some(view)) => Ok(Cow::Borrowed(self.view(view)?.0)),
            (Some(uri), None) => {
                Ok(Cow::Owned(uri::fetch(self.files, uri, &self.at(format!("images[{index}]")))?))
            }
            (None, None) => {
                let at = self.at(format!("images[{index}]"));
                Err(Error::invalid(at, "neither uri nor bufferView", "one of them"))
            }
        }
    }

    fn buffer(&self, index: usize) -> Result<&[u8]> {
        let cell = &self.buffers[index];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.load_buffer(index)?;
        Ok(cell.get_or_init(|| bytes))
    }

    fn load_buffer(&self, index: usize) -> Result<Cow<'a, [u8]>> {
        let buffer = &self.root.buffers[index];
        let at = self.at(format!("buffers[{index}]"));
        let mut bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => {
                let bytes = uri::fetch(self.files, uri, &at)?;
                self.buffer_budget.take(bytes.len() as u64, &at)?;
                Cow::Owned(bytes)
            }
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                return Err(Error::invalid(
                    at,
                    "no uri",
                    "a uri, or to be the first buffer of a .glb with a BIN chunk",
                ));
            }
        };
        let Some(length) = usize::try_from(buffer.byte_length.0).ok().filter(|&n| n <= bytes.len()) else {
            let found = format!("byteLength = {}", buffer.byte_length.0);
            return Err(Error::invalid(
                at,
                found,
                format!("at most {}, the bytes that are there", bytes.len()),
            ));
        };
        match &mut bytes {
            Cow::Borrowed(slice) => *slice = &slice[..length],
            Cow::Owned(vector) => vector.truncate(length),
        }
        Ok(bytes)
    }
}
