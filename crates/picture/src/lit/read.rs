//! Reading of lit models.
//!
//! Only files as this crate writes them are read; whatever differs is an error that says what, not a guess.

use std::f64::consts::PI;
use std::fs;
use std::io;
use std::path::Path;

use glam::{DQuat, DVec3};
use gltf::binary::Glb;
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked::Valid;
use gltf::json::{self, Accessor, Index, Root};
use radiosity_geometry::Patches;
use radiosity_scene::Camera;
use serde::de::DeserializeOwned;

use super::{Extras, FileExtras, LitData, MeshExtras, QUANTITIES, VERSION, attribute_names};
use radiosity_store::files::{FileError, invalid};

/// Reads a lit model back; `None` if the file is some other glTF.
///
/// # Errors
/// If the file cannot be read, is no glTF, or is a lit model with anything amiss.
pub fn read_lit(path: &Path) -> Result<Option<LitData>, FileError> {
    let decoded = fs::read(path).and_then(|bytes| decode(&bytes));
    decoded.map_err(|error| FileError::new(path, error))
}

pub(super) fn decode(bytes: &[u8]) -> io::Result<Option<LitData>> {
    let (json, bin) = if bytes.starts_with(b"glTF") { split(bytes)? } else { (bytes.to_vec(), None) };
    let value: json::Value = serde_json::from_slice(&json).map_err(|e| invalid(format!("no glTF: {e}")))?;
    if value.get("asset").is_none() {
        return Err(invalid("no glTF: it has no asset"));
    }
    if value.get("extras").and_then(|extras| extras.get("radiosity")).is_none() {
        return Ok(None);
    }
    drop(value);
    let root: Root = serde_json::from_slice(&json)?;
    let file: FileExtras = extras(&root.extras, "the file")?;
    if file.version != VERSION {
        return Err(invalid(format!("a lit model of version {}, where {VERSION} is known", file.version)));
    }
    let bin = bin.unwrap_or_default();
    let mut reader = Reader { root: &root, bin: &bin, bands: file.bands.len(), found: Vec::new() };
    for mesh in &root.meshes {
        reader.read_mesh(mesh, file.surfaces.len())?;
    }
    let found = std::mem::take(&mut reader.found);
    let cameras = root.nodes.iter().filter_map(|node| reader.camera(node).transpose()).collect::<io::Result<_>>()?;
    let data = collect(file, found, cameras)?;
    data.model().check().map_err(invalid)?;
    Ok(Some(data))
}

/// The JSON and the binary chunk of a binary glTF.
fn split(bytes: &[u8]) -> io::Result<(Vec<u8>, Option<Vec<u8>>)> {
    let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if length.map(|length| length as usize) != Some(bytes.len()) {
        return Err(invalid("the file is cut off, or has something after its end"));
    }
    let glb = Glb::from_slice(bytes).map_err(|error| invalid(error.to_string()))?;
    Ok((glb.json.into_owned(), glb.bin.map(|bin| bin.into_owned())))
}

fn extras<T: DeserializeOwned>(extras: &json::Extras, of: &str) -> io::Result<T> {
    let raw = extras.as_ref().ok_or_else(|| invalid(format!("{of} has no extras")))?;
    let ours: Extras<T> = serde_json::from_str(raw.get()).map_err(|e| invalid(format!("extras of {of}: {e}")))?;
    Ok(ours.radiosity)
}

/// One patch as it was found.
struct Found {
    id: u32,
    surface: u32,
    face: u32,
    polygon: [DVec3; 4],
    /// Four quantities of all bands.
    values: Vec<f64>,
}

struct Reader<'a> {
    root: &'a Root,
    bin: &'a [u8],
    bands: usize,
    found: Vec<Found>,
}

impl Reader<'_> {
    fn read_mesh(&mut self, mesh: &json::Mesh, n_surfaces: usize) -> io::Result<()> {
        let name = mesh.name.as_deref().unwrap_or("");
        let in_mesh = |error: io::Error| invalid(format!("mesh '{name}': {error}"));
        let MeshExtras { surface } = extras(&mesh.extras, &format!("mesh '{name}'"))?;
        if surface as usize >= n_surfaces {
            return Err(in_mesh(invalid(format!("there is no surface {surface}"))));
        }
        let [primitive] = &mesh.primitives[..] else { return Err(in_mesh(invalid("one primitive was expected"))) };
        self.read_primitive(primitive, surface).map_err(in_mesh)
    }

    fn read_primitive(&mut self, primitive: &Primitive, surface: u32) -> io::Result<()> {
        let positions = self.attribute(primitive, Semantic::Positions, 3)?;
        let n = positions.len() / 3;
        let ids = self.ids(primitive, "PATCH", n)?;
        let faces = self.ids(primitive, "FACE", n)?;
        let values = self.quantities(primitive, n)?;
        let width = QUANTITIES.len() * self.bands;
        let mut indices = Vec::with_capacity(2 * n);
        let mut first = 0;
        for vertices in ids.chunk_by(|a, b| a == b) {
            let (id, count) = (vertices[0], vertices.len());
            let own = &values[first * width..(first + count) * width];
            let is_one = own.chunks(width.max(1)).all(|v| v == &own[..width])
                && faces[first..first + count].iter().all(|face| *face == faces[first]);
            if !(3..=4).contains(&count) || !is_one {
                return Err(invalid(format!("the vertices of patch {id} are not three or four of one kind")));
            }
            let corner = |k: usize| {
                let i = 3 * (first + k.min(count - 1));
                DVec3::new(positions[i].into(), positions[i + 1].into(), positions[i + 2].into())
            };
            let values = own[..width].iter().map(|&v| f64::from(v)).collect();
            self.found.push(Found { id, surface, face: faces[first], polygon: [0, 1, 2, 3].map(corner), values });
            indices.extend(super::fan(first as u32, count as u32));
            first += count;
        }
        if self.indices(primitive)? != indices {
            return Err(invalid("the triangles are not those of the patches"));
        }
        Ok(())
    }

    /// All quantities of each vertex, one after the other.
    fn quantities(&self, primitive: &Primitive, n: usize) -> io::Result<Vec<f32>> {
        let width = QUANTITIES.len() * self.bands;
        // What is not there cannot be long: this many bands have as many attributes.
        let mut columns = Vec::new();
        for quantity in QUANTITIES {
            let (names, components) = attribute_names(quantity, self.bands);
            for name in names {
                let column = self.attribute(primitive, Semantic::Extras(name.clone()), components)?;
                if column.len() != n * components {
                    return Err(invalid(format!("_{name} is not as long as POSITION")));
                }
                columns.push((components, column));
            }
        }
        let mut values = Vec::with_capacity(n * width);
        for i in 0..n {
            values.extend(columns.iter().flat_map(|(m, column)| &column[i * m..(i + 1) * m]));
        }
        Ok(values)
    }

    /// The finite floats of an attribute.
    fn attribute(&self, primitive: &Primitive, semantic: Semantic, components: usize) -> io::Result<Vec<f32>> {
        let type_ = if components == 3 { Type::Vec3 } else { Type::Scalar };
        let bytes = self.bytes(primitive, &semantic, ComponentType::F32, type_)?;
        let floats: Vec<f32> = words(bytes).map(f32::from_le_bytes).collect();
        match floats.iter().all(|f| f.is_finite()) {
            true => Ok(floats),
            false => Err(invalid(format!("{} holds a number that is not finite", semantic.to_string()))),
        }
    }

    fn ids(&self, primitive: &Primitive, name: &str, n: usize) -> io::Result<Vec<u32>> {
        let bytes = self.bytes(primitive, &Semantic::Extras(name.into()), ComponentType::U16, Type::Vec2)?;
        let ids: Vec<u32> = words(bytes).map(u32::from_le_bytes).collect();
        if ids.len() == n { Ok(ids) } else { Err(invalid(format!("_{name} is not as long as POSITION"))) }
    }

    fn indices(&self, primitive: &Primitive) -> io::Result<Vec<u32>> {
        let index = primitive.indices.ok_or_else(|| invalid("there are no indices"))?;
        let bytes = self.accessor(index, ComponentType::U32, Type::Scalar)?;
        Ok(words(bytes).map(u32::from_le_bytes).collect())
    }

    fn bytes(&self, primitive: &Primitive, name: &Semantic, of: ComponentType, type_: Type) -> io::Result<&[u8]> {
        let index = primitive.attributes.get(&Valid(name.clone()));
        let index = index.ok_or_else(|| invalid(format!("{} is missing", name.to_string())))?;
        self.accessor(*index, of, type_)
    }

    /// The bytes of a plain accessor of the type asked for.
    fn accessor(&self, index: Index<Accessor>, component: ComponentType, type_: Type) -> io::Result<&[u8]> {
        let accessor = self.root.accessors.get(index.value()).ok_or_else(|| invalid("an accessor is missing"))?;
        let fits = matches!(accessor.component_type, Valid(GenericComponentType(c)) if c == component)
            && matches!(accessor.type_, Valid(t) if t == type_)
            && accessor.sparse.is_none()
            && !accessor.normalized;
        let view = accessor.buffer_view.and_then(|view| self.root.buffer_views.get(view.value()));
        let view = view.filter(|view| fits && view.buffer.value() == 0 && view.byte_stride.is_none());
        let view = view.ok_or_else(|| invalid(format!("accessor {} is not as expected", index.value())))?;
        let size = (component.size() * type_.multiplicity()) as u64;
        let (skipped, start) = (accessor.byte_offset.unwrap_or_default().0, view.byte_offset.unwrap_or_default().0);
        let range = || {
            let length = accessor.count.0.checked_mul(size)?;
            if skipped.checked_add(length)? > view.byte_length.0 {
                return None;
            }
            let from = usize::try_from(start.checked_add(skipped)?).ok()?;
            let to = from.checked_add(usize::try_from(length).ok()?)?;
            self.bin.get(from..to)
        };
        range().ok_or_else(|| invalid(format!("accessor {} reaches beyond the data", index.value())))
    }

    /// The viewpoint at a node, if it has one.
    fn camera(&self, node: &json::Node) -> io::Result<Option<Camera>> {
        let Some(index) = node.camera else { return Ok(None) };
        let camera = self.root.cameras.get(index.value()).ok_or_else(|| invalid("a camera is missing"))?;
        let name = camera.name.clone().unwrap_or_default();
        let fault = || invalid(format!("camera '{name}' is not as expected"));
        let perspective = camera.perspective.as_ref().ok_or_else(fault)?;
        let rotation = node.rotation.ok_or_else(fault)?.0.map(f64::from);
        let position = DVec3::from_array(node.translation.ok_or_else(fault)?.map(f64::from));
        let (rotation, fov) = (DQuat::from_array(rotation), f64::from(perspective.yfov));
        let aspect = perspective.aspect_ratio.map(f64::from);
        let is_usable = position.is_finite()
            && (rotation.length() - 1.0).abs() < 1e-3
            && (fov > 0.0 && fov < PI)
            && aspect.is_none_or(|a| a > 0.0 && a.is_finite());
        if !is_usable {
            return Err(fault());
        }
        let rotation = rotation.normalize();
        let (forward, up) = (rotation * DVec3::NEG_Z, rotation * DVec3::Y);
        Ok(Some(Camera { name, position, forward, up, vertical_fov: fov, aspect }))
    }
}

/// Four bytes at a time.
fn words(bytes: &[u8]) -> impl Iterator<Item = [u8; 4]> + '_ {
    bytes.as_chunks::<4>().0.iter().copied()
}

/// Puts the patches in order of their ids.
fn collect(file: FileExtras, mut found: Vec<Found>, cameras: Vec<Camera>) -> io::Result<LitData> {
    found.sort_by_key(|patch| patch.id);
    let is_complete = found.len() == file.patches && found.iter().zip(0..).all(|(patch, id)| patch.id == id);
    if !is_complete {
        let message = format!("{} patches were found, not each of {} once", found.len(), file.patches);
        return Err(invalid(message));
    }
    let bands = file.bands.len();
    let column = |k: usize| -> Vec<f64> {
        found.iter().flat_map(|patch| &patch.values[k * bands..(k + 1) * bands]).copied().collect()
    };
    let patches = Patches::new(
        found.iter().map(|patch| patch.polygon).collect(),
        found.iter().map(|patch| patch.surface).collect(),
        found.iter().map(|patch| patch.face).collect(),
        found.iter().map(|patch| file.surfaces[patch.surface as usize].two_sided).collect(),
    );
    let obstructions: Vec<_> = file.obstructions.iter().map(|polygon| polygon.map(DVec3::from_array)).collect();
    Ok(LitData {
        patches: patches.with_obstructions(obstructions),
        emission: column(0),
        irradiance: column(1),
        radiosity: column(2),
        error: column(3),
        surfaces: file.surfaces,
        bands: file.bands,
        cameras,
        lights: file.lights.map(|lights| lights.into_iter().map(Into::into).collect()),
        report_json: file.report.map(|raw| raw.get().into()).unwrap_or_default(),
        exposure: file.exposure,
    })
}
