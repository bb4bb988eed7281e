//! Files that are either whole or not there.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file that could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong.
    pub source: io::Error,
}

impl FileError {
    /// An error about `path`.
    pub fn new(path: &Path, source: io::Error) -> Self {
        Self { path: path.into(), source }
    }

    /// An error about what is in `path`, or was to be.
    pub fn invalid(path: &Path, message: impl Into<String>) -> Self {
        Self::new(path, invalid(message))
    }
}

/// An error about contents.
pub fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

/// Where [`atomic_write`] has its caller write.
pub type Output<'a> = BufWriter<&'a File>;

/// Writes a file that appears under its name when it is complete, and not at all when anything fails.
///
/// The content goes to a temporary file in the same folder, to the disk, and is then renamed. A link is followed; what
/// is no regular file, such as a terminal, is written to directly.
///
/// # Errors
/// If `write` or the file system fails; the file that was there before stays.
pub fn atomic_write(path: &Path, write: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), FileError> {
    write_whole(path, write).map_err(|source| FileError::new(path, source))
}

fn write_whole(path: &Path, write: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let existing = fs::metadata(&target).ok();
    if existing.as_ref().is_some_and(|metadata| !metadata.is_file()) {
        return fill(&File::options().write(true).open(&target)?, write);
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // Dropping the temporary file on the way out removes it.
    let temporary = builder().tempfile_in(folder)?;
    fill(temporary.as_file(), write)?;
    if let Some(metadata) = existing {
        temporary.as_file().set_permissions(metadata.permissions())?;
    }
    temporary.as_file().sync_all()?;
    temporary.persist(&target).map_err(|error| error.error)?;
    sync_folder(folder);
    Ok(())
}

fn fill(file: &File, write: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    let mut output = BufWriter::new(file);
    let result = write(&mut output).and_then(|()| output.flush());
    if result.is_err() {
        // Dropping the buffer would write what is in it.
        let _ = output.into_parts();
    }
    result
}

/// Temporary files with the permissions of ordinary ones.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".radiosity-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

/// Has the new name survive a power cut, where the system can do that; the content is safe already.
pub(crate) fn sync_folder(folder: &Path) {
    if cfg!(unix) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        atomic_write(&path, |out| out.write_all(b"first")).unwrap();
        let failed = atomic_write(&path, |out| {
            out.write_all(&[b'x'; 100_000])?;
            Err(io::Error::other("no"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("a.txt: no"));
        assert_eq!(fs::read(&path).unwrap(), b"first");
        atomic_write(&path, |out| out.write_all(b"second")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn no_folder_no_file() {
        let folder = tempfile::tempdir().unwrap();
        assert!(atomic_write(&folder.path().join("none/a.txt"), |_| Ok(())).is_err());
        assert!(atomic_write(folder.path(), |_| Ok(())).is_err());
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("b.txt"));
        fs::write(&path, "first").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        atomic_write(&link, |out| out.write_all(b"second")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        atomic_write(Path::new("/dev/null"), |out| out.write_all(b"gone")).unwrap();
    }
}
