//! Pictures and files of a solution: reconstruction, rendering, PNG and EXR, lit glTF, VTK.
//!
//! Values come in as plain slices, one entry per patch and band: this crate solves nothing. Text within pictures is
//! deliberately absent; whoever draws legends has fonts.

pub mod image;
pub mod image_files;
pub mod lit;
pub mod reconstruction;
pub mod render;
#[cfg(test)]
mod test_scenes;
pub mod tone;
pub mod vtp;

pub use image::{Image, Rgb8};
pub use image_files::{write_exr, write_png};
pub use lit::{LitData, LitModel, LitSurface, read_lit, write_lit};
pub use radiosity_store::files::{FileError, atomic_write};
pub use reconstruction::Smoother;
pub use render::{RenderSettings, Shading, render};
pub use tone::{ColourMap, ColourScale, Exposure, ToneCurve};
pub use vtp::write_vtp;
