//! STL as text: `facet normal`, `outer loop`, three of `vertex`, `endloop`, `endfacet`, between `solid` and `endsolid`.

use std::str::SplitWhitespace;

use glam::DVec3;

use super::{Content, Fault, Solid};
use crate::formats::mesh::is_coordinate;
use crate::model::Finding;

/// Reads all solids.
pub(super) fn read(bytes: &[u8]) -> Result<Content, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    let mut last = 0;
    for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        last = number + 1;
        reader.line(line).map_err(|message| Fault { element: format!("line {last}"), message })?;
    }
    if !reader.corners.is_empty() {
        let message = "the file ends within a facet; it was cut short".into();
        return Err(Fault { element: format!("line {last}"), message });
    }
    if reader.is_open {
        let message = "the file ends without endsolid; it may have been cut short";
        reader.content.findings.push(Finding::warning("no-endsolid", format!("line {last}"), message));
    }
    Ok(reader.content)
}

#[derive(Default)]
struct Reader {
    content: Content,
    /// Whether a solid began and has not ended.
    is_open: bool,
    normal: DVec3,
    corners: Vec<DVec3>,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => self.solid(words.collect::<Vec<_>>().join(" "))?,
            "facet" => self.normal = vector(words.by_ref().skip(1)).unwrap_or(DVec3::ZERO),
            "vertex" => self.corners.push(vertex(words)?),
            "outer" if !self.corners.is_empty() => return Err("a loop begins before the last one ends".into()),
            "endloop" => self.facet()?,
            "endsolid" => self.is_open = false,
            "outer" | "endfacet" | "color" => {}
            _ => return Err(format!("'{keyword}' is no keyword of STL; export the file again")),
        }
        Ok(())
    }

    fn solid(&mut self, name: String) -> Result<(), String> {
        if !self.corners.is_empty() {
            return Err("a solid begins within a facet; export the file again".into());
        }
        self.content.solids.push(Solid { name, ..Solid::default() });
        self.is_open = true;
        Ok(())
    }

    fn facet(&mut self) -> Result<(), String> {
        let corners = std::mem::take(&mut self.corners);
        let normal = std::mem::take(&mut self.normal);
        let Some(solid) = self.content.solids.last_mut().filter(|_| self.is_open) else {
            return Err("a facet lies outside of any solid; export the file again".into());
        };
        if corners.len() < 3 {
            return Err(format!("the facet has {} corners; a triangle needs three", corners.len()));
        }
        solid.push(&corners, normal);
        Ok(())
    }
}

fn vertex(words: SplitWhitespace) -> Result<DVec3, String> {
    let text = words.clone().collect::<Vec<_>>().join(" ");
    let position = vector(words).filter(|v| v.to_array().into_iter().all(is_coordinate));
    position.ok_or_else(|| format!("'{text}' are not three finite coordinates; repair the vertex"))
}

fn vector<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut next = || words.next()?.parse::<f64>().ok();
    Some(DVec3::new(next()?, next()?, next()?))
}
