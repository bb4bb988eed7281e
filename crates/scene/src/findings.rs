//! The rules a scene must keep, and what is said when it does not.
//!
//! Each rule appends findings and knows nothing of the others. Rules about one surface report once per surface with
//! a count, so that a broken file does not answer with a million sentences.

mod edges;
mod overlaps;

use std::collections::HashMap;

use glam::DVec3;

use self::overlaps::{corner_key, duplicate_faces};
use crate::model::{Camera, Finding, Light, Scene, SceneError, Severity, Surface};
use crate::quad::{self, Shape};

/// Above this reflectance solutions need hundreds of bounces and small errors grow.
const HIGH_REFLECTANCE: f64 = 0.95;

/// Diagonals in metres outside which the unit of length is probably wrong.
const PLAUSIBLE_SIZE: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

impl Scene {
    /// All that the loader noticed, followed by all that the rules find. Whether the surfaces enclose a space is asked
    /// only where the scene says that they should, in [`Scene::hints`].
    pub fn findings(&self) -> Vec<Finding> {
        let mut found = self.essential_findings();
        if self.is_indexed() {
            edges::mixed_winding(self, &mut found);
            overlaps::overlapping_faces(self, &mut found);
        }
        if self.hints.enclosure {
            found.extend(self.enclosure_findings());
        }
        found
    }

    /// Where the surfaces fail to enclose a space that they see: edges of one face only, edges where more than two meet,
    /// surfaces turned outward. Only the author of a scene knows whether it should be closed.
    pub fn enclosure_findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        if self.is_indexed() {
            edges::enclosure(self, &mut found);
        }
        found
    }

    /// Whether all corners of all surfaces are points.
    fn is_indexed(&self) -> bool {
        let mut ignored = Vec::new();
        let mut is_indexed =
            |s: &Surface| vertices_are_finite(s, "", &mut ignored) && indices_in_range(s, "", &mut ignored);
        self.surfaces.iter().all(&mut is_indexed)
    }

    /// All findings that may be errors, and those that come with them.
    fn essential_findings(&self) -> Vec<Finding> {
        let mut found = self.findings.clone();
        found.extend(geometry_findings(self));
        found.extend(optics_findings(self));
        found.extend(light_findings(self));
        found
    }

    /// Whether the scene can be lit.
    ///
    /// # Errors
    /// The first finding of severity [`Severity::Error`], a missing light included.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.refuse(self.essential_findings())
    }

    /// Whether the shapes are sound, whatever the materials and lights: all that form factors need.
    ///
    /// # Errors
    /// The first error among vertices and faces.
    pub fn validate_geometry(&self) -> Result<(), SceneError> {
        self.refuse(geometry_findings(self))
    }

    fn refuse(&self, found: Vec<Finding>) -> Result<(), SceneError> {
        match found.into_iter().find(|finding| finding.severity == Severity::Error) {
            Some(finding) => Err(SceneError::new(&self.name, finding.element, finding.message)),
            None => Ok(()),
        }
    }
}

fn geometry_findings(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    if scene.face_count() == 0 {
        let message = "the scene has no faces; add surfaces with triangles or quads";
        found.push(Finding::error("no-faces", "", message));
    }
    let mut sound = true;
    for (surface, name) in scene.surfaces.iter().map(|surface| (surface, named(surface))) {
        empty_surface(surface, &name, &mut found);
        sound &= shape_findings(surface, &name, &mut found);
    }
    for obstruction in &scene.obstructions {
        sound &= shape_findings(obstruction, &format!("obstruction '{}'", obstruction.name), &mut found);
    }
    repeated_names(scene, &mut found);
    combinations(scene, &mut found);
    if sound {
        duplicate_faces(scene, &mut found);
        plausible_size(scene, &mut found);
    }
    found
}

/// The rules about one surface by itself, called `name` in messages; whether others can look at its corners.
fn shape_findings(surface: &Surface, name: &str, found: &mut Vec<Finding>) -> bool {
    let indexed = vertices_are_finite(surface, name, found) & indices_in_range(surface, name, found);
    if indexed {
        face_shapes(surface, name, found);
        unused_vertices(surface, name, found);
    }
    indexed
}

fn optics_findings(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    if scene.bands.is_empty() {
        let message = "the scene has no bands; name at least one, such as R, G and B";
        found.push(Finding::error("no-bands", "", message));
    }
    for surface in &scene.surfaces {
        spectrum_lengths(scene, surface, &mut found);
        reflectances(scene, surface, &mut found);
        emissions(scene, surface, &mut found);
    }
    found
}

fn light_findings(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    for light in &scene.lights {
        light_rules(scene, light, &mut found);
    }
    for camera in &scene.cameras {
        camera_rules(camera, &mut found);
    }
    if !scene.has_light() {
        let message = "nothing in the scene emits; give a material an emission or add a light";
        found.push(Finding::error("no-light", "", message));
    }
    found
}

fn named(surface: &Surface) -> String {
    format!("surface '{}'", surface.name)
}

fn empty_surface(surface: &Surface, name: &str, found: &mut Vec<Finding>) {
    if surface.faces.is_empty() {
        let message = "has no faces and takes no part; remove it";
        found.push(Finding::warning("empty-surface", name, message));
    }
}

fn vertices_are_finite(surface: &Surface, name: &str, found: &mut Vec<Finding>) -> bool {
    let Some(bad) = surface.vertices.iter().position(|vertex| !vertex.is_finite()) else {
        return true;
    };
    let v = surface.vertices[bad];
    found.push(Finding::error(
        "non-finite-vertex",
        format!("{name}, vertex {bad}"),
        format!("its position ({}, {}, {}) is not finite; repair the mesh", v.x, v.y, v.z),
    ));
    false
}

fn indices_in_range(surface: &Surface, name: &str, found: &mut Vec<Finding>) -> bool {
    let count = surface.vertices.len();
    let out_of_range = |face: &[u32; 4]| face.iter().any(|&vertex| vertex as usize >= count);
    let Some(bad) = surface.faces.iter().position(out_of_range) else { return true };
    found.push(Finding::error(
        "index-out-of-range",
        format!("{name}, face {bad}"),
        format!("it refers to vertices {:?} of {count}; indices count from 0", surface.faces[bad]),
    ));
    false
}

/// The first face of a kind and how many more there are.
#[derive(Default)]
struct Tally {
    first: Option<(usize, f64)>,
    count: usize,
}

impl Tally {
    fn add(&mut self, face: usize, measure: f64) {
        self.first.get_or_insert((face, measure));
        self.count += 1;
    }

    fn and_more(&self) -> String {
        match self.count {
            0 | 1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        }
    }
}

fn face_shapes(surface: &Surface, name: &str, found: &mut Vec<Finding>) {
    let [mut flat, mut bent, mut folded] = [const { Tally { first: None, count: 0 } }; 3];
    for (i, &face) in surface.faces.iter().enumerate() {
        match quad::classify(surface.corners(face)) {
            Shape::Sound => {}
            Shape::ZeroArea => flat.add(i, 0.0),
            Shape::NonPlanar(off) => bent.add(i, off),
            Shape::NotConvex => folded.add(i, 0.0),
        }
    }
    if let Some((i, off)) = bent.first {
        found.push(Finding::error(
            "non-planar-face",
            format!("{name}, face {i}{}", bent.and_more()),
            format!("the corners of the quad lie {off:.3e} m off their plane; split it in triangles"),
        ));
    }
    if let Some((i, _)) = folded.first {
        found.push(Finding::error(
            "non-convex-face",
            format!("{name}, face {i}{}", folded.and_more()),
            "the quad has an inward corner or crosses itself; order its corners around its edge or split it in triangles",
        ));
    }
    if let Some((i, _)) = flat.first {
        let count = flat.count;
        found.push(Finding::warning(
            "zero-area-faces",
            name,
            format!("{count} of {} faces have no area, face {i} first; they are left out", surface.faces.len()),
        ));
    }
}

fn unused_vertices(surface: &Surface, name: &str, found: &mut Vec<Finding>) {
    let mut used = vec![false; surface.vertices.len()];
    for &vertex in surface.faces.iter().flatten() {
        used[vertex as usize] = true;
    }
    let unused = used.iter().filter(|&&used| !used).count();
    if unused > 0 && !surface.faces.is_empty() {
        let message = format!("{unused} of {} vertices belong to no face", used.len());
        found.push(Finding::note("unused-vertices", name, message));
    }
}

fn repeated_names(scene: &Scene, found: &mut Vec<Finding>) {
    let mut seen = HashMap::new();
    for surface in &scene.surfaces {
        *seen.entry(surface.name.as_str()).or_insert(0) += 1;
    }
    for surface in &scene.surfaces {
        if let Some(count @ 2..) = seen.remove(surface.name.as_str()) {
            let message = format!("{count} surfaces share this name; results by name will be ambiguous");
            found.push(Finding::warning("repeated-name", named(surface), message));
        }
    }
}

/// Surfaces count with one that exists and counts by itself.
fn combinations(scene: &Scene, found: &mut Vec<Finding>) {
    let count = scene.surfaces.len();
    for (&part, &whole) in &scene.combined {
        let message = if part >= count || whole >= count {
            format!("surface {part} counts with surface {whole}, of {count}; indices count from 0")
        } else if part == whole || scene.combined.contains_key(&whole) {
            format!("surface {part} counts with surface {whole}, which counts with another; name the last one")
        } else {
            continue;
        };
        found.push(Finding::error("combined-surfaces", "", message));
    }
}

fn plausible_size(scene: &Scene, found: &mut Vec<Finding>) {
    let Some((low, high)) = scene.bounds() else { return };
    let diagonal = (high - low).length();
    if !PLAUSIBLE_SIZE.contains(&diagonal) && scene.face_count() > 0 {
        let message = format!(
            "the scene measures {diagonal:.3e} m across; if that is a mistake, give the unit of the file, as in --unit mm"
        );
        found.push(Finding::warning("implausible-size", "", message));
    }
}

fn spectrum_lengths(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let bands = scene.bands.len();
    let spectra = [("reflectance", surface.material.reflectance.len()), ("emission", surface.material.emission.len())];
    for (what, length) in spectra {
        if length != bands {
            let message = format!("its {what} has {length} values for {bands} bands; give one per band");
            found.push(Finding::error("spectrum-length", named(surface), message));
        }
    }
}

fn band(scene: &Scene, index: usize) -> String {
    scene.bands.get(index).cloned().unwrap_or_else(|| index.to_string())
}

fn reflectances(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let spectrum = &surface.material.reflectance;
    if let Some(i) = spectrum.iter().position(|rho| !(0.0..1.0).contains(rho)) {
        let message = format!(
            "its reflectance in band {} is {}; it must be at least 0 and less than 1",
            band(scene, i),
            spectrum[i]
        );
        found.push(Finding::error("reflectance-range", named(surface), message));
    } else if let Some(i) = spectrum.iter().position(|&rho| rho > HIGH_REFLECTANCE) {
        let message = format!(
            "its reflectance in band {} is {}; real paints stay below 0.9 and such values take long to solve",
            band(scene, i),
            spectrum[i]
        );
        found.push(Finding::note("high-reflectance", named(surface), message));
    }
}

fn emissions(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let spectrum = &surface.material.emission;
    if let Some(i) = first_improper(spectrum) {
        let message =
            format!("its emission in band {} is {}; it must be finite and not negative", band(scene, i), spectrum[i]);
        found.push(Finding::error("emission-range", named(surface), message));
    }
}

fn first_improper(spectrum: &[f64]) -> Option<usize> {
    spectrum.iter().position(|power| !(power.is_finite() && *power >= 0.0))
}

fn light_rules(scene: &Scene, light: &Light, found: &mut Vec<Finding>) {
    let element = || format!("light '{}'", light.name());
    let power = light.power();
    if power.len() != scene.bands.len() {
        let message = format!("it has {} values for {} bands; give one per band", power.len(), scene.bands.len());
        found.push(Finding::error("spectrum-length", element(), message));
    }
    if let Some(i) = first_improper(power) {
        let message =
            format!("its intensity in band {} is {}; it must be finite and not negative", band(scene, i), power[i]);
        found.push(Finding::error("light-intensity", element(), message));
    } else if power.iter().all(|&power| power == 0.0) {
        let message = "its intensity is zero; remove it or raise it";
        found.push(Finding::warning("dark-light", element(), message));
    }
    if let Some(message) = misplaced(light) {
        found.push(Finding::error("light-placement", element(), message));
    }
}

/// What is wrong with the position, direction and cone of a light.
fn misplaced(light: &Light) -> Option<&'static str> {
    let (position, direction) = match light {
        Light::Point { position, .. } => (*position, DVec3::Z),
        Light::Spot { position, direction, .. } => (*position, *direction),
        Light::Directional { direction, .. } => (DVec3::ZERO, *direction),
    };
    if !position.is_finite() {
        return Some("its position is not finite; place it within the scene");
    }
    let off_unit = (direction.length() - 1.0).abs();
    if off_unit.is_nan() || off_unit > 1e-6 {
        return Some("its direction is not a unit vector; normalise it");
    }
    if let Light::Spot { inner_angle, outer_angle, .. } = light {
        let ordered = 0.0 <= *inner_angle && inner_angle <= outer_angle;
        let within = 0.0 < *outer_angle && *outer_angle <= std::f64::consts::FRAC_PI_2 + 1e-6;
        if !(ordered && within) {
            return Some("its cone must have 0 <= inner <= outer <= pi/2 with outer above 0");
        }
    }
    None
}

fn camera_rules(camera: &Camera, found: &mut Vec<Finding>) {
    let vectors = [camera.position, camera.forward, camera.up];
    let upright = camera.forward.cross(camera.up).length() > 1e-6;
    let fov = camera.vertical_fov;
    if !(vectors.iter().all(|v| v.is_finite()) && upright && 0.0 < fov && fov < std::f64::consts::PI) {
        let message = "it needs finite, independent forward and up vectors and an angle of view between 0 and pi";
        found.push(Finding::warning("camera", format!("camera '{}'", camera.name), message));
    }
}

#[cfg(test)]
#[path = "findings_tests.rs"]
mod tests;
