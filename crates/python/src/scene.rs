//! Scenes across the border: plain tuples and arrays out, the same in.

use crate::textures::Raster;
use crate::{convert, errors, patches};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radiosity_scene::meshing::{self, Contacts, Meshing};
use radiosity_scene::{
    Camera, Gloss, Light, LoadOptions, Material, Severity, Surface, Texture, Unit, builtin as builtins,
};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A scene as the engine knows it.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Scene {
    pub inner: radiosity_scene::Scene,
}

/// Image and (n_vertices, 2) coordinates.
type TextureOut<'py> = Option<(Raster, Bound<'py, PyArray2<f64>>)>;
type TextureIn<'py> = Option<(Py<Raster>, PyReadonlyArray2<'py, f64>)>;

/// Metallic and roughness.
type GlossTuple = (f64, f64);

/// Name, vertices, faces; name of the material, reflectance, emission, two-sided, specular, transmittance, diffuse
/// transmittance or nothing; texture, gloss.
type SurfaceOut<'py> = (
    String,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<u32>>,
    String,
    Vec<f64>,
    Vec<f64>,
    bool,
    f64,
    f64,
    Vec<f64>,
    TextureOut<'py>,
    GlossTuple,
);
type SurfaceIn<'py> = (
    String,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, i64>,
    String,
    Vec<f64>,
    Vec<f64>,
    bool,
    f64,
    f64,
    Vec<f64>,
    TextureIn<'py>,
    GlossTuple,
);

/// kind, name, position, direction, inner and outer angle, strength.
pub type LightTuple = (String, String, [f64; 3], [f64; 3], f64, f64, Vec<f64>);
/// name, position, forward, up, vertical angle of view, aspect.
pub type CameraTuple = (String, [f64; 3], [f64; 3], [f64; 3], f64, Option<f64>);

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (name, bands, surfaces, lights, cameras, obstructions=Vec::new(), combined=BTreeMap::new()))]
    fn new(
        name: String,
        bands: Vec<String>,
        surfaces: Vec<SurfaceIn<'_>>,
        lights: Vec<LightTuple>,
        cameras: Vec<CameraTuple>,
        obstructions: Vec<SurfaceIn<'_>>,
        combined: BTreeMap<usize, usize>,
    ) -> PyResult<Self> {
        let inner = radiosity_scene::Scene {
            name,
            bands,
            surfaces: surfaces.into_iter().map(surface_in).collect::<PyResult<_>>()?,
            obstructions: obstructions.into_iter().map(surface_in).collect::<PyResult<_>>()?,
            combined,
            lights: lights.into_iter().map(light_in).collect::<PyResult<_>>()?,
            cameras: cameras.into_iter().map(camera_in).collect(),
            ..Default::default()
        };
        Ok(Self { inner })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn bands(&self) -> Vec<String> {
        self.inner.bands.clone()
    }

    fn surfaces<'py>(&self, py: Python<'py>) -> Vec<SurfaceOut<'py>> {
        self.inner.surfaces.iter().map(|s| surface_out(py, s)).collect()
    }

    fn obstructions<'py>(&self, py: Python<'py>) -> Vec<SurfaceOut<'py>> {
        self.inner.obstructions.iter().map(|s| surface_out(py, s)).collect()
    }

    /// Index of a surface -> index of the surface it counts with.
    fn combined(&self) -> BTreeMap<usize, usize> {
        self.inner.combined.clone()
    }

    /// What the file asks of a computation of factors, by name; what it does not ask is left out.
    fn hints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (hints, named) = (&self.inner.hints, PyDict::new(py));
        if let Some(tolerance) = hints.tolerance {
            named.set_item("tolerance", tolerance)?;
        }
        for (name, _) in [("enclosure", hints.enclosure), ("emissivity", hints.emissivity)].iter().filter(|h| h.1) {
            named.set_item(name, true)?;
        }
        for (name, surface) in [("row", hints.row), ("column", hints.column)] {
            if let Some(index) = surface {
                named.set_item(name, index)?;
            }
        }
        Ok(named)
    }

    fn lights(&self) -> Vec<LightTuple> {
        self.inner.lights.iter().map(light_out).collect()
    }

    fn cameras(&self) -> Vec<CameraTuple> {
        self.inner.cameras.iter().map(camera_out).collect()
    }

    /// What the loader noticed: severity, code, element, message, surface, faces, edges and points of each.
    fn loading_findings<'py>(&self, py: Python<'py>) -> Vec<FindingOut<'py>> {
        findings_out(py, &self.inner.findings)
    }

    /// Everything worth knowing before lighting it.
    fn findings<'py>(&self, py: Python<'py>) -> Vec<FindingOut<'py>> {
        findings_out(py, &py.detach(|| self.inner.findings()))
    }

    /// Where the surfaces fail to enclose a space.
    fn enclosure_findings<'py>(&self, py: Python<'py>) -> Vec<FindingOut<'py>> {
        findings_out(py, &py.detach(|| self.inner.enclosure_findings()))
    }

    /// Raises `SceneError` if the scene cannot be lit.
    fn validate(&self) -> PyResult<()> {
        self.inner.validate().map_err(errors::scene)
    }

    /// Raises `SceneError` if the shapes are unsound, whatever materials and lights are.
    fn validate_geometry(&self) -> PyResult<()> {
        self.inner.validate_geometry().map_err(errors::scene)
    }

    /// Cuts the scene into patches: exactly one of the first three arguments is given.
    #[pyo3(signature = (max_edge=None, count=None, as_is=false, contacts=true))]
    fn patches(
        &self,
        py: Python<'_>,
        max_edge: Option<f64>,
        count: Option<usize>,
        as_is: bool,
        contacts: bool,
    ) -> PyResult<patches::Patches> {
        let meshing = match (max_edge, count, as_is) {
            (Some(edge), None, false) => Meshing::MaxEdge(edge),
            (None, Some(count), false) => Meshing::Count(count),
            (None, None, true) => Meshing::AsIs,
            _ => return Err(PyValueError::new_err("give exactly one of max_edge, count and as_is=True")),
        };
        let contacts = if contacts { Contacts::Cut } else { Contacts::Ignore };
        let patches = py.detach(|| meshing::patches_with(&self.inner, &meshing, contacts)).map_err(errors::scene)?;
        Ok(patches.into())
    }

    /// Cuts each face into an explicit grid, one (nu, nv) per face.
    fn grid(&self, divisions: Vec<(usize, usize)>) -> PyResult<patches::Patches> {
        let patches = meshing::grid(&self.inner, &divisions).map_err(errors::scene)?;
        Ok(patches.into())
    }
}

/// Reads a scene file.
#[pyfunction]
#[pyo3(signature = (path, unit=None, two_sided=None))]
pub fn load(py: Python<'_>, path: PathBuf, unit: Option<&str>, two_sided: Option<bool>) -> PyResult<Scene> {
    let unit = unit.map_or(Ok(Unit::default()), str::parse).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let options = LoadOptions { unit, two_sided, ..LoadOptions::default() };
    let inner = py.detach(|| radiosity_scene::load(&path, &options)).map_err(errors::scene)?;
    Ok(Scene { inner })
}

/// Makes a built-in scene by name.
#[pyfunction]
pub fn builtin(name: &str, numbers: Vec<f64>, spectra: Vec<Vec<f64>>) -> PyResult<Scene> {
    let spectrum = |k: usize| spectra.get(k).map(Vec::as_slice).unwrap_or_default();
    let number = |k: usize| numbers.get(k).copied().unwrap_or(0.0);
    let inner = match name {
        "cornell_box" => builtins::cornell_box(builtins::CornellVariant::Rgb),
        "cornell_box_original" => builtins::cornell_box(builtins::CornellVariant::Original),
        "furnace" => builtins::furnace(spectrum(0), spectrum(1)),
        "two_plates" => builtins::two_plates(
            number(0),
            number(1),
            number(2),
            Material::new("lower", spectrum(0), spectrum(1)),
            Material::new("upper", spectrum(2), spectrum(3)),
        ),
        "furnished_room" => builtins::furnished_room(number(0) as u32),
        _ => return Err(PyValueError::new_err(format!("there is no built-in scene '{name}'"))),
    };
    Ok(Scene { inner })
}

fn surface_out<'py>(py: Python<'py>, s: &Surface) -> SurfaceOut<'py> {
    let flat: Vec<u32> = s.faces.iter().flatten().copied().collect();
    let faces = numpy::ndarray::Array2::from_shape_vec((s.faces.len(), 4), flat).expect("four indices a face");
    let m = &s.material;
    (
        s.name.clone(),
        convert::points_out(py, &s.vertices),
        numpy::IntoPyArray::into_pyarray(faces, py),
        m.name.clone(),
        m.reflectance.clone(),
        m.emission.clone(),
        m.two_sided,
        m.specular,
        m.transmittance,
        m.diffuse_transmittance.clone(),
        s.texture.as_ref().map(|texture| {
            let coordinates = texture.coordinates.as_flattened().to_vec();
            (Raster { inner: texture.image.clone() }, convert::block_out(py, coordinates, 2))
        }),
        (m.gloss.metallic, m.gloss.roughness),
    )
}

fn surface_in(
    (
        name,
        vertices,
        faces,
        material,
        reflectance,
        emission,
        two_sided,
        specular,
        transmittance,
        through,
        texture,
        gloss,
    ): SurfaceIn<'_>,
) -> PyResult<Surface> {
    let view = faces.as_array();
    if !(view.ncols() == 3 || view.ncols() == 4) {
        let shape = view.shape();
        return Err(PyValueError::new_err(format!(
            "faces of surface '{name}' must have shape (m, 3) or (m, 4), not {shape:?}"
        )));
    }
    let index = |face: usize, corner: usize| {
        let value = view[[face, corner.min(view.ncols() - 1)]];
        u32::try_from(value).map_err(|_| {
            errors::SceneError::new_err(format!("surface '{name}', face {face}: vertex index {value} is out of range"))
        })
    };
    let faces = (0..view.nrows())
        .map(|f| Ok([index(f, 0)?, index(f, 1)?, index(f, 2)?, index(f, 3)?]))
        .collect::<PyResult<_>>()?;
    let vertices = convert::points_in(&vertices, &format!("vertices of surface '{name}'"))?;
    let (metallic, roughness) = gloss;
    let material = Material {
        name: material,
        reflectance,
        emission,
        specular,
        transmittance,
        two_sided,
        diffuse_transmittance: through,
        gloss: Gloss { metallic, roughness },
    };
    let texture = texture.map(|(image, coordinates)| {
        let coordinates = coordinates.as_array().rows().into_iter().map(|row| [row[0], row[1]]).collect();
        Texture { image: image.get().inner.clone(), coordinates }
    });
    Ok(Surface { vertices, faces, material, name, texture })
}

pub fn light_out(light: &Light) -> LightTuple {
    let none = [0.0; 3];
    match light.clone() {
        Light::Point { name, position, intensity } => {
            ("point".into(), name, position.to_array(), none, 0.0, 0.0, intensity)
        }
        Light::Spot { name, position, direction, intensity, inner_angle, outer_angle } => {
            ("spot".into(), name, position.to_array(), direction.to_array(), inner_angle, outer_angle, intensity)
        }
        Light::Directional { name, direction, irradiance } => {
            ("directional".into(), name, none, direction.to_array(), 0.0, 0.0, irradiance)
        }
    }
}

pub fn light_in((kind, name, position, direction, inner_angle, outer_angle, power): LightTuple) -> PyResult<Light> {
    let (position, direction) = (convert::vec3(position), convert::vec3(direction));
    Ok(match kind.as_str() {
        "point" => Light::Point { name, position, intensity: power },
        "spot" => Light::Spot { name, position, direction, intensity: power, inner_angle, outer_angle },
        "directional" => Light::Directional { name, direction, irradiance: power },
        _ => return Err(PyValueError::new_err(format!("there is no light of kind '{kind}'"))),
    })
}

pub fn camera_out(c: &Camera) -> CameraTuple {
    (c.name.clone(), c.position.to_array(), c.forward.to_array(), c.up.to_array(), c.vertical_fov, c.aspect)
}

pub fn camera_in((name, position, forward, up, vertical_fov, aspect): CameraTuple) -> Camera {
    let (position, forward, up) = (convert::vec3(position), convert::vec3(forward), convert::vec3(up));
    Camera { name, position, forward, up, vertical_fov, aspect }
}

/// severity, code, element, message; surface, (k,) faces of it, (k, 2, 3) edges and (k, 3) points.
type FindingOut<'py> = (
    &'static str,
    &'static str,
    String,
    String,
    Option<u32>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
);

fn findings_out<'py>(py: Python<'py>, findings: &[radiosity_scene::Finding]) -> Vec<FindingOut<'py>> {
    let severity = |s| match s {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    let out = |f: &radiosity_scene::Finding| {
        let place = &f.place;
        (
            severity(f.severity),
            f.code,
            f.element.clone(),
            f.message.clone(),
            place.surface,
            convert::vector_out(py, &place.faces),
            convert::edges_out(py, &place.edges),
            convert::points_out(py, &place.points),
        )
    };
    findings.iter().map(out).collect()
}
