//! Images in memory.

/// A linear image: radiance, or another quantity, per band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values per pixel.
    pub bands: usize,
    /// `height x width x bands` values, the top row first.
    pub pixels: Vec<f32>,
}

impl Image {
    /// The bands of the pixel in column `x` of row `y`.
    pub fn at(&self, x: usize, y: usize) -> &[f32] {
        let i = (y * self.width + x) * self.bands;
        &self.pixels[i..i + self.bands]
    }

    /// The bands of each pixel, row by row.
    pub fn iter(&self) -> impl Iterator<Item = &[f32]> {
        // An image without bands has no values, and chunks of none are not allowed.
        self.pixels.chunks_exact(self.bands.max(1))
    }
}

/// An image for the screen: sRGB, 8 bits per channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rgb8 {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `height x width x 3` values, the top row first.
    pub pixels: Vec<u8>,
}
