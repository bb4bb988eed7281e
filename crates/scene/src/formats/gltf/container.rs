//! The outermost layer: chunks of a .glb, JSON, version, required extensions.

use ::gltf::json::{self, Root};

use crate::formats::skip_blanks;

/// What is wrong with the file as a whole.
pub(super) struct Fault {
    pub element: String,
    pub message: String,
}

fn fault(element: &str, message: impl Into<String>) -> Fault {
    Fault { element: element.into(), message: message.into() }
}

/// Extensions that are read, or that may be ignored with no more loss than the materials' findings tell.
pub(super) const UNDERSTOOD: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "EXT_texture_avif",
    "EXT_texture_webp",
];

/// Extensions that hide the vertices.
const COMPRESSED: &[&str] = &["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The JSON of a file and the binary chunk that a .glb carries.
pub(super) fn open(bytes: &[u8]) -> Result<(Root, Option<&[u8]>), Fault> {
    let (text, chunk) = if bytes.starts_with(b"glTF") { split(bytes)? } else { (skip_blanks(bytes), None) };
    let root: Root = json::deserialize::from_slice(text).map_err(|error| unreadable(text, &error))?;
    refuse_version(&root.asset.version)?;
    refuse_requirements(&root)?;
    Ok((root, chunk))
}

/// Says what is wrong with JSON that does not fit, the version first: glTF 1 differs throughout.
fn unreadable(text: &[u8], error: &json::Error) -> Fault {
    if error.to_string().starts_with("number out of range") {
        let (line, column) = (error.line(), error.column());
        let place = format!("the number that ends at line {line}, column {column}");
        return fault("JSON", format!("{place} is out of range; correct it to one below 3.4e38"));
    }
    let value: Option<serde_json::Value> = serde_json::from_slice(text).ok();
    let version = value.as_ref().and_then(|value| value["asset"]["version"].as_str());
    match version.map(refuse_version) {
        Some(Err(fault)) => fault,
        _ => fault("JSON", format!("it is damaged or not glTF 2.0 ({error}); export the file again")),
    }
}

fn refuse_version(version: &str) -> Result<(), Fault> {
    if version.starts_with("2.") {
        return Ok(());
    }
    Err(fault("asset", format!("the file is glTF {version} and only glTF 2.0 is read; convert or export it again")))
}

fn refuse_requirements(root: &Root) -> Result<(), Fault> {
    for name in &root.extensions_required {
        if COMPRESSED.contains(&name.as_str()) {
            let message = format!("the meshes are compressed with {name}; export the file without mesh compression");
            return Err(fault("extensionsRequired", message));
        }
        if !UNDERSTOOD.contains(&name.as_str()) {
            let message = format!("the file needs {name}, which is not supported; export it without that extension");
            return Err(fault("extensionsRequired", message));
        }
    }
    Ok(())
}

/// The JSON and binary chunks of a .glb.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(fault("header", "the file ends within its header; copy or export it again"));
    };
    if version != 2 {
        let message = format!("the file is binary glTF {version} and only version 2 is read; export it again");
        return Err(fault("header", message));
    }
    let Some(content) = bytes.get(12..length) else {
        let message = format!("it promises {length} bytes and the file has {}; copy or export it again", bytes.len());
        return Err(fault("header", message));
    };
    let json = chunk(content, "JSON chunk")?;
    if json.kind != b"JSON" {
        return Err(fault("JSON chunk", "the file does not begin with JSON; export it again"));
    }
    if json.rest.is_empty() {
        return Ok((json.payload, None));
    }
    let binary = chunk(json.rest, "BIN chunk")?;
    // Chunks of unknown kinds are to be skipped, says the specification.
    Ok((json.payload, (binary.kind == b"BIN\0").then_some(binary.payload)))
}

/// A chunk and what follows it.
struct Chunk<'a> {
    kind: &'a [u8],
    payload: &'a [u8],
    rest: &'a [u8],
}

fn chunk<'a>(bytes: &'a [u8], name: &str) -> Result<Chunk<'a>, Fault> {
    let cut_short = || fault(name, "the file ends within the chunk; copy or export it again");
    let length = word(bytes, 0).ok_or_else(cut_short)?;
    let kind = bytes.get(4..8).ok_or_else(cut_short)?;
    let (payload, rest) = bytes[8..].split_at_checked(length).ok_or_else(cut_short)?;
    Ok(Chunk { kind, payload, rest })
}

/// A little-endian 32-bit number.
fn word(bytes: &[u8], offset: usize) -> Option<usize> {
    let word = bytes.get(offset..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word) as usize)
}
