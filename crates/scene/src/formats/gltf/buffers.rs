//! Buffers and the views into them.

use std::borrow::Cow;

use ::gltf::json::{self, Index, Root, buffer};

use crate::formats::folder::{Folder, abbreviated};
use crate::model::SceneError;

/// A file's JSON with the bytes that it refers to.
pub(super) struct Document<'a> {
    pub root: &'a Root,
    file: &'a str,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> Document<'a> {
    /// Reads all buffers; each has at least the length that it declares.
    pub fn open(root: &'a Root, chunk: Option<&'a [u8]>, folder: &Folder, file: &'a str) -> Result<Self, SceneError> {
        let read = |(index, buffer): (usize, &'a json::Buffer)| {
            let chunk = chunk.filter(|_| index == 0);
            load(buffer, chunk, folder).map_err(|message| SceneError::new(file, format!("buffer {index}"), message))
        };
        let buffers = root.buffers.iter().enumerate().map(read).collect::<Result<_, _>>()?;
        Ok(Self { root, file, buffers })
    }

    /// An error of this file.
    pub fn fail(&self, element: impl Into<String>, message: impl Into<String>) -> SceneError {
        SceneError::new(self.file, element, message)
    }

    /// The bytes of a view and its stride.
    pub fn view(&self, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>), String> {
        let index = index.value();
        let view = self.root.buffer_views.get(index).ok_or(format!("bufferView {index} does not exist"))?;
        let buffer = self.buffers.get(view.buffer.value());
        let buffer =
            buffer.ok_or(format!("bufferView {index} refers to buffer {}, which does not exist", view.buffer))?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let bytes = slice(buffer, start, view.byte_length.0).ok_or_else(|| {
            let (length, whole) = (view.byte_length.0, buffer.len());
            format!("bufferView {index} takes {length} bytes from byte {start} of a buffer of {whole} bytes")
        })?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

/// `length` bytes from `start`, if they exist.
pub(super) fn slice(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let end = start.checked_add(length)?;
    bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
}

fn load<'a>(buffer: &'a json::Buffer, chunk: Option<&'a [u8]>, folder: &Folder) -> Result<Cow<'a, [u8]>, String> {
    let declared = buffer.byte_length.0;
    let (bytes, source) = match (&buffer.uri, chunk) {
        (Some(uri), _) => (Cow::Owned(folder.read_uri(uri, declared)?), abbreviated(uri)),
        (None, Some(chunk)) => (Cow::Borrowed(chunk), "the BIN chunk".into()),
        (None, None) => return Err("it has no data; export the file again without mesh compression".into()),
    };
    if (bytes.len() as u64) < declared {
        let length = bytes.len();
        return Err(format!(
            "{declared} bytes are declared and {source} has {length}; it was cut short, copy or export it again"
        ));
    }
    Ok(bytes)
}
