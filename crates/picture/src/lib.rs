//! Pictures and files of a solution: reconstruction, rendering, legends, PNG and EXR, lit glTF, VTK.
//!
//! Values come in as plain slices, one entry per patch and band: this crate solves nothing. Traced pictures show what
//! paths of `radiosity-paths` find at what is seen.

pub mod backs;
mod beyond;
mod eye;
pub mod gather;
pub mod image;
pub mod image_files;
pub mod legend;
pub mod lit;
mod metals;
pub mod reconstruction;
pub mod render;
#[cfg(test)]
mod test_scenes;
pub mod tone;
pub mod traced;
mod view;
pub mod vtp;

pub use backs::Sheets;
pub use eye::Surfaces;
pub use gather::{Fields, GatherSettings, Gathered, direct_and_rest, gather};
pub use image::{Image, Rgb8};
pub use image_files::{write_exr, write_png};
pub use legend::with_legend;
pub use lit::{LitData, LitModel, LitSurface, read_lit, write_lit};
pub use radiosity_store::files::{FileError, atomic_write};
pub use reconstruction::{Smoother, emission_of};
pub use render::{Mirrors, RenderSettings, Shading, Textured, render, render_with_mirrors};
pub use tone::{ColourMap, ColourScale, Exposure, ToneCurve};
pub use traced::{TraceSettings, Traced, trace};
pub use vtp::write_vtp;
