//! The final gather and path tracing.

use crate::patches::{Enclosure, Patches};
use crate::picture::image_out;
use crate::scene::{CameraTuple, LightTuple, camera_in};
use crate::solution::lamp_in;
use crate::textures::{Textures, textures_in};
use crate::{convert, watch};
use numpy::{PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use radiosity_geometry::corners::CREASE_ANGLE;
use radiosity_paths::{Effort, Exitance, Gloss, Light, Measured, Tracer};
use radiosity_picture::{Fields, GatherSettings, Gathered, Sheets, Smoother, Surfaces, TraceSettings, Traced};

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(gather, module)?)?;
    module.add_function(wrap_pyfunction!(path_trace, module)?)?;
    module.add_function(wrap_pyfunction!(path_irradiance, module)?)
}

/// Image and its standard error, (height, width, bands); samples, relative error, rays.
type TracedOut<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray3<f32>>, u32, f64, u64);
/// Irradiance and its standard error, (n, bands); samples, relative error, rays.
type MeasuredOut<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, u32, f64, u64);

/// What a picture shows: "radiance" or "irradiance".
fn shown<'a>(
    show: &str,
    emission: &'a [f32],
    reflectance: &'a [f32],
    transmittance: &'a [f32],
) -> PyResult<Surfaces<'a>> {
    match show {
        "radiance" => Ok(Surfaces::Radiance { emission, reflectance, transmittance }),
        "irradiance" => Ok(Surfaces::Irradiance),
        _ => Err(PyValueError::new_err(format!("traced pictures show radiance or irradiance, not '{show}'"))),
    }
}

fn lights_in(lights: Vec<LightTuple>, bands: usize) -> PyResult<Vec<Light>> {
    let single = |lamp: radiosity_equilibrium::Lamp| Light {
        luminaire: lamp.luminaire,
        strength: lamp.strength.iter().map(|&s| s as f32).collect(),
    };
    lights.into_iter().map(|light| lamp_in(light, bands).map(single)).collect()
}

fn effort_in(samples: u32, accuracy: Option<f64>) -> PyResult<Effort> {
    match accuracy {
        None => Ok(Effort::of_samples(samples)),
        Some(wanted) if wanted > 0.0 && wanted.is_finite() => Ok(Effort::of_accuracy(wanted, samples)),
        Some(wanted) => {
            Err(PyValueError::new_err(format!("accuracy must be a positive number such as 0.05, not {wanted}")))
        }
    }
}

fn reflectance_in(array: &PyReadonlyArray2<'_, f64>, n: usize, bands: usize) -> PyResult<Vec<f64>> {
    let values = convert::block_in(array, n, bands, "reflectance")?;
    match values.iter().position(|rho| !(0.0..=1.0).contains(rho)) {
        Some(i) => Err(PyValueError::new_err(format!("the reflectance of patch {} is not in [0, 1]", i / bands))),
        None => Ok(values),
    }
}

/// Parts of a whole: what patches reflect diffusely must be no more than what mirrors and panes leave.
fn check_whole(reflectance: &[f64], through: &[f64], bands: usize, going_on: Option<&[Vec<f64>; 2]>) -> PyResult<()> {
    check_scattered(reflectance, through, bands, |_| 1.0)?;
    let Some([specular, transmittance]) = going_on else { return Ok(()) };
    let left = |patch: usize| 1.0 - specular[patch] - transmittance[patch];
    check_scattered(reflectance, through, bands, left)?;
    match reflectance.iter().enumerate().find(|(i, rho)| **rho > left(i / bands) + 1e-9) {
        None => Ok(()),
        Some((i, rho)) => Err(PyValueError::new_err(format!(
            "patch {}: reflectance {rho}, specular {} and transmittance {} are together more than 1",
            i / bands,
            specular[i / bands],
            transmittance[i / bands]
        ))),
    }
}

/// The same of what leaves either side, where light passes through.
fn check_scattered(reflectance: &[f64], through: &[f64], bands: usize, share: impl Fn(usize) -> f64) -> PyResult<()> {
    match through.iter().enumerate().find(|(i, tau)| **tau > 0.0 && reflectance[*i] + **tau > share(i / bands) + 1e-9) {
        None => Ok(()),
        Some((i, tau)) => Err(PyValueError::new_err(format!(
            "patch {}: reflectance {} and diffuse transmittance {tau} are together more than {}",
            i / bands,
            reflectance[i],
            share(i / bands)
        ))),
    }
}

/// Sheets as rays see them, of which some are mirrors and panes.
fn enclosure_of(sheets: &Sheets, going_on: Option<&[Vec<f64>; 2]>) -> radiosity_exchange::Enclosure {
    let parts = going_on.map(|parts| parts.each_ref().map(|part| sheets.of_patches(part)));
    let enclosure = radiosity_exchange::Enclosure::new(sheets.patches.clone());
    match parts {
        None => enclosure,
        Some([specular, transmittance]) => enclosure.with_specular(specular, transmittance),
    }
}

/// What of the reflectance of (n,) patches is of rough metals, and how rough they are: (n, 2).
fn gloss_in(array: Option<PyReadonlyArray2<'_, f64>>, n: usize) -> PyResult<Option<Gloss>> {
    let Some(array) = array else { return Ok(None) };
    let values = convert::block_in(&array, n, 2, "gloss")?;
    if !values.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Err(PyValueError::new_err("metallic and roughness lie in [0, 1]"));
    }
    let part = |k: usize| values.iter().skip(k).step_by(2).map(|&value| value as f32).collect();
    Ok(Some(Gloss { metallic: part(0), roughness: part(1) }))
}

fn traced_out(py: Python<'_>, traced: Traced) -> PyResult<TracedOut<'_>> {
    let (image, error) = (image_out(py, traced.image)?, image_out(py, traced.standard_error)?);
    Ok((image, error, traced.rounds.samples, traced.rounds.error, traced.rays))
}

/// Picture, its noise over its mean, and rays.
type GatheredOut<'py> = (Bound<'py, PyArray3<f32>>, f64, u64);

/// Renders a solution by a final gather; blocks are (n_patches, bands). Backs of two-sided patches may be patches of
/// their own.
#[pyfunction]
#[pyo3(signature = (patches, emission, reflectance, irradiance, radiosity, lights, camera, width, height, samples, show,
                    seed, going_on=None, threads=None, progress=None, diffuse_transmittance=None, textures=None, gloss=None))]
fn gather<'py>(
    py: Python<'py>,
    patches: &Patches,
    emission: PyReadonlyArray2<'py, f64>,
    reflectance: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    radiosity: PyReadonlyArray2<'py, f64>,
    lights: Vec<LightTuple>,
    camera: CameraTuple,
    width: usize,
    height: usize,
    samples: u32,
    show: &str,
    seed: u64,
    going_on: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
    diffuse_transmittance: Option<PyReadonlyArray2<'py, f64>>,
    textures: Option<PyRef<'py, Textures>>,
    gloss: Option<PyReadonlyArray2<'py, f64>>,
) -> PyResult<GatheredOut<'py>> {
    let given = patches.inner.clone();
    let (n, bands) = (given.len(), emission.as_array().ncols());
    let emission = convert::block_in(&emission, n, bands, "emission")?;
    let reflectance = reflectance_in(&reflectance, n, bands)?;
    let irradiance = convert::block_in(&irradiance, n, bands, "irradiance")?;
    let radiosity = convert::block_in(&radiosity, n, bands, "radiosity")?;
    let going_on = going_on.map(|parts| convert::going_on_in(&parts, n)).transpose()?;
    let through = convert::through_in(diffuse_transmittance.as_ref(), n, bands)?;
    check_whole(&reflectance, &through, bands, going_on.as_ref())?;
    let (textures, gloss) = (textures_in(textures, n)?, gloss_in(gloss, n)?);
    let (lights, camera) = (lights_in(lights, bands)?, camera_in(camera));
    shown(show, &[], &[], &[])?;
    let settings = GatherSettings { width, height, samples, culls_backs: true };
    let gathered = watch::run(py, threads, progress.as_ref(), |control| {
        let sheets = Sheets::new(&given);
        let smoother = Smoother::new(&given, CREASE_ANGLE);
        let corners = smoother.corner_radiosity_of_patches(&radiosity, &irradiance, &reflectance, &through, bands);
        let exitance = Exitance::Corners(sheets.corners_of_sides(&given, &corners, bands));
        let (emission, reflectance) = (sheets.of_sides(&emission, bands), sheets.of_sides(&reflectance, bands));
        let through = passing(&sheets, &through, bands);
        let textures = textures.map(|textures| textures.picked(&sheets.patch_of_side));
        let gloss = gloss.map(|gloss| gloss.picked(&sheets.patch_of_side));
        let enclosure = enclosure_of(&sheets, going_on.as_ref());
        let tracer = Tracer::gather(&enclosure, bands, exitance, lights, seed);
        let tracer = tracer.with_textures(textures).with_gloss(gloss);
        let rays = width * height * samples as usize;
        let parts = radiosity_picture::direct_and_rest(&tracer, &sheets.patch_of_side, &irradiance, rays, control)?;
        let at_corners = |part: &Vec<f64>| sheets.corners_of_sides(&given, &smoother.corner_values(part, bands), bands);
        let [direct, rest] = parts.each_ref().map(at_corners);
        let fields = Fields { direct: &direct, rest: &rest };
        let surfaces = shown(show, &emission, &reflectance, &through).expect("it was checked above");
        radiosity_picture::gather(&tracer, surfaces, fields, &camera, &settings, control)
    })?;
    let Gathered { image, noise, rays } = gathered.map_err(|_| PyKeyboardInterrupt::new_err("stopped on request"))?;
    Ok((image_out(py, image)?, noise, rays))
}

/// Renders patches by path tracing, without a solution; blocks are (n_patches, bands). With an accuracy, `samples` are
/// the most.
#[pyfunction]
#[pyo3(signature = (patches, emission, reflectance, lights, camera, width, height, samples, accuracy, show, seed,
                    going_on=None, threads=None, progress=None, diffuse_transmittance=None, textures=None, gloss=None))]
fn path_trace<'py>(
    py: Python<'py>,
    patches: &Patches,
    emission: PyReadonlyArray2<'py, f64>,
    reflectance: PyReadonlyArray2<'py, f64>,
    lights: Vec<LightTuple>,
    camera: CameraTuple,
    width: usize,
    height: usize,
    samples: u32,
    accuracy: Option<f64>,
    show: &str,
    seed: u64,
    going_on: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
    diffuse_transmittance: Option<PyReadonlyArray2<'py, f64>>,
    textures: Option<PyRef<'py, Textures>>,
    gloss: Option<PyReadonlyArray2<'py, f64>>,
) -> PyResult<TracedOut<'py>> {
    let given = patches.inner.clone();
    let (n, bands) = (given.len(), emission.as_array().ncols());
    let emission = convert::block_in(&emission, n, bands, "emission")?;
    let reflectance = reflectance_in(&reflectance, n, bands)?;
    let going_on = going_on.map(|parts| convert::going_on_in(&parts, n)).transpose()?;
    let through = convert::through_in(diffuse_transmittance.as_ref(), n, bands)?;
    check_whole(&reflectance, &through, bands, going_on.as_ref())?;
    let (textures, gloss) = (textures_in(textures, n)?, gloss_in(gloss, n)?);
    let (lights, camera) = (lights_in(lights, bands)?, camera_in(camera));
    let effort = effort_in(samples, accuracy)?;
    shown(show, &[], &[], &[])?;
    let settings = TraceSettings { width, height, effort, culls_backs: true };
    let traced = watch::run(py, threads, progress.as_ref(), |control| {
        let sheets = Sheets::new(&given);
        let (emission, reflectance) = (sheets.of_sides(&emission, bands), sheets.of_sides(&reflectance, bands));
        let through = passing(&sheets, &through, bands);
        let textures = textures.map(|textures| textures.picked(&sheets.patch_of_side));
        let gloss = gloss.map(|gloss| gloss.picked(&sheets.patch_of_side));
        let enclosure = enclosure_of(&sheets, going_on.as_ref());
        let exitance = Exitance::Uniform(emission.clone());
        let tracer = Tracer::paths(&enclosure, bands, exitance, reflectance.clone(), lights, seed);
        let tracer = tracer.with_textures(textures).with_gloss(gloss);
        let tracer = if through.is_empty() { tracer } else { tracer.with_diffuse_transmittance(through.clone()) };
        let surfaces = shown(show, &emission, &reflectance, &through).expect("it was checked above");
        radiosity_picture::trace(&tracer, surfaces, &camera, &settings, control)
    })?;
    traced_out(py, traced.map_err(|_| PyKeyboardInterrupt::new_err("stopped on request"))?)
}

/// Irradiance by path tracing at points, or the means of all sides, fronts before backs; blocks are (n_patches, bands).
#[pyfunction]
#[pyo3(signature = (enclosure, emission, reflectance, lights, points, normals, samples, accuracy, seed, threads=None,
                    progress=None, diffuse_transmittance=None, textures=None))]
fn path_irradiance<'py>(
    py: Python<'py>,
    enclosure: &Enclosure,
    emission: PyReadonlyArray2<'py, f64>,
    reflectance: PyReadonlyArray2<'py, f64>,
    lights: Vec<LightTuple>,
    points: Option<PyReadonlyArray2<'py, f64>>,
    normals: Option<PyReadonlyArray2<'py, f64>>,
    samples: u32,
    accuracy: Option<f64>,
    seed: u64,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
    diffuse_transmittance: Option<PyReadonlyArray2<'py, f64>>,
    textures: Option<PyRef<'py, Textures>>,
) -> PyResult<MeasuredOut<'py>> {
    let enclosure = enclosure.inner.clone();
    let (n, bands) = (enclosure.patches().len(), emission.as_array().ncols());
    let emission = convert::block_in(&emission, n, bands, "emission")?;
    let reflectance = reflectance_in(&reflectance, n, bands)?;
    let through = convert::through_in(diffuse_transmittance.as_ref(), n, bands)?;
    check_scattered(&reflectance, &through, bands, |patch| enclosure.diffuse_share(patch))?;
    if let Some(i) = (0..through.len()).find(|&i| through[i] > 0.0 && !enclosure.patches().two_sided[i / bands]) {
        let message = format!("patch {}: light passes through it diffusely, and it has one side only", i / bands);
        return Err(PyValueError::new_err(message));
    }
    let share = |i: usize| enclosure.specular().map_or(1.0, |specular| specular.diffuse_share(i / bands));
    if let Some(i) = (0..reflectance.len()).find(|&i| reflectance[i] > share(i) + 1e-9) {
        return Err(PyValueError::new_err(format!(
            "patch {}: reflectance {} is more than the {} that its specular reflectance and transmittance leave",
            i / bands,
            reflectance[i],
            share(i)
        )));
    }
    let lights = lights_in(lights, bands)?;
    let textures = textures_in(textures, n)?;
    let effort = effort_in(samples, accuracy)?;
    let places = match (points, normals) {
        (None, None) => None,
        (Some(points), Some(normals)) => {
            Some((convert::points_in(&points, "points")?, convert::points_in(&normals, "normals")?))
        }
        _ => return Err(PyValueError::new_err("points and normals go together")),
    };
    if places.as_ref().is_some_and(|(points, normals)| points.len() != normals.len()) {
        return Err(PyValueError::new_err("give one normal per point"));
    }
    let measured = watch::run(py, threads, progress.as_ref(), |control| {
        let (emission, reflectance) =
            (of_sides(&enclosure, &emission, bands), of_sides(&enclosure, &reflectance, bands));
        let patches: Vec<u32> = (0..enclosure.sides()).map(|side| enclosure.patch_of(side) as u32).collect();
        let tracer = Tracer::paths(&enclosure, bands, Exitance::Uniform(emission), reflectance, lights, seed)
            .with_textures(textures.map(|textures| textures.picked(&patches)));
        let tracer = match through.is_empty() {
            true => tracer,
            false => tracer.with_diffuse_transmittance(of_sides(&enclosure, &through, bands)),
        };
        match &places {
            Some((points, normals)) => radiosity_paths::at_points(&tracer, points, normals, &effort, control),
            None => radiosity_paths::of_sides(&tracer, &effort, control),
        }
    })?;
    let Measured { irradiance, standard_error, rounds, rays } =
        measured.map_err(|_| PyKeyboardInterrupt::new_err("stopped on request"))?;
    let (value, error) = (convert::block_out(py, irradiance, bands), convert::block_out(py, standard_error, bands));
    Ok((value, error, rounds.samples, rounds.error, rays))
}

/// What passes of sides, in single precision: nothing where patches have one side only. Empty if nothing is.
fn passing(sheets: &Sheets, through: &[f64], bands: usize) -> Vec<f32> {
    if through.is_empty() {
        return Vec::new();
    }
    let mut values = sheets.of_sides(through, bands);
    let one_sided = (0..sheets.patches.len()).filter(|&patch| !sheets.patches.two_sided[patch]);
    one_sided.for_each(|patch| values[patch * bands..][..bands].fill(0.0));
    values
}

/// Values of patches as those of sides, in single precision.
fn of_sides(enclosure: &radiosity_exchange::Enclosure, values: &[f64], bands: usize) -> Vec<f32> {
    let own = |side| &values[enclosure.patch_of(side) * bands..][..bands];
    (0..enclosure.sides()).flat_map(own).map(|&v| v as f32).collect()
}
