//! The scene model: plain data, validated by [`Scene::findings`].

use glam::DVec3;

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
    /// Lights without area.
    pub lights: Vec<Light>,
    /// Viewpoints the file carries.
    pub cameras: Vec<Camera>,
    /// What the loader noticed and approximated (metals read as diffuse, and the like).
    pub findings: Vec<Finding>,
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
    /// Its diffuse optics.
    pub material: Material,
}

/// Diffuse reflectance and emission per band.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Name from the file.
    pub name: String,
    /// Diffuse reflectance in [0, 1) per band.
    pub reflectance: Vec<f64>,
    /// Radiant exitance per band, W/m2: pi times the radiance of a Lambertian surface.
    pub emission: Vec<f64>,
    /// Whether both sides reflect and emit; otherwise the back is black and opaque.
    pub two_sided: bool,
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
}

/// A scene that cannot be loaded or lit: one sentence with file, element and remedy.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{file}: {element}: {message}")]
pub struct SceneError {
    /// The file, or the name of the scene.
    pub file: String,
    /// The element at fault.
    pub element: String,
    /// What is wrong and what to do.
    pub message: String,
}
