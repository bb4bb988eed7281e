//! What is to be lit: surfaces with materials, lights, cameras; the files they come from; their meshing into patches.

pub mod model;

pub use model::{Camera, Face, Finding, Light, Material, Scene, SceneError, Severity, Surface};
