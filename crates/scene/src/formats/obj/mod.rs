//! Wavefront OBJ with its material library.
//!
//! Each pair of group (`o`, `g`) and material (`usemtl`) becomes one surface. Planar, convex quads stay quads; other
//! polygons are cut into triangles. Surfaces are two-sided unless the options say otherwise, because many writers of
//! OBJ do not care which way faces wind. Normals, lines, points and curves are not read.

mod library;
mod statements;

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use self::library::Library;
use self::statements::{Geometry, Group};
use super::LoadOptions;
use super::folder::Folder;
use super::mesh::{self, Polygons};
use super::names::{Roll, UniqueNames};
use crate::model::{Finding, Scene, SceneError, Surface, Texture, band_names};

/// Reads an `.obj` file and the `.mtl` files it names.
///
/// # Errors
/// If the file is missing or damaged, or holds no faces.
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    parse(path, &super::read(path)?, options)
}

/// Reads the bytes of a file; its path serves messages and finds its material libraries.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    super::check(options, &file)?;
    let text = String::from_utf8_lossy(bytes);
    let geometry = statements::read(&text).map_err(|fault| SceneError::new(&file, fault.element(), fault.message))?;
    let folder = Folder::of(path);
    let mut library = Library::open(&geometry.libraries, &folder)?;
    let mut builder = Builder::new(&geometry, options);
    for group in &geometry.groups {
        builder.add(group, &mut library)?;
        super::check_faces(builder.faces, options, &file)?;
    }
    if builder.faces == 0 {
        let message = "the file holds no faces with an area; export meshes as polygons";
        return Err(SceneError::new(file, "", message));
    }
    let mut scene = builder.scene;
    scene.name = super::scene_name(path);
    scene.findings = library.into_findings();
    scene.findings.extend(builder.roll.into_findings());
    scene.findings.extend(left_out(&geometry));
    Ok(scene)
}

/// Findings for what has no area by its kind.
fn left_out(geometry: &Geometry) -> impl Iterator<Item = Finding> {
    let lines = geometry.first_without_area.map(|line| {
        let message = "lines, points and curves have no area and were left out";
        Finding::warning("no-area-primitives", format!("line {line}"), message)
    });
    let slender = geometry.slender.map(|(line, count)| {
        let message = format!("{count} faces have fewer than three corners and were left out, this line's first");
        Finding::warning("slender-faces", format!("line {line}"), message)
    });
    lines.into_iter().chain(slender)
}

/// The scene so far.
struct Builder<'a> {
    geometry: &'a Geometry,
    options: &'a LoadOptions,
    names: UniqueNames,
    /// How many materials each group name appears with.
    materials_of: HashMap<&'a str, usize>,
    roll: Roll,
    faces: usize,
    scene: Scene,
}

impl<'a> Builder<'a> {
    fn new(geometry: &'a Geometry, options: &'a LoadOptions) -> Self {
        let mut materials_of = HashMap::new();
        for group in geometry.groups.iter().filter(|group| !group.polygons.is_empty()) {
            *materials_of.entry(group.name.as_str()).or_insert(0) += 1;
        }
        Self {
            geometry,
            options,
            names: UniqueNames::default(),
            materials_of,
            roll: Roll::default(),
            faces: 0,
            scene: Scene { bands: band_names(3), ..Scene::default() },
        }
    }

    fn add(&mut self, group: &Group, library: &mut Library) -> Result<(), SceneError> {
        let name = self.name(group);
        if group.polygons.is_empty() {
            return Ok(());
        }
        let has_image = library.has_image(group.material.as_deref());
        let sheet = if has_image { Unfolded::new(self.geometry, group) } else { None };
        let (mut material, image) = library.material(group.material.as_deref(), sheet.is_some())?;
        let sheet = sheet.filter(|_| image.is_some());
        let (polygons, positions) = match &sheet {
            Some(sheet) => (&sheet.polygons, &sheet.positions),
            None => (&group.polygons, &self.geometry.positions),
        };
        let (kept, faces) = mesh::renumbered(mesh::faces(polygons, positions, &name, &mut self.roll));
        if faces.is_empty() {
            return Ok(());
        }
        self.faces += faces.len();
        let metres = self.options.unit.metres();
        let vertices = kept.iter().map(|&vertex| metres * positions[vertex as usize]).collect();
        let texture = image.zip(sheet).map(|(painted, sheet)| {
            let coordinates = kept.iter().map(|&vertex| painted.moved(sheet.coordinates[vertex as usize])).collect();
            Texture { image: painted.image, coordinates }
        });
        material.two_sided = self.options.two_sided.unwrap_or(true);
        let name = self.names.claim(&name);
        self.scene.surfaces.push(Surface { name, vertices, faces, material, texture });
        Ok(())
    }

    /// The group's name, with the material's where a group has several.
    fn name(&self, group: &Group) -> String {
        let shared = self.materials_of.get(group.name.as_str()).is_some_and(|&materials| materials > 1);
        match (&group.material, group.name.as_str()) {
            (Some(material), "") => material.clone(),
            (None, "") => "unnamed".into(),
            (Some(material), name) if shared => format!("{name}.{material}"),
            (_, name) => name.into(),
        }
    }
}

/// A group whose vertices are as many as have texture coordinates of their own.
struct Unfolded {
    polygons: Polygons,
    positions: Vec<DVec3>,
    coordinates: Vec<[f64; 2]>,
}

impl Unfolded {
    /// None if a corner has no sound coordinates.
    fn new(geometry: &Geometry, group: &Group) -> Option<Self> {
        let (mut known, mut positions, mut coordinates) = (HashMap::new(), Vec::new(), Vec::new());
        let mut corners = Vec::with_capacity(group.polygons.corners.len());
        for (&vertex, &place) in group.polygons.corners.iter().zip(&group.coordinates) {
            let found = geometry.coordinates.get(place as usize).copied().flatten()?;
            corners.push(*known.entry((vertex, place)).or_insert_with(|| {
                positions.push(geometry.positions[vertex as usize]);
                coordinates.push(found);
                positions.len() as u32 - 1
            }));
        }
        Some(Self { polygons: Polygons { corners, ends: group.polygons.ends.clone() }, positions, coordinates })
    }
}

#[cfg(test)]
mod tests;
