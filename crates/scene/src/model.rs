//! The scene model: plain data, validated by [`Scene::findings`].

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use radiosity_geometry::texture::Raster;

/// A face as four vertex indices; a triangle repeats its last index.
pub type Face = [u32; 4];

/// Surfaces with materials, lights and cameras. Lengths are metres.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name for messages, usually the file's.
    pub name: String,
    /// Names of the wavelength bands, `["R", "G", "B"]` for files. Every spectrum below has this length.
    pub bands: Vec<String>,
    /// What reflects and emits.
    pub surfaces: Vec<Surface>,
    /// What only blocks: opaque from both sides, black, cut into no patches. Materials are ignored.
    pub obstructions: Vec<Surface>,
    /// Surfaces that count with another in tables of factors: index of the surface -> index of the one it counts with,
    /// which itself counts with none.
    pub combined: BTreeMap<usize, usize>,
    /// What the file asks of a computation of factors.
    pub hints: Hints,
    /// Lights without area.
    pub lights: Vec<Light>,
    /// Viewpoints the file carries.
    pub cameras: Vec<Camera>,
    /// What the loader noticed and approximated (metals read as diffuse, and the like).
    pub findings: Vec<Finding>,
}

/// What a file asks of a computation of factors. The engine obeys none of it by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    /// The accuracy its author wanted, such as the criterion of convergence of another program.
    pub tolerance: Option<f64>,
    /// Whether the surfaces are meant to enclose a space, so that every row of factors sums to one.
    pub enclosure: bool,
    /// Whether factors of total interchange are wanted, which include reflections.
    pub emissivity: bool,
    /// The only surface from which factors are wanted.
    pub row: Option<usize>,
    /// The only surface to which factors are wanted.
    pub column: Option<usize>,
}

/// Polygons that share one material; keeps the name that its file gave it.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Name from the file, unique within the scene.
    pub name: String,
    /// Vertex positions in metres.
    pub vertices: Vec<DVec3>,
    /// Triangles and planar quads, counter-clockwise seen from the front.
    pub faces: Vec<Face>,
    /// Its optics.
    pub material: Material,
    /// An image that its diffuse reflectance is to be multiplied with.
    pub texture: Option<Texture>,
}

/// An image on a surface, as a part of its diffuse reflectance: linear, of one channel or one per band.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Values in [0, 1].
    pub image: Arc<Raster>,
    /// Texture coordinates of each vertex; (0, 0) is the upper left corner of the image.
    pub coordinates: Vec<[f64; 2]>,
}

/// Diffuse reflectance and emission per band, and what goes on as from a mirror or through clear glass.
///
/// Of what meets a surface, diffuse reflectance, diffuse transmittance, specular reflectance and transmittance are parts;
/// the rest is absorbed.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Name from the file.
    pub name: String,
    /// Diffuse reflectance in [0, 1) per band.
    pub reflectance: Vec<f64>,
    /// Radiant exitance per band, W/m2: pi times the radiance of a Lambertian surface.
    pub emission: Vec<f64>,
    /// Mirror reflectance in [0, 1], the same in all bands.
    pub specular: f64,
    /// The part that passes straight through a thin sheet, from either side, in [0, 1], the same in all bands.
    pub transmittance: f64,
    /// Whether both sides reflect and emit; otherwise the back is black, and opaque but for what passes.
    pub two_sided: bool,
    /// The part that leaves the other side diffusely, as of paper and leaves, per band and from either side; may be empty
    /// where there is none. What has any must be two-sided.
    pub diffuse_transmittance: Vec<f64>,
    /// Its metal, if it has any.
    pub gloss: Gloss,
}

/// What of a diffuse reflectance is really the lobe of a rough metal. The solve takes it for diffuse; traced pictures show
/// it where a camera looks at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// The part of the reflectance, in [0, 1].
    pub metallic: f64,
    /// From 0, a mirror, to 1.
    pub roughness: f64,
}

impl Default for Gloss {
    fn default() -> Self {
        Self { metallic: 0.0, roughness: 1.0 }
    }
}

/// A light without area.
#[derive(Clone, Debug)]
pub enum Light {
    /// Radiates equally in all directions.
    Point {
        /// Name from the file.
        name: String,
        /// Metres.
        position: DVec3,
        /// W/sr per band.
        intensity: Vec<f64>,
    },
    /// Radiates within a cone with a smooth edge (KHR_lights_punctual's falloff).
    Spot {
        /// Name from the file.
        name: String,
        /// Metres.
        position: DVec3,
        /// Unit vector along the axis, away from the light.
        direction: DVec3,
        /// W/sr per band on the axis.
        intensity: Vec<f64>,
        /// Half angle where the falloff starts, radians.
        inner_angle: f64,
        /// Half angle where the light ends, radians.
        outer_angle: f64,
    },
    /// Parallel light, the sun.
    Directional {
        /// Name from the file.
        name: String,
        /// Unit vector the light travels along.
        direction: DVec3,
        /// W/m2 per band on a surface that faces the light.
        irradiance: Vec<f64>,
    },
}

/// A perspective viewpoint.
#[derive(Clone, Debug)]
pub struct Camera {
    /// Name from the file.
    pub name: String,
    /// Metres.
    pub position: DVec3,
    /// Unit vector of the line of sight.
    pub forward: DVec3,
    /// Unit vector upward in the picture.
    pub up: DVec3,
    /// Full vertical angle of view, radians.
    pub vertical_fov: f64,
    /// Width over height where the file fixes it.
    pub aspect: Option<f64>,
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing.
    Note,
    /// The answer may not be what the author of the scene meant.
    Warning,
    /// The scene cannot be lit.
    Error,
}

/// Where in a scene something was noticed. What is not known, or does not apply, is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// Index of the surface.
    pub surface: Option<u32>,
    /// Faces of that surface; where there are none, the whole of it is meant.
    pub faces: Vec<u32>,
    /// Stretches of edges, metres.
    pub edges: Vec<[DVec3; 2]>,
    /// Points, metres.
    pub points: Vec<DVec3>,
}

/// So many faces, edges and points of a finding are kept; its message says how many there are.
pub const MOST_PLACES: usize = 10_000;

/// One thing noticed about a scene: what, where and what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// A stable machine-readable kind, such as `zero-area-faces`.
    pub code: &'static str,
    /// The element concerned, such as `surface 'floor', face 12`.
    pub element: String,
    /// One sentence that says what is wrong and what to do.
    pub message: String,
    /// Where it is, for those who draw it.
    pub place: Place,
}

/// A scene that cannot be loaded or lit: one sentence with file, element and remedy.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{file}: {}{message}", prefix(.element))]
pub struct SceneError {
    /// The file, or the name of the scene.
    pub file: String,
    /// The element at fault; empty where it is the whole file.
    pub element: String,
    /// What is wrong and what to do.
    pub message: String,
}

impl SceneError {
    /// An error about `element` of `file`.
    pub fn new(file: impl Into<String>, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { file: file.into(), element: element.into(), message: message.into() }
    }
}

impl Finding {
    /// Something worth knowing about `element`.
    pub fn note(code: &'static str, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, element, message)
    }

    /// Something about `element` that may spoil the answer.
    pub fn warning(code: &'static str, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, element, message)
    }

    /// Something about `element` that makes the scene impossible to light.
    pub fn error(code: &'static str, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, element, message)
    }

    fn new(severity: Severity, code: &'static str, element: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity, code, element: element.into(), message: message.into(), place: Place::default() }
    }

    /// The same, at some faces of a surface; at all of it where there are none.
    pub fn on(mut self, surface: usize, faces: impl IntoIterator<Item = u32>) -> Self {
        self.place.surface = Some(surface as u32);
        self.place.faces = faces.into_iter().take(MOST_PLACES).collect();
        self
    }

    /// The same, along some edges.
    pub fn along(mut self, edges: impl IntoIterator<Item = [DVec3; 2]>) -> Self {
        self.place.edges = edges.into_iter().take(MOST_PLACES).collect();
        self
    }

    /// The same, at some points.
    pub fn at(mut self, points: impl IntoIterator<Item = DVec3>) -> Self {
        self.place.points = points.into_iter().take(MOST_PLACES).collect();
        self
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let severity = match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        let (code, element, message) = (self.code, prefix(&self.element), &self.message);
        write!(out, "{severity} [{code}]: {element}{message}")
    }
}

fn prefix(element: &str) -> String {
    if element.is_empty() { String::new() } else { format!("{element}: ") }
}

/// The names of `n` bands: R, G, B for three, numbers otherwise.
pub fn band_names(n: usize) -> Vec<String> {
    match n {
        1 => vec!["grey".into()],
        3 => vec!["R".into(), "G".into(), "B".into()],
        _ => (1..=n).map(|band| format!("band {band}")).collect(),
    }
}

impl Material {
    /// A one-sided material.
    pub fn new(name: impl Into<String>, reflectance: &[f64], emission: &[f64]) -> Self {
        Self { name: name.into(), reflectance: reflectance.to_vec(), emission: emission.to_vec(), ..Self::default() }
    }

    /// The same, of which parts are a mirror and clear.
    pub fn with_specular(self, specular: f64, transmittance: f64) -> Self {
        Self { specular, transmittance, ..self }
    }

    /// The same on both sides, with a part that leaves the other side diffusely, per band.
    pub fn with_diffuse_transmittance(self, transmittance: &[f64]) -> Self {
        Self { diffuse_transmittance: transmittance.to_vec(), two_sided: true, ..self }
    }

    /// Whether any light leaves the other side diffusely.
    pub fn is_translucent(&self) -> bool {
        self.diffuse_transmittance.iter().any(|&tau| tau != 0.0)
    }

    /// What a band scatters, to both sides together.
    pub fn scattered(&self, band: usize) -> f64 {
        self.reflectance[band] + self.diffuse_transmittance.get(band).unwrap_or(&0.0)
    }

    /// Whether any light goes on from it as from a mirror or through glass.
    pub fn is_specular(&self) -> bool {
        self.specular > 0.0 || self.transmittance > 0.0
    }

    /// The same material on both sides of its surfaces.
    pub fn on_both_sides(self) -> Self {
        Self { two_sided: true, ..self }
    }

    /// Whether it emits in any band.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&exitance| exitance > 0.0)
    }
}

impl Surface {
    /// The four corner positions of a face; a triangle repeats its last.
    ///
    /// # Panics
    /// If the face refers to a vertex that does not exist, which [`Scene::findings`] reports.
    pub fn corners(&self, face: Face) -> [DVec3; 4] {
        face.map(|vertex| self.vertices[vertex as usize])
    }
}

impl Light {
    /// Name from the file.
    pub fn name(&self) -> &str {
        match self {
            Self::Point { name, .. } | Self::Spot { name, .. } | Self::Directional { name, .. } => name,
        }
    }

    /// Where it is, metres; directional light is nowhere.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(*position),
            Self::Directional { .. } => None,
        }
    }

    /// What it sends out per band: W/sr, or W/m2 for directional light.
    pub fn power(&self) -> &[f64] {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }
}

impl Scene {
    /// The smallest box around all vertices as its two extreme corners; `None` without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let mut vertices = self.surfaces.iter().flat_map(|surface| &surface.vertices);
        let first = *vertices.next()?;
        Some(vertices.fold((first, first), |(low, high), &v| (low.min(v), high.max(v))))
    }

    /// Whether any surface or light emits.
    pub fn has_light(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.material.emits() && !surface.faces.is_empty())
            || self.lights.iter().any(|light| light.power().iter().any(|&power| power > 0.0))
    }

    /// The number of faces of all surfaces.
    pub fn face_count(&self) -> usize {
        self.surfaces.iter().map(|surface| surface.faces.len()).sum()
    }
}
