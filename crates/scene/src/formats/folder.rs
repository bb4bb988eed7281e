//! The folder a scene file lies in: the only place from which other files are read.
//!
//! A scene file may come from anywhere, so that the names in it must not reach outside its own folder: not by `..`,
//! not as absolute paths, not through percent encoding, not through links.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// Exporters disagree about padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A folder to read from and never to leave.
pub(super) struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder of a scene file.
    pub fn of(file: &Path) -> Self {
        let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
        Self { path: parent.unwrap_or(Path::new(".")).to_path_buf() }
    }

    /// The bytes of a glTF URI: a data URI or a percent-encoded relative path. At most `limit` bytes are read.
    pub fn read_uri(&self, uri: &str, limit: u64) -> Result<Vec<u8>, String> {
        match uri.strip_prefix("data:") {
            Some(data) => decode_data_uri(data),
            None => self.read(&percent_decoded(uri)?, limit),
        }
    }

    /// The first `limit` bytes of a file named relative to this folder.
    pub fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, String> {
        let path = self.resolve(name)?;
        let file = File::open(&path).map_err(|error| missing(name, &error))?;
        let mut bytes = Vec::new();
        file.take(limit).read_to_end(&mut bytes).map_err(|error| missing(name, &error))?;
        Ok(bytes)
    }

    /// The true path of a regular file within this folder.
    fn resolve(&self, name: &str) -> Result<PathBuf, String> {
        refuse_escape(name)?;
        let path = self.path.join(name).canonicalize().map_err(|error| missing(name, &error))?;
        let folder = self.path.canonicalize().map_err(|error| missing(name, &error))?;
        if !path.starts_with(&folder) {
            return Err(format!("'{name}' is a link that leads out of the scene's folder; copy the file there"));
        }
        if !path.is_file() {
            return Err(format!("'{name}' is not a regular file"));
        }
        Ok(path)
    }
}

fn refuse_escape(name: &str) -> Result<(), String> {
    let outside = "only files below the scene's own folder are read; move it there and name it relative to the scene";
    if name.is_empty() || name.chars().any(char::is_control) {
        return Err(format!("{name:?} is not a file name"));
    }
    if name.contains(':') {
        return Err(format!("'{name}' has a scheme or drive; {outside}"));
    }
    if name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..") {
        return Err(format!("'{name}' leads out of the folder; {outside}"));
    }
    Ok(())
}

fn missing(name: &str, error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => format!("'{name}' does not exist in the scene's folder; put it there"),
        _ => format!("'{name}' cannot be read ({error})"),
    }
}

fn percent_decoded(uri: &str) -> Result<Cow<'_, str>, String> {
    percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| format!("'{uri}' does not decode to UTF-8; rename the file"))
}

/// The payload of a data URI after `data:`, such as `application/octet-stream;base64,AAAA`.
fn decode_data_uri(data: &str) -> Result<Vec<u8>, String> {
    let (kind, payload) = data.split_once(',').ok_or("its data URI has no comma; export the file again")?;
    if !kind.ends_with(";base64") {
        return Err("its data URI is not base64; export the file again".into());
    }
    BASE64.decode(payload).map_err(|error| format!("its data URI is damaged ({error}); export the file again"))
}

/// A URI for messages; data URIs run to megabytes.
pub(super) fn abbreviated(uri: &str) -> String {
    match uri.strip_prefix("data:") {
        Some(_) => "data URI".into(),
        None => format!("'{uri}'"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(uri: &str) -> String {
        Folder { path: "/tmp".into() }.read_uri(uri, 10).unwrap_err()
    }

    #[test]
    fn paths_out_of_the_folder_are_refused() {
        for uri in ["../a.bin", "a/../../b", "%2e%2e/a.bin", "..%2Fa.bin", "a\\..\\..\\b", "%2E./x"] {
            let message = refused(uri);
            assert!(message.contains("leads out of the folder") || message.contains("does not exist"), "{message}");
        }
        for uri in ["/etc/passwd", "%2fetc/passwd", "\\\\server\\share"] {
            assert!(refused(uri).contains("leads out of the folder"), "{uri}");
        }
        for uri in ["http://a/b.bin", "file:///etc/passwd", "C:/a.bin", "C%3A/a.bin"] {
            assert!(refused(uri).contains("has a scheme"), "{uri}");
        }
        for uri in ["", "%00", "a%0Ab", "%ff"] {
            assert!(refused(uri).contains("not a file name") || refused(uri).contains("UTF-8"), "{uri}");
        }
    }

    #[test]
    fn double_encoding_stays_a_name() {
        assert!(refused("%252e%252e/a.bin").contains("does not exist"));
    }

    #[test]
    fn data_uris_decode_with_and_without_padding() {
        let folder = Folder { path: ".".into() };
        for uri in ["data:application/octet-stream;base64,AAE=", "data:;base64,AAE"] {
            assert_eq!(folder.read_uri(uri, 0), Ok(vec![0, 1]));
        }
        for uri in ["data:", "data:text/plain,hello", "data:;base64,!!"] {
            assert!(folder.read_uri(uri, 0).is_err(), "{uri}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_may_not_lead_out() {
        let base = std::env::temp_dir().join(format!("radiosity-folder-{}", std::process::id()));
        let inner = base.join("scene");
        std::fs::create_dir_all(&inner).unwrap();
        std::fs::write(base.join("secret"), "secret").unwrap();
        std::fs::write(inner.join("own data"), "own").unwrap();
        let _ = std::os::unix::fs::symlink(base.join("secret"), inner.join("link"));
        let _ = std::os::unix::fs::symlink(inner.join("own data"), inner.join("alias"));
        let folder = Folder::of(&inner.join("room.gltf"));
        assert!(folder.read_uri("link", 10).unwrap_err().contains("link that leads out"));
        assert_eq!(folder.read_uri("own%20data", 10), Ok(b"own".to_vec()));
        assert_eq!(folder.read_uri("alias", 2), Ok(b"ow".to_vec()));
        std::fs::remove_dir_all(base).unwrap();
    }
}
