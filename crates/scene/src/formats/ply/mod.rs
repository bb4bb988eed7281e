//! PLY, as text or binary of either byte order.
//!
//! The whole file becomes one surface. Planar, convex quads stay quads; other polygons are cut into triangles. Colours
//! and normals are not read, and neither are the points of point clouds. Format: G. Turk, "The PLY polygon file
//! format", 1994.

mod header;
mod values;

use std::path::Path;

use glam::DVec3;

use self::header::{Element, Encoding, Header, Kind};
use self::values::{Source, Text};
use super::LoadOptions;
use super::mesh::{self, Polygons, is_coordinate};
use super::names::Roll;
use crate::model::{Finding, Scene, SceneError, Surface, band_names};

/// Reads the bytes of a file; its path serves messages and names the surface.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    super::check(options, &file)?;
    let fail = |fault: Fault| SceneError::new(&file, fault.element, fault.message);
    let (header, body) = header::read(bytes).map_err(fail)?;
    let content = read(&header, body).map_err(fail)?;
    super::check_faces(content.polygons.len(), options, &file)?;

    let (material, without_material) = super::unknown_material(options.two_sided);
    let (name, mut roll) = (super::surface_name(path), Roll::default());
    let faces = mesh::faces(&content.polygons, &content.positions, &name, &mut roll);
    if faces.is_empty() {
        let message = "the file holds no faces with an area; export the mesh with polygons";
        return Err(SceneError::new(file, "", message));
    }
    let (vertices, faces) = mesh::compacted(&content.positions, faces, options.unit.metres());
    let mut findings = vec![without_material];
    findings.extend(left_out(&header, &content));
    findings.extend(roll.into_findings());
    let surfaces = vec![Surface { name, vertices, faces, material, texture: None }];
    Ok(Scene { name: super::scene_name(path), bands: band_names(3), surfaces, findings, ..Scene::default() })
}

/// What is wrong, and where.
#[derive(Debug)]
struct Fault {
    element: String,
    message: String,
}

impl Fault {
    fn new(element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { element: element.into(), message: message.into() }
    }
}

/// What a file says.
#[derive(Default)]
struct Content {
    positions: Vec<DVec3>,
    polygons: Polygons,
    /// The first face of fewer than three corners, and how many there are.
    slender: Option<(u64, usize)>,
}

fn left_out(header: &Header, content: &Content) -> Vec<Finding> {
    let mut found = Vec::new();
    if let Some((face, count)) = content.slender {
        let message = format!("{count} faces have fewer than three corners and were left out, this one first");
        found.push(Finding::warning("slender-faces", format!("face {face}"), message));
    }
    if header.elements.iter().any(|element| element.name == "tristrips" && element.count > 0) {
        let message = "triangle strips are not read and were left out; export the mesh with faces";
        found.push(Finding::warning("no-strips", "", message));
    }
    found
}

fn read(header: &Header, body: &[u8]) -> Result<Content, Fault> {
    match header.encoding {
        Encoding::Text => elements(header, &mut Text::new(body)),
        Encoding::LittleEndian => elements(header, &mut values::Binary::new(body, false)),
        Encoding::BigEndian => elements(header, &mut values::Binary::new(body, true)),
    }
}

/// Reads the elements in their order; faces need all vertices, which may follow them.
fn elements(header: &Header, source: &mut impl Source) -> Result<Content, Fault> {
    let mut content = Content::default();
    for element in &header.elements {
        let columns = Columns::of(element)?;
        for row in 0..element.rows() {
            let cut_short = || {
                let message = format!("the file ends within element {row} of {}; it was cut short", element.count);
                Fault::new(format!("{} {row}", element.name), message)
            };
            let at = |message: String| Fault::new(format!("{} {row}", element.name), message);
            columns.read(element, source, &mut content, row).map_err(|trouble| match trouble {
                Trouble::End => cut_short(),
                Trouble::Value(message) => at(message),
            })?;
        }
    }
    check_indices(&content)?;
    Ok(content)
}

/// Why a row could not be read.
enum Trouble {
    End,
    Value(String),
}

/// Which properties of an element matter.
enum Columns {
    Vertex([usize; 3]),
    Face(usize),
    Other,
}

impl Columns {
    fn of(element: &Element) -> Result<Self, Fault> {
        let place = |names: &[&str], is_list: bool| {
            let suits = |p: &header::Property| names.contains(&p.name.as_str()) && p.length.is_some() == is_list;
            element.properties.iter().position(suits)
        };
        match element.name.as_str() {
            "vertex" => match ["x", "y", "z"].map(|name| place(&[name], false)) {
                [Some(x), Some(y), Some(z)] => Ok(Self::Vertex([x, y, z])),
                _ => Err(Fault::new("vertex", "vertices need the properties x, y and z; export the file again")),
            },
            "face" => match place(&["vertex_indices", "vertex_index"], true) {
                Some(list) => Ok(Self::Face(list)),
                None if element.count == 0 => Ok(Self::Other),
                None => Err(Fault::new("face", "faces need a property list vertex_indices; export the file again")),
            },
            _ => Ok(Self::Other),
        }
    }

    /// Reads one row of the element.
    fn read(
        &self,
        element: &Element,
        source: &mut impl Source,
        content: &mut Content,
        row: u64,
    ) -> Result<(), Trouble> {
        let mut position = DVec3::ZERO;
        for (index, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                let value = source.next(property.kind)?;
                if let Self::Vertex(columns) = self
                    && let Some(axis) = columns.iter().position(|&column| column == index)
                {
                    position[axis] = value;
                }
                continue;
            };
            let length = whole(source.next(length)?)?;
            match self {
                Self::Face(list) if *list == index => face(length, property.kind, source, content, row)?,
                _ => (0..length).try_for_each(|_| source.next(property.kind).map(|_| ()))?,
            }
        }
        if matches!(self, Self::Vertex(_)) {
            if !position.to_array().into_iter().all(is_coordinate) {
                return Err(Trouble::Value("its coordinates are not three finite numbers; repair the mesh".into()));
            }
            content.positions.push(position);
        }
        Ok(())
    }
}

/// Reads the corners of a face.
fn face(length: u32, kind: Kind, source: &mut impl Source, content: &mut Content, row: u64) -> Result<(), Trouble> {
    let start = content.polygons.corners.len();
    for _ in 0..length {
        content.polygons.corners.push(whole(source.next(kind)?)?);
    }
    if length >= 3 {
        content.polygons.push([]);
    } else {
        content.polygons.corners.truncate(start);
        content.slender.get_or_insert((row, 0)).1 += 1;
    }
    Ok(())
}

/// An index or a length.
fn whole(value: f64) -> Result<u32, Trouble> {
    let number = value as u32;
    if f64::from(number) == value { Ok(number) } else { Err(Trouble::Value(format!("{value} is no index or length"))) }
}

fn check_indices(content: &Content) -> Result<(), Fault> {
    let count = content.positions.len();
    let is_missing = |corners: &[u32]| corners.iter().any(|&corner| corner as usize >= count);
    match content.polygons.iter().position(is_missing) {
        Some(face) => {
            let message = format!("it refers to a vertex beyond the {count} there are; export the file again");
            Err(Fault::new(format!("face {face}"), message))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
