//! Writing records one after the other.

use crate::error::StoreError;
use crate::files::{FileError, atomic_write};
use crate::format::{Digest, Footer, HEAD, Identity, Preamble, RecordHead, padding, role};
use crate::section::Section;
use std::io::{self, Write};
use std::path::Path;

/// A file in the making.
pub struct Writer<W> {
    pub(crate) out: W,
    pub(crate) state: State,
}

/// How far a file is.
#[derive(Clone)]
pub(crate) struct State {
    pub preamble: Preamble,
    pub digest: Digest,
    pub records: u64,
    pub length: u64,
}

impl State {
    /// After a preamble.
    pub fn after(preamble: Preamble) -> Self {
        Self { preamble, digest: Digest::new(&preamble), records: 0, length: HEAD as u64 }
    }

    /// After one record more.
    pub fn add(&mut self, head: &[u8; HEAD], length: u64) {
        self.digest.add(head);
        self.records += 1;
        self.length += length;
    }

    pub fn footer(&self) -> Footer {
        Footer { records: self.records, length: self.length + HEAD as u64, digest: self.digest.value() }
    }
}

impl<W: Write> Writer<W> {
    /// Begins with the preamble and the first record: the settings, then `head`.
    pub(crate) fn begin(mut out: W, identity: &Identity, head: &[Section]) -> io::Result<Self> {
        let preamble = Preamble::of(identity);
        out.write_all(&preamble.encode())?;
        let mut writer = Self { out, state: State::after(preamble) };
        let settings = identity.settings_text();
        let mut sections = vec![Section::text(&settings)];
        sections.extend_from_slice(head);
        writer.append(role::HEAD, &sections)?;
        Ok(writer)
    }

    /// Adds a record.
    ///
    /// # Errors
    /// Of the system.
    pub fn append(&mut self, role: u32, sections: &[Section]) -> io::Result<()> {
        let State { preamble, records, .. } = &self.state;
        let (head, table) = RecordHead::of(role, *records, preamble.checksum, sections);
        let bytes = head.encode(&table);
        self.out.write_all(&bytes)?;
        self.out.write_all(&table)?;
        for section in sections {
            self.out.write_all(&section.bytes)?;
            self.out.write_all(padding(section.bytes.len()))?;
        }
        self.state.add(&bytes, head.length);
        Ok(())
    }

    /// Adds the footer.
    pub(crate) fn end(&mut self) -> io::Result<()> {
        self.out.write_all(&self.state.footer().encode())
    }
}

/// Writes a file at once: the settings, `head`, and the records that `fill` appends. It appears under its name when it
/// is whole, and not at all when anything fails; a file that it replaces stays with those who have it mapped.
///
/// # Errors
/// Of the system.
pub fn save(
    path: &Path,
    identity: &Identity,
    head: &[Section],
    fill: impl FnOnce(&mut Writer<&mut dyn Write>) -> io::Result<()>,
) -> Result<(), StoreError> {
    let written: Result<(), FileError> = atomic_write(path, |out| {
        let mut writer = Writer::begin(out as &mut dyn Write, identity, head)?;
        fill(&mut writer)?;
        writer.end()
    });
    Ok(written?)
}
