//! Blocks as flat arrays.

use crate::error::StoreError;
use crate::format::Place;
use crate::numbers::{Element, Mapped, Numbers, described};
use crate::store_file::StoreFile;
use std::borrow::Cow;

/// What can be a record of a file: a few flat arrays in a fixed order.
pub trait Stored: Sized {
    /// Its arrays.
    fn sections(&self) -> Vec<Section<'_>>;

    /// What the arrays of a record say. Anything may be in them: lengths and indices must be held against each other
    /// before they are used, here or before the first use.
    ///
    /// # Errors
    /// If the arrays are not those of such a block.
    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError>;
}

/// An array on its way into a file.
#[derive(Clone, Debug)]
pub struct Section<'a> {
    pub(crate) code: u32,
    pub(crate) count: u64,
    pub(crate) bytes: Cow<'a, [u8]>,
}

impl<'a> Section<'a> {
    /// An array that lives elsewhere.
    pub fn of<T: Element>(values: &'a [T]) -> Self {
        Self { code: T::CODE, count: values.len() as u64, bytes: Cow::Borrowed(bytemuck::cast_slice(values)) }
    }

    /// A small array made for the file.
    pub fn owned<T: Element>(values: &[T]) -> Section<'static> {
        Section {
            code: T::CODE,
            count: values.len() as u64,
            bytes: Cow::Owned(bytemuck::cast_slice::<T, u8>(values).to_vec()),
        }
    }

    /// Text.
    pub fn text(text: &'a str) -> Self {
        Self::of(text.as_bytes())
    }
}

/// The arrays of one record of an open file, taken one after the other.
pub struct Sections<'a> {
    file: &'a StoreFile,
    record: usize,
    next: usize,
}

impl<'a> Sections<'a> {
    pub(crate) fn new(file: &'a StoreFile, record: usize) -> Self {
        Self { file, record, next: 0 }
    }

    /// The next array, where it is mapped.
    ///
    /// # Errors
    /// If there is none or it is of another type.
    pub fn take<T: Element>(&mut self) -> Result<Numbers<T>, StoreError> {
        let place = self.file.places(self.record).get(self.next).copied();
        let Some(Place { code, start, bytes }) = place else {
            return Err(self.damaged(format!("section {} is missing", self.next)));
        };
        if code != T::CODE {
            let name = |code| described(code).map_or("unknown", |d| d.0);
            return Err(self.damaged(format!("section {} holds {}, not {}", self.next, name(code), name(T::CODE))));
        }
        self.next += 1;
        Ok(Numbers::Mapped(Mapped { map: self.file.map.clone(), start, bytes }))
    }

    /// The next array, copied, which has `N` entries.
    ///
    /// # Errors
    /// If it has not, or there is none, or it is of another type.
    pub fn take_few<T: Element, const N: usize>(&mut self) -> Result<[T; N], StoreError> {
        let values = self.take::<T>()?;
        <[T; N]>::try_from(&*values)
            .map_err(|_| self.damaged(format!("section {} has {} entries, not {N}", self.next - 1, values.len())))
    }

    /// The next array as text.
    ///
    /// # Errors
    /// If it is none.
    pub fn take_text(&mut self) -> Result<String, StoreError> {
        let bytes = self.take::<u8>()?;
        let text = std::str::from_utf8(&bytes).map_err(|_| self.damaged("text that is not UTF-8"))?;
        Ok(text.to_owned())
    }

    /// The type of the next array, if there is one.
    pub fn next_is<T: Element>(&self) -> bool {
        self.file.places(self.record).get(self.next).is_some_and(|place| place.code == T::CODE)
    }

    /// An error about this record.
    pub fn damaged(&self, what: impl std::fmt::Display) -> StoreError {
        StoreError::damaged(self.file.path(), format!("the file is damaged: record {}: {what}", self.record))
    }
}
