//! What goes wrong with files of numbers.

use crate::files::FileError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a file was not written, opened or resumed.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The system refused: no such file, no space ...
    #[error(transparent)]
    System(#[from] FileError),
    /// The file is not what it should be: foreign, newer, truncated or damaged.
    #[error("{}: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The file is whole or may be, but is of something else than what is asked for.
    #[error("{}: {what}", path.display())]
    Different {
        /// The file.
        path: PathBuf,
        /// What differs and what to do.
        what: String,
    },
    /// Another process is building the file.
    #[error("{}: another process is building this file", path.display())]
    Busy {
        /// The file while it is built.
        path: PathBuf,
    },
}

impl StoreError {
    pub(crate) fn system(path: &Path, source: io::Error) -> Self {
        FileError::new(path, source).into()
    }

    /// An error about what is in a file.
    pub fn damaged(path: &Path, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.into(), what: what.into() }
    }

    /// An error about a file of something else.
    pub fn different(path: &Path, what: impl Into<String>) -> Self {
        Self::Different { path: path.into(), what: what.into() }
    }
}
