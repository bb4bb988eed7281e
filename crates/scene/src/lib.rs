//! What is to be lit: surfaces with materials, lights, cameras; the files they come from; their meshing into patches.

pub mod builtin;
mod findings;
pub mod formats;
pub mod meshing;
pub mod model;
mod quad;
mod textures;

pub use formats::srgb;
pub use formats::{LoadOptions, Unit, load};
pub use model::{
    Camera, Face, Finding, Gloss, Hints, Light, Material, Place, Scene, SceneError, Severity, Surface, Texture,
};
