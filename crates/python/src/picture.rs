//! Pictures and files of a solution.

use crate::patches::Patches;
use crate::scene::{CameraTuple, LightTuple, camera_in, camera_out, light_in, light_out};
use crate::textures::{Textures, textures_in};
use crate::{convert, errors, watch};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use radiosity_geometry::texture::TexturedPatches;
use radiosity_picture::{
    ColourMap, ColourScale, Exposure, Image, LitModel, LitSurface, Mirrors, RenderSettings, Shading, Smoother,
    Textured, ToneCurve, tone,
};
use std::path::PathBuf;
use std::sync::Arc;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(write_lit, module)?)?;
    module.add_function(wrap_pyfunction!(write_vtp, module)?)?;
    module.add_function(wrap_pyfunction!(read_lit, module)?)?;
    module.add_function(wrap_pyfunction!(render, module)?)?;
    module.add_function(wrap_pyfunction!(write_png, module)?)?;
    module.add_function(wrap_pyfunction!(write_false_colours, module)?)?;
    module.add_function(wrap_pyfunction!(write_exr, module)?)
}

/// name, material, reflectance, two_sided, specular, transmittance, diffuse transmittance or nothing.
type SurfaceTuple = (String, String, Vec<f64>, bool, f64, f64, Vec<f64>);
/// Emission, irradiance, radiosity, error.
type BlocksIn<'py> = [PyReadonlyArray2<'py, f64>; 4];

struct Lit {
    patches: Arc<radiosity_geometry::Patches>,
    surfaces: Vec<LitSurface>,
    bands: Vec<String>,
    blocks: [Vec<f64>; 4],
    cameras: Vec<radiosity_scene::Camera>,
    lights: Option<Vec<radiosity_scene::Light>>,
    report: String,
}

impl Lit {
    fn new(
        patches: &Patches,
        surfaces: Vec<SurfaceTuple>,
        bands: Vec<String>,
        blocks: BlocksIn<'_>,
        cameras: Vec<CameraTuple>,
        lights: Option<Vec<LightTuple>>,
        report: String,
    ) -> PyResult<Self> {
        let (n, b) = (patches.inner.len(), bands.len());
        let [emission, irradiance, radiosity, error] = &blocks;
        let blocks = [
            convert::block_in(emission, n, b, "emission")?,
            convert::block_in(irradiance, n, b, "irradiance")?,
            convert::block_in(radiosity, n, b, "radiosity")?,
            convert::block_in(error, n, b, "error")?,
        ];
        let surfaces = surfaces
            .into_iter()
            .map(|(name, material, reflectance, two_sided, specular, transmittance, diffuse_transmittance)| {
                LitSurface { name, material, reflectance, two_sided, specular, transmittance, diffuse_transmittance }
            })
            .collect();
        let cameras = cameras.into_iter().map(camera_in).collect();
        let lights = lights.map(|lights| lights.into_iter().map(light_in).collect::<PyResult<_>>()).transpose()?;
        Ok(Self { patches: patches.inner.clone(), surfaces, bands, blocks, cameras, lights, report })
    }

    fn model(&self) -> LitModel<'_> {
        let [emission, irradiance, radiosity, error] = &self.blocks;
        LitModel {
            patches: &self.patches,
            surfaces: &self.surfaces,
            bands: &self.bands,
            emission,
            irradiance,
            radiosity,
            error,
            cameras: &self.cameras,
            lights: self.lights.as_deref(),
            report_json: &self.report,
            exposure: LitModel::automatic_exposure(&self.patches, radiosity, self.bands.len()),
        }
    }
}

/// Writes a lit model as binary glTF.
#[pyfunction]
fn write_lit(
    py: Python<'_>,
    path: PathBuf,
    patches: &Patches,
    surfaces: Vec<SurfaceTuple>,
    bands: Vec<String>,
    blocks: BlocksIn<'_>,
    cameras: Vec<CameraTuple>,
    lights: Option<Vec<LightTuple>>,
    report: String,
) -> PyResult<()> {
    let lit = Lit::new(patches, surfaces, bands, blocks, cameras, lights, report)?;
    py.detach(|| radiosity_picture::write_lit(&path, &lit.model())).map_err(errors::file)
}

/// Writes a lit model as VTK PolyData.
#[pyfunction]
fn write_vtp(
    py: Python<'_>,
    path: PathBuf,
    patches: &Patches,
    surfaces: Vec<SurfaceTuple>,
    bands: Vec<String>,
    blocks: BlocksIn<'_>,
    cameras: Vec<CameraTuple>,
    lights: Option<Vec<LightTuple>>,
    report: String,
) -> PyResult<()> {
    let lit = Lit::new(patches, surfaces, bands, blocks, cameras, lights, report)?;
    py.detach(|| radiosity_picture::write_vtp(&path, &lit.model())).map_err(errors::file)
}

type LitTuple<'py> = (
    Patches,
    Vec<SurfaceTuple>,
    Vec<String>,
    [Bound<'py, PyArray2<f64>>; 4],
    Vec<CameraTuple>,
    Option<Vec<LightTuple>>,
    String,
);

/// Reads a lit model; `None` if the file is a glTF without a solution.
#[pyfunction]
fn read_lit(py: Python<'_>, path: PathBuf) -> PyResult<Option<LitTuple<'_>>> {
    let Some(lit) = py.detach(|| radiosity_picture::read_lit(&path)).map_err(errors::file)? else {
        return Ok(None);
    };
    let bands = lit.bands.len();
    let blocks =
        [lit.emission, lit.irradiance, lit.radiosity, lit.error].map(|block| convert::block_out(py, block, bands));
    let surface = |s: LitSurface| {
        (s.name, s.material, s.reflectance, s.two_sided, s.specular, s.transmittance, s.diffuse_transmittance)
    };
    let surfaces = lit.surfaces.into_iter().map(surface).collect();
    let cameras = lit.cameras.iter().map(camera_out).collect();
    let lights = lit.lights.map(|lights| lights.iter().map(light_out).collect());
    Ok(Some((lit.patches.into(), surfaces, lit.bands, blocks, cameras, lights, lit.report_json)))
}

/// Renders values on patches as a camera sees them, (height, width, bands) float32.
///
/// `irradiance` and `reflectance` (n, bands) are given for radiosity, whose smooth shading keeps lamps and paints apart;
/// other quantities are smoothed as they are. `going_on` is (n, 2), the mirror reflectance and transmittance of patches in
/// which there is to be seen what is beyond. `diffuse_transmittance` (n, bands) is what passes to the patch that is the
/// back. `textures` are shown by smooth shading of radiosity.
#[pyfunction]
#[pyo3(signature = (patches, values, camera, width, height, samples, scale, smooth, irradiance=None, reflectance=None,
                    going_on=None, threads=None, progress=None, diffuse_transmittance=None, textures=None))]
fn render<'py>(
    py: Python<'py>,
    patches: &Patches,
    values: PyReadonlyArray2<'py, f64>,
    camera: CameraTuple,
    width: usize,
    height: usize,
    samples: usize,
    scale: f64,
    smooth: bool,
    irradiance: Option<PyReadonlyArray2<'py, f64>>,
    reflectance: Option<PyReadonlyArray2<'py, f64>>,
    going_on: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
    diffuse_transmittance: Option<PyReadonlyArray2<'py, f64>>,
    textures: Option<PyRef<'py, Textures>>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let patches = patches.inner.clone();
    let (n, bands) = (patches.len(), values.as_array().ncols());
    let values = convert::block_in(&values, n, bands, "values")?;
    let block = |array: Option<PyReadonlyArray2<'py, f64>>, what: &str| {
        array.map(|array| convert::block_in(&array, n, bands, what)).transpose()
    };
    let paint = block(irradiance, "irradiance")?.zip(block(reflectance, "reflectance")?);
    let textures = textures_in(textures, n)?;
    let camera = camera_in(camera);
    let settings = RenderSettings { width, height, samples, scale, ..RenderSettings::default() };
    let going_on = going_on.map(|parts| convert::going_on_in(&parts, n)).transpose()?;
    let through = convert::through_in(diffuse_transmittance.as_ref(), n, bands)?;
    let image = watch::run(py, threads, progress.as_ref(), |control| {
        let light = Light { patches: &patches, values: &values, bands, paint: paint.as_ref(), through: &through };
        let show = |shading: Shading| match &going_on {
            None => radiosity_picture::render(&patches, shading, bands, &camera, &settings, control),
            Some([specular, transmittance]) => {
                let mirrors = Mirrors { specular, transmittance };
                radiosity_picture::render_with_mirrors(&patches, mirrors, shading, bands, &camera, &settings, control)
            }
        };
        if smooth { light.smoothed(textures.as_ref(), show) } else { show(Shading::Patches(&values)) }
    })?;
    let image = image.map_err(|_| PyKeyboardInterrupt::new_err("stopped on request"))?;
    image_out(py, image)
}

/// Values of patches, and irradiance and reflectance if they are radiosity.
struct Light<'a> {
    patches: &'a radiosity_geometry::Patches,
    values: &'a [f64],
    bands: usize,
    paint: Option<&'a (Vec<f64>, Vec<f64>)>,
    /// What passes diffusely; empty if nothing does.
    through: &'a [f64],
}

impl Light<'_> {
    /// Has them shown with values at corners.
    fn smoothed<T>(&self, textures: Option<&TexturedPatches>, show: impl Fn(Shading) -> T) -> T {
        let (values, bands) = (self.values, self.bands);
        let smoother = Smoother::new(self.patches, radiosity_geometry::corners::CREASE_ANGLE);
        let Some((irradiance, reflectance)) = self.paint else {
            return show(Shading::Smooth(&smoother.corner_values(values, bands)));
        };
        let radiosity = smoother.corner_radiosity_of_patches(values, irradiance, reflectance, self.through, bands);
        let Some(textures) = textures else { return show(Shading::Smooth(&radiosity)) };
        let emission = radiosity_picture::emission_of(values, irradiance, reflectance);
        let irradiance = smoother.corner_values(irradiance, bands);
        show(Shading::Textured(Textured {
            radiosity: &radiosity,
            irradiance: &irradiance,
            emission: &emission,
            textures,
        }))
    }
}

/// (height, width, bands).
pub fn image_out(py: Python<'_>, image: Image) -> PyResult<Bound<'_, PyArray3<f32>>> {
    let array = Array3::from_shape_vec((image.height, image.width, image.bands), image.pixels);
    Ok(array.map_err(|e| PyValueError::new_err(e.to_string()))?.into_pyarray(py))
}

fn image_in(pixels: &PyReadonlyArray3<'_, f32>) -> Image {
    let view = pixels.as_array();
    let (height, width, bands) = view.dim();
    Image { width, height, bands, pixels: view.iter().copied().collect() }
}

/// Develops a linear image to an sRGB PNG: exposure in stops, or automatic; curve filmic, linear or reinhard.
#[pyfunction]
#[pyo3(signature = (path, image, exposure=None, curve="filmic"))]
fn write_png(
    py: Python<'_>,
    path: PathBuf,
    image: PyReadonlyArray3<'_, f32>,
    exposure: Option<f64>,
    curve: &str,
) -> PyResult<()> {
    let image = image_in(&image);
    let curve = match curve {
        "filmic" => ToneCurve::Filmic,
        "linear" => ToneCurve::Linear,
        "reinhard" => ToneCurve::Reinhard { white: 4.0 },
        _ => return Err(PyValueError::new_err(format!("there is no tone curve '{curve}'"))),
    };
    let exposure = exposure.map_or(Exposure::default(), Exposure::Stops);
    py.detach(|| {
        let picture = tone::developed(&image, exposure.factor(&image), curve);
        radiosity_picture::write_png(&path, &picture)
    })
    .map_err(errors::file)
}

/// Writes the mean over bands in false colours and returns the values of the first and the last colour; with a legend on
/// the right if it is given a title, of one line or more.
#[pyfunction]
#[pyo3(signature = (path, image, low=None, high=None, legend=None))]
fn write_false_colours(
    path: PathBuf,
    image: PyReadonlyArray3<'_, f32>,
    low: Option<f64>,
    high: Option<f64>,
    legend: Option<&str>,
) -> PyResult<(f64, f64)> {
    let image = image_in(&image);
    let automatic = ColourScale::automatic(&image, false);
    let scale = ColourScale { low: low.unwrap_or(automatic.low), high: high.unwrap_or(automatic.high), ..automatic };
    let picture = tone::false_colours(&image, &scale, ColourMap::default());
    let with_legend = |title| radiosity_picture::with_legend(&picture, &scale, ColourMap::default(), title);
    let picture = legend.map_or_else(|| picture.clone(), with_legend);
    radiosity_picture::write_png(&path, &picture).map_err(errors::file)?;
    Ok((scale.low, scale.high))
}

/// Writes a linear image as OpenEXR with one channel per band.
#[pyfunction]
fn write_exr(py: Python<'_>, path: PathBuf, image: PyReadonlyArray3<'_, f32>, bands: Vec<String>) -> PyResult<()> {
    let image = image_in(&image);
    py.detach(|| radiosity_picture::write_exr(&path, &image, &bands)).map_err(errors::file)
}
