//! Writing of lit models.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_PI;
use std::io::{self, Write};
use std::path::Path;

use glam::{DMat3, DQuat, DVec3};
use gltf::binary::Glb;
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::Target;
use gltf::json::extensions::material::Unlit;
use gltf::json::mesh::Semantic;
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked::Valid;
use gltf::json::{self, Accessor, Index, Root};
use radiosity_scene::Camera;
use serde::Serialize;

use super::{Extras, FileExtras, LitModel, MaterialExtras, MeshExtras, QUANTITIES, VERSION, attribute_names};
use crate::tone::rgb;
use crate::{Smoother, ToneCurve};
use radiosity_store::files::{FileError, atomic_write, invalid};

/// Writes a lit model as binary glTF.
///
/// # Errors
/// If the parts of the model do not fit together or are not finite, the file would pass the 4 GiB that glTF allows, or
/// it cannot be written; then nothing is left behind.
pub fn write_lit(path: &Path, model: &LitModel) -> Result<(), FileError> {
    let (root, bin) = assemble(model).map_err(|error| FileError::new(path, error))?;
    atomic_write(path, |out| encode(&root, bin, out))
}

fn encode(root: &Root, bin: Vec<u8>, out: &mut impl Write) -> io::Result<()> {
    let json = json::serialize::to_vec(root)?;
    // The header and the heads of two chunks take 28 bytes, padding at most six.
    if json.len() + bin.len() + 34 > u32::MAX as usize {
        return Err(invalid("glTF files end at 4 GiB; use fewer patches or bands"));
    }
    let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
    let bin = (!bin.is_empty()).then_some(bin.into());
    Glb { header, json: json.into(), bin }.to_writer(out).map_err(|error| match error {
        gltf::Error::Io(error) => error,
        other => io::Error::other(other),
    })
}

/// The JSON and the binary part of the file.
fn assemble(model: &LitModel) -> io::Result<(Root, Vec<u8>)> {
    model.check().map_err(invalid)?;
    let mut assembly = Assembly::default();
    let colours = colours(model);
    for (surface, patches) in patches_by_surface(model).iter().enumerate().filter(|(_, patches)| !patches.is_empty()) {
        assembly.add_surface(model, surface, patches, &colours)?;
    }
    for camera in model.cameras {
        assembly.add_camera(camera)?;
    }
    assembly.finish(model)
}

fn patches_by_surface(model: &LitModel) -> Vec<Vec<usize>> {
    let mut lists = vec![Vec::new(); model.surfaces.len()];
    for (patch, &surface) in model.patches.surface.iter().enumerate() {
        lists[surface as usize].push(patch);
    }
    lists
}

/// The displayed colour of each corner of each patch.
fn colours(model: &LitModel) -> Vec<[f32; 3]> {
    let bands = model.bands.len();
    let reflectance: Vec<&[f64]> = model.surfaces.iter().map(|s| &s.reflectance[..]).collect();
    let through: Vec<&[f64]> = model.surfaces.iter().map(|s| &s.diffuse_transmittance[..]).collect();
    let smoother = Smoother::new(model.patches, radiosity_geometry::corners::CREASE_ANGLE);
    let corners = smoother.corner_radiosity(model.radiosity, model.irradiance, &reflectance, &through, bands);
    let exposed = |b: &f64| (b * FRAC_1_PI * model.exposure) as f32;
    let colour = |corner: &[f64]| ToneCurve::Filmic.apply(rgb(&corner.iter().map(exposed).collect::<Vec<_>>()));
    match bands {
        0 => vec![[0.0; 3]; 4 * model.patches.len()],
        _ => corners.chunks_exact(bands).map(colour).collect(),
    }
}

/// A file in the making.
#[derive(Default)]
struct Assembly {
    root: Root,
    bin: Vec<u8>,
    nodes: Vec<Index<json::Node>>,
}

type Attributes = BTreeMap<json::validation::Checked<Semantic>, Index<Accessor>>;

impl Assembly {
    fn add_surface(
        &mut self,
        model: &LitModel,
        surface: usize,
        patches: &[usize],
        colours: &[[f32; 3]],
    ) -> io::Result<()> {
        let vertices = Vertices { model, patches };
        let name = Some(model.surfaces[surface].name.clone());
        let primitive = json::mesh::Primitive {
            attributes: self.add_attributes(&vertices, colours)?,
            indices: Some(self.add_indices(&vertices)?),
            material: Some(self.add_material(model, surface)?),
            mode: Valid(json::mesh::Mode::Triangles),
            extensions: None,
            extras: None,
            targets: None,
        };
        let mesh = self.root.push(json::Mesh {
            name: name.clone(),
            primitives: vec![primitive],
            extras: extras(MeshExtras { surface: surface as u32 })?,
            extensions: None,
            weights: None,
        });
        let node = self.root.push(json::Node { name, mesh: Some(mesh), ..json::Node::default() });
        self.nodes.push(node);
        Ok(())
    }

    fn add_attributes(&mut self, vertices: &Vertices, colours: &[[f32; 3]]) -> io::Result<Attributes> {
        let patches = vertices.model.patches;
        let mut attributes = Attributes::new();
        let positions = vertices.floats(|i, k| patches.polygons[i][k].as_vec3().to_array());
        let position = self.add_floats(&positions, Type::Vec3)?;
        let (least, most) = bounds(&positions)?;
        let accessor = &mut self.root.accessors[position.value()];
        (accessor.min, accessor.max) = (Some(least), Some(most));
        attributes.insert(Valid(Semantic::Positions), position);
        // glTF has no vertices without normals, so patches without area face up.
        let normal = |i: usize| patches.normal[i].normalize_or(DVec3::Z).as_vec3().to_array();
        let normals = vertices.floats(|i, _| normal(i));
        attributes.insert(Valid(Semantic::Normals), self.add_floats(&normals, Type::Vec3)?);
        let colours = vertices.floats(|i, k| colours[4 * i + k]);
        attributes.insert(Valid(Semantic::Colors(0)), self.add_floats(&colours, Type::Vec3)?);
        self.add_quantities(vertices, &mut attributes)?;
        let patch_ids = self.add_ids(vertices, |i| i as u32)?;
        attributes.insert(Valid(Semantic::Extras("PATCH".into())), patch_ids);
        let face_ids = self.add_ids(vertices, |i| patches.face[i])?;
        attributes.insert(Valid(Semantic::Extras("FACE".into())), face_ids);
        Ok(attributes)
    }

    fn add_quantities(&mut self, vertices: &Vertices, attributes: &mut Attributes) -> io::Result<()> {
        let bands = vertices.model.bands.len();
        for (quantity, values) in QUANTITIES.iter().zip(vertices.model.quantities()) {
            let (names, components) = attribute_names(quantity, bands);
            for (first, name) in (0..).step_by(components).zip(names) {
                let value = |i: usize, k: usize| values[i * bands + first + k] as f32;
                let accessor = if components == 3 {
                    self.add_floats(&vertices.floats(|i, _| [0, 1, 2].map(|k| value(i, k))), Type::Vec3)?
                } else {
                    self.add_floats(&vertices.floats(|i, _| [value(i, 0)]), Type::Scalar)?
                };
                attributes.insert(Valid(Semantic::Extras(name)), accessor);
            }
        }
        Ok(())
    }

    fn add_floats<const N: usize>(&mut self, values: &[[f32; N]], type_: Type) -> io::Result<Index<Accessor>> {
        let bytes = values.iter().flatten().flat_map(|v| v.to_le_bytes());
        self.add_accessor(bytes, values.len(), ComponentType::F32, type_, Target::ArrayBuffer)
    }

    fn add_ids(&mut self, vertices: &Vertices, id: impl Fn(usize) -> u32) -> io::Result<Index<Accessor>> {
        // Little-endian halves of a 32-bit number are that number.
        let ids: Vec<u32> = vertices.each(|i, _| id(i));
        let bytes = ids.iter().flat_map(|id| id.to_le_bytes());
        self.add_accessor(bytes, ids.len(), ComponentType::U16, Type::Vec2, Target::ArrayBuffer)
    }

    fn add_indices(&mut self, vertices: &Vertices) -> io::Result<Index<Accessor>> {
        let mut indices: Vec<u32> = Vec::new();
        let mut first = 0;
        for &patch in vertices.patches {
            let n = vertices.model.patches.corners(patch).len() as u32;
            indices.extend(super::fan(first, n));
            first += n;
        }
        let bytes = indices.iter().flat_map(|i| i.to_le_bytes());
        self.add_accessor(bytes, indices.len(), ComponentType::U32, Type::Scalar, Target::ElementArrayBuffer)
    }

    fn add_accessor(
        &mut self,
        bytes: impl Iterator<Item = u8>,
        count: usize,
        component: ComponentType,
        type_: Type,
        target: Target,
    ) -> io::Result<Index<Accessor>> {
        let offset = self.bin.len();
        self.bin.extend(bytes);
        if self.bin.len() > u32::MAX as usize {
            return Err(invalid("glTF files end at 4 GiB; use fewer patches or bands"));
        }
        let view = self.root.push(json::buffer::View {
            buffer: Index::new(0),
            byte_length: (self.bin.len() - offset).into(),
            byte_offset: Some(offset.into()),
            byte_stride: None,
            name: None,
            target: Some(Valid(target)),
            extensions: None,
            extras: None,
        });
        Ok(self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: count.into(),
            component_type: Valid(GenericComponentType(component)),
            type_: Valid(type_),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: None,
        }))
    }

    fn add_material(&mut self, model: &LitModel, surface: usize) -> io::Result<Index<json::Material>> {
        let surface = &model.surfaces[surface];
        let unlit = json::extensions::material::Material { unlit: Some(Unlit {}), ..Default::default() };
        // For those who know no unlit materials: glTF's own defaults are those of a metal.
        let diffuse = json::material::PbrMetallicRoughness {
            metallic_factor: json::material::StrengthFactor(0.0),
            roughness_factor: json::material::StrengthFactor(1.0),
            ..Default::default()
        };
        Ok(self.root.push(json::Material {
            name: Some(surface.material.clone()),
            double_sided: surface.two_sided,
            pbr_metallic_roughness: diffuse,
            extensions: Some(unlit),
            extras: extras(MaterialExtras {
                reflectance: &surface.reflectance,
                two_sided: surface.two_sided,
                specular: surface.specular,
                transmittance: surface.transmittance,
            })?,
            ..json::Material::default()
        }))
    }

    fn add_camera(&mut self, camera: &Camera) -> io::Result<()> {
        let placement = placement(camera).ok_or_else(|| invalid(format!("camera '{}' is unusable", camera.name)))?;
        let perspective = json::camera::Perspective {
            aspect_ratio: camera.aspect.map(|aspect| aspect as f32),
            yfov: camera.vertical_fov as f32,
            // Near enough for rooms; a viewer chooses the far plane.
            znear: 0.01,
            zfar: None,
            extensions: None,
            extras: None,
        };
        let index = self.root.push(json::Camera {
            name: Some(camera.name.clone()),
            perspective: Some(perspective),
            orthographic: None,
            type_: Valid(json::camera::Type::Perspective),
            extensions: None,
            extras: None,
        });
        let node = self.root.push(json::Node {
            name: Some(camera.name.clone()),
            camera: Some(index),
            translation: Some(camera.position.as_vec3().to_array()),
            rotation: Some(UnitQuaternion(placement.as_quat().normalize().to_array())),
            ..json::Node::default()
        });
        self.nodes.push(node);
        Ok(())
    }

    fn finish(mut self, model: &LitModel) -> io::Result<(Root, Vec<u8>)> {
        if !self.bin.is_empty() {
            self.root.push(json::Buffer {
                byte_length: self.bin.len().into(),
                name: None,
                uri: None,
                extensions: None,
                extras: None,
            });
        }
        if !self.nodes.is_empty() {
            let scene = json::Scene { nodes: self.nodes, name: None, extensions: None, extras: None };
            self.root.scene = Some(self.root.push(scene));
        }
        if !self.root.materials.is_empty() {
            self.root.extensions_used = vec!["KHR_materials_unlit".into()];
        }
        self.root.asset.generator = Some(concat!("radiosity ", env!("CARGO_PKG_VERSION")).into());
        self.root.extras = extras(FileExtras {
            version: VERSION,
            patches: model.patches.len(),
            bands: model.bands.to_vec(),
            surfaces: model.surfaces.to_vec(),
            exposure: model.exposure,
            lights: model.lights.map(|lights| lights.iter().map(Into::into).collect()),
            obstructions: model.patches.obstructions.iter().map(|polygon| polygon.map(|p| p.to_array())).collect(),
            report: report(model.report_json)?,
        })?;
        Ok((self.root, self.bin))
    }
}

/// The vertices of one surface.
struct Vertices<'a> {
    model: &'a LitModel<'a>,
    patches: &'a [usize],
}

impl Vertices<'_> {
    /// One value per vertex, from its patch and the number of its corner.
    fn each<T>(&self, value: impl Fn(usize, usize) -> T) -> Vec<T> {
        let mut values = Vec::with_capacity(4 * self.patches.len());
        for &patch in self.patches {
            values.extend((0..self.model.patches.corners(patch).len()).map(|corner| value(patch, corner)));
        }
        values
    }

    fn floats<const N: usize>(&self, value: impl Fn(usize, usize) -> [f32; N]) -> Vec<[f32; N]> {
        self.each(value)
    }
}

/// The least and the greatest coordinates.
fn bounds(positions: &[[f32; 3]]) -> io::Result<(json::Value, json::Value)> {
    if positions.iter().flatten().any(|x| !x.is_finite()) {
        return Err(invalid("a patch has a corner that is not finite"));
    }
    let fold = |start: f32, f: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|axis| positions.iter().map(|p| p[axis]).fold(start, f)).to_vec()
    };
    Ok((json::Value::from(fold(f32::INFINITY, f32::min)), json::Value::from(fold(f32::NEG_INFINITY, f32::max))))
}

/// The rotation from glTF's camera, which looks down its z axis, to this one; none if that makes no sense.
fn placement(camera: &Camera) -> Option<DQuat> {
    let back = -camera.forward.try_normalize()?;
    let right = camera.up.cross(back).try_normalize()?;
    // As they will be in the file: single precision may round what is barely possible to what is not.
    let is_aspect = camera.aspect.is_none_or(|a| (a as f32).is_finite() && a as f32 > 0.0);
    let angle = f64::from(camera.vertical_fov as f32);
    let is_angle = angle > 0.0 && angle < std::f64::consts::PI;
    let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
    (is_aspect && is_angle && camera.position.as_vec3().is_finite() && rotation.is_finite()).then_some(rotation)
}

fn report(text: &str) -> io::Result<Option<Box<serde_json::value::RawValue>>> {
    if text.is_empty() {
        return Ok(None);
    }
    let raw = serde_json::value::RawValue::from_string(text.into());
    raw.map(Some).map_err(|error| invalid(format!("the report is no JSON: {error}")))
}

fn extras(ours: impl Serialize) -> io::Result<json::Extras> {
    Ok(Some(serde_json::value::to_raw_value(&Extras { radiosity: ours })?))
}
