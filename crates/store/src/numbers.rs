//! Arrays that are in memory of their own or where a file is mapped.

use memmap2::Mmap;
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

#[cfg(target_endian = "big")]
compile_error!("files are little-endian and are read where they are mapped");

/// What arrays consist of.
pub trait Element: bytemuck::Pod + Send + Sync {
    /// How files name the type.
    const CODE: u32;
}

macro_rules! elements {
    ($($type:ty = $code:literal),*) => {
        $(impl Element for $type {
            const CODE: u32 = $code;
        })*

        /// The name and the size of the type that a file names by a code.
        pub(crate) fn described(code: u32) -> Option<(&'static str, usize)> {
            match code {
                $($code => Some((stringify!($type), size_of::<$type>())),)*
                _ => None,
            }
        }
    };
}

elements!(u8 = 1, u16 = 2, u32 = 3, u64 = 4, f32 = 5, f64 = 6);

/// An array, owned or mapped; reads as a slice.
///
/// In a loop over elements take the slice first: `let values: &[f64] = &numbers`.
#[derive(Clone)]
pub enum Numbers<T: Element> {
    /// In memory of its own.
    Owned(Vec<T>),
    /// In a file. Clones share the map.
    Mapped(Mapped),
}

/// Takes a part of a map out of what counts as this process's memory.
#[cfg(unix)]
pub(crate) fn release(map: &Mmap, start: usize, bytes: usize) {
    // SAFETY: the map is shared and read-only, so that pages which are let go come back with the same bytes.
    let _ = unsafe { map.unchecked_advise_range(memmap2::UncheckedAdvice::DontNeed, start, bytes) };
}

#[cfg(not(unix))]
pub(crate) fn release(_: &Mmap, _: usize, _: usize) {}

/// A place in a mapped file.
#[derive(Clone)]
pub struct Mapped {
    pub(crate) map: Arc<Mmap>,
    pub(crate) start: usize,
    pub(crate) bytes: usize,
}

impl<T: Element> Deref for Numbers<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Numbers::Owned(values) => values,
            Numbers::Mapped(m) => bytemuck::cast_slice(&m.map[m.start..m.start + m.bytes]),
        }
    }
}

impl<T: Element> Numbers<T> {
    /// Whether they are where a file is mapped.
    pub fn is_mapped(&self) -> bool {
        matches!(self, Numbers::Mapped(_))
    }

    /// Lets go of the pages that they are read through, where they are mapped. The system may keep them, and they are
    /// there again when they are read.
    pub fn release(&self) {
        if let Numbers::Mapped(m) = self {
            release(&m.map, m.start, m.bytes);
        }
    }
}

impl<T: Element> Default for Numbers<T> {
    fn default() -> Self {
        Numbers::Owned(Vec::new())
    }
}

impl<T: Element> From<Vec<T>> for Numbers<T> {
    fn from(values: Vec<T>) -> Self {
        Numbers::Owned(values)
    }
}

impl<T: Element> FromIterator<T> for Numbers<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Numbers::Owned(values.into_iter().collect())
    }
}

impl<T: Element + fmt::Debug> fmt::Debug for Numbers<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}
