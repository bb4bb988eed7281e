//! Images on surfaces.

use crate::patches::Patches;
use crate::scene::Scene;
use crate::{convert, errors};
use numpy::ndarray::Array3;
use numpy::{Element, IntoPyArray, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use radiosity_geometry::texture::{self, TexturedPatches, Wrap};
use std::sync::Arc;

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Raster>()?;
    module.add_class::<Textures>()
}

/// An image, linear, of values in [0, 1].
#[pyclass(frozen, module = "radiosity._native")]
pub struct Raster {
    pub inner: Arc<texture::Raster>,
}

const WRAPS: [(&str, Wrap); 3] = [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)];

fn wraps_in((u, v): (String, String)) -> PyResult<[Wrap; 2]> {
    let wrap = |name: String| {
        let known = WRAPS.iter().find(|(known, _)| *known == name);
        known.map(|(_, wrap)| *wrap).ok_or_else(|| {
            PyValueError::new_err(format!("there is no wrap mode '{name}'; choose repeat, clamp or mirror"))
        })
    };
    Ok([wrap(u)?, wrap(v)?])
}

/// The size, the channels and the texels of an image.
fn texels_in<T: Element + Copy>(image: &PyReadonlyArray3<'_, T>) -> PyResult<([usize; 2], usize, Vec<T>)> {
    let view = image.as_array();
    let (height, width, channels) = view.dim();
    if width * height == 0 || !(channels == 1 || channels == 3) {
        let shape = view.shape();
        return Err(PyValueError::new_err(format!("an image has shape (height, width, 1 or 3), not {shape:?}")));
    }
    Ok(([width, height], channels, view.iter().copied().collect()))
}

#[pymethods]
impl Raster {
    /// An image of (height, width, 1 or 3) bytes in sRGB.
    #[staticmethod]
    fn of_bytes(image: PyReadonlyArray3<'_, u8>, wrap: (String, String)) -> PyResult<Self> {
        let (wrap, (size, channels, levels)) = (wraps_in(wrap)?, texels_in(&image)?);
        Ok(Self { inner: Arc::new(radiosity_scene::srgb(size, channels, levels).with_wrap(wrap)) })
    }

    /// An image of (height, width, 1 or 3) linear values in [0, 1].
    #[staticmethod]
    fn of_values(image: PyReadonlyArray3<'_, f32>, wrap: (String, String)) -> PyResult<Self> {
        let (wrap, (size, channels, values)) = (wraps_in(wrap)?, texels_in(&image)?);
        if !values.iter().all(|value| (0.0..=1.0).contains(value)) {
            return Err(PyValueError::new_err("the values of an image lie in [0, 1]"));
        }
        Ok(Self { inner: Arc::new(texture::Raster::of_values(size, channels, values).with_wrap(wrap)) })
    }

    /// The same image with other edges.
    fn with_wrap(&self, wrap: (String, String)) -> PyResult<Self> {
        Ok(Self { inner: Arc::new((*self.inner).clone().with_wrap(wraps_in(wrap)?)) })
    }

    /// Linear values, (height, width, channels).
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let [width, height] = self.inner.size();
        let array = Array3::from_shape_vec((height, width, self.inner.channels()), self.inner.values());
        Ok(array.map_err(|e| PyValueError::new_err(e.to_string()))?.into_pyarray(py))
    }

    /// Height, width and channels.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [width, height] = self.inner.size();
        (height, width, self.inner.channels())
    }

    /// What is beyond the edges, along u and v.
    #[getter]
    fn wrap(&self) -> (&'static str, &'static str) {
        let name = |wrap: Wrap| WRAPS.iter().find(|(_, known)| *known == wrap).map_or("", |(name, _)| *name);
        let [u, v] = self.inner.wrap();
        (name(u), name(v))
    }

    /// Bytes held.
    #[getter]
    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

/// The textures on patches.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Textures {
    pub inner: TexturedPatches,
}

#[pymethods]
impl Textures {
    /// Those of a scene on patches of it; raises `SceneError` if one does not fit.
    #[new]
    fn new(py: Python<'_>, scene: &Scene, patches: &Patches) -> PyResult<Self> {
        let (scene, patches) = (&scene.inner, &patches.inner);
        let found = py.detach(|| Ok(TexturedPatches::new(patches, &scene.textured_faces()?)));
        Ok(Self { inner: found.map_err(errors::scene)? })
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    /// The same for others, the k-th of which is the `which[k]`-th of these; none where not `keep[k]`.
    fn picked(&self, which: PyReadonlyArray1<'_, u32>, keep: PyReadonlyArray1<'_, bool>) -> PyResult<Self> {
        let (which, keep) = (which.as_array().to_vec(), keep.as_array().to_vec());
        if which.len() != keep.len() || which.iter().any(|&index| index as usize >= self.inner.len()) {
            return Err(PyValueError::new_err("there must be one mark for each, and all must be among these"));
        }
        Ok(Self { inner: self.inner.picked(&which).kept(&keep) })
    }

    /// Values of the patches they are on, (n, bands), with the means over those that have a texture in their place.
    fn with_means<'py>(
        &self,
        py: Python<'py>,
        patches: &Patches,
        values: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bands = values.as_array().ncols();
        let mut values = convert::block_in(&values, self.inner.len(), bands, "values")?;
        if patches.inner.len() != self.inner.len() {
            return Err(PyValueError::new_err("the textures are on other patches"));
        }
        py.detach(|| self.inner.set_means(&patches.inner, &mut values, bands));
        Ok(convert::block_out(py, values, bands))
    }
}

/// Textures for `n` patches.
pub fn textures_in(textures: Option<PyRef<'_, Textures>>, n: usize) -> PyResult<Option<TexturedPatches>> {
    match textures {
        Some(textures) if textures.inner.len() != n => Err(PyValueError::new_err(format!(
            "there are textures for {} patches instead of {n}",
            textures.inner.len()
        ))),
        Some(textures) => Ok(Some(textures.inner.clone())),
        None => Ok(None),
    }
}
