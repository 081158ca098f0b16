//! NumPy arrays in and out, by NumPy's own functions.
//!
//! Out: the samples are copied once, into an immutable bytes object that backs the array, so that
//! arrays are read-only and in row-major order. In: anything that NumPy converts to an array,
//! checked for its shape; `n` rows of `N` numbers.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::option;

/// A number as NumPy stores it.
pub trait Number: Copy {
    /// NumPy's name of the type.
    const TYPE: &'static str;
    /// Bytes of the number, in the order of this machine.
    fn bytes(self) -> impl AsRef<[u8]>;
}

impl Number for f32 {
    const TYPE: &'static str = "float32";
    fn bytes(self) -> impl AsRef<[u8]> {
        self.to_ne_bytes()
    }
}

impl Number for f64 {
    const TYPE: &'static str = "float64";
    fn bytes(self) -> impl AsRef<[u8]> {
        self.to_ne_bytes()
    }
}

impl Number for u32 {
    const TYPE: &'static str = "uint32";
    fn bytes(self) -> impl AsRef<[u8]> {
        self.to_ne_bytes()
    }
}

/// Array of the given shape, whose product is the number of samples.
pub fn array<'py, T: Number>(
    py: Python<'py>,
    samples: impl ExactSizeIterator<Item = T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    // `frombuffer` refuses an empty buffer.
    if samples.len() == 0 {
        return numpy.call_method1("zeros", (shape, T::TYPE));
    }
    let bytes = PyBytes::new_with(py, samples.len() * size_of::<T>(), |slots| {
        for (slot, sample) in slots.chunks_exact_mut(size_of::<T>()).zip(samples) {
            slot.copy_from_slice(sample.bytes().as_ref());
        }
        Ok(())
    })?;
    numpy.call_method1("frombuffer", (bytes, T::TYPE))?.call_method1("reshape", (shape,))
}

/// Returns `n` rows of three numbers in single precision.
pub fn vectors<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f32; 3]>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [rows.len(), 3];
    let flat: Vec<f32> = rows.flatten().collect();
    array(py, flat.into_iter(), &shape)
}

/// Returns `n` rows of three numbers in double precision.
pub fn wide_vectors<'py>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [f64; 3]>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [rows.len(), 3];
    let flat: Vec<f64> = rows.flatten().collect();
    array(py, flat.into_iter(), &shape)
}

/// An array of any shape, in row-major order.
pub struct Array {
    /// Size along each axis.
    pub shape: Vec<usize>,
    /// Numbers, in row-major order.
    pub content: Content,
}

/// The numbers of an array.
pub enum Content {
    /// Numbers of an array of `uint8`.
    Bytes(Vec<u8>),
    /// Numbers of an array of any other type.
    Floats(Vec<f32>),
}

impl Array {
    /// Reads anything that NumPy converts to an array of numbers; `name` is that of the argument.
    pub fn read(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let numpy = value.py().import("numpy")?;
        let array = numpy.call_method1("asarray", (value,))?;
        let kind: String = array.getattr("dtype")?.getattr("str")?.extract()?;
        let shape = array.getattr("shape")?.extract()?;
        let bytes = |array: &Bound<'_, PyAny>| -> PyResult<Vec<u8>> {
            Ok(array.call_method0("tobytes")?.cast::<PyBytes>()?.as_bytes().to_vec())
        };
        if kind == "|u1" {
            return Ok(Self { shape, content: Content::Bytes(bytes(&array)?) });
        }
        if !["f", "i", "u"].contains(&&kind[1..2]) {
            let dtype = array.getattr("dtype")?.str()?;
            return Err(option(name, format!("an array of {dtype}"), "an array of numbers"));
        }
        let floats = bytes(&numpy.call_method1("asarray", (array, "float32"))?)?;
        let floats = floats.as_chunks().0.iter().map(|bytes| f32::from_ne_bytes(*bytes)).collect();
        Ok(Self { shape, content: Content::Floats(floats) })
    }
}

/// Returns the numbers of shape `(n, N)` in single precision; `name` is that of the argument.
pub fn float_rows<const N: usize>(name: &str, rows: &Bound<'_, PyAny>) -> PyResult<Vec<[f32; N]>> {
    let numbers = |b: [u8; 4]| Ok(f32::from_ne_bytes(b));
    read_rows(name, rows, "float32", numbers)
}

/// Returns the numbers of shape `(n, N)` in double precision.
pub fn wide_rows<const N: usize>(name: &str, rows: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; N]>> {
    let numbers = |b: [u8; 8]| Ok(f64::from_ne_bytes(b));
    read_rows(name, rows, "float64", numbers)
}

/// Returns all numbers of an array of any shape in double precision, in row-major order.
pub fn wide_numbers(array: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numpy = array.py().import("numpy")?;
    let bytes = numpy.call_method1("asarray", (array, "float64"))?.call_method0("tobytes")?;
    let bytes = bytes.cast::<PyBytes>()?.as_bytes();
    Ok(bytes.as_chunks().0.iter().map(|bytes| f64::from_ne_bytes(*bytes)).collect())
}

/// Returns the indices of shape `(n, N)`: whole numbers from 0.
pub fn index_rows<const N: usize>(name: &str, rows: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; N]>> {
    let numpy = rows.py().import("numpy")?;
    let found = numpy.call_method1("asarray", (rows,))?;
    let kind: String = found.getattr("dtype")?.getattr("kind")?.extract()?;
    let empty: usize = found.getattr("size")?.extract()?;
    if !["i", "u"].contains(&kind.as_str()) && empty > 0 {
        let dtype = found.getattr("dtype")?.str()?;
        return Err(option(name, format!("an array of {dtype}"), "an array of integers"));
    }
    read_rows(name, &found, "int64", |b: [u8; 8]| {
        let index = i64::from_ne_bytes(b);
        u32::try_from(index).map_err(|_| option(name, index, "indices from 0 to 4294967295"))
    })
}

/// Returns `n` whole numbers from 0; `name` is that of the argument.
pub fn index_column(name: &str, column: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    let column = column.py().import("numpy")?.call_method1("asarray", (column,))?;
    let rows = column.call_method1("reshape", (-1, 1))?;
    Ok(index_rows::<1>(name, &rows)?.into_iter().map(|[n]| n).collect())
}

fn read_rows<T, const N: usize, const SIZE: usize>(
    name: &str,
    rows: &Bound<'_, PyAny>,
    dtype: &str,
    number: impl Fn([u8; SIZE]) -> PyResult<T>,
) -> PyResult<Vec<[T; N]>>
where
    T: Copy + Default,
{
    let numpy = rows.py().import("numpy")?;
    let rows = numpy.call_method1("asarray", (rows, dtype))?;
    let shape: Vec<usize> = rows.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != N {
        return Err(option(name, format!("an array of the shape {shape:?}"), format!("the shape (n, {N})")));
    }
    let bytes = rows.call_method0("tobytes")?;
    let numbers = bytes.cast::<PyBytes>()?.as_bytes().as_chunks::<SIZE>().0;
    numbers
        .chunks_exact(N)
        .map(|row| {
            let mut read = [T::default(); N];
            for (slot, bytes) in read.iter_mut().zip(row) {
                *slot = number(*bytes)?;
            }
            Ok(read)
        })
        .collect()
}
