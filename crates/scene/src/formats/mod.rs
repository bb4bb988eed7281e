//! Files that scenes are read from: glTF 2.0 (.glb, .gltf), Wavefront OBJ (.obj), STL (.stl), PLY (.ply) and View3D
//! (.vs3).
//!
//! glTF and OBJ describe radiance and intensity in photometric units (nits, candela, lux). The numbers are kept:
//! a file in photometric units gives irradiance in lux, one that was written in watts gives W/m2.

mod colour;
mod folder;
pub mod gltf;
mod mesh;
mod names;
pub mod obj;
pub mod ply;
mod polygon;
pub mod stl;
mod texture;
mod unit;
pub mod view3d;

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

pub use texture::srgb;
pub use unit::Unit;

use crate::model::{Finding, Material, Scene, SceneError};

/// How to read a file.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// The length that the number 1 in the file stands for. glTF files are in metres unless their author erred; the
    /// others do not say.
    pub unit: Unit,
    /// Whether surfaces reflect and emit on both sides, whatever the file says. `None` follows glTF's `doubleSided`,
    /// and makes all surfaces of an OBJ file two-sided, because OBJ winding cannot be relied upon. Surfaces of other
    /// files are one-sided.
    pub two_sided: Option<bool>,
    /// More faces than this, instances counted singly, are refused before they fill the memory.
    pub max_faces: usize,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { unit: Unit::Metre, two_sided: None, max_faces: 20_000_000 }
    }
}

/// Reads a scene from a `.glb`, `.gltf`, `.obj`, `.stl`, `.ply` or `.vs3` file, told apart by content and extension.
///
/// What had to be approximated is in [`Scene::findings`]; whether the scene can be lit is for [`Scene::validate`].
///
/// # Errors
/// If the file is missing, damaged, of another kind, or holds nothing to light.
///
/// # Example
/// ```no_run
/// use radiosity_scene::{LoadOptions, load};
/// let scene = load("room.glb", &LoadOptions::default())?;
/// for finding in scene.findings() {
///     println!("{finding}");
/// }
/// # Ok::<(), radiosity_scene::SceneError>(())
/// ```
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let bytes = read(path)?;
    match kind(path, &bytes)? {
        Kind::Gltf => gltf::parse(path, &bytes, options),
        Kind::Obj => obj::parse(path, &bytes, options),
        Kind::Stl => stl::parse(path, &bytes, options),
        Kind::Ply => ply::parse(path, &bytes, options),
        Kind::View3d => view3d::parse(path, &bytes, options),
    }
}

/// Refuses options that no file can be read with.
fn check(options: &LoadOptions, file: &str) -> Result<(), SceneError> {
    let metres = options.unit.metres();
    if metres.is_finite() && metres > 0.0 {
        return Ok(());
    }
    let message = format!("a unit of {metres} m makes no sense; give m, cm, mm, in, ft, km or a positive number");
    Err(SceneError::new(file, "unit", message))
}

enum Kind {
    Gltf,
    Obj,
    Stl,
    Ply,
    View3d,
}

/// The bytes of a regular file that is not empty.
fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    let fail = |message: String| SceneError::new(path.display().to_string(), "", message);
    let metadata = fs::metadata(path).map_err(|error| fail(unreadable(&error)))?;
    if metadata.is_dir() {
        return Err(fail("this is a directory; name a scene file in it".into()));
    }
    if !metadata.is_file() {
        return Err(fail("this is a device or pipe; name a regular file".into()));
    }
    let bytes = fs::read(path).map_err(|error| fail(unreadable(&error)))?;
    if bytes.is_empty() {
        return Err(fail("the file is empty; export or copy it again".into()));
    }
    Ok(bytes)
}

/// A sentence for a file that cannot be opened.
fn unreadable(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "the file does not exist; check the path".into(),
        ErrorKind::PermissionDenied => "the file may not be read; check its permissions".into(),
        _ => format!("the file cannot be read ({error}); check the disk and the path"),
    }
}

fn kind(path: &Path, bytes: &[u8]) -> Result<Kind, SceneError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if bytes.starts_with(b"glTF") {
        return Ok(Kind::Gltf);
    }
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Ok(Kind::Ply);
    }
    let refuse = |message: String| Err(SceneError::new(path.display().to_string(), "", message));
    let content = content(bytes);
    match extension.as_str() {
        "glb" | "gltf" if content == JSON => Ok(Kind::Gltf),
        "glb" | "gltf" => {
            refuse(format!("the file is named .{extension} but holds {content}, not glTF; export or fetch it again"))
        }
        "obj" if content == TEXT => Ok(Kind::Obj),
        "obj" => refuse(format!("the file is named .obj but holds {content}, not Wavefront OBJ; export it again")),
        "ply" => refuse(format!("the file is named .ply but holds {content}, not a PLY mesh; export it again")),
        "stl" if content == TEXT || content == BINARY => Ok(Kind::Stl),
        "stl" => refuse(format!("the file is named .stl but holds {content}, not an STL mesh; export it again")),
        "vs3" if content == TEXT => Ok(Kind::View3d),
        "vs3" => refuse(format!("the file is named .vs3 but holds {content}, not View3D's text; export it again")),
        _ => refuse(format!(
            "the file holds {content}, and only .glb, .gltf, .obj, .stl, .ply and .vs3 are read; export the scene as \
             glTF binary (.glb)"
        )),
    }
}

const JSON: &str = "JSON";
const TEXT: &str = "text";
const BINARY: &str = "unknown binary data";

/// What a file without glTF's signature looks like.
fn content(bytes: &[u8]) -> &'static str {
    const SIGNATURES: [(&[u8], &str); 8] = [
        (b"version https://git-lfs", "a Git LFS pointer (run git lfs pull)"),
        (b"PK\x03\x04", "a zip archive (unpack it first)"),
        (b"\x1f\x8b", "a gzip archive (unpack it first)"),
        (b"Kaydara FBX", "an FBX scene"),
        (b"BLENDER", "a Blender scene"),
        (b"PXR-USDC", "a USD scene"),
        (b"<", "a web page or XML"),
        (b"{", JSON),
    ];
    let start = skip_blanks(bytes);
    let known = SIGNATURES.iter().find(|(signature, _)| start.starts_with(signature));
    match known {
        Some((_, name)) => name,
        None if bytes[..bytes.len().min(4096)].contains(&0) => BINARY,
        None => TEXT,
    }
}

/// The bytes after a byte-order mark and white space.
fn skip_blanks(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start()
}

/// The name of the only surface of a file that gives it none.
fn surface_name(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The material of files that have none, and the finding that says so.
fn unknown_material(two_sided: Option<bool>) -> (Material, Finding) {
    let grey = Material::new("none", &[colour::UNKNOWN_REFLECTANCE; 3], &[0.0; 3]);
    let message = "files of this kind have no materials; reflectance 0.5 was taken";
    let material = Material { two_sided: two_sided.unwrap_or(false), ..grey };
    (material, Finding::note("no-material", "", message))
}

/// Refuses more faces than the options allow.
fn check_faces(faces: usize, options: &LoadOptions, file: &str) -> Result<(), SceneError> {
    if faces <= options.max_faces {
        return Ok(());
    }
    let message = format!("the file has more than {} faces; simplify it or raise the limit", options.max_faces);
    Err(SceneError::new(file, "", message))
}

/// The file's own name, for the scene.
fn scene_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
