//! The rules a scene must keep, and what is said when it does not.
//!
//! Each rule appends findings and knows nothing of the others. Rules about one surface report once per surface with
//! a count, so that a broken file does not answer with a million sentences.

mod edges;
mod gaps;
mod overlaps;
mod shapes;

use std::collections::HashMap;

use glam::DVec3;

use self::overlaps::{corner_key, duplicate_faces};
use crate::model::{
    Camera, Face, Finding, Gloss, Light, MOST_PLACES, Material, Scene, SceneError, Severity, Surface, Texture,
};
use crate::quad::{self, Shape};

/// Above this reflectance solutions need hundreds of bounces and small errors grow.
const HIGH_REFLECTANCE: f64 = 0.95;

/// Diagonals in metres outside which the unit of length is probably wrong.
const PLAUSIBLE_SIZE: std::ops::RangeInclusive<f64> = 1e-2..=1e3;

impl Scene {
    /// All that the loader noticed, followed by all that the rules find. Whether the surfaces enclose a space is asked
    /// only where the scene says that they should, in [`Scene::hints`].
    pub fn findings(&self) -> Vec<Finding> {
        let mut found = self.essential_findings();
        if self.is_indexed() {
            edges::mixed_winding(self, &mut found);
            overlaps::overlapping_faces(self, &mut found);
            gaps::narrow_gaps(self, &mut found);
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
        self.surfaces.iter().all(shapes::is_indexed)
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

    /// Whether all textures fit their surfaces and the bands; shapes are not looked at.
    ///
    /// # Errors
    /// The first error among materials with a texture.
    pub(crate) fn validate_textures(&self) -> Result<(), SceneError> {
        let mut found = Vec::new();
        for surface in self.surfaces.iter().filter(|surface| surface.texture.is_some()) {
            spectrum_lengths(self, surface, &mut found);
            textures(self, surface, &mut found);
        }
        self.refuse(found)
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
    for (index, surface) in scene.surfaces.iter().enumerate() {
        empty_surface(index, surface, &mut found);
        sound &= shapes::check(&Subject { surface, index: Some(index), name: named(surface) }, &mut found);
    }
    for surface in &scene.obstructions {
        let name = format!("obstruction '{}'", surface.name);
        sound &= shapes::check(&Subject { surface, index: None, name }, &mut found);
    }
    repeated_names(scene, &mut found);
    combinations(scene, &mut found);
    if sound {
        duplicate_faces(scene, &mut found);
        plausible_size(scene, &mut found);
    }
    found
}

fn optics_findings(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    if scene.bands.is_empty() {
        let message = "the scene has no bands; name at least one, such as R, G and B";
        found.push(Finding::error("no-bands", "", message));
    }
    for (index, surface) in scene.surfaces.iter().enumerate() {
        let before = found.len();
        spectrum_lengths(scene, surface, &mut found);
        reflectances(scene, surface, &mut found);
        textures(scene, surface, &mut found);
        speculars(scene, surface, &mut found);
        translucency(scene, surface, &mut found);
        gloss(surface, &mut found);
        emissions(scene, surface, &mut found);
        lamp_without_area(surface, &mut found);
        found[before..].iter_mut().for_each(|finding| finding.place.surface = Some(index as u32));
    }
    found
}

fn light_findings(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    for light in &scene.lights {
        let before = found.len();
        light_rules(scene, light, &mut found);
        let position = light.position().filter(|position| position.is_finite());
        found[before..].iter_mut().for_each(|finding| finding.place.points.extend(position));
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

fn empty_surface(index: usize, surface: &Surface, found: &mut Vec<Finding>) {
    if surface.faces.is_empty() {
        let message = "has no faces and takes no part; remove it";
        found.push(Finding::warning("empty-surface", named(surface), message).on(index, []));
    }
}

/// A surface or an obstruction that rules are about.
struct Subject<'a> {
    surface: &'a Surface,
    /// Among the surfaces of the scene; obstructions have none.
    index: Option<usize>,
    /// What it is called in messages.
    name: String,
}

impl Subject<'_> {
    /// The finding with its place: the faces of a surface, or their outlines.
    fn place(&self, finding: Finding, tally: &Tally) -> Finding {
        match self.index {
            Some(index) => finding.on(index, tally.faces.iter().copied()),
            None => {
                let outline = |&f: &u32| outline(self.surface.corners(self.surface.faces[f as usize]));
                finding.along(tally.faces.iter().flat_map(outline))
            }
        }
    }
}

/// The edges of a face; those without length are left out.
fn outline(corners: [DVec3; 4]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]]).filter(|[a, b]| a != b)
}

/// Faces of one kind: as many as are kept, how many there are, and a measure of the first.
#[derive(Default)]
struct Tally {
    faces: Vec<u32>,
    count: usize,
    measure: f64,
}

impl Tally {
    const NONE: Self = Self { faces: Vec::new(), count: 0, measure: 0.0 };

    fn add(&mut self, face: u32, measure: f64) {
        if self.count == 0 {
            self.measure = measure;
        }
        if self.faces.len() < MOST_PLACES {
            self.faces.push(face);
        }
        self.count += 1;
    }

    /// A surface, the first face and how many more there are; nothing where there is none.
    fn element(&self, name: &str) -> Option<String> {
        let first = self.faces.first()?;
        let more = if self.count > 1 { format!(" (and {} more)", self.count - 1) } else { String::new() };
        Some(format!("{name}, face {first}{more}"))
    }
}

fn repeated_names(scene: &Scene, found: &mut Vec<Finding>) {
    let mut seen = HashMap::new();
    for surface in &scene.surfaces {
        *seen.entry(surface.name.as_str()).or_insert(0) += 1;
    }
    for (index, surface) in scene.surfaces.iter().enumerate() {
        if let Some(count @ 2..) = seen.remove(surface.name.as_str()) {
            let message = format!("{count} surfaces share this name; results by name will be ambiguous; rename them");
            found.push(Finding::warning("repeated-name", named(surface), message).on(index, []));
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
    if PLAUSIBLE_SIZE.contains(&diagonal) || scene.face_count() == 0 {
        return;
    }
    let remedy = match usual_unit(diagonal) {
        Some((unit, metres)) => format!(
            "if a room is meant, give the unit of the file: --unit {unit} would make it {:.3} m across",
            diagonal * metres
        ),
        None => "if that is a mistake, give the unit of the file, as in --unit mm".into(),
    };
    let message = format!("the scene measures {diagonal:.3e} m across; {remedy}");
    found.push(Finding::warning("implausible-size", "", message).at([low, high]));
}

/// The unit that would make a length in metres that of a room, and its metres.
fn usual_unit(diagonal: f64) -> Option<(&'static str, f64)> {
    let room = 2.0..=50.0;
    [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("km", 1e3)].into_iter().find(|(_, m)| room.contains(&(diagonal * m)))
}

fn spectrum_lengths(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let bands = scene.bands.len();
    let material = &surface.material;
    let through = Some(material.diffuse_transmittance.len()).filter(|&length| length > 0);
    let spectra = [("reflectance", Some(material.reflectance.len())), ("emission", Some(material.emission.len()))];
    for (what, length) in spectra.into_iter().chain([("diffuse transmittance", through)]) {
        if let Some(length) = length.filter(|&length| length != bands) {
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
            "its reflectance in band {} is {}; real paints stay below 0.9 and such values take long to solve; \
             lower it unless it was measured",
            band(scene, i),
            spectrum[i]
        );
        found.push(Finding::note("high-reflectance", named(surface), message));
    }
}

/// Every vertex has a place on the image, and the image is grey or has the bands of the scene.
fn textures(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let Some(Texture { image, coordinates }) = &surface.texture else { return };
    let (bands, vertices) = (scene.bands.len(), surface.vertices.len());
    let message = if image.channels() != 1 && image.channels() != bands {
        format!("its texture has {} channels for {bands} bands; give one channel, or one per band", image.channels())
    } else if coordinates.len() != vertices {
        format!("it has {} texture coordinates for {vertices} vertices; give one pair each", coordinates.len())
    } else if let Some(bad) = coordinates.iter().position(|uv| uv.iter().any(|c| !c.is_finite())) {
        format!("texture coordinate {bad} is not finite; repair the mesh")
    } else {
        return;
    };
    found.push(Finding::error("texture", named(surface), message));
}

/// Mirror, glass and paint share what meets a surface. All of it may go on only from a surface that is nothing else.
fn speculars(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let material = &surface.material;
    for (what, part) in [("specular", material.specular), ("transmittance", material.transmittance)] {
        if !(0.0..=1.0).contains(&part) {
            let message = format!("its {what} is {part}; it must be at least 0 and at most 1");
            found.push(Finding::error("specular-range", named(surface), message));
            return;
        }
    }
    if !material.is_specular() {
        return;
    }
    let going_on = material.specular + material.transmittance;
    let scattered = (0..material.reflectance.len()).map(|band| (band, material.scattered(band)));
    let (index, diffuse) = scattered.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
    let is_ideal = diffuse == 0.0 && going_on <= 1.0 + ROUNDING;
    if !is_ideal && diffuse + going_on >= 1.0 {
        let message = format!(
            "its {}, specular {} and transmittance {} in band {} make {}; together they must stay \
             below 1: lower them, or give reflectance 0 for an ideal mirror or pane, which may have 1",
            diffuse_parts(material, index),
            material.specular,
            material.transmittance,
            band(scene, index),
            diffuse + going_on
        );
        found.push(Finding::error("specular-sum", named(surface), message));
    } else if material.emits() && going_on >= 1.0 - ROUNDING {
        let message = "it emits, and all that meets it goes on: nothing of it is left to emit; lower its specular or \
                       transmittance";
        found.push(Finding::error("specular-lamp", named(surface), message));
    }
}

/// What a surface sends to its other side comes out there, which must be one, and of the same whole as what it reflects.
fn translucency(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let material = &surface.material;
    if !material.is_translucent() {
        return;
    }
    if let Some(i) = material.diffuse_transmittance.iter().position(|tau| !(0.0..1.0).contains(tau)) {
        let tau = material.diffuse_transmittance[i];
        let message = format!(
            "its diffuse transmittance in band {} is {tau}; it must be at least 0 and less than 1",
            band(scene, i)
        );
        found.push(Finding::error("translucent-range", named(surface), message));
        return;
    }
    let bands = material.reflectance.len().min(material.diffuse_transmittance.len());
    if let Some(i) = (0..bands).find(|&i| material.scattered(i) >= 1.0).filter(|_| !material.is_specular()) {
        let message = format!(
            "its {} in band {} make {}; together they must stay below 1: lower them",
            diffuse_parts(material, i),
            band(scene, i),
            material.scattered(i)
        );
        found.push(Finding::error("translucent-sum", named(surface), message));
    }
    if !material.two_sided {
        let message = "it lets light through diffusely, which must leave its back, and that is black: make it two-sided, or \
                       its diffuse transmittance 0";
        found.push(Finding::error("translucent-one-sided", named(surface), message));
    }
}

/// What is diffuse of a material in a band, in words.
fn diffuse_parts(material: &Material, band: usize) -> String {
    let reflectance = material.reflectance[band];
    match material.diffuse_transmittance.get(band) {
        Some(tau) if *tau > 0.0 => format!("reflectance {reflectance} and diffuse transmittance {tau}"),
        _ => format!("reflectance {reflectance}"),
    }
}

fn gloss(surface: &Surface, found: &mut Vec<Finding>) {
    let Gloss { metallic, roughness } = surface.material.gloss;
    for (what, value) in [("metallic", metallic), ("roughness", roughness)] {
        if !(0.0..=1.0).contains(&value) {
            let message = format!("its {what} is {value}; it must be at least 0 and at most 1");
            found.push(Finding::error("gloss-range", named(surface), message));
        }
    }
}

/// What rounding may add to parts of one whole.
const ROUNDING: f64 = 1e-12;

fn emissions(scene: &Scene, surface: &Surface, found: &mut Vec<Finding>) {
    let spectrum = &surface.material.emission;
    if let Some(i) = first_improper(spectrum) {
        let message =
            format!("its emission in band {} is {}; it must be finite and not negative", band(scene, i), spectrum[i]);
        found.push(Finding::error("emission-range", named(surface), message));
    }
}

fn lamp_without_area(surface: &Surface, found: &mut Vec<Finding>) {
    let has_area = |&face: &Face| quad::classify(surface.corners(face)) != Shape::ZeroArea;
    let is_drawn = !surface.faces.is_empty() && shapes::is_indexed(surface);
    if surface.material.emits() && is_drawn && !surface.faces.iter().any(has_area) {
        let message = "it emits, but none of its faces has an area, so that it sends nothing; give it an extent, or make \
                       it a point light";
        found.push(Finding::warning("lamp-without-area", named(surface), message));
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
