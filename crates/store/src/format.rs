//! The layout of files, byte by byte.

use crate::numbers::described;
use crate::section::Section;
use serde_json::{Map, Value};
use xxhash_rust::xxh3::{Xxh3, xxh3_64, xxh3_128};

/// The version of the format that is written, and the newest that is read.
pub const VERSION: u32 = 1;

/// Sections and records start at multiples of so many bytes.
pub(crate) const ALIGNMENT: usize = 64;

/// Bytes of the preamble, of the head of a record and of the footer.
pub(crate) const HEAD: usize = 64;

/// The most sections of a record.
const MOST_SECTIONS: u32 = 1 << 12;

/// Bytes of an entry of the table of sections.
const ENTRY: usize = 16;

/// The first byte is no text; the line end tells whether the file was sent as text.
const MAGIC: [u8; 8] = *b"\x89EXCHG\r\n";
const RECORD_MARK: [u8; 4] = *b"RECD";
const FOOTER_MAGIC: [u8; 8] = *b"EXCHGEND";

/// What a record is for.
pub mod role {
    /// The first record: settings, and what makes the file stand alone.
    pub const HEAD: u32 = 0;
    /// A block of the operator, in the order in which it was built.
    pub const BLOCK: u32 = 1;
    /// From here on kinds of records are their owner's; a build that is resumed begins after the last block.
    pub const OTHER: u32 = 0x100;
}

/// Names and values of what the numbers follow from.
pub type Settings = Map<String, Value>;

/// What the numbers of a file are, and follow from.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// The kind of operator, 16 bytes of text at most.
    pub kind: &'static str,
    /// All that the numbers depend on: a hash of the geometry, method, tolerance, seed, version of the engine. No
    /// times, no threads.
    pub settings: Settings,
}

impl Identity {
    /// A hash of kind and settings.
    pub fn fingerprint(&self) -> u128 {
        xxh3_128(format!("{}\n{}", self.kind, self.settings_text()).as_bytes())
    }

    pub(crate) fn settings_text(&self) -> String {
        Value::Object(self.settings.clone()).to_string()
    }

    /// How the settings of a file differ from these, in words.
    pub(crate) fn differences(&self, there: &Settings) -> String {
        let value = |settings: &Settings, name: &str| settings.get(name).map_or("none".into(), Value::to_string);
        let mut names: Vec<&String> = self.settings.keys().chain(there.keys()).collect();
        names.sort();
        names.dedup();
        let differ: Vec<String> = names
            .into_iter()
            .filter(|name| self.settings.get(*name) != there.get(*name))
            .map(|name| format!("{name} is {} there and {} here", value(there, name), value(&self.settings, name)))
            .collect();
        if differ.is_empty() { "it is of another kind".into() } else { differ.join(", ") }
    }
}

/// A hash of arrays, as text.
pub fn fingerprint(sections: &[Section]) -> String {
    let mut hash = Xxh3::new();
    for section in sections {
        hash.update(&section.code.to_le_bytes());
        hash.update(&section.count.to_le_bytes());
        hash.update(&section.bytes);
    }
    format!("{:032x}", hash.digest128())
}

/// The beginning of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Preamble {
    pub kind: [u8; 16],
    pub fingerprint: u128,
    /// Its own checksum, which all records repeat.
    pub checksum: u64,
}

impl Preamble {
    pub fn of(identity: &Identity) -> Self {
        let mut kind = [0; 16];
        kind[..identity.kind.len()].copy_from_slice(identity.kind.as_bytes());
        let unsigned = Self { kind, fingerprint: identity.fingerprint(), checksum: 0 };
        let bytes = unsigned.encode();
        Self { checksum: u64_at(&bytes, 56), ..unsigned }
    }

    pub fn encode(&self) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..12].copy_from_slice(&VERSION.to_le_bytes());
        bytes[16..32].copy_from_slice(&self.kind);
        bytes[32..48].copy_from_slice(&self.fingerprint.to_le_bytes());
        signed(bytes)
    }

    pub fn decode(bytes: &[u8; HEAD]) -> Result<Self, String> {
        if bytes[..8] != MAGIC {
            return Err("this is no file of an exchange".into());
        }
        if !is_signed(bytes) {
            return Err("the file is damaged: its first 64 bytes do not fit their checksum".into());
        }
        let version = u32_at(bytes, 8);
        if version != VERSION {
            return Err(format!("the file is of version {version} of its format, and this program reads {VERSION}"));
        }
        let kind = bytes[16..32].try_into().expect("16 bytes");
        let fingerprint = u128::from_le_bytes(bytes[32..48].try_into().expect("16 bytes"));
        Ok(Self { kind, fingerprint, checksum: u64_at(bytes, 56) })
    }
}

/// The beginning of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RecordHead {
    pub role: u32,
    pub number: u64,
    pub sections: u32,
    /// Of the whole record.
    pub length: u64,
    /// Of the sections.
    pub data_checksum: u64,
    /// Of the file's preamble, so that records of other files are known as such.
    pub file: u64,
}

impl RecordHead {
    /// The head and the table of a record.
    pub fn of(role: u32, number: u64, file: u64, sections: &[Section]) -> (Self, Vec<u8>) {
        assert!(sections.len() <= MOST_SECTIONS as usize, "a record of {} sections", sections.len());
        let mut table = Vec::with_capacity(aligned(ENTRY * sections.len()));
        let (mut hash, mut data) = (Xxh3::new(), 0);
        for section in sections {
            table.extend_from_slice(&section.code.to_le_bytes());
            table.extend_from_slice(&[0; 4]);
            table.extend_from_slice(&section.count.to_le_bytes());
            hash.update(&section.bytes);
            hash.update(padding(section.bytes.len()));
            data += aligned(section.bytes.len());
        }
        table.resize(aligned(table.len()), 0);
        let length = (HEAD + table.len() + data) as u64;
        let data_checksum = hash.digest();
        (Self { role, number, sections: sections.len() as u32, length, data_checksum, file }, table)
    }

    /// The bytes, with a checksum of them and of the table.
    pub fn encode(&self, table: &[u8]) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..4].copy_from_slice(&RECORD_MARK);
        bytes[4..8].copy_from_slice(&self.role.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.number.to_le_bytes());
        bytes[16..20].copy_from_slice(&self.sections.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.length.to_le_bytes());
        bytes[32..40].copy_from_slice(&self.data_checksum.to_le_bytes());
        bytes[40..48].copy_from_slice(&self.file.to_le_bytes());
        let checksum = head_checksum(&bytes, table);
        bytes[56..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// The head, not held against its checksum yet, for which the table is needed.
    pub fn decode(bytes: &[u8; HEAD]) -> Option<Self> {
        let head = Self {
            role: u32_at(bytes, 4),
            number: u64_at(bytes, 8),
            sections: u32_at(bytes, 16),
            length: u64_at(bytes, 24),
            data_checksum: u64_at(bytes, 32),
            file: u64_at(bytes, 40),
        };
        (bytes[..4] == RECORD_MARK && head.sections <= MOST_SECTIONS).then_some(head)
    }

    /// Bytes of the table.
    pub fn table_length(&self) -> usize {
        aligned(ENTRY * self.sections as usize)
    }

    /// Where the sections of a record that starts at `start` are; none if head and table do not fit their checksum, the
    /// place, or each other.
    pub fn places(&self, start: u64, bytes: &[u8; HEAD], table: &[u8]) -> Option<Vec<Place>> {
        if head_checksum(bytes, table) != u64_at(bytes, 56) {
            return None;
        }
        let mut next = start.checked_add((HEAD + table.len()) as u64)?;
        let mut places = Vec::with_capacity(self.sections as usize);
        for entry in table.chunks_exact(ENTRY).take(self.sections as usize) {
            let code = u32_at(entry, 0);
            let size = described(code)?.1 as u64;
            let bytes = u64_at(entry, 8).checked_mul(size)?;
            places.push(Place { code, start: next.try_into().ok()?, bytes: bytes.try_into().ok()? });
            next = next.checked_add(bytes.checked_next_multiple_of(ALIGNMENT as u64)?)?;
        }
        (next == start.checked_add(self.length)?).then_some(places)
    }
}

/// Where a section is in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub code: u32,
    pub start: usize,
    pub bytes: usize,
}

/// The end of a file, which says that it is whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footer {
    pub records: u64,
    pub length: u64,
    /// Of the checksums of the preamble and of all heads.
    pub digest: u64,
}

impl Footer {
    pub fn encode(&self) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..8].copy_from_slice(&FOOTER_MAGIC);
        bytes[8..16].copy_from_slice(&self.records.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.length.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.digest.to_le_bytes());
        signed(bytes)
    }

    pub fn decode(bytes: &[u8; HEAD]) -> Option<Self> {
        let footer = Self { records: u64_at(bytes, 8), length: u64_at(bytes, 16), digest: u64_at(bytes, 24) };
        (bytes[..8] == FOOTER_MAGIC && is_signed(bytes)).then_some(footer)
    }
}

/// The digest of the structure: checksums of the preamble and of heads, in order.
#[derive(Clone)]
pub(crate) struct Digest(Xxh3);

impl Digest {
    pub fn new(preamble: &Preamble) -> Self {
        let mut hash = Xxh3::new();
        hash.update(&preamble.checksum.to_le_bytes());
        Self(hash)
    }

    /// Takes the head of the next record.
    pub fn add(&mut self, head: &[u8; HEAD]) {
        self.0.update(&head[56..]);
    }

    pub fn value(&self) -> u64 {
        self.0.digest()
    }
}

/// The next multiple of [`ALIGNMENT`].
pub(crate) fn aligned(bytes: usize) -> usize {
    bytes.next_multiple_of(ALIGNMENT)
}

/// What follows so many bytes up to the next multiple of [`ALIGNMENT`].
pub(crate) fn padding(bytes: usize) -> &'static [u8] {
    &[0; ALIGNMENT][..aligned(bytes) - bytes]
}

fn head_checksum(head: &[u8; HEAD], table: &[u8]) -> u64 {
    let mut hash = Xxh3::new();
    hash.update(&head[..56]);
    hash.update(table);
    hash.digest()
}

fn signed(mut bytes: [u8; HEAD]) -> [u8; HEAD] {
    let checksum = xxh3_64(&bytes[..56]);
    bytes[56..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

fn is_signed(bytes: &[u8; HEAD]) -> bool {
    xxh3_64(&bytes[..56]) == u64_at(bytes, 56)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"))
}
