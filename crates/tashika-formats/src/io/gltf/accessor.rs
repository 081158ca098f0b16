//! Reading accessors: typed, strided, possibly sparse arrays of numbers in buffer views.
//!
//! Element `i` of an accessor starts at byte `offset + i · stride` of its view (glTF 2.0 section
//! 3.6.2). Normalized integers stand for fractions: `c / (2ᵇ − 1)` if unsigned,
//! `max(c / (2ᵇ⁻¹ − 1), −1)` if signed (section 3.11). A sparse accessor replaces some elements by
//! others. If it has no view, all other elements are zero.
//!
//! # Guarantee
//! No byte outside the view is read, and nothing is allocated for elements whose bytes are missing.
//! The elements of an accessor without a view are zero and take no bytes in the file. Their number
//! is limited to [`MAX_ZERO_ELEMENTS`], or in morph targets to the number of vertices.
//!
//! # Held to this by
//! The tests below; `gltf::strided_normalized_and_sparse_accessors`,
//! `damaged_gltf::counts_beyond_the_bytes_present_are_refused`.

use std::ops::Range;

use gltf::json;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::source::Source;
use crate::error::{Error, Location, Result};

/// Largest number of elements of an accessor without a buffer view; chosen. Exporters write such
/// accessors for morph targets and masks, which are far smaller. The zeros take less than a
/// megabyte.
const MAX_ZERO_ELEMENTS: u64 = 1 << 16;

/// An accessor whose bytes were found to lie in the file.
pub(super) struct Accessor<'s> {
    count: usize,
    component: ComponentType,
    normalized: bool,
    /// None if all elements are zero.
    elements: Option<Strided<'s>>,
    sparse: Option<Sparse<'s>>,
    at: Location,
}

/// Replaced elements.
struct Sparse<'s> {
    count: usize,
    index_type: ComponentType,
    indices: Strided<'s>,
    values: Strided<'s>,
}

/// Equally spaced elements of equal size.
struct Strided<'s> {
    bytes: &'s [u8],
    stride: usize,
    size: usize,
}

impl<'s> Strided<'s> {
    /// `count` elements of `size` bytes from byte `offset` of a view; `what` is for messages.
    fn new(
        view: (&'s [u8], Option<usize>),
        offset: u64,
        count: u64,
        size: usize,
        what: &str,
        at: &Location,
    ) -> Result<Self> {
        let (bytes, stride) = view;
        let stride = stride.unwrap_or(size);
        let length = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride as u64).and_then(|start| start.checked_add(size as u64)),
            None => Some(0),
        };
        let end = length.and_then(|length| offset.checked_add(length));
        if stride < size || end.is_none_or(|end| end > bytes.len() as u64) {
            return Err(Error::invalid(
                at.clone(),
                format!(
                    "{what}: {count} elements of {size} bytes, each {stride} after the last, from byte {offset}"
                ),
                format!("them not to overlap and to fit into the {} bytes of their buffer view", bytes.len()),
            ));
        }
        // In range because the end is.
        Ok(Self { bytes: &bytes[offset as usize..], stride, size })
    }

    fn element(&self, i: usize) -> &'s [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

impl Source<'_> {
    /// Returns the accessor, which must have elements of type `expected`. `at` is the place in the
    /// file that refers to it.
    pub fn accessor(
        &self,
        index: json::Index<json::Accessor>,
        expected: Type,
        at: Location,
    ) -> Result<Accessor<'_>> {
        self.accessor_beside(index, expected, 0, at)
    }

    /// Like [`Self::accessor`], for an accessor that accompanies another one with `beside`
    /// elements. This number of elements is allowed even without bytes.
    pub fn accessor_beside(
        &self,
        index: json::Index<json::Accessor>,
        expected: Type,
        beside: usize,
        at: Location,
    ) -> Result<Accessor<'_>> {
        let accessor = &self.root.accessors[index.value()];
        let (Checked::Valid(component), Checked::Valid(found)) = (accessor.component_type, accessor.type_)
        else {
            return Err(Error::invalid(
                at,
                format!("accessors[{index}] of unknown type"),
                format!("{expected:?}"),
            ));
        };
        let component = component.0;
        if found != expected {
            let found = format!("accessors[{index}] of type {found:?}");
            return Err(Error::invalid(at, found, format!("{expected:?}")));
        }
        let size = component.size() * expected.multiplicity();
        let count = accessor.count.0;
        let what = format!("accessors[{index}]");
        let elements = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(Strided::new(self.view(view)?, offset, count, size, &what, &at)?)
            }
            None if count > MAX_ZERO_ELEMENTS.max(beside as u64) => {
                let found = format!("{what}: {count} elements without a buffer view");
                let most = MAX_ZERO_ELEMENTS.max(beside as u64);
                return Err(Error::invalid(at, found, format!("at most {most}")));
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, size, &what, &at)?),
            None => None,
        };
        let Ok(count) = usize::try_from(count) else {
            return Err(Error::invalid(
                at,
                format!("{what}: {count} elements"),
                "as many as fit into memory",
            ));
        };
        Ok(Accessor { count, component, normalized: accessor.normalized, elements, sparse, at })
    }

    fn sparse(
        &self,
        sparse: &json::accessor::sparse::Sparse,
        size: usize,
        what: &str,
        at: &Location,
    ) -> Result<Sparse<'_>> {
        let json::accessor::sparse::Sparse { count, indices, values, .. } = sparse;
        let Checked::Valid(index_type) = indices.component_type else {
            return Err(Error::invalid(
                at.clone(),
                format!("{what}.sparse.indices of unknown type"),
                "U8, U16 or U32",
            ));
        };
        let index_type = index_type.0;
        // The specification packs both tightly, whatever strides the views have.
        let packed = |view| self.view(view).map(|(bytes, _)| (bytes, None));
        let (index_view, value_view) = (packed(indices.buffer_view)?, packed(values.buffer_view)?);
        let names = [format!("{what}.sparse.indices"), format!("{what}.sparse.values")];
        Ok(Sparse {
            index_type,
            indices: Strided::new(
                index_view,
                indices.byte_offset.0,
                count.0,
                index_type.size(),
                &names[0],
                at,
            )?,
            values: Strided::new(value_view, values.byte_offset.0, count.0, size, &names[1], at)?,
            // Fits into `usize`, because the indices alone occupy at least this number of bytes.
            count: count.0 as usize,
        })
    }
}

impl Accessor<'_> {
    /// Number of elements.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Refuses a number of elements other than `count`.
    pub fn expect_count(self, count: usize) -> Result<Self> {
        if self.count == count {
            return Ok(self);
        }
        Err(Error::invalid(
            self.at,
            format!("{} elements", self.count),
            format!("{count}, one for each POSITION"),
        ))
    }

    /// Vectors of `range`, which must lie below [`Self::count`]; `N` must match the expected type.
    pub fn vectors<const N: usize>(&self, range: Range<usize>) -> Result<Vec<[f32; N]>> {
        let size = self.component.size();
        self.read(range, [0.0; N], |bytes| {
            std::array::from_fn(|c| number(self.component, self.normalized, &bytes[c * size..][..size]))
        })
    }

    /// Elements of `range`; elements without bytes are `zero`.
    fn read<T: Clone>(&self, range: Range<usize>, zero: T, element: impl Fn(&[u8]) -> T) -> Result<Vec<T>> {
        let mut all = match &self.elements {
            Some(elements) => range.clone().map(|i| element(elements.element(i))).collect(),
            None => vec![zero; range.len()],
        };
        self.replace_sparse(|i, bytes| {
            if range.contains(&i) {
                all[i - range.start] = element(bytes);
            }
        })?;
        Ok(all)
    }

    /// Elements as indices, which must be unsigned integers.
    pub fn indices(&self) -> Result<Vec<u32>> {
        self.expect_unsigned()?;
        self.read(0..self.count, 0, unsigned)
    }

    /// Vectors of indices of `range`, under the conditions of [`vectors`](Self::vectors).
    pub fn index_vectors<const N: usize>(&self, range: Range<usize>) -> Result<Vec<[u32; N]>> {
        self.expect_unsigned()?;
        let size = self.component.size();
        self.read(range, [0; N], |bytes| std::array::from_fn(|c| unsigned(&bytes[c * size..][..size])))
    }

    fn expect_unsigned(&self) -> Result<()> {
        if matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Ok(());
        }
        let found = format!("indices of type {:?}", self.component);
        Err(Error::invalid(self.at.clone(), found, "U8, U16 or U32"))
    }

    /// Calls `replace` with the index and the new bytes of each replaced element. The index is in
    /// range.
    fn replace_sparse(&self, mut replace: impl FnMut(usize, &[u8])) -> Result<()> {
        let Some(sparse) = &self.sparse else { return Ok(()) };
        for k in 0..sparse.count {
            let i = unsigned(sparse.indices.element(k)) as usize;
            if i >= self.count {
                let found = format!("sparse index {i} of type {:?}", sparse.index_type);
                return Err(Error::invalid(self.at.clone(), found, format!("an index below {}", self.count)));
            }
            replace(i, sparse.values.element(k));
        }
        Ok(())
    }
}

/// A little-endian unsigned integer of at most four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// Value of one component; `bytes` has the component's size.
fn number(component: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    let bits = unsigned(bytes);
    // The integer, and the largest value of its type.
    let (value, largest) = match component {
        ComponentType::I8 => (f32::from(bits as u8 as i8), 127.0),
        ComponentType::U8 => (bits as f32, 255.0),
        ComponentType::I16 => (f32::from(bits as u16 as i16), 32767.0),
        ComponentType::U16 => (bits as f32, 65535.0),
        ComponentType::U32 => (bits as f32, u32::MAX as f32),
        ComponentType::F32 => return f32::from_bits(bits),
    };
    // The most negative signed integer would give a value below −1.
    if normalized { (value / largest).max(-1.0) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_component_type() {
        use ComponentType::{F32, I8, I16, U8, U16, U32};
        let cases: [(ComponentType, &[u8], f32, f32); 9] = [
            (I8, &[0x81], -127.0, -1.0),
            (I8, &[0x80], -128.0, -1.0),
            (I8, &[0x7f], 127.0, 1.0),
            (U8, &[0x33], 51.0, 0.2),
            (I16, &[0x01, 0x80], -32767.0, -1.0),
            (I16, &[0xff, 0x7f], 32767.0, 1.0),
            (U16, &[0x33, 0x33], 13107.0, 0.2),
            (U32, &[0, 0, 1, 0], 65536.0, 65536.0 / 4294967296.0),
            (F32, &[0, 0, 0xc0, 0x3f], 1.5, 1.5),
        ];
        for (component, bytes, plain, normalized) in cases {
            assert_eq!(number(component, false, bytes), plain, "{component:?}");
            assert_eq!(number(component, true, bytes), normalized, "{component:?}");
        }
    }

    #[test]
    fn strided_elements_fit_exactly_or_are_refused() {
        let bytes = [0_u8; 28];
        let at = Location::default();
        let new = |stride, offset, count, size| Strided::new((&bytes, stride), offset, count, size, "a", &at);
        assert!(new(None, 4, 2, 12).is_ok());
        assert!(new(None, 5, 2, 12).is_err(), "one byte too many");
        assert!(new(Some(16), 0, 2, 12).is_ok(), "the last element needs no stride");
        assert!(new(Some(16), 1, 2, 12).is_err());
        assert!(new(Some(8), 0, 2, 12).is_err(), "overlap");
        assert!(new(None, 28, 0, 12).is_ok());
        for (offset, count) in
            [(0, u64::MAX), (u64::MAX, 1), (u64::MAX, u64::MAX), (29, 0), (0, 4_000_000_000)]
        {
            assert!(new(None, offset, count, 12).is_err(), "{count} from {offset}");
        }
        assert_eq!(new(Some(16), 0, 2, 12).map(|s| s.element(1).len()).unwrap_or_default(), 12);
    }
}
