//! `radiosity._native`: conversion between numpy and the engine, errors, and releasing the interpreter lock.
//!
//! Nothing is computed here. Every long call runs on its own thread pool with the lock released, reports progress and
//! answers Ctrl-C (see [`watch`]).

mod convert;
mod errors;
mod factors;
mod patches;
mod paths;
mod picture;
mod scene;
mod shooting;
mod solution;
mod teaching;
mod textures;
mod watch;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<scene::Scene>()?;
    module.add_class::<patches::Patches>()?;
    module.add_class::<patches::Enclosure>()?;
    module.add_class::<patches::AdaptiveMesh>()?;
    module.add_class::<solution::Solution>()?;
    module.add_class::<shooting::ShotSolution>()?;
    module.add_class::<shooting::ShootingState>()?;
    module.add_class::<factors::Factors>()?;
    module.add_class::<factors::ExchangeFile>()?;
    module.add_class::<teaching::ItemBuffer>()?;
    module.add("SceneError", module.py().get_type::<errors::SceneError>())?;
    module.add("ResourceError", module.py().get_type::<errors::ResourceError>())?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(scene::builtin, module)?)?;
    module.add_function(wrap_pyfunction!(patches::corner_field, module)?)?;
    module.add_function(wrap_pyfunction!(solution::solve, module)?)?;
    module.add_function(wrap_pyfunction!(solution::solve_on_demand, module)?)?;
    module.add_function(wrap_pyfunction!(solution::solve_linked, module)?)?;
    module.add_function(wrap_pyfunction!(shooting::shoot, module)?)?;
    module.add_function(wrap_pyfunction!(factors::form_factors, module)?)?;
    module.add_function(wrap_pyfunction!(factors::given_factors, module)?)?;
    module.add_function(wrap_pyfunction!(teaching::frame, module)?)?;
    module.add_function(wrap_pyfunction!(teaching::nusselt_outline, module)?)?;
    module.add_function(wrap_pyfunction!(teaching::nusselt_share, module)?)?;
    module.add_function(wrap_pyfunction!(teaching::item_buffer, module)?)?;
    module.add_function(wrap_pyfunction!(teaching::delta_form_factors, module)?)?;
    paths::register(module)?;
    picture::register(module)?;
    textures::register(module)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    Ok(())
}
