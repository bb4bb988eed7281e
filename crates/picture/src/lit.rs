//! Lit models: a solution as a binary glTF file that any viewer shows and that reads back.
//!
//! One mesh per surface with patches. Each patch has its own three or four vertices, in order, and two triangles if it
//! is a quad: corners 0, 1, 2 and 0, 2, 3. Attributes:
//!
//! | attribute | type | what |
//! |---|---|---|
//! | `POSITION`, `NORMAL` | float VEC3 | metres; the patch's normal |
//! | `COLOR_0` | float VEC3 | radiance, smooth, exposed and tone mapped into [0, 1], for unlit materials |
//! | `_EMISSION`, `_IRRADIANCE`, `_RADIOSITY`, `_ERROR` | float VEC3 | of the patch, W/m2, where there are three bands |
//! | `_EMISSION_<k>` and so on | float SCALAR | band `k` of any other number of bands |
//! | `_PATCH`, `_FACE` | unsigned short VEC2 | the patch's id, and its face within the surface: `x + 65536 y` |
//!
//! Ids are pairs because glTF allows no 32-bit integers in attributes, and floats end at 2^24. The rest is in
//! `extras.radiosity`: of the file the bands, the surfaces and what they reflect and let through, the lights without area, polygons that
//! only block, the report and the exposure, of each mesh the index of its surface.

mod lights;
mod read;
#[cfg(test)]
mod tests;
mod write;

use radiosity_geometry::Patches;
use radiosity_scene::{Camera, Light, Scene};
use serde::{Deserialize, Serialize};

use crate::tone::{Exposure, luminance, rgb};
use lights::FileLight;
pub use read::read_lit;
pub use write::write_lit;

/// The version of what is in `extras.radiosity`.
const VERSION: u32 = 1;

/// The names of the quantities that patches carry, in order of [`LitModel::quantities`].
const QUANTITIES: [&str; 4] = ["EMISSION", "IRRADIANCE", "RADIOSITY", "ERROR"];

/// What a lit model says of a surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LitSurface {
    /// The surface's name.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// Diffuse reflectance per band.
    pub reflectance: Vec<f64>,
    /// Whether both sides reflect and emit.
    pub two_sided: bool,
    /// Mirror reflectance; older files have none.
    #[serde(default, skip_serializing_if = "is_none")]
    pub specular: f64,
    /// Clear transmittance; older files have none.
    #[serde(default, skip_serializing_if = "is_none")]
    pub transmittance: f64,
    /// Diffuse transmittance per band, to the patch that is the back; empty where there is none, as in older files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub diffuse_transmittance: Vec<f64>,
}

fn is_none(part: &f64) -> bool {
    *part == 0.0
}

impl LitSurface {
    /// The surfaces of a scene.
    pub fn all_of(scene: &Scene) -> Vec<Self> {
        let of = |surface: &radiosity_scene::Surface| Self {
            name: surface.name.clone(),
            material: surface.material.name.clone(),
            reflectance: surface.material.reflectance.clone(),
            two_sided: surface.material.two_sided,
            specular: surface.material.specular,
            transmittance: surface.material.transmittance,
            diffuse_transmittance: surface.material.diffuse_transmittance.clone(),
        };
        scene.surfaces.iter().map(of).collect()
    }
}

/// A solution and what it is the solution of. Values are `n_patches x bands`, row-major, in W/m2.
#[derive(Clone, Copy, Debug)]
pub struct LitModel<'a> {
    /// The patches.
    pub patches: &'a Patches,
    /// The surfaces that `patches.surface` counts.
    pub surfaces: &'a [LitSurface],
    /// Names of the bands.
    pub bands: &'a [String],
    /// Radiant exitance of the patches themselves.
    pub emission: &'a [f64],
    /// What arrives.
    pub irradiance: &'a [f64],
    /// What leaves.
    pub radiosity: &'a [f64],
    /// The estimated standard error of irradiance.
    pub error: &'a [f64],
    /// Viewpoints.
    pub cameras: &'a [Camera],
    /// Lights without area; none if unknown.
    pub lights: Option<&'a [Light]>,
    /// The solver's report as JSON; may be empty.
    pub report_json: &'a str,
    /// What radiance is multiplied by for `COLOR_0`, see [`LitModel::automatic_exposure`].
    pub exposure: f64,
}

impl LitModel<'_> {
    /// An exposure that makes the mean over area of what is lit middle grey.
    pub fn automatic_exposure(patches: &Patches, radiosity: &[f64], bands: usize) -> f64 {
        let radiance = |i: usize| {
            let bands: Vec<f32> = radiosity[i * bands..(i + 1) * bands]
                .iter()
                .map(|b| (b * std::f64::consts::FRAC_1_PI) as f32)
                .collect();
            luminance(rgb(&bands))
        };
        Exposure::default().factor_of((0..patches.len()).map(|i| (radiance(i), patches.area[i])))
    }

    /// The values of the patches in order of [`QUANTITIES`].
    fn quantities(&self) -> [&[f64]; 4] {
        [self.emission, self.irradiance, self.radiosity, self.error]
    }

    /// Says what does not fit together.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (n, bands) = (self.patches.len(), self.bands.len());
        for (name, values) in QUANTITIES.iter().zip(self.quantities()) {
            let name = name.to_lowercase();
            if values.len() != n * bands {
                return Err(format!("{name} has {} values, not {n} patches x {bands} bands", values.len()));
            }
            if let Some(i) = values.iter().position(|v| !(*v as f32).is_finite()) {
                return Err(format!("{name} of patch {} is not finite", i / bands));
            }
        }
        if let Some(s) = self.surfaces.iter().find(|s| s.reflectance.len() != bands) {
            return Err(format!("surface '{}' has {} reflectances for {bands} bands", s.name, s.reflectance.len()));
        }
        if let Some(s) = self.surfaces.iter().find(|s| s.reflectance.iter().any(|r| !r.is_finite())) {
            return Err(format!("surface '{}' has a reflectance that is not finite", s.name));
        }
        let passes = |s: &LitSurface| {
            let is_fitting = [0, bands].contains(&s.diffuse_transmittance.len());
            is_fitting && s.diffuse_transmittance.iter().all(|tau| (0.0..=1.0).contains(tau))
        };
        if let Some(s) = self.surfaces.iter().find(|s| !passes(s)) {
            return Err(format!(
                "surface '{}' has diffuse transmittances {:?}, which must be from 0 to 1, one per band or none",
                s.name, s.diffuse_transmittance
            ));
        }
        let is_whole =
            |s: &LitSurface| s.specular >= 0.0 && s.transmittance >= 0.0 && s.specular + s.transmittance <= 1.0 + 1e-12;
        if let Some(s) = self.surfaces.iter().find(|s| !is_whole(s)) {
            return Err(format!(
                "surface '{}' has a specular reflectance of {} and a transmittance of {}, which must be at least 0 and \
                 together at most 1",
                s.name, s.specular, s.transmittance
            ));
        }
        if let Some(s) = self.patches.surface.iter().find(|&&s| s as usize >= self.surfaces.len()) {
            return Err(format!("a patch belongs to surface {s}, but there are {}", self.surfaces.len()));
        }
        if let Some(i) = self.patches.obstructions.iter().position(|p| p.iter().any(|corner| !corner.is_finite())) {
            return Err(format!("obstruction {i} has a corner that is not finite"));
        }
        for light in self.lights.unwrap_or_default() {
            lights::check(light, bands)?;
        }
        if !self.exposure.is_finite() {
            return Err("the exposure is not finite".into());
        }
        Ok(())
    }
}

/// A lit model read back.
#[derive(Clone, Debug, Default)]
pub struct LitData {
    /// As [`LitModel::patches`].
    pub patches: Patches,
    /// As [`LitModel::surfaces`].
    pub surfaces: Vec<LitSurface>,
    /// As [`LitModel::bands`].
    pub bands: Vec<String>,
    /// As [`LitModel::emission`].
    pub emission: Vec<f64>,
    /// As [`LitModel::irradiance`].
    pub irradiance: Vec<f64>,
    /// As [`LitModel::radiosity`].
    pub radiosity: Vec<f64>,
    /// As [`LitModel::error`].
    pub error: Vec<f64>,
    /// As [`LitModel::cameras`].
    pub cameras: Vec<Camera>,
    /// As [`LitModel::lights`]; files of earlier versions do not say.
    pub lights: Option<Vec<Light>>,
    /// As [`LitModel::report_json`].
    pub report_json: String,
    /// As [`LitModel::exposure`].
    pub exposure: f64,
}

impl LitData {
    /// The same as a model to write.
    pub fn model(&self) -> LitModel<'_> {
        LitModel {
            patches: &self.patches,
            surfaces: &self.surfaces,
            bands: &self.bands,
            emission: &self.emission,
            irradiance: &self.irradiance,
            radiosity: &self.radiosity,
            error: &self.error,
            cameras: &self.cameras,
            lights: self.lights.as_deref(),
            report_json: &self.report_json,
            exposure: self.exposure,
        }
    }
}

/// What `extras` hold: an object with one entry of ours.
#[derive(Serialize, Deserialize)]
struct Extras<T> {
    radiosity: T,
}

/// `extras.radiosity` of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileExtras {
    version: u32,
    patches: usize,
    bands: Vec<String>,
    surfaces: Vec<LitSurface>,
    exposure: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lights: Option<Vec<FileLight>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    obstructions: Vec<[[f64; 3]; 4]>,
    /// As it was given, to the letter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    report: Option<Box<serde_json::value::RawValue>>,
}

/// `extras.radiosity` of a mesh.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshExtras {
    surface: u32,
}

/// `extras.radiosity` of a material, for those who read the file with other tools.
#[derive(Serialize)]
struct MaterialExtras<'a> {
    reflectance: &'a [f64],
    two_sided: bool,
    #[serde(skip_serializing_if = "is_none")]
    specular: f64,
    #[serde(skip_serializing_if = "is_none")]
    transmittance: f64,
}

/// The names of the attributes that carry a quantity, without their leading underscore, and their components.
fn attribute_names(quantity: &str, bands: usize) -> (Vec<String>, usize) {
    match bands {
        3 => (vec![quantity.into()], 3),
        _ => ((0..bands).map(|k| format!("{quantity}_{k}")).collect(), 1),
    }
}

/// The indices of the triangles of a patch whose `n` vertices start at `first`.
fn fan(first: u32, n: u32) -> impl Iterator<Item = u32> {
    (1..n - 1).flat_map(move |k| [first, first + k, first + k + 1])
}
