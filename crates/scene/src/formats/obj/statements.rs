//! The statements of an OBJ file.
//!
//! Format: Wavefront, "Object files (.obj)", appendix B1 of the Advanced Visualizer manual.

use std::collections::HashMap;

use glam::DVec3;

use crate::formats::mesh::{Polygons, is_coordinate};

/// What an OBJ file says.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub positions: Vec<DVec3>,
    /// Texture coordinates as the file has them: (0, 0) is the lower left corner of an image. None where they are unsound.
    pub coordinates: Vec<Option<[f64; 2]>>,
    pub groups: Vec<Group>,
    pub libraries: Vec<String>,
    /// The line of the first point, line or curve.
    pub first_without_area: Option<usize>,
    /// The line of the first face with fewer than three corners, and how many there are.
    pub slender: Option<(usize, usize)>,
}

/// Polygons that share a group name and a material.
#[derive(Debug)]
pub(super) struct Group {
    pub name: String,
    pub material: Option<String>,
    pub polygons: Polygons,
    /// Texture coordinates of each corner of the polygons; [`NO_COORDINATES`] where it has none.
    pub coordinates: Vec<u32>,
}

/// What stands for texture coordinates that a corner does not have; beyond all that there are.
pub(super) const NO_COORDINATES: u32 = u32::MAX;

/// What is wrong, and on which line.
#[derive(Debug)]
pub(super) struct Fault {
    pub line: usize,
    pub message: String,
}

impl Fault {
    pub fn element(&self) -> String {
        format!("line {}", self.line)
    }
}

/// Reads all statements; every index of the result is in range.
pub(super) fn read(text: &str) -> Result<Geometry, Fault> {
    let mut reader = Reader::default();
    for (line, statement) in logical_lines(text) {
        reader.statement(line, &statement).map_err(|message| Fault { line, message })?;
    }
    reader.check_indices()?;
    Ok(reader.geometry)
}

/// Lines with their number; a backslash at the end joins the next.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let Some(start) = line.trim_end().strip_suffix('\\') else { return Some((number + 1, line.into())) };
        let mut joined = start.to_string();
        for (_, next) in lines.by_ref() {
            joined.push(' ');
            match next.trim_end().strip_suffix('\\') {
                Some(part) => joined.push_str(part),
                None => {
                    joined.push_str(next);
                    break;
                }
            }
        }
        Some((number + 1, joined.into()))
    })
}

/// The keyword and the rest of a statement, without its comment. A `#` within a word belongs to a name.
pub(super) fn split(statement: &str) -> (&str, &str) {
    let comment = statement
        .match_indices('#')
        .find(|&(at, _)| statement[..at].chars().next_back().is_none_or(char::is_whitespace))
        .map_or(statement.len(), |(at, _)| at);
    let statement = statement[..comment].trim();
    let (keyword, rest) = statement.split_once(char::is_whitespace).unwrap_or((statement, ""));
    (keyword, rest.trim())
}

#[derive(Default)]
struct Reader {
    geometry: Geometry,
    name: String,
    material: Option<String>,
    /// The group of the current name and material, once it has a polygon.
    current: Option<usize>,
    known: HashMap<(String, Option<String>), usize>,
    /// The largest vertex index and the line that has it: vertices may follow the faces that use them.
    farthest: Option<(u32, usize)>,
}

impl Reader {
    fn statement(&mut self, line: usize, statement: &str) -> Result<(), String> {
        let (keyword, rest) = split(statement);
        match keyword {
            "v" => self.geometry.positions.push(vertex(rest)?),
            "vt" => self.geometry.coordinates.push(coordinates(rest)),
            "f" | "fo" => self.face(rest, line)?,
            "o" | "g" => self.switch(|reader| reader.name = rest.to_string()),
            "usemtl" => self.switch(|reader| reader.material = Some(rest.to_string())),
            "mtllib" => self.geometry.libraries.push(rest.to_string()),
            "l" | "p" | "curv" | "curv2" | "surf" => {
                self.geometry.first_without_area.get_or_insert(line);
            }
            _ => {}
        }
        Ok(())
    }

    fn switch(&mut self, change: impl FnOnce(&mut Self)) {
        change(self);
        self.current = None;
    }

    fn face(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let group = self.group();
        let Group { polygons, coordinates, .. } = &mut self.geometry.groups[group];
        let start = polygons.corners.len();
        for corner in rest.split_whitespace() {
            let index = index(corner, self.geometry.positions.len())?;
            if self.farthest.is_none_or(|(largest, _)| index > largest) {
                self.farthest = Some((index, line));
            }
            polygons.corners.push(index);
            coordinates.push(coordinate_index(corner, self.geometry.coordinates.len()));
        }
        if polygons.corners.len() - start >= 3 {
            polygons.ends.push(polygons.corners.len());
        } else {
            // Modellers write edges that were left over as faces of two corners.
            polygons.corners.truncate(start);
            coordinates.truncate(start);
            self.geometry.slender.get_or_insert((line, 0)).1 += 1;
        }
        Ok(())
    }

    fn group(&mut self) -> usize {
        if let Some(current) = self.current {
            return current;
        }
        let groups = &mut self.geometry.groups;
        let index = *self.known.entry((self.name.clone(), self.material.clone())).or_insert_with(|| {
            let (name, material) = (self.name.clone(), self.material.clone());
            groups.push(Group { name, material, polygons: Polygons::default(), coordinates: Vec::new() });
            groups.len() - 1
        });
        self.current = Some(index);
        index
    }

    fn check_indices(&self) -> Result<(), Fault> {
        let count = self.geometry.positions.len();
        match self.farthest {
            Some((index, line)) if index as usize >= count => {
                let vertex = u64::from(index) + 1;
                let message = format!("the face refers to vertex {vertex} of {count}; export the file again");
                Err(Fault { line, message })
            }
            _ => Ok(()),
        }
    }
}

fn vertex(rest: &str) -> Result<DVec3, String> {
    let mut numbers = rest.split_whitespace().map(str::parse::<f64>);
    let mut next = || match numbers.next() {
        Some(Ok(number)) if is_coordinate(number) => Ok(number),
        Some(_) => Err(format!("'{rest}' are not three finite coordinates; repair the vertex")),
        None => Err(format!("the vertex '{rest}' has fewer than three coordinates; repair it")),
    };
    Ok(DVec3::new(next()?, next()?, next()?))
}

/// One or two numbers; none if they are not finite numbers.
fn coordinates(rest: &str) -> Option<[f64; 2]> {
    let mut numbers = rest.split_whitespace().map(|word| word.parse::<f64>().ok().filter(|c| is_coordinate(*c)));
    let u = numbers.next()??;
    Some([u, numbers.next().unwrap_or(Some(0.0))?])
}

/// The texture coordinates of a corner such as `7/1/3`, counted from zero; `count` came before. Whether there are so many
/// is for those who use them.
fn coordinate_index(corner: &str, count: usize) -> u32 {
    let number: i64 = corner.split('/').nth(1).and_then(|word| word.parse().ok()).unwrap_or(0);
    let index = match number {
        0 => return NO_COORDINATES,
        1.. => number - 1,
        _ => (count as i64).saturating_add(number),
    };
    u32::try_from(index).unwrap_or(NO_COORDINATES)
}

/// The vertex of a corner such as `7`, `7/1/3` or `-2//-2`, counted from zero. `count` vertices came before.
fn index(corner: &str, count: usize) -> Result<u32, String> {
    let vertex = corner.split('/').next().unwrap_or_default();
    let number: i64 = vertex.parse().map_err(|_| format!("'{corner}' is not a vertex index; repair the face"))?;
    let index = match number {
        0 => return Err("the face refers to vertex 0; OBJ counts from 1".into()),
        1.. => number - 1,
        // Relative to the vertices so far; the smallest integer must not overflow.
        _ => (count as i64).saturating_add(number),
    };
    u32::try_from(index).map_err(|_| format!("the face refers to vertex {number} of {count}; export the file again"))
}
