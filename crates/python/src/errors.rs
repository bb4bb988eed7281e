//! Errors as Python raises them.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use radiosity_equilibrium::Failure;

pyo3::create_exception!(_native, SceneError, PyValueError, "A scene that cannot be read, meshed or lit.");
pyo3::create_exception!(_native, ResourceError, PyRuntimeError, "The work does not fit the limits given.");

pub fn scene(error: radiosity_scene::SceneError) -> PyErr {
    SceneError::new_err(error.to_string())
}

pub fn failure(error: Failure) -> PyErr {
    match error {
        Failure::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        Failure::Memory { .. } => ResourceError::new_err(error.to_string()),
    }
}

pub fn factors(error: radiosity_exchange::factors::Failure) -> PyErr {
    use radiosity_exchange::factors::Failure;
    match error {
        Failure::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        Failure::Memory { .. } => ResourceError::new_err(error.to_string()),
    }
}
