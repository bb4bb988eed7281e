//! Whatever is in a file, and wherever the building of one was cut off.

use proptest::prelude::*;
use radiosity_store::{
    Checkpoint, Identity, Opened, Section, Sections, Settings, StoreError, StoreFile, Stored, partial_name, role, save,
};
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A block of a few arrays, some of odd length, some empty.
#[derive(Clone, Debug, PartialEq)]
struct Few {
    integers: Vec<u32>,
    numbers: Vec<f64>,
    bytes: Vec<u8>,
}

impl Few {
    fn numbered(k: usize) -> Self {
        Self {
            integers: (0..k as u32).collect(),
            numbers: (0..2 * k).map(|i| (i as f64).sqrt()).collect(),
            bytes: vec![k as u8; 7 * (k % 3)],
        }
    }
}

impl Stored for Few {
    fn sections(&self) -> Vec<Section<'_>> {
        vec![Section::of(&self.integers), Section::of(&self.numbers), Section::of(&self.bytes)]
    }

    fn from_sections(s: &mut Sections<'_>) -> Result<Self, StoreError> {
        Ok(Self { integers: s.take()?.to_vec(), numbers: s.take()?.to_vec(), bytes: s.take()?.to_vec() })
    }
}

const BLOCKS: usize = 6;
const LAST: u32 = role::OTHER;

fn identity(tolerance: f64) -> Identity {
    let mut settings = Settings::new();
    settings.insert("tolerance".into(), json!(tolerance));
    settings.insert("engine".into(), json!("1"));
    Identity { kind: "test", settings }
}

fn open(path: &Path) -> Result<Opened, StoreError> {
    Checkpoint::open(path, &identity(0.5), &[Section::text("what it is")])
}

fn building(path: &Path) -> Checkpoint {
    match open(path).unwrap() {
        Opened::Building(checkpoint) => *checkpoint,
        Opened::Whole(_) => panic!("it is whole"),
    }
}

/// Builds what is missing.
fn build(path: &Path) -> StoreFile {
    let mut checkpoint = building(path);
    for k in checkpoint.blocks()..BLOCKS {
        checkpoint.append(&Few::numbered(k)).unwrap();
    }
    checkpoint.finish(&[(LAST, vec![Section::text("the end")])]).unwrap()
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exchange");
    (folder, path)
}

/// The bytes of the whole file.
fn whole() -> Vec<u8> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    let build = || {
        let (_folder, path) = folder();
        build(&path);
        fs::read(path).unwrap()
    };
    BYTES.get_or_init(build).clone()
}

/// All that a user of a file reads.
fn read_all(path: &Path) -> Result<Vec<Few>, StoreError> {
    let file = StoreFile::open(path)?;
    file.verify()?;
    file.head().take_text()?;
    file.only(LAST)?.take_text()?;
    file.with_role(role::BLOCK).map(|mut s| Few::from_sections(&mut s)).collect()
}

#[test]
fn what_was_built_is_read() {
    let (_folder, path) = folder();
    let file = build(&path);
    assert!(file.is(&identity(0.5)) && !file.is(&identity(0.25)));
    assert_eq!((file.kind().as_str(), file.settings()), ("test", &identity(0.5).settings));
    assert_eq!(file.head().take_text().unwrap(), "what it is");
    assert_eq!(read_all(&path).unwrap(), (0..BLOCKS).map(Few::numbered).collect::<Vec<_>>());
    assert!(!partial_name(&path).exists());
    assert!(matches!(open(&path).unwrap(), Opened::Whole(_)));
}

#[test]
fn saving_writes_the_same_bytes() {
    let (_folder, path) = folder();
    let head = [Section::text("what it is")];
    save(&path, &identity(0.5), &head, |writer| {
        (0..BLOCKS).try_for_each(|k| writer.append(role::BLOCK, &Few::numbered(k).sections()))?;
        writer.append(LAST, &[Section::text("the end")])
    })
    .unwrap();
    assert_eq!(fs::read(&path).unwrap(), whole());
}

#[test]
fn a_flipped_bit_is_found_wherever_it_is() {
    let (_folder, path) = folder();
    let bytes = whole();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        fs::write(&path, damaged).unwrap();
        let error = read_all(&path).expect_err(&format!("byte {at}")).to_string();
        assert!(error.starts_with(path.to_str().unwrap()), "{error}");
    }
}

#[test]
fn a_truncated_file_is_found_wherever_it_ends() {
    let (_folder, path) = folder();
    let bytes = whole();
    for end in 0..bytes.len() {
        fs::write(&path, &bytes[..end]).unwrap();
        // Truncation is a matter of structure, which opening checks.
        let error = StoreFile::open(&path).map(|_| ()).expect_err(&format!("{end} bytes")).to_string();
        assert!(error.starts_with(path.to_str().unwrap()), "{error}");
    }
    fs::write(&path, [bytes.as_slice(), &[0; 64]].concat()).unwrap();
    assert!(StoreFile::open(&path).is_err());
}

#[test]
fn other_files_are_told_from_damaged_ones() {
    let (_folder, path) = folder();
    let message = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        StoreFile::open(&path).map(|_| ()).unwrap_err().to_string()
    };
    assert!(message(b"").contains("empty"));
    assert!(message(&[b'x'; 1000]).contains("no file of an exchange"));
    assert!(message(b"PK\x03\x04").contains("no file of an exchange"));
    assert!(message(&whole()[..64 * 5]).contains("truncated"));
    // A later version says so, with a checksum that fits.
    let mut newer = whole();
    newer[8] = 9;
    let checksum = xxhash_rust::xxh3::xxh3_64(&newer[..56]);
    newer[56..64].copy_from_slice(&checksum.to_le_bytes());
    assert!(message(&newer).contains("version 9"));
    assert!(matches!(StoreFile::open(Path::new("/nowhere/a")), Err(StoreError::System(_))));
    assert!(StoreFile::open(path.parent().unwrap()).is_err());
}

#[test]
fn building_goes_on_wherever_it_was_cut_off() {
    let (_folder, path) = folder();
    let bytes = whole();
    // Every record has a head, a table and sections at multiples of 64 bytes; a build takes a few milliseconds.
    for end in (0..=bytes.len()).step_by(32).chain((1..bytes.len()).step_by(61)) {
        fs::write(partial_name(&path), &bytes[..end]).unwrap();
        build(&path);
        assert_eq!(fs::read(&path).unwrap(), bytes, "cut off after {end} bytes");
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn building_goes_on_whatever_was_torn() {
    let (_folder, path) = folder();
    let bytes = whole();
    for at in (64..bytes.len()).step_by(43) {
        let mut torn = bytes.clone();
        torn[at..(at + 100).min(bytes.len())].fill(0xa5);
        fs::write(partial_name(&path), torn).unwrap();
        build(&path);
        assert_eq!(fs::read(&path).unwrap(), bytes, "torn at {at}");
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn what_was_resumed_can_be_read_while_building() {
    let (_folder, path) = folder();
    let mut checkpoint = building(&path);
    (0..4).for_each(|k| checkpoint.append(&Few::numbered(k)).unwrap());
    drop(checkpoint);
    let mut checkpoint = building(&path);
    assert_eq!((checkpoint.blocks(), checkpoint.resumed()), (4, 4));
    assert_eq!(checkpoint.section::<f64>(3, 1).unwrap(), Few::numbered(3).numbers);
    assert!(checkpoint.section::<u8>(3, 1).is_err() && checkpoint.section::<f64>(4, 1).is_err());
    checkpoint.append(&Few::numbered(4)).unwrap();
    drop(checkpoint);
    build(&path);
    assert_eq!(fs::read(&path).unwrap(), whole());
}

#[test]
fn other_settings_are_refused() {
    let (_folder, path) = folder();
    let other = |path: &Path| Checkpoint::open(path, &identity(0.25), &[]).map(|_| ()).unwrap_err();
    drop(building(&path));
    let partial = other(&path);
    assert!(matches!(partial, StoreError::Different { .. }));
    assert!(partial.to_string().contains("tolerance is 0.5 there and 0.25 here"), "{partial}");
    assert!(partial.to_string().contains("a.exchange.partial"), "{partial}");
    build(&path);
    assert!(other(&path).to_string().contains("tolerance is 0.5 there and 0.25 here"));
    // What is no such file at all is left alone.
    fs::write(&path, "notes").unwrap();
    assert!(matches!(other(&path), StoreError::Damaged { .. }));
    fs::remove_file(&path).unwrap();
    fs::write(partial_name(&path), [b'n'; 100]).unwrap();
    assert!(matches!(other(&path), StoreError::Damaged { .. }));
    assert_eq!(fs::read(partial_name(&path)).unwrap(), [b'n'; 100]);
}

#[test]
fn two_do_not_build_one_file() {
    let (_folder, path) = folder();
    let first = building(&path);
    assert!(matches!(open(&path), Err(StoreError::Busy { .. })));
    drop(first);
    assert!(matches!(open(&path), Ok(Opened::Building(_))));
}

#[test]
fn a_mapped_file_stays_when_it_is_replaced() {
    let (_folder, path) = folder();
    let file = build(&path);
    let mapped = file.with_role(role::BLOCK).nth(5).unwrap().take::<u32>().unwrap();
    save(&path, &identity(0.25), &[], |_| Ok(())).unwrap();
    assert!(mapped.is_mapped());
    assert_eq!(*mapped, [0, 1, 2, 3, 4]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Damage whose checksums fit, as of a hostile file: heads and tables are read with care.
    #[test]
    fn lengths_are_not_trusted(record in 0usize..8, at in 0usize..48, value: u8, table in any::<[u8; 16]>(), patch_table: bool) {
        let (_folder, path) = folder();
        let mut bytes = whole();
        let mut start = 64;
        for _ in 0..record {
            start += u64::from_le_bytes(bytes[start + 24..start + 32].try_into().unwrap()) as usize;
        }
        bytes[start + at] = value;
        if patch_table {
            bytes[start + 64 + 4..start + 64 + 16].copy_from_slice(&table[4..]);
        }
        let sections = u32::from_le_bytes(bytes[start + 16..start + 20].try_into().unwrap()) as usize;
        let end = (start + 64 + (16 * sections).next_multiple_of(64)).min(bytes.len());
        let signed = [&bytes[start..start + 56], &bytes[(start + 64).min(end)..end]].concat();
        let checksum = xxhash_rust::xxh3::xxh3_64(&signed);
        bytes[start + 56..start + 64].copy_from_slice(&checksum.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        let _ = read_all(&path);
        fs::rename(&path, partial_name(&path)).unwrap();
        let _ = open(&path);
    }

    #[test]
    fn noise_is_no_file(noise: Vec<u8>, keep in 0usize..256) {
        let (_folder, path) = folder();
        let bytes = whole();
        fs::write(&path, [&bytes[..keep], &noise].concat()).unwrap();
        prop_assert!(StoreFile::open(&path).is_err());
    }
}
