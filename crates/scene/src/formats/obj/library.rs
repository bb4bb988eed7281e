//! The material library of an OBJ file (.mtl).
//!
//! `Kd` x mean of `map_Kd` is the reflectance, `Ke` x mean of `map_Ke` the radiance. Format: Wavefront, "MTL material
//! format", 1995; `Ke` and `map_Ke` are a later custom that all current exporters follow.

use std::collections::HashMap;

use super::statements::{logical_lines, split};
use crate::formats::colour::{self, UNKNOWN_REFLECTANCE, times};
use crate::formats::folder::Folder;
use crate::formats::names::Roll;
use crate::formats::texture::mean;
use crate::model::{Finding, Material, SceneError};

/// Neither libraries nor images need more.
const MAX_BYTES: u64 = 1 << 30;

/// The materials an OBJ file may use.
pub(super) struct Library<'a> {
    folder: &'a Folder,
    entries: HashMap<String, Entry>,
    images: HashMap<String, Result<[f64; 3], String>>,
    findings: Vec<Finding>,
    roll: Roll,
}

/// What the library says of one material.
#[derive(Clone, Debug, Default, PartialEq)]
struct Entry {
    diffuse: Option<[f64; 3]>,
    diffuse_image: Option<String>,
    radiance: Option<[f64; 3]>,
    radiance_image: Option<String>,
    transparent: bool,
}

impl<'a> Library<'a> {
    /// Reads the libraries that the `mtllib` statements name.
    pub fn open(statements: &[String], folder: &'a Folder) -> Result<Self, SceneError> {
        let mut library = Self {
            folder,
            entries: HashMap::new(),
            images: HashMap::new(),
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

    /// The material of a name.
    pub fn material(&mut self, name: Option<&str>) -> Result<Material, SceneError> {
        let grey = |name: &str| Material::new(name, &[UNKNOWN_REFLECTANCE; 3], &[0.0; 3]);
        let Some(name) = name else {
            let message = "surfaces without material were given reflectance 0.5; assign one";
            self.roll.warn("no-material", "material", "none", message);
            return Ok(grey("none"));
        };
        let Some(entry) = self.entries.get(name).cloned() else {
            let message = "no library defines it and reflectance 0.5 was taken; supply the .mtl file";
            self.roll.warn("unknown-material", "material", name, message);
            return Ok(grey(name));
        };
        if entry.transparent {
            let message = "transparency is not modelled and they were read as opaque and diffuse; remove panes that \
                           should let light through";
            self.roll.warn("transparent-material", "material", name, message);
        }
        let reflectance = self.reflectance(&entry, name);
        let reflectance = colour::limited(reflectance, name, &mut self.roll);
        let emission = colour::exitance(self.radiance(&entry, name));
        Ok(Material::new(name, &reflectance, &emission))
    }

    pub fn into_findings(mut self) -> Vec<Finding> {
        self.findings.extend(self.roll.into_findings());
        self.findings
    }

    fn reflectance(&mut self, entry: &Entry, name: &str) -> [f64; 3] {
        match (entry.diffuse, &entry.diffuse_image) {
            (Some(colour), None) => colour,
            (colour, Some(image)) => {
                times(colour.unwrap_or([1.0; 3]), self.image(image, name, "map_Kd", UNKNOWN_REFLECTANCE))
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
                times(radiance, self.image(image, name, "map_Ke", 1.0))
            }
            (radiance, _) => radiance.unwrap_or_default(),
        }
    }

    /// The mean colour of an image, or `otherwise` and a finding.
    fn image(&mut self, file: &str, material: &str, what: &str, otherwise: f64) -> [f64; 3] {
        let folder = self.folder;
        let read = || mean(&folder.read(file, MAX_BYTES)?).map(|mean| mean.colour);
        let result = self.images.entry(file.to_string()).or_insert_with(read);
        result.clone().unwrap_or_else(|fault| {
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
        "map_Kd" => entry.diffuse_image = Some(image_name(rest)),
        "map_Ke" => entry.radiance_image = Some(image_name(rest)),
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

/// The file of a map statement, which options such as `-s 1 1 1` may precede.
fn image_name(rest: &str) -> String {
    let name = if rest.starts_with('-') { rest.split_whitespace().last().unwrap_or_default() } else { rest };
    name.replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_are_read_by_material() {
        let text = "# made by hand\nnewmtl oak\nKd 0.4 0.3 0.2\nmap_Kd -s 1 1 1 tex\\oak.png\nnewmtl lamp\nKe 5\nd 0.5";
        let entries = entries("a.mtl", text).unwrap();
        assert_eq!(entries["oak"].diffuse, Some([0.4, 0.3, 0.2]));
        assert_eq!(entries["oak"].diffuse_image.as_deref(), Some("tex/oak.png"));
        assert_eq!(entries["lamp"].radiance, Some([5.0; 3]));
        assert!(entries["lamp"].transparent);
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
