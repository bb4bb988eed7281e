//! glTF 2.0, binary (.glb) and text (.gltf).
//!
//! | glTF | here |
//! |---|---|
//! | primitive of a node | one surface, named after the node or else the mesh |
//! | base colour factor x mean of COLOR_0 x (1 - metallic of smooth ones) | reflectance; with the texture limited to 0.95 |
//! | base colour texture, its wrap modes, coordinates and KHR_texture_transform | texture; without coordinates, its mean |
//! | base colour x metallic, where roughness is at most 0.1 | mirror reflectance: its luminance |
//! | metallic and roughness, where that is more | gloss, which traced pictures show |
//! | base colour x (1 - metallic) x transmission factor x mean of its texture, likewise | transmittance: its luminance |
//! | diffuse transmission factor x its colour x means of their textures x (1 - metallic) | diffuse transmittance |
//! | emissive factor x mean of its texture x strength | radiance; exitance is pi times that |
//! | doubleSided | two-sided |
//! | KHR_lights_punctual | point, spot and directional lights; ranges are ignored |
//! | perspective camera | camera |
//!
//! What transmits diffusely reflects the rest of its factor of the base colour, and is two-sided whatever the file says.
//! Images other than that of the base colour count by their means, and mirrors and glass by the mean of that. Images take
//! 512 MiB at most together; those beyond are averaged, with a finding.
//!
//! Glass that is rougher is what is diffuse of it, with a finding. What a coat or glass mirrors of light
//! by its refractive index, a few per cent, is left out.
//!
//! Coordinates stay as they are: y points up. The `gltf` crate parses the JSON; what the JSON promises about indices,
//! offsets and counts is checked here before it is used, because that crate's own validation and accessors panic on
//! some malformed files.

mod accessors;
mod buffers;
mod container;
mod geometry;
mod hierarchy;
mod lights;
mod materials;
#[cfg(test)]
pub(super) mod testing;
mod textures;

use std::path::Path;
use std::rc::Rc;

use ::gltf::json;

use self::buffers::Document;
use self::geometry::{Decoded, Primitive};
use self::hierarchy::Placement;
use self::materials::Materials;
use super::LoadOptions;
use super::folder::Folder;
use super::names::{Roll, UniqueNames};
use crate::model::{Finding, Scene, SceneError, Surface, band_names};

/// Reads a `.glb` or `.gltf` file.
///
/// # Errors
/// If the file is missing, damaged, needs an extension that is not supported, or holds no triangles.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    parse(path, &super::read(path)?, options)
}

/// Reads the bytes of a file; its path serves messages and finds the files it refers to.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    super::check(options, &file)?;
    let (root, chunk) = container::open(bytes).map_err(|fault| SceneError::new(&file, fault.element, fault.message))?;
    let folder = Folder::of(path);
    let document = Document::open(&root, chunk, &folder, &file)?;
    let mut reader = Reader::new(&document, &folder, options);
    for placement in hierarchy::placements(&document)? {
        reader.place(&placement)?;
    }
    let scene = reader.finish(super::scene_name(path));
    if scene.face_count() == 0 {
        let message = "the file holds no triangles in its scene; export meshes along with it";
        return Err(SceneError::new(file, "", message));
    }
    Ok(scene)
}

/// The scene so far.
struct Reader<'a> {
    document: &'a Document<'a>,
    options: &'a LoadOptions,
    metres: f64,
    materials: Materials<'a>,
    /// Each mesh is decoded once, however many nodes show it.
    meshes: Vec<Option<Rc<Vec<Primitive>>>>,
    decoded: Decoded,
    names: UniqueNames,
    roll: Roll,
    faces: usize,
    scene: Scene,
}

impl<'a> Reader<'a> {
    fn new(document: &'a Document<'a>, folder: &'a Folder, options: &'a LoadOptions) -> Self {
        Self {
            document,
            options,
            metres: options.unit.metres(),
            materials: Materials::new(document, folder),
            meshes: vec![None; document.root.meshes.len()],
            decoded: Decoded::default(),
            names: UniqueNames::default(),
            roll: Roll::default(),
            faces: 0,
            scene: Scene { bands: band_names(3), ..Scene::default() },
        }
    }

    /// Adds what a node shows.
    fn place(&mut self, placement: &Placement) -> Result<(), SceneError> {
        let node = placement.node;
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                let message = "the mesh is posed by a skeleton and was read in its bind pose; bake the pose first";
                self.roll.warn("skinned-mesh", "node", &placement.name, message);
            }
            self.place_mesh(mesh, placement)?;
        }
        if let Some(camera) = node.camera {
            let camera = lights::camera(self.document, camera, placement, self.metres, &mut self.roll)?;
            self.scene.cameras.extend(camera);
        }
        let light = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            let light = lights::light(self.document, light.light, placement, self.metres, &mut self.roll)?;
            self.scene.lights.push(light);
        }
        Ok(())
    }

    fn place_mesh(&mut self, index: json::Index<json::Mesh>, placement: &Placement) -> Result<(), SceneError> {
        let primitives = self.primitives(index, placement)?;
        let mesh = &self.document.root.meshes[index.value()];
        let fallback = || mesh.name.clone().filter(|name| !name.is_empty());
        let name = placement.given_name().or_else(fallback).unwrap_or_else(|| format!("node {}", placement.index));
        for primitive in primitives.iter() {
            self.faces += primitive.triangles.len();
            if self.faces > self.options.max_faces {
                return Err(self.document.fail(
                    format!("node '{}'", placement.name),
                    format!(
                        "the scene has more than {} triangles; simplify it or raise the limit",
                        self.options.max_faces
                    ),
                ));
            }
            let (mut material, texture) = self.materials.of(primitive)?;
            let two_sided = self.options.two_sided.unwrap_or(material.two_sided);
            material.two_sided = two_sided || material.is_translucent();
            let (vertices, faces) = geometry::placed(primitive, placement.world, self.metres);
            self.scene.surfaces.push(Surface { name: self.names.claim(&name), vertices, faces, material, texture });
        }
        Ok(())
    }

    fn primitives(
        &mut self,
        index: json::Index<json::Mesh>,
        placement: &Placement,
    ) -> Result<Rc<Vec<Primitive>>, SceneError> {
        let Some(slot) = self.meshes.get(index.value()) else {
            let message = format!("it shows mesh {}, which does not exist; export the file again", index.value());
            return Err(self.document.fail(format!("node '{}'", placement.name), message));
        };
        if let Some(known) = slot {
            return Ok(Rc::clone(known));
        }
        let mesh = geometry::mesh(self.document, index.value(), self.options, &mut self.decoded, &mut self.roll)?;
        let mesh = Rc::new(mesh);
        self.meshes[index.value()] = Some(Rc::clone(&mesh));
        Ok(mesh)
    }

    fn finish(mut self, name: String) -> Scene {
        self.scene.name = name;
        self.scene.findings = lit_model(self.document.root).into_iter().collect();
        self.scene.findings.extend(self.materials.into_findings());
        self.scene.findings.extend(self.roll.into_findings());
        self.scene.findings.extend(ignored_extensions(self.document.root));
        self.scene
    }
}

/// A finding for files that hold a solution, as their `extras.radiosity` says.
fn lit_model(root: &json::Root) -> Option<Finding> {
    let extras: serde_json::Value = serde_json::from_str(root.extras.as_ref()?.get()).ok()?;
    let message = "the file is a lit model: a solution already, whose colours are light and not paint; draw it with \
                   radiosity render, or solve the scene that it was made from";
    extras.get("radiosity").map(|_| Finding::error("lit-model", "", message))
}

/// A finding for extensions that change what is seen and that are not read.
fn ignored_extensions(root: &json::Root) -> Option<Finding> {
    let ignored: Vec<_> = root
        .extensions_used
        .iter()
        .filter(|name| !container::UNDERSTOOD.contains(&name.as_str()))
        .map(String::as_str)
        .collect();
    let message = "the file uses extensions that are not read; what they add is missing";
    (!ignored.is_empty())
        .then(|| Finding::warning("ignored-extensions", format!("extensions {}", ignored.join(", ")), message))
}

#[cfg(test)]
mod tests;
