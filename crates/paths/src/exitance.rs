//! What leaves sides, for paths that meet them.

use radiosity_exchange::Enclosure;

/// Radiant exitance of sides per band, W/m2; in single precision, which is far finer than any noise.
#[derive(Clone, Debug)]
pub enum Exitance {
    /// The same all over each side: sides x bands.
    Uniform(Vec<f32>),
    /// At the four corners of each side's patch, interpolated: sides x 4 x bands.
    Corners(Vec<f32>),
}

impl Exitance {
    /// Adds `weight` times the exitance at chart coordinates of a side, band by band through `filter`, to `sum`.
    #[inline]
    pub(crate) fn add(
        &self,
        enclosure: &Enclosure,
        (side, s, t): (u32, f64, f64),
        weight: f32,
        filter: &[f32],
        sum: &mut [f32],
    ) {
        let (side, bands) = (side as usize, sum.len());
        match self {
            Self::Uniform(values) => add(&values[side * bands..][..bands], weight, filter, sum),
            Self::Corners(values) => {
                let corners = &values[4 * side * bands..][..4 * bands];
                for (corner, share) in corners.chunks_exact(bands).zip(enclosure.corner_weights(side, s, t)) {
                    add(corner, weight * share as f32, filter, sum);
                }
            }
        }
    }

    /// The mean over bands, and over corners, of a side.
    pub(crate) fn mean(&self, side: usize, bands: usize) -> f64 {
        let (values, width) = match self {
            Self::Uniform(values) => (values, bands),
            Self::Corners(values) => (values, 4 * bands),
        };
        let own = &values[side * width..(side + 1) * width];
        own.iter().map(|&v| f64::from(v)).sum::<f64>() / width.max(1) as f64
    }

    /// How many values there are for so many sides and bands.
    pub(crate) fn len(&self) -> (usize, usize) {
        match self {
            Self::Uniform(values) => (values.len(), 1),
            Self::Corners(values) => (values.len(), 4),
        }
    }
}

#[inline]
fn add(values: &[f32], weight: f32, filter: &[f32], sum: &mut [f32]) {
    for ((sum, value), filter) in sum.iter_mut().zip(values).zip(filter) {
        *sum += weight * value * filter;
    }
}
