//! The material library of an OBJ file (.mtl).
//!
//! `Kd` is the reflectance and `map_Kd` its texture, where there are texture coordinates, and else counts by its mean; `Ke`
//! x mean of `map_Ke` is the radiance. Format: Wavefront, "MTL material
//! format", 1995; `Ke` and `map_Ke` are a later custom that all current exporters follow.

use std::collections::HashMap;
use std::sync::Arc;

use radiosity_geometry::texture::{Raster, Wrap};

use super::statements::{logical_lines, split};
use crate::formats::colour::{self, UNKNOWN_REFLECTANCE, times};
use crate::formats::folder::Folder;
use crate::formats::mesh::is_coordinate;
use crate::formats::names::Roll;
use crate::formats::texture::{self, MOST_BYTES, NO_ROOM, Wrapped, mean};
use crate::model::{Finding, Material, SceneError};

/// Neither libraries nor images need more.
const MAX_BYTES: u64 = 1 << 30;

/// The materials an OBJ file may use.
pub(super) struct Library<'a> {
    folder: &'a Folder,
    entries: HashMap<String, Entry>,
    images: HashMap<String, Result<[f64; 3], String>>,
    textures: HashMap<String, Result<texture::Texture, String>>,
    wrapped: Wrapped<String>,
    /// Bytes left for textures.
    room: usize,
    findings: Vec<Finding>,
    roll: Roll,
}

/// What the library says of one material.
#[derive(Clone, Debug, Default, PartialEq)]
struct Entry {
    diffuse: Option<[f64; 3]>,
    diffuse_image: Option<Map>,
    radiance: Option<[f64; 3]>,
    radiance_image: Option<Map>,
    transparent: bool,
}

/// A map statement: the file and what of its options matters.
#[derive(Clone, Debug, PartialEq)]
struct Map {
    file: String,
    scale: [f64; 2],
    offset: [f64; 2],
    clamps: bool,
}

/// The image of a material for a surface that has texture coordinates.
pub(super) struct Painted {
    pub image: Arc<Raster>,
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Painted {
    /// Coordinates on the image as the engine takes them, from its upper left corner.
    pub fn moved(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        [self.scale[0] * u + self.offset[0], 1.0 - (self.scale[1] * v + self.offset[1])]
    }
}

impl<'a> Library<'a> {
    /// Reads the libraries that the `mtllib` statements name.
    pub fn open(statements: &[String], folder: &'a Folder) -> Result<Self, SceneError> {
        let mut library = Self {
            folder,
            entries: HashMap::new(),
            images: HashMap::new(),
            textures: HashMap::new(),
            wrapped: Wrapped::default(),
            room: MOST_BYTES,
            findings: Vec::new(),
            roll: Roll::default(),
        };
        for statement in statements {
            library.open_statement(statement)?;
        }
        Ok(library)
    }

    /// A statement is one name that may contain blanks, or several names between blanks.
    fn open_statement(&mut self, statement: &str) -> Result<(), SceneError> {
        let names: Vec<&str> = match self.folder.read(statement, 1) {
            Ok(_) => vec![statement],
            Err(_) => statement.split_whitespace().collect(),
        };
        for name in names {
            match self.folder.read(name, MAX_BYTES) {
                Ok(bytes) => self.entries.extend(entries(name, &String::from_utf8_lossy(&bytes))?),
                Err(fault) => self.findings.push(Finding::warning(
                    "missing-library",
                    format!("material library '{name}'"),
                    format!("{fault}; its materials were given reflectance 0.5 and no emission"),
                )),
            }
        }
        Ok(())
    }

    /// Whether an image goes with the reflectance of a material.
    pub fn has_image(&self, name: Option<&str>) -> bool {
        name.and_then(|name| self.entries.get(name)).is_some_and(|entry| entry.diffuse_image.is_some())
    }

    /// The material of a name, and its image for surfaces with texture coordinates.
    pub fn material(
        &mut self,
        name: Option<&str>,
        has_coordinates: bool,
    ) -> Result<(Material, Option<Painted>), SceneError> {
        let grey = |name: &str| Material::new(name, &[UNKNOWN_REFLECTANCE; 3], &[0.0; 3]);
        let Some(name) = name else {
            let message = "surfaces without material were given reflectance 0.5; assign one";
            self.roll.warn("no-material", "material", "none", message);
            return Ok((grey("none"), None));
        };
        let Some(entry) = self.entries.get(name).cloned() else {
            let message = "no library defines it and reflectance 0.5 was taken; supply the .mtl file";
            self.roll.warn("unknown-material", "material", name, message);
            return Ok((grey(name), None));
        };
        if entry.transparent {
            let message = "transparency is not modelled and they were read as opaque and diffuse; remove panes that \
                           should let light through";
            self.roll.warn("transparent-material", "material", name, message);
        }
        let (reflectance, painted) = match self.painted(&entry, name, has_coordinates) {
            Some((reflectance, painted)) => (reflectance, Some(painted)),
            None => {
                let mean = self.reflectance(&entry, name);
                (colour::limited(mean, name, &mut self.roll), None)
            }
        };
        let emission = colour::exitance(self.radiance(&entry, name));
        Ok((Material::new(name, &reflectance, &emission), painted))
    }

    /// The image of a material, and what multiplies it; none if there is none that can be laid on a surface.
    fn painted(&mut self, entry: &Entry, name: &str, has_coordinates: bool) -> Option<([f64; 3], Painted)> {
        let Map { file, scale, offset, clamps } = entry.diffuse_image.clone()?;
        let factor = entry.diffuse.unwrap_or([1.0; 3]);
        if factor == [0.0; 3] {
            return None;
        }
        if !has_coordinates && self.mean(&file).is_ok() {
            let message = "surfaces have no sound texture coordinates for its map_Kd, and the mean of the image was \
                           taken; export them along with the mesh";
            self.roll.warn("no-texture-coordinates", "material", name, message);
        }
        if !has_coordinates {
            return None;
        }
        let (folder, room) = (self.folder, &mut self.room);
        let read = || texture::texture(&folder.read(&file, MAX_BYTES)?, room);
        let texture = self.textures.entry(file.clone()).or_insert_with(read).as_ref().ok()?;
        let Some(image) = &texture.image else {
            let element = format!("material '{name}', map_Kd '{file}'");
            self.findings.push(Finding::warning("texture-averaged", element, NO_ROOM));
            return None;
        };
        let (reflectance, is_limited) = colour::limited_with(factor, texture.brightest, name, &mut self.roll);
        let wrap = if clamps { Wrap::Clamp } else { Wrap::Repeat };
        let image = self.wrapped.get(file, image, [wrap; 2], is_limited);
        Some((reflectance, Painted { image, scale, offset }))
    }

    pub fn into_findings(mut self) -> Vec<Finding> {
        self.findings.extend(self.roll.into_findings());
        self.findings
    }

    fn reflectance(&mut self, entry: &Entry, name: &str) -> [f64; 3] {
        match (entry.diffuse, &entry.diffuse_image) {
            (Some(colour), None) => colour,
            (colour, Some(image)) => {
                times(colour.unwrap_or([1.0; 3]), self.image(&image.file, name, "map_Kd", UNKNOWN_REFLECTANCE))
            }
            (None, None) => {
                let message = "it has no Kd and reflectance 0.5 was taken; add a line Kd to the .mtl file";
                self.roll.warn("no-diffuse-colour", "material", name, message);
                [UNKNOWN_REFLECTANCE; 3]
            }
        }
    }

    fn radiance(&mut self, entry: &Entry, name: &str) -> [f64; 3] {
        match (entry.radiance, &entry.radiance_image) {
            (Some(radiance), Some(image)) if radiance != [0.0; 3] => {
                times(radiance, self.image(&image.file, name, "map_Ke", 1.0))
            }
            (radiance, _) => radiance.unwrap_or_default(),
        }
    }

    fn mean(&mut self, file: &str) -> Result<[f64; 3], String> {
        let folder = self.folder;
        let read = || mean(&folder.read(file, MAX_BYTES)?).map(|mean| mean.colour);
        self.images.entry(file.to_string()).or_insert_with(read).clone()
    }

    /// The mean colour of an image, or `otherwise` and a finding.
    fn image(&mut self, file: &str, material: &str, what: &str, otherwise: f64) -> [f64; 3] {
        self.mean(file).unwrap_or_else(|fault| {
            self.findings.push(Finding::warning(
                "unreadable-texture",
                format!("material '{material}', {what} '{file}'"),
                format!("it cannot be read ({fault}); {otherwise} was taken for it; supply it as PNG or JPEG"),
            ));
            [otherwise; 3]
        })
    }
}

/// The materials of one library.
fn entries(file: &str, text: &str) -> Result<HashMap<String, Entry>, SceneError> {
    let mut entries = HashMap::new();
    let mut current: Option<(String, Entry)> = None;
    for (line, statement) in logical_lines(text) {
        let (keyword, rest) = split(&statement);
        if keyword == "newmtl" {
            entries.extend(current.replace((rest.to_string(), Entry::default())));
        } else if let Some((name, entry)) = &mut current {
            let fail = |message| SceneError::new(file, format!("line {line}, material '{name}'"), message);
            property(entry, keyword, rest).map_err(fail)?;
        }
    }
    entries.extend(current);
    Ok(entries)
}

fn property(entry: &mut Entry, keyword: &str, rest: &str) -> Result<(), String> {
    match keyword {
        "Kd" => entry.diffuse = colour(rest)?.map(fraction).transpose()?,
        "Ke" => entry.radiance = colour(rest)?.map(power).transpose()?,
        "map_Kd" => entry.diffuse_image = Some(map(rest)),
        "map_Ke" => entry.radiance_image = Some(map(rest)),
        "d" => entry.transparent |= rest.parse::<f64>().is_ok_and(|opacity| opacity < 1.0),
        "Tr" => entry.transparent |= rest.parse::<f64>().is_ok_and(|transparency| transparency > 0.0),
        _ => {}
    }
    Ok(())
}

/// Three numbers or one for all; `None` for spectral files and other notations.
fn colour(rest: &str) -> Result<Option<[f64; 3]>, String> {
    if rest.starts_with("spectral") || rest.starts_with("xyz") {
        return Ok(None);
    }
    let numbers: Result<Vec<f64>, _> = rest.split_whitespace().map(str::parse).collect();
    match numbers.as_deref() {
        Ok(&[grey]) => Ok(Some([grey; 3])),
        Ok(&[r, g, b, ..]) => Ok(Some([r, g, b])),
        _ => Err(format!("'{rest}' is not a colour; give three numbers")),
    }
}

fn fraction(colour: [f64; 3]) -> Result<[f64; 3], String> {
    let message = || format!("its Kd {colour:?} must lie within 0 and 1; correct it");
    colour::is_fraction(colour).then_some(colour).ok_or_else(message)
}

fn power(colour: [f64; 3]) -> Result<[f64; 3], String> {
    let message = || format!("its Ke {colour:?} must be finite and not negative; correct it");
    colour::is_power(colour).then_some(colour).ok_or_else(message)
}

/// A map statement, whose options such as `-s 1 1 1` stand before the name of the file.
fn map(rest: &str) -> Map {
    let words: Vec<&str> = rest.split_whitespace().collect();
    let has_options = rest.starts_with('-');
    let name = if has_options { words.last().copied().unwrap_or_default() } else { rest };
    let options = if has_options { &words[..words.len() - 1] } else { &[][..] };
    let after = |option: &str| options.iter().position(|word| *word == option).map(|at| &options[at + 1..]);
    let pair = |option: &str, otherwise: f64| {
        let number = |k: usize| after(option)?.get(k)?.parse::<f64>().ok().filter(|n| is_coordinate(*n));
        let first = number(0);
        [first.unwrap_or(otherwise), first.and_then(|_| number(1)).unwrap_or(otherwise)]
    };
    Map {
        file: name.replace('\\', "/"),
        scale: pair("-s", 1.0),
        offset: pair("-o", 0.0),
        clamps: after("-clamp").is_some_and(|rest| rest.first() == Some(&"on")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_are_read_by_material() {
        let text = "# made by hand\nnewmtl oak\nKd 0.4 0.3 0.2\nmap_Kd -s 1 1 1 tex\\oak.png\nnewmtl lamp\nKe 5\nd 0.5";
        let entries = entries("a.mtl", text).unwrap();
        assert_eq!(entries["oak"].diffuse, Some([0.4, 0.3, 0.2]));
        assert_eq!(entries["oak"].diffuse_image, Some(map("tex/oak.png")));
        assert_eq!(entries["lamp"].radiance, Some([5.0; 3]));
        assert!(entries["lamp"].transparent);
    }

    #[test]
    fn maps_are_scaled_moved_and_clamped_and_v_points_down() {
        let Map { file, scale, offset, clamps } = map("-s 2 3 1 -o 0.5 -mm 0 1 -clamp on a.png");
        assert_eq!((file.as_str(), scale, offset, clamps), ("a.png", [2.0, 3.0], [0.5, 0.0], true));
        let plain = map("my oak.png");
        assert_eq!(
            (plain.file.as_str(), plain.scale, plain.offset, plain.clamps),
            ("my oak.png", [1.0; 2], [0.0; 2], false)
        );
        assert_eq!(map("-s x -o nan -clamp").file, "-clamp");
        let image = Arc::new(Raster::of_values([1, 1], 1, vec![1.0]));
        let painted = Painted { image, scale, offset };
        assert_eq!(painted.moved([0.25, 0.1]), [1.0, 1.0 - 3.0 * 0.1]);
    }

    #[test]
    fn impossible_colours_name_their_line() {
        for line in ["Kd 1.5 0 0", "Kd nan 0 0", "Kd -0.1", "Ke -1 0 0", "Ke inf inf inf", "Kd red", "Kd", "Kd 1 2"] {
            let error = entries("a.mtl", &format!("newmtl m\n{line}")).unwrap_err().to_string();
            assert!(error.starts_with("a.mtl: line 2, material 'm': "), "{line}: {error}");
        }
        assert!(entries("a.mtl", "newmtl m\nKd spectral file.rfl").unwrap()["m"].diffuse.is_none());
    }
}
