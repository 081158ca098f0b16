//! Values in a form common to all encodings. All numbers are `f64`, regardless of their type in the
//! file.
//!
//! A quaternion is stored as `(w, x, y, z)`, a matrix row by row.

use std::collections::BTreeSet;
use std::rc::Rc;

/// A name, a path or a text of a file.
pub(super) type Text = Rc<str>;

/// Value of an attribute or a field.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// `None`: hides weaker opinions.
    Blocked,
    /// A number or a boolean.
    Number(f64),
    /// A string, a token, the path of an asset or of a prim.
    Text(Text),
    /// A vector, a quaternion or a matrix.
    Tuple(Vec<f64>),
    /// An array of numbers, or of tuples of `width` numbers.
    Array {
        /// Numbers of an element, at least 1.
        width: usize,
        /// All numbers, element by element.
        numbers: Vec<f64>,
    },
    /// An array of strings or tokens.
    Texts(Vec<Text>),
    /// Edits of a list of paths, tokens or strings.
    Paths(ListOp<Text>),
    /// Edits of a list of references or payloads.
    References(ListOp<Reference>),
    /// Edits of a list of whole numbers, such as ids of instances.
    Ids(ListOp<i64>),
    /// Chosen variants: set and choice.
    Selections(Vec<(Text, Text)>),
    /// A value of a type that is not used.
    Other,
}

/// Reference from a prim to another prim, whose opinions it receives.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Reference {
    /// The file; empty for the same stack of layers.
    pub asset: Text,
    /// The prim; empty for the default one.
    pub prim: Text,
    /// True if times are shifted or scaled.
    pub has_offset: bool,
}

/// Edits of a list by one layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ListOp<T> {
    pub explicit: Option<Vec<T>>,
    pub prepended: Vec<T>,
    pub appended: Vec<T>,
    pub deleted: Vec<T>,
}

impl<T> Default for ListOp<T> {
    fn default() -> Self {
        Self { explicit: None, prepended: Vec::new(), appended: Vec::new(), deleted: Vec::new() }
    }
}

/// Kind of a statement that edits a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edit {
    Explicit,
    Prepend,
    Append,
    Delete,
    /// Changes the order only; ignored.
    Reorder,
}

impl<T: Clone + Ord> ListOp<T> {
    /// Records one statement that edits the list.
    pub fn edit(&mut self, edit: Edit, items: Vec<T>) {
        match edit {
            Edit::Explicit => self.explicit = Some(items),
            Edit::Prepend => self.prepended = items,
            Edit::Append => self.appended.extend(items),
            Edit::Delete => self.deleted = items,
            Edit::Reorder => {}
        }
    }

    /// Returns the first item that is added.
    pub fn first(&self) -> Option<&T> {
        self.explicit.iter().flatten().chain(&self.prepended).chain(&self.appended).next()
    }

    /// Applies these edits to the list that results from the weaker layers.
    pub fn apply(&self, list: &mut Vec<T>) {
        if let Some(explicit) = &self.explicit {
            list.clone_from(explicit);
            return;
        }
        let moved: BTreeSet<&T> = self.deleted.iter().chain(&self.prepended).chain(&self.appended).collect();
        list.retain(|item| !moved.contains(item));
        list.splice(0..0, self.prepended.iter().cloned());
        list.extend(self.appended.iter().cloned());
    }
}

impl Value {
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    pub fn text(&self) -> Option<&Text> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A vector of `N` numbers.
    pub fn tuple<const N: usize>(&self) -> Option<[f64; N]> {
        match self {
            Self::Tuple(numbers) => numbers.as_slice().try_into().ok(),
            _ => None,
        }
    }

    /// An array of elements of `N` numbers; an empty array has any width.
    pub fn array<const N: usize>(&self) -> Option<&[[f64; N]]> {
        match self {
            Self::Array { width, numbers } if *width == N || numbers.is_empty() => {
                Some(numbers.as_chunks::<N>().0)
            }
            Self::Texts(none) if none.is_empty() => Some(&[]),
            _ => None,
        }
    }

    /// An array of numbers; an empty array of texts also counts as one.
    pub fn numbers(&self) -> Option<&[f64]> {
        match self {
            Self::Array { width: 1, numbers } => Some(numbers),
            Self::Texts(none) if none.is_empty() => Some(&[]),
            _ => None,
        }
    }

    pub fn texts(&self) -> Option<&[Text]> {
        match self {
            Self::Texts(texts) => Some(texts),
            Self::Array { numbers, .. } if numbers.is_empty() => Some(&[]),
            _ => None,
        }
    }

    /// Approximate size in memory (bytes).
    pub fn bytes(&self) -> u64 {
        let numbers = |n: &Vec<f64>| 8 * n.len() as u64;
        match self {
            Self::Tuple(n) => numbers(n),
            Self::Array { numbers: n, .. } => numbers(n),
            Self::Texts(texts) => 16 * texts.len() as u64,
            _ => 0,
        }
    }

    /// Linear interpolation to `other` at the fraction `u`; none unless both values consist of
    /// numbers and have the same shape.
    pub fn between(&self, other: &Self, u: f64) -> Option<Self> {
        let mix = |a: &[f64], b: &[f64]| -> Option<Vec<f64>> {
            (a.len() == b.len()).then(|| a.iter().zip(b).map(|(a, b)| a * (1.0 - u) + b * u).collect())
        };
        Some(match (self, other) {
            (Self::Number(a), Self::Number(b)) => Self::Number(a * (1.0 - u) + b * u),
            (Self::Tuple(a), Self::Tuple(b)) => Self::Tuple(mix(a, b)?),
            (Self::Array { width, numbers: a }, Self::Array { width: other, numbers: b })
                if width == other =>
            {
                Self::Array { width: *width, numbers: mix(a, b)? }
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_edited_from_the_weakest_layer_up() {
        let mut list = vec![1, 2, 3];
        let op = |edit, items| {
            let mut op = ListOp::default();
            op.edit(edit, items);
            op
        };
        op(Edit::Prepend, vec![3, 9]).apply(&mut list);
        assert_eq!(list, [3, 9, 1, 2]);
        op(Edit::Append, vec![9, 4]).apply(&mut list);
        assert_eq!(list, [3, 1, 2, 9, 4]);
        op(Edit::Delete, vec![1]).apply(&mut list);
        assert_eq!(list, [3, 2, 9, 4]);
        op(Edit::Explicit, vec![]).apply(&mut list);
        assert!(list.is_empty());
    }

    #[test]
    fn values_alike_are_blended() {
        let (a, b) = (Value::Tuple(vec![0.0, 4.0]), Value::Tuple(vec![2.0, 8.0]));
        assert_eq!(a.between(&b, 0.25), Some(Value::Tuple(vec![0.5, 5.0])));
        assert_eq!(a.between(&Value::Number(1.0), 0.5), None);
        let text = Value::Text("a".into());
        assert_eq!(text.between(&text, 0.5), None);
    }
}
