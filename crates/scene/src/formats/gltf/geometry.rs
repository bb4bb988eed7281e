//! Meshes: primitives as triangles.

use std::collections::HashMap;
use std::rc::Rc;

use ::gltf::json;
use ::gltf::json::mesh::{Mode, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DVec3};

use super::accessors::Table;
use super::buffers::Document;
use super::textures;
use crate::formats::LoadOptions;
use crate::formats::names::Roll;
use crate::model::{Face, SceneError};

/// Triangles in the coordinates of their mesh.
pub(super) struct Primitive {
    /// Only those that a triangle uses.
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Mean of COLOR_0 over the area.
    pub colour: Option<[f64; 3]>,
    pub material: Option<usize>,
    /// Of its vertices, for the base colour texture; none if it has no texture, or no sound coordinates for it.
    pub coordinates: Option<Vec<[f64; 2]>>,
}

/// Arrays that were decoded already: exporters let many primitives share one.
#[derive(Default)]
pub(super) struct Decoded {
    positions: HashMap<usize, Rc<Vec<DVec3>>>,
    colours: HashMap<usize, Rc<Table>>,
}

/// The triangles of all primitives of a mesh.
pub(super) fn mesh(
    document: &Document,
    index: usize,
    options: &LoadOptions,
    decoded: &mut Decoded,
    roll: &mut Roll,
) -> Result<Vec<Primitive>, SceneError> {
    let mesh = &document.root.meshes[index];
    let name = mesh.name.clone().unwrap_or_else(|| index.to_string());
    let (mut primitives, mut left) = (Vec::new(), options.max_faces);
    for (number, source) in mesh.primitives.iter().enumerate() {
        let fail = |message| document.fail(format!("mesh '{name}', primitive {number}"), message);
        let primitive = primitive(document, source, &name, decoded, left, roll).map_err(fail)?;
        left -= primitive.as_ref().map_or(0, |primitive| primitive.triangles.len());
        primitives.extend(primitive);
    }
    if mesh.weights.as_ref().is_some_and(|weights| weights.iter().any(|&weight| weight != 0.0)) {
        let message = "its morph targets are ignored; apply them before export";
        roll.warn("morph-targets", "mesh", &name, message);
    }
    Ok(primitives)
}

/// The triangles of one primitive; `None` for points, lines and nothing.
fn primitive(
    document: &Document,
    source: &json::mesh::Primitive,
    mesh: &str,
    decoded: &mut Decoded,
    max_faces: usize,
    roll: &mut Roll,
) -> Result<Option<Primitive>, String> {
    let Checked::Valid(mode) = source.mode else { return Err("its mode is unknown; export the file again".into()) };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        let message = "points and lines have no area and were left out";
        roll.warn("no-area-primitives", "mesh", mesh, message);
        return Ok(None);
    }
    let positions = positions(document, source, decoded)?;
    let indices = indices(document, source, positions.len())?;
    if mode == Mode::Triangles && indices.len() % 3 != 0 {
        let message = "the number of its indices is no multiple of 3 and the rest was left out";
        roll.warn("odd-indices", "mesh", mesh, message);
    }
    let triangles = triangles(mode, &indices);
    if triangles.is_empty() {
        return Ok(None);
    }
    if triangles.len() > max_faces {
        return Err("the scene has too many triangles; simplify it or raise the limit of faces".into());
    }
    let colours = colours(document, source, decoded)?;
    let colour = colours.map(|colours| mean_colour(&colours, &positions, &triangles)).transpose()?;
    let material = source.material.map(|material| material.value());
    let coordinates = coordinates(document, source, material, positions.len());
    let (kept, triangles) = compacted(triangles);
    let coordinates = coordinates.map(|table| {
        let of = |&vertex: &u32| [table.values[2 * vertex as usize], table.values[2 * vertex as usize + 1]];
        kept.iter().map(of).collect()
    });
    let positions = kept.iter().map(|&vertex| positions[vertex as usize]).collect();
    Ok(Some(Primitive { positions, triangles, colour, material, coordinates }))
}

/// The texture coordinates that the base colour texture of a material asks for; none if they are not there or unsound.
fn coordinates(
    document: &Document,
    source: &json::mesh::Primitive,
    material: Option<usize>,
    count: usize,
) -> Option<Table> {
    let texture = textures::of_base_colour(document.root.materials.get(material?)?)?;
    let semantic = Semantic::TexCoords(textures::coordinate_set(texture));
    let table = document.table(*source.attributes.get(&Checked::Valid(semantic))?).ok()?;
    let is_sound = table.columns == 2 && table.rows().len() >= count && table.values.iter().all(|c| c.is_finite());
    is_sound.then_some(table)
}

fn positions(
    document: &Document,
    source: &json::mesh::Primitive,
    decoded: &mut Decoded,
) -> Result<Rc<Vec<DVec3>>, String> {
    let Some(&accessor) = source.attributes.get(&Checked::Valid(Semantic::Positions)) else {
        return Err("it has no POSITION; export the file again".into());
    };
    if let Some(known) = decoded.positions.get(&accessor.value()) {
        return Ok(Rc::clone(known));
    }
    let table = document.table(accessor)?;
    if table.columns != 3 {
        return Err(format!("its POSITION has {} components instead of 3", table.columns));
    }
    let positions: Vec<_> = table.rows().map(DVec3::from_slice).collect();
    if let Some(bad) = positions.iter().position(|position| !position.is_finite()) {
        return Err(format!("vertex {bad} is not finite ({}); repair the mesh", positions[bad]));
    }
    let positions = Rc::new(positions);
    decoded.positions.insert(accessor.value(), Rc::clone(&positions));
    Ok(positions)
}

/// The vertex of each corner, all within `count`.
fn indices(document: &Document, source: &json::mesh::Primitive, count: usize) -> Result<Vec<u32>, String> {
    let Some(accessor) = source.indices else {
        let count = u32::try_from(count).map_err(|_| "it has too many vertices; split it")?;
        return Ok((0..count).collect());
    };
    let indices = document.indices(accessor)?;
    match indices.iter().position(|&index| index as usize >= count) {
        Some(bad) => Err(format!("index {bad} refers to vertex {} of {count}; export the file again", indices[bad])),
        None => Ok(indices),
    }
}

/// glTF 2.0, section 3.7.2.1. Strips use triangles without area as stitches, which are dropped.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let whole = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(turned).filter(whole).collect()
        }
        Mode::TriangleFan => {
            let fan = indices.split_first().map(|(&hub, rim)| rim.windows(2).map(move |w| [w[0], w[1], hub]));
            fan.into_iter().flatten().filter(whole).collect()
        }
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

fn colours(
    document: &Document,
    source: &json::mesh::Primitive,
    decoded: &mut Decoded,
) -> Result<Option<Rc<Table>>, String> {
    let Some(&accessor) = source.attributes.get(&Checked::Valid(Semantic::Colors(0))) else { return Ok(None) };
    if let Some(known) = decoded.colours.get(&accessor.value()) {
        return Ok(Some(Rc::clone(known)));
    }
    let table = Rc::new(document.table(accessor)?);
    if table.columns < 3 {
        return Err("its COLOR_0 has fewer than 3 components".into());
    }
    decoded.colours.insert(accessor.value(), Rc::clone(&table));
    Ok(Some(table))
}

/// Vertex colours averaged over each triangle and then over the area; they are linear in glTF.
fn mean_colour(colours: &Table, positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<[f64; 3], String> {
    if colours.rows().len() < positions.len() {
        return Err("its COLOR_0 has fewer elements than its POSITION".into());
    }
    let colour = |vertex: u32| DVec3::from_slice(&colours.values[vertex as usize * colours.columns..]);
    let (mut sum, mut plain, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let mean = triangle.map(colour).into_iter().sum::<DVec3>() / 3.0;
        let weight = (b - a).cross(c - a).length();
        (sum, plain, area) = (sum + weight * mean, plain + mean, area + weight);
    }
    let mean = if area > 0.0 { sum / area } else { plain / triangles.len() as f64 };
    let slack = DVec3::splat(1e-9);
    if !(mean.cmpge(-slack).all() && mean.cmple(DVec3::ONE + slack).all()) {
        return Err(format!("its vertex colours average to {mean}; they must lie within 0 and 1"));
    }
    Ok(mean.clamp(DVec3::ZERO, DVec3::ONE).to_array())
}

/// The vertices that the triangles use, in order of first use, and the triangles renumbered.
fn compacted(mut triangles: Vec<[u32; 3]>) -> (Vec<u32>, Vec<[u32; 3]>) {
    let (mut place, mut kept) = (HashMap::new(), Vec::new());
    for corner in triangles.iter_mut().flatten() {
        // Work in proportion to the triangles: the array may be shared by thousands of primitives.
        *corner = *place.entry(*corner).or_insert_with(|| {
            kept.push(*corner);
            kept.len() as u32 - 1
        });
    }
    (kept, triangles)
}

/// The vertices and faces of an instance.
pub(super) fn placed(primitive: &Primitive, world: DAffine3, metres: f64) -> (Vec<DVec3>, Vec<Face>) {
    let vertices = primitive.positions.iter().map(|&position| metres * world.transform_point3(position));
    // A mirror turns fronts into backs.
    let mirrored = world.matrix3.determinant() < 0.0;
    let face = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b, b] } else { [a, b, c, c] };
    (vertices.collect(), primitive.triangles.iter().map(face).collect())
}
