//! A whole file, mapped.

use crate::error::StoreError;
use crate::format::{Digest, Footer, HEAD, Identity, Place, Preamble, RecordHead, Settings, role};
use crate::numbers::release;
use crate::section::Sections;
use memmap2::Mmap;
use rayon::prelude::*;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// A file whose structure has been checked; numbers are read as they are used.
#[derive(Clone)]
pub struct StoreFile {
    path: PathBuf,
    pub(crate) map: Arc<Mmap>,
    preamble: Preamble,
    records: Vec<Record>,
    settings: Settings,
}

/// Looking at a head has the system map the pages around it; after so many heads they are let go of.
const RELEASE_AFTER: usize = 32;

#[derive(Clone)]
struct Record {
    role: u32,
    /// Where its sections are.
    data: Range<usize>,
    data_checksum: u64,
    places: Vec<Place>,
}

impl StoreFile {
    /// Maps a file, for reading only, and checks its structure: preamble, footer, and the head of every record.
    ///
    /// # Errors
    /// If it cannot be read, or is foreign, newer, truncated or damaged.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let file = File::open(path).map_err(|e| StoreError::system(path, e))?;
        let metadata = file.metadata().map_err(|e| StoreError::system(path, e))?;
        if !metadata.is_file() {
            return Err(StoreError::system(path, io::Error::new(io::ErrorKind::InvalidInput, "this is no file")));
        }
        if metadata.len() == 0 {
            return Err(StoreError::damaged(path, "the file is empty"));
        }
        // SAFETY: whole files are replaced by renaming and never written to, so that the bytes stay as they are unless
        // another program breaks in; the module's comment says what happens then.
        let map = unsafe { Mmap::map(&file) }.map_err(|e| StoreError::system(path, e))?;
        Self::read(path, Arc::new(map)).map_err(|what| StoreError::damaged(path, what))
    }

    fn read(path: &Path, map: Arc<Mmap>) -> Result<Self, String> {
        let Some(first) = map.first_chunk::<HEAD>() else {
            return Err("this is no file of an exchange, or only its beginning".into());
        };
        let preamble = Preamble::decode(first)?;
        let end = map.len().saturating_sub(HEAD);
        let footer = map.last_chunk::<HEAD>().filter(|_| end >= HEAD).and_then(Footer::decode);
        let Some(footer) = footer.filter(|f| f.length == map.len() as u64) else {
            return Err(format!(
                "the file is truncated or damaged: it does not end as it should ({} bytes)",
                map.len()
            ));
        };
        let mut digest = Digest::new(&preamble);
        let (mut records, mut next) = (Vec::new(), HEAD);
        while next < end {
            let (record, head, after) = Record::read(&map[..end], next, records.len() as u64, &preamble)
                .ok_or_else(|| format!("the file is damaged: record {} at byte {next}", records.len()))?;
            digest.add(head);
            records.push(record);
            next = after;
            if records.len() % RELEASE_AFTER == 0 {
                release(&map, 0, next);
            }
        }
        if footer.records != records.len() as u64 || footer.digest != digest.value() {
            return Err("the file is damaged: its records are not those that its end tells of".into());
        }
        let mut file = Self { path: path.into(), map, preamble, records, settings: Settings::new() };
        file.settings = file.read_settings().ok_or("the file is damaged: its first record holds no settings")?;
        // What was touched to look at the structure.
        file.release();
        Ok(file)
    }

    /// The settings, whose bytes are held against their checksum before they are read.
    fn read_settings(&self) -> Option<Settings> {
        let first = self.records.first().filter(|r| r.role == role::HEAD && self.is_sound(r))?;
        let place = first.places.first()?;
        serde_json::from_slice(&self.map[place.start..place.start + place.bytes]).ok()
    }

    /// Holds all numbers against their checksums, which reads the whole file.
    ///
    /// # Errors
    /// If a record is damaged.
    pub fn verify(&self) -> Result<(), StoreError> {
        let is_damaged = |k: &usize| {
            let record = &self.records[*k];
            let is_sound = self.is_sound(record);
            release(&self.map, record.data.start, record.data.len());
            !is_sound
        };
        let damaged = (0..self.records.len()).into_par_iter().find_first(is_damaged);
        match damaged {
            None => Ok(()),
            Some(k) => {
                let what = format!("the file is damaged: the numbers of record {k} do not fit their checksum");
                Err(StoreError::damaged(&self.path, what))
            }
        }
    }

    /// Lets go of all pages that were read; they are there again when they are read.
    pub fn release(&self) {
        release(&self.map, 0, self.map.len());
    }

    fn is_sound(&self, record: &Record) -> bool {
        xxh3_64(&self.map[record.data.clone()]) == record.data_checksum
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The kind of operator.
    pub fn kind(&self) -> String {
        String::from_utf8_lossy(&self.preamble.kind).trim_end_matches('\0').to_owned()
    }

    /// What the numbers follow from.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Whether the numbers are what an identity says.
    pub fn is(&self, identity: &Identity) -> bool {
        self.preamble == Preamble::of(identity)
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.map.len() as u64
    }

    /// The records of a role, in order.
    pub fn with_role(&self, role: u32) -> impl Iterator<Item = Sections<'_>> {
        let of_role = (0..self.records.len()).filter(move |&k| self.records[k].role == role);
        of_role.enumerate().map(|(count, k)| {
            if count % RELEASE_AFTER == RELEASE_AFTER - 1 {
                self.release();
            }
            Sections::new(self, k)
        })
    }

    /// The sections of the first record after the settings.
    pub fn head(&self) -> Sections<'_> {
        let mut sections = Sections::new(self, 0);
        sections.take::<u8>().expect("settings were read");
        sections
    }

    /// The only record of a role.
    ///
    /// # Errors
    /// If there is none.
    pub fn only(&self, role: u32) -> Result<Sections<'_>, StoreError> {
        let mut found = self.with_role(role);
        match (found.next(), found.next()) {
            (Some(sections), None) => Ok(sections),
            _ => Err(StoreError::damaged(&self.path, format!("the file has no record or several of role {role:#x}"))),
        }
    }

    pub(crate) fn places(&self, record: usize) -> &[Place] {
        &self.records[record].places
    }
}

impl Record {
    /// The record that starts at byte `start`, its head, and where the next one starts; none if it is damaged.
    fn read<'a>(
        bytes: &'a [u8],
        start: usize,
        number: u64,
        preamble: &Preamble,
    ) -> Option<(Self, &'a [u8; HEAD], usize)> {
        let rest = &bytes[start..];
        let head_bytes = rest.first_chunk::<HEAD>()?;
        let head = RecordHead::decode(head_bytes)?;
        let table = rest.get(HEAD..HEAD + head.table_length())?;
        let places = head.places(start as u64, head_bytes, table)?;
        let end = start.checked_add(usize::try_from(head.length).ok()?)?;
        let belongs = head.number == number && head.file == preamble.checksum;
        if !belongs || end > bytes.len() {
            return None;
        }
        let data = start + HEAD + table.len()..end;
        Some((Self { role: head.role, data, data_checksum: head.data_checksum, places }, head_bytes, end))
    }
}
