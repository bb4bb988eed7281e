//! A file that is built block by block, and goes on where it was cut off.

use crate::error::StoreError;
use crate::files::sync_folder;
use crate::format::{HEAD, Identity, Place, Preamble, RecordHead, Settings, role};
use crate::numbers::Element;
use crate::ordered::Keep;
use crate::section::{Section, Stored};
use crate::store_file::StoreFile;
use crate::writer::{State, Writer};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use xxhash_rust::xxh3::Xxh3;

/// What is older than this when a block has been appended is brought to the disk.
const SYNC_AFTER: Duration = Duration::from_secs(1);

/// A file in the making, locked against other processes.
///
/// Killing the process loses the blocks that were not appended yet; a power cut also those of about the last second.
pub struct Checkpoint {
    target: PathBuf,
    partial: PathBuf,
    writer: Writer<File>,
    /// Where the sections of the blocks are that were there when it was opened.
    resumed: Vec<Vec<Place>>,
    blocks: usize,
    synced: Instant,
}

/// What there is to build.
pub enum Opened {
    /// Nothing: the file is there and is what was asked for.
    Whole(StoreFile),
    /// All, or what is missing.
    Building(Box<Checkpoint>),
}

/// Where a file is while it is built: `F.partial` beside `F`.
pub fn partial_name(target: &Path) -> PathBuf {
    let mut name = target.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

impl Checkpoint {
    /// Opens `target` if it is whole; else begins, or goes on, building it. The first record holds the identity's
    /// settings and then `head`.
    ///
    /// # Errors
    /// If the file, whole or partial, is of another identity, or of another program, or damaged at its beginning, if
    /// another process is building it, or if the system refuses.
    pub fn open(target: &Path, identity: &Identity, head: &[Section]) -> Result<Opened, StoreError> {
        let target = fs::canonicalize(target).unwrap_or_else(|_| target.into());
        let partial = partial_name(&target);
        loop {
            if target.exists() {
                return whole(&target, identity).map(Opened::Whole);
            }
            if let Some(file) = locked(&partial)? {
                let checkpoint = Self::resume(target, partial, file, identity, head)?;
                return Ok(Opened::Building(Box::new(checkpoint)));
            }
            // While this process waited for the lock another one finished the file.
        }
    }

    fn resume(
        target: PathBuf,
        partial: PathBuf,
        file: File,
        identity: &Identity,
        head: &[Section],
    ) -> Result<Self, StoreError> {
        let found = Prefix::read(&file, &partial, identity)?;
        let system = |e| StoreError::system(&partial, e);
        let (state, resumed) = match found {
            Some(Prefix { state, blocks }) => (state, blocks),
            None => {
                file.set_len(0).map_err(system)?;
                (&file).rewind().map_err(system)?;
                (Writer::begin(&file, identity, head).map_err(system)?.state, Vec::new())
            }
        };
        // What follows the last whole block was being written when the process ended.
        file.set_len(state.length).map_err(system)?;
        (&file).seek(SeekFrom::Start(state.length)).map_err(system)?;
        let blocks = resumed.len();
        let writer = Writer { out: file, state };
        Ok(Self { target, partial, writer, resumed, blocks, synced: Instant::now() })
    }

    /// How many blocks there are.
    pub fn blocks(&self) -> usize {
        self.blocks
    }

    /// How many there were when it was opened.
    pub fn resumed(&self) -> usize {
        self.resumed.len()
    }

    /// Where it is while it is built.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// A section of a block that was there when the file was opened, copied.
    ///
    /// # Errors
    /// If there is no such section of this type, or of the system.
    pub fn section<T: Element>(&mut self, block: usize, section: usize) -> Result<Vec<T>, StoreError> {
        let place = self.resumed.get(block).and_then(|places| places.get(section)).filter(|p| p.code == T::CODE);
        let Some(&Place { start, bytes, .. }) = place else {
            let what = format!("block {block} has no such section {section}; delete the file to start over");
            return Err(StoreError::damaged(&self.partial, what));
        };
        let mut values = vec![T::zeroed(); bytes / size_of::<T>()];
        let file = &mut self.writer.out;
        let mut read = || {
            file.seek(SeekFrom::Start(start as u64))?;
            file.read_exact(bytemuck::cast_slice_mut(&mut values))?;
            file.seek(SeekFrom::Start(self.writer.state.length))
        };
        read().map_err(|e| StoreError::system(&self.partial, e))?;
        Ok(values)
    }

    /// Appends a block. What cannot be written whole is taken back, so that the file can be gone on with.
    ///
    /// # Errors
    /// Of the system.
    pub fn append(&mut self, block: &impl Stored) -> Result<(), StoreError> {
        self.record(role::BLOCK, &block.sections())?;
        self.blocks += 1;
        Ok(())
    }

    fn record(&mut self, role: u32, sections: &[Section]) -> Result<(), StoreError> {
        let mut written = self.writer.append(role, sections);
        if written.is_ok() && self.synced.elapsed() >= SYNC_AFTER {
            written = self.writer.out.sync_data();
            self.synced = Instant::now();
        }
        written.map_err(|e| self.taken_back(e))
    }

    /// Drops what was written of a record that could not be.
    fn taken_back(&mut self, error: io::Error) -> StoreError {
        let length = self.writer.state.length;
        let _ = self.writer.out.set_len(length).and_then(|()| self.writer.out.seek(SeekFrom::Start(length)));
        StoreError::system(&self.partial, error)
    }

    /// Appends the last records, `(role, sections)`, has the file appear under its name, and maps it.
    ///
    /// # Errors
    /// Of the system.
    pub fn finish(mut self, last: &[(u32, Vec<Section>)]) -> Result<StoreFile, StoreError> {
        for (role, sections) in last {
            self.record(*role, sections)?;
        }
        let end = |writer: &mut Writer<File>| {
            writer.end()?;
            writer.out.sync_all()
        };
        end(&mut self.writer).map_err(|e| self.taken_back(e))?;
        fs::rename(&self.partial, &self.target).map_err(|e| StoreError::system(&self.target, e))?;
        sync_folder(self.target.parent().unwrap_or(Path::new(".")));
        StoreFile::open(&self.target)
    }
}

impl<B: Stored + Send> Keep<B> for Checkpoint {
    fn kept(&self) -> usize {
        self.blocks
    }

    fn keep(&mut self, block: B) -> Result<(), StoreError> {
        self.append(&block)
    }
}

/// A file that is there, if it is what was asked for.
fn whole(target: &Path, identity: &Identity) -> Result<StoreFile, StoreError> {
    let file = StoreFile::open(target)?;
    if file.is(identity) {
        return Ok(file);
    }
    let differs = identity.differences(file.settings());
    Err(StoreError::different(target, format!("the file is of something else: {differs}; {DISCARD}")))
}

const DISCARD: &str = "delete it or name another file";

/// The partial file, locked; none if it has become whole meanwhile.
fn locked(partial: &Path) -> Result<Option<File>, StoreError> {
    let system = |e| StoreError::system(partial, e);
    let file = File::options().read(true).write(true).create(true).truncate(false).open(partial).map_err(system)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(StoreError::Busy { path: partial.into() }),
        // Some network file systems have no locks.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => {}
        Err(TryLockError::Error(e)) => return Err(system(e)),
    }
    Ok(is_at(&file, partial).then_some(file))
}

/// Whether a file is still what a name stands for.
#[cfg(unix)]
fn is_at(file: &File, name: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let key = |m: io::Result<fs::Metadata>| m.ok().map(|m| (m.dev(), m.ino()));
    key(file.metadata()) == key(fs::metadata(name))
}

#[cfg(not(unix))]
fn is_at(_: &File, name: &Path) -> bool {
    name.exists()
}

/// The whole records at the beginning of a partial file.
struct Prefix {
    state: State,
    blocks: Vec<Vec<Place>>,
}

impl Prefix {
    /// None if there is not even the first record.
    fn read(file: &File, path: &Path, identity: &Identity) -> Result<Option<Self>, StoreError> {
        let system = |e| StoreError::system(path, e);
        let length = file.metadata().map_err(system)?.len();
        let mut source = Source { reader: BufReader::with_capacity(1 << 20, file), path, length };
        let Some(first) = source.head(0)? else { return Ok(None) };
        if first == [0; HEAD] {
            // Written as the power went.
            return Ok(None);
        }
        let preamble = Preamble::decode(&first)
            .map_err(|what| StoreError::damaged(path, format!("{what}; {DISCARD}, to start over")))?;
        let mut state = State::after(preamble);
        let Some(read) = source.record(&mut state, role::HEAD)? else { return Ok(None) };
        if preamble != Preamble::of(identity) {
            let there: Settings = serde_json::from_slice(&read.first).unwrap_or_default();
            let differs = identity.differences(&there);
            let what = format!("it was begun with other settings: {differs}; {DISCARD}, to start over");
            return Err(StoreError::different(path, what));
        }
        let mut blocks = Vec::new();
        while let Some(read) = source.record(&mut state, role::BLOCK)? {
            blocks.push(read.places);
        }
        Ok(Some(Self { state, blocks }))
    }
}

/// A partial file, read from the front without mapping it.
struct Source<'a> {
    reader: BufReader<&'a File>,
    path: &'a Path,
    length: u64,
}

/// A record that is whole.
struct Whole {
    places: Vec<Place>,
    /// The first section, if it is short.
    first: Vec<u8>,
}

impl Source<'_> {
    /// The next 64 bytes; none at the end.
    fn head(&mut self, at: u64) -> Result<Option<[u8; HEAD]>, StoreError> {
        let mut bytes = [0; HEAD];
        if self.length < at + HEAD as u64 {
            return Ok(None);
        }
        self.fill(&mut bytes)?;
        Ok(Some(bytes))
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), StoreError> {
        self.reader.read_exact(bytes).map_err(|e| StoreError::system(self.path, e))
    }

    /// The next record if it is whole and of a role; moves `state` past it.
    fn record(&mut self, state: &mut State, role: u32) -> Result<Option<Whole>, StoreError> {
        let Some(bytes) = self.head(state.length)? else { return Ok(None) };
        let Some(head) = RecordHead::decode(&bytes) else { return Ok(None) };
        let left = self.length - state.length;
        let belongs = head.number == state.records && head.file == state.preamble.checksum;
        if !belongs || head.role != role || head.length > left {
            return Ok(None);
        }
        if ((HEAD + head.table_length()) as u64) > left {
            return Ok(None);
        }
        let mut table = vec![0; head.table_length()];
        self.fill(&mut table)?;
        let Some(places) = head.places(state.length, &bytes, &table) else { return Ok(None) };
        let data = head.length - (HEAD + table.len()) as u64;
        let (checksum, start) = self.checksum(data)?;
        if checksum != head.data_checksum {
            return Ok(None);
        }
        let first = start[..places.first().map_or(0, |p| p.bytes.min(start.len()))].to_vec();
        state.add(&bytes, head.length);
        Ok(Some(Whole { places, first }))
    }

    /// The checksum of the next bytes, and those of them that fit a buffer.
    fn checksum(&mut self, bytes: u64) -> Result<(u64, Vec<u8>), StoreError> {
        let (mut hash, mut left, mut start) = (Xxh3::new(), bytes, Vec::new());
        let mut buffer = vec![0; bytes.min(1 << 20) as usize];
        while left > 0 {
            let part = &mut buffer[..left.min(1 << 20) as usize];
            self.reader.read_exact(part).map_err(|e| StoreError::system(self.path, e))?;
            hash.update(part);
            if start.is_empty() {
                start = part.to_vec();
            }
            left -= part.len() as u64;
        }
        Ok((hash.digest(), start))
    }
}
