//! Input of View3D (.vs3): surfaces for view factors.
//!
//! Format: G. N. Walton, "Calculation of obstructed view factors by adaptive integration", NISTIR 6925, 2002, and the
//! user manual of View3D 3.3, sections 4 and 5; the forms `F 3` (numbered vertices) and `F 3a` (planes). Corners run
//! counter-clockwise seen from the front. What the kinds of surfaces mean here:
//!
//! - `S` radiates from its front; its back blocks. One surface with one face and reflectance 1 - emissivity.
//! - `S` with a base lies in the plane of its base, which is a surface or an obstruction. View3D takes its factors from
//!   those of the base, so that the base keeps what its subsurfaces leave of it: it is cut into faces.
//! - `O` only blocks, from both sides. It becomes one of [`Scene::obstructions`].
//! - `N` covers a part of its base, which then has neither area nor factors but still blocks: cut from the base, and an
//!   obstruction.
//! - `M` covers a part of its base and sees nothing else. Refused: faces without distance between them are not modelled.
//!
//! Surfaces combined with another stay apart and are in [`Scene::combined`]; what `C` asks is in [`Scene::hints`].
//! Surfaces count in the order of the file without `N` and `O`, as rows of View3D's results do before it combines them.

mod cover;
mod planes;
mod statements;

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use self::cover::Cover;
use self::statements::{Controls, Document, Entry, Kind};
use super::LoadOptions;
use super::mesh::Vertices;
use super::names::UniqueNames;
use crate::model::{Face, Finding, Hints, Material, Scene, SceneError, Surface, band_names};
use crate::quad::{self, Shape};

/// The most surfaces that may lie in one: cutting takes time with their square.
const MOST_IN_ONE: usize = 2000;

/// The least emissivity, which View3D takes as well; a surface with none would keep light forever.
const LEAST_EMISSIVITY: f64 = 0.001;

/// Reads the bytes of a file; its path serves messages.
pub(super) fn parse(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    super::check(options, &file)?;
    let fail = |fault: Fault| SceneError::new(&file, format!("line {}", fault.line), fault.message);
    let document = statements::read(&String::from_utf8_lossy(bytes)).map_err(fail)?;
    if !document.entries.iter().any(|entry| entry.kind == Kind::Radiating) {
        return Err(SceneError::new(
            file,
            "",
            "the file holds no surfaces; a line such as S 1 1 2 3 4 0 0 0.9 wall has one",
        ));
    }
    super::check_faces(document.entries.len(), options, &file)?;
    let mut scene = Builder::new(&document, options).build().map_err(fail)?;
    scene.name = super::scene_name(path);
    super::check_faces(scene.face_count(), options, &file)?;
    Ok(scene)
}

/// What is wrong, and on which line.
#[derive(Debug)]
struct Fault {
    line: usize,
    message: String,
}

impl Entry {
    fn fault(&self, message: impl Into<String>) -> Fault {
        Fault { line: self.line, message: message.into() }
    }
}

/// The scene so far.
struct Builder<'a> {
    document: &'a Document,
    options: &'a LoadOptions,
    /// For each entry those that lie in it, by their places in the document.
    inside: HashMap<usize, Vec<usize>>,
    /// Place in the document -> index of the surface.
    surface: HashMap<usize, usize>,
    names: UniqueNames,
    obstruction_names: UniqueNames,
    scene: Scene,
}

impl<'a> Builder<'a> {
    fn new(document: &'a Document, options: &'a LoadOptions) -> Self {
        let radiating = (0..document.entries.len()).filter(|&i| document.entries[i].kind == Kind::Radiating);
        Self {
            document,
            options,
            inside: HashMap::new(),
            surface: radiating.zip(0..).collect(),
            names: UniqueNames::default(),
            obstruction_names: UniqueNames::default(),
            scene: Scene { bands: band_names(1), ..Scene::default() },
        }
    }

    fn build(mut self) -> Result<Scene, Fault> {
        for (place, entry) in self.document.entries.iter().enumerate() {
            if let Some(base) = self.base(place, entry)? {
                let inside = self.inside.entry(base).or_default();
                inside.push(place);
                if inside.len() > MOST_IN_ONE {
                    return Err(entry.fault(format!("more than {MOST_IN_ONE} surfaces lie in one; divide the base")));
                }
            }
        }
        for (place, entry) in self.document.entries.iter().enumerate() {
            self.add(place, entry)?;
        }
        self.scene.hints = self.hints(&self.document.controls);
        self.findings();
        Ok(self.scene)
    }

    /// The place of the surface that this one lies in.
    fn base(&self, place: usize, entry: &Entry) -> Result<Option<usize>, Fault> {
        let entries = &self.document.entries;
        let Some(base) = entry.base.checked_sub(1) else {
            return match entry.kind {
                Kind::Null => Err(entry.fault("a null surface needs a base; name the surface that it covers")),
                _ => Ok(None),
            };
        };
        let Some(other) = entries.get(base) else {
            return Err(entry.fault(format!("its base is surface {} of {}", entry.base, entries.len())));
        };
        match (entry.kind, other.kind) {
            (_, Kind::Null) => {
                Err(entry.fault(format!("its base {} is a null surface, which has no area", entry.base)))
            }
            (Kind::Null, Kind::Obstruction) => Err(entry.fault("the base of a null surface must radiate")),
            (_, Kind::Radiating) if base >= place => Err(entry.fault("the base of a surface must come before it")),
            _ => Ok(Some(base)),
        }
    }

    fn add(&mut self, place: usize, entry: &Entry) -> Result<(), Fault> {
        let (vertices, faces) = self.shape(place, entry)?;
        match entry.kind {
            Kind::Radiating => {
                let name = self.names.claim(&entry.name);
                let reflectance = 1.0 - entry.emissivity.max(LEAST_EMISSIVITY);
                let mut material = Material::new(name.clone(), &[reflectance], &[0.0]);
                material.two_sided = self.options.two_sided.unwrap_or(false);
                if let Some(whole) = self.combined(place, entry)? {
                    self.scene.combined.insert(self.surface[&place], whole);
                }
                self.scene.surfaces.push(Surface { name, vertices, faces, material, texture: None });
            }
            Kind::Obstruction | Kind::Null => {
                let name = self.obstruction_names.claim(&entry.name);
                let material = Material::new(name.clone(), &[0.0], &[0.0]);
                self.scene.obstructions.push(Surface { name, vertices, faces, material, texture: None });
            }
        }
        Ok(())
    }

    /// Its polygon, or what those that lie in it leave of it.
    fn shape(&self, place: usize, entry: &Entry) -> Result<(Vec<DVec3>, Vec<Face>), Fault> {
        let polygons = match self.inside.get(&place) {
            Some(inside) => self.remainder(entry, inside)?,
            None => vec![padded(&entry.corners)],
        };
        let mut vertices = Vertices::default();
        let faces = polygons.iter().map(|polygon| polygon.map(|corner| vertices.index(corner))).collect();
        let metres = self.options.unit.metres();
        Ok((vertices.positions.into_iter().map(|position| metres * position).collect(), faces))
    }

    fn remainder(&self, entry: &Entry, inside: &[usize]) -> Result<Vec<[DVec3; 4]>, Fault> {
        check_shape(entry)?;
        let mut cover = Cover::new(&entry.corners);
        for part in inside.iter().map(|&place| &self.document.entries[place]) {
            check_shape(part)?;
            let faces_base = part.kind == Kind::Null;
            let mut corners = part.corners.clone();
            if faces_base {
                corners.reverse();
            }
            cover.remove(&corners).map_err(|misfit| part.fault(misfit.message(faces_base)))?;
        }
        Ok(cover.into_faces())
    }

    /// The surface that this one counts with.
    fn combined(&self, place: usize, entry: &Entry) -> Result<Option<usize>, Fault> {
        let Some(whole) = entry.combined.checked_sub(1) else { return Ok(None) };
        match self.document.entries.get(whole) {
            Some(other) if other.kind == Kind::Radiating && whole < place => {
                if other.combined > 0 {
                    return Err(entry.fault(format!(
                        "it is combined with surface {}, which is combined with another; name {} instead",
                        entry.combined, other.combined
                    )));
                }
                Ok(Some(self.surface[&whole]))
            }
            _ => Err(entry.fault(format!("it is combined with {}, which is no earlier surface", entry.combined))),
        }
    }

    fn hints(&self, controls: &Controls) -> Hints {
        let surface = |number: usize| self.surface.get(&number.checked_sub(1)?).copied();
        Hints {
            tolerance: controls.tolerance,
            enclosure: controls.enclosure,
            emissivity: controls.emissivity,
            row: surface(controls.row),
            column: surface(controls.column),
        }
    }

    fn findings(&mut self) {
        let found = &mut self.scene.findings;
        let controls = &self.document.controls;
        if !controls.ignored.is_empty() {
            let message = format!("controls without meaning here were ignored: {}", controls.ignored.join(", "));
            found.push(Finding::note("ignored-controls", "", message));
        }
        for (what, number) in [("row", controls.row), ("col", controls.column)] {
            if number > 0 && !self.surface.contains_key(&(number - 1)) {
                let message = format!("{what}={number} names no surface with factors and was ignored");
                found.push(Finding::warning("ignored-controls", "", message));
            }
        }
        if let Some((line, word)) = &self.document.unknown {
            let message =
                format!("'{word}' is no element of View3D's input; this line and others like it were ignored");
            found.push(Finding::warning("unknown-statement", format!("line {line}"), message));
        }
        let shiny: Vec<_> = self.document.entries.iter().filter(|entry| entry.emissivity < LEAST_EMISSIVITY).collect();
        if let [first, ..] = shiny[..] {
            let message = format!(
                "{} surfaces have an emissivity below {LEAST_EMISSIVITY}, which was taken instead, this one first",
                shiny.len()
            );
            found.push(Finding::note("emissivity-limited", format!("line {}", first.line), message));
        }
    }
}

/// Three or four corners as four.
fn padded(corners: &[DVec3]) -> [DVec3; 4] {
    std::array::from_fn(|i| corners[i.min(corners.len() - 1)])
}

/// Refuses what cannot be cut: unless they lie in one another, surfaces of any shape are left to the findings.
fn check_shape(entry: &Entry) -> Result<(), Fault> {
    match quad::classify(padded(&entry.corners)) {
        Shape::Sound => Ok(()),
        Shape::ZeroArea => Err(entry.fault("the surface has no area; remove it or correct its vertices")),
        Shape::NonPlanar(off) => Err(entry.fault(format!("its corners lie {off:.3e} off their plane; make it planar"))),
        Shape::NotConvex => {
            Err(entry.fault("it has an inward corner or crosses itself; order its vertices around its edge"))
        }
    }
}

#[cfg(test)]
mod tests;
