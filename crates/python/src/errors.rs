//! Errors as Python raises them.

use pyo3::exceptions::{PyBlockingIOError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use radiosity_equilibrium::Failure;
use radiosity_store::StoreError;
use radiosity_store::files::FileError;

pyo3::create_exception!(_native, SceneError, PyValueError, "A scene that cannot be read, meshed or lit.");
pyo3::create_exception!(_native, ResourceError, PyRuntimeError, "The work does not fit the limits given.");

pub fn scene(error: radiosity_scene::SceneError) -> PyErr {
    SceneError::new_err(error.to_string())
}

pub fn failure(error: Failure) -> PyErr {
    match error {
        Failure::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        Failure::Memory { .. } => ResourceError::new_err(error.to_string()),
        Failure::Specular(_) | Failure::Translucent { .. } => PyValueError::new_err(error.to_string()),
    }
}

pub fn gradients(error: radiosity_equilibrium::adjoint::Failure) -> PyErr {
    use radiosity_equilibrium::adjoint::Failure;
    match error {
        Failure::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        Failure::OnDemand | Failure::Diverged | Failure::Translucent => PyValueError::new_err(error.to_string()),
    }
}

pub fn factors(error: radiosity_exchange::factors::Failure) -> PyErr {
    use radiosity_exchange::factors::Failure;
    match error {
        Failure::Cancelled => pyo3::exceptions::PyKeyboardInterrupt::new_err(error.to_string()),
        Failure::Memory { .. } => ResourceError::new_err(error.to_string()),
        Failure::Store(error) => store(error),
        Failure::Specular(_) => PyValueError::new_err(error.to_string()),
    }
}

/// Of the system as `OSError` with number and file name; of what is in a file as `ValueError`.
pub fn store(error: StoreError) -> PyErr {
    match error {
        StoreError::System(error) => file(error),
        StoreError::Busy { path } => {
            PyBlockingIOError::new_err((EAGAIN, "another process is building this file", path.display().to_string()))
        }
        other => PyValueError::new_err(other.to_string()),
    }
}

/// The number of `BlockingIOError`.
const EAGAIN: i32 = if cfg!(target_os = "linux") { 11 } else { 35 };

/// An `OSError` with number, text and file as the interpreter's own.
pub fn file(error: FileError) -> PyErr {
    let path = error.path.display().to_string();
    match error.source.raw_os_error() {
        Some(code) => PyOSError::new_err((code, describe(&error.source), path)),
        None => PyOSError::new_err(error.to_string()),
    }
}

fn describe(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_string()
}
