//! Images laid over faces: what they hold at a point, and their means over polygons.
//!
//! An image is numbers here, and knows not what they mean. Texture coordinates (u, v) are those of glTF: (0, 0) is the
//! upper left corner of an image and (1, 1) the lower right one, whose texels have their centres at halves.

mod faces;
mod integral;
mod patches;
mod raster;

pub use faces::{TexturedFaces, Values, unwrapped};
pub use patches::TexturedPatches;
pub use raster::{Raster, Wrap};
