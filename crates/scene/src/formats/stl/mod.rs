//! STL, as text or binary.
//!
//! Each `solid` becomes one surface; a binary file is one. Corners in the same place become one vertex. The corners'
//! order decides which side is the front (right-hand rule), and normals in the file serve to doubt it only. STL has
//! neither units nor materials. Format: 3D Systems, "StereoLithography interface specification", 1989.

mod binary;
mod text;

use std::path::Path;

use glam::DVec3;

use super::LoadOptions;
use super::mesh::{self, Polygons, Vertices};
use super::names::{Roll, UniqueNames};
use crate::model::{Finding, Scene, SceneError, Surface, band_names};

/// Reads the bytes of a file; its path serves messages and names a surface without a name.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    super::check(options, &file)?;
    let read = if is_text(bytes) { text::read(bytes) } else { binary::read(bytes) };
    let content = read.map_err(|fault| SceneError::new(&file, fault.element, fault.message))?;
    super::check_faces(content.solids.iter().map(|solid| solid.polygons.len()).sum(), options, &file)?;

    let (material, without_material) = super::unknown_material(options.two_sided);
    let mut scene = Scene { name: super::scene_name(path), bands: band_names(3), ..Scene::default() };
    let (mut names, mut roll) = (UniqueNames::default(), Roll::default());
    for solid in content.solids {
        let name = if solid.name.is_empty() { super::surface_name(path) } else { solid.name };
        let faces = mesh::faces(&solid.polygons, &solid.vertices.positions, &name, &mut roll);
        if faces.is_empty() {
            continue;
        }
        if solid.contradicted > 0 {
            let message = "the file's normals contradict the order of corners, which was followed; export it again if \
                           fronts and backs are exchanged";
            roll.warn("contradicting-normals", "surface", &name, message);
        }
        let (vertices, faces) = mesh::compacted(&solid.vertices.positions, faces, options.unit.metres());
        scene.surfaces.push(Surface {
            name: names.claim(&name),
            vertices,
            faces,
            material: material.clone(),
            texture: None,
        });
    }
    if scene.surfaces.is_empty() {
        let message = "the file holds no triangles with an area; export meshes as triangles";
        return Err(SceneError::new(file, "", message));
    }
    scene.findings = vec![without_material];
    scene.findings.extend(content.findings);
    scene.findings.extend(roll.into_findings());
    Ok(scene)
}

/// Whether the file is text. Binary files may begin with `solid` too, but their length tells.
fn is_text(bytes: &[u8]) -> bool {
    let start = super::skip_blanks(bytes);
    let says_solid = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let has_binary = bytes[..bytes.len().min(4096)].contains(&0);
    says_solid && !has_binary && !binary::has_exact_length(bytes)
}

/// What a file says.
#[derive(Default)]
struct Content {
    solids: Vec<Solid>,
    findings: Vec<Finding>,
}

/// The triangles of one solid.
#[derive(Default)]
struct Solid {
    name: String,
    vertices: Vertices,
    polygons: Polygons,
    /// How many triangles have a normal that points the other way.
    contradicted: usize,
}

/// What is wrong, and where.
#[derive(Debug)]
struct Fault {
    element: String,
    message: String,
}

impl Solid {
    /// Adds a polygon with the normal that the file gives, which may be zero for none.
    fn push(&mut self, corners: &[DVec3], normal: DVec3) {
        let winding = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        // Rounding alone never turns a normal this far.
        if winding.normalize_or_zero().dot(normal.normalize_or_zero()) < -0.5 {
            self.contradicted += 1;
        }
        let corners: Vec<u32> = corners.iter().map(|&corner| self.vertices.index(corner)).collect();
        self.polygons.push(corners);
    }
}

#[cfg(test)]
mod tests;
