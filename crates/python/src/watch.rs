//! Long work beside a listening interpreter.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use radiosity_operator::Control;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex};
use std::time::Duration;

/// How often signals are checked and progress is shown.
const TICK: Duration = Duration::from_millis(50);

/// Runs `work` on a pool of `threads` (all cores if `None`) with the interpreter lock released.
///
/// While it runs, signals are checked and `progress(done, total)` is called at every tick; an exception from either
/// stops the work and is raised. A panic becomes a `RuntimeError`.
pub fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> T + Send,
) -> PyResult<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|e| PyRuntimeError::new_err(format!("no threads to work on: {e}")))?;
    let control = Control::default();
    let (finished, bell) = (Mutex::new(false), Condvar::new());
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(&control))));
            *finished.lock().unwrap() = true;
            bell.notify_all();
            result
        });
        let mut interrupted = None;
        while !py.detach(|| {
            let guard = finished.lock().unwrap();
            *bell.wait_timeout_while(guard, TICK, |done| !*done).unwrap().0
        }) {
            if interrupted.is_none()
                && let Err(error) = listen(py, progress, &control)
            {
                control.cancel();
                interrupted = Some(error);
            }
        }
        let result = worker.join().expect("the worker catches its panics");
        match (interrupted, result) {
            (Some(error), _) => Err(error),
            (None, Ok(value)) => Ok(value),
            (None, Err(panic)) => Err(PyRuntimeError::new_err(format!(
                "internal error, please report it with the scene that caused it: {}",
                message(&*panic)
            ))),
        }
    })
}

fn listen(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, control: &Control) -> PyResult<()> {
    py.check_signals()?;
    if let Some(progress) = progress {
        progress.call1(control.progress())?;
    }
    Ok(())
}

fn message(panic: &(dyn std::any::Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown panic")
}
