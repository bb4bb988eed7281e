//! An image as numbers, interpolated.

use std::sync::{Arc, OnceLock};

use super::integral::RowSums;

/// What an image shows beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Itself again.
    #[default]
    Repeat,
    /// The texels of the edge.
    Clamp,
    /// Itself in a mirror.
    Mirror,
}

impl Wrap {
    /// The texel of `n` that stands for one that may lie beyond the edges.
    #[inline]
    pub(super) fn index(self, i: i64, n: usize) -> usize {
        let n = n as i64;
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let i = i.rem_euclid(2 * n);
                i.min(2 * n - 1 - i)
            }
        };
        inside as usize
    }
}

/// An image of one or three channels, row by row from the top; copies share the texels. Values lie in [0, 1].
#[derive(Clone)]
pub struct Raster {
    width: usize,
    height: usize,
    channels: usize,
    texels: Texels,
    wrap: [Wrap; 2],
    gain: [f32; 3],
    /// For means, made when they are first asked for.
    sums: OnceLock<Arc<RowSums>>,
}

#[derive(Clone)]
enum Texels {
    /// Bytes, and the value that each of them stands for.
    Levels(Arc<Vec<u8>>, Arc<[f32; 256]>),
    Values(Arc<Vec<f32>>),
}

/// Nothing is farther out than this, in texels: coordinates of a file may be anything.
const FARTHEST: f64 = 1e15;

impl Raster {
    /// An image of bytes, `height x width x channels`, each of which stands for a value in `table`.
    ///
    /// # Panics
    /// If there are no texels, or not as many as the size says, or not one or three channels.
    pub fn of_levels([width, height]: [usize; 2], channels: usize, levels: Vec<u8>, table: Arc<[f32; 256]>) -> Self {
        Self::new([width, height], channels, levels.len(), Texels::Levels(Arc::new(levels), table))
    }

    /// An image of values.
    ///
    /// # Panics
    /// As [`Raster::of_levels`].
    pub fn of_values([width, height]: [usize; 2], channels: usize, values: Vec<f32>) -> Self {
        Self::new([width, height], channels, values.len(), Texels::Values(Arc::new(values)))
    }

    fn new([width, height]: [usize; 2], channels: usize, count: usize, texels: Texels) -> Self {
        assert!(channels == 1 || channels == 3, "one or three channels");
        assert!(count > 0 && count == width * height * channels, "as many texels as the size says");
        let (wrap, gain) = ([Wrap::Repeat; 2], [1.0; 3]);
        Self { width, height, channels, texels, wrap, gain, sums: OnceLock::new() }
    }

    /// The same image with other edges: along u and v.
    pub fn with_wrap(self, wrap: [Wrap; 2]) -> Self {
        Self { wrap, sums: OnceLock::new(), ..self }
    }

    /// The same image with each channel times a factor and limited to 1 texel by texel.
    pub fn with_gain(self, gain: [f32; 3]) -> Self {
        Self { gain, sums: OnceLock::new(), ..self }
    }

    /// Texels a row and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// One or three.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// What is beyond the edges, along u and v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Bytes that its texels take.
    pub fn memory_bytes(&self) -> usize {
        match &self.texels {
            Texels::Levels(levels, _) => levels.len(),
            Texels::Values(values) => 4 * values.len(),
        }
    }

    /// The value of a texel within the image.
    #[inline]
    pub fn texel(&self, x: usize, y: usize, channel: usize) -> f32 {
        let i = (y * self.width + x) * self.channels + channel;
        let value = match &self.texels {
            Texels::Levels(levels, table) => table[usize::from(levels[i])],
            Texels::Values(values) => values[i],
        };
        (self.gain[channel] * value).min(1.0)
    }

    /// All values, `height x width x channels`.
    pub fn values(&self) -> Vec<f32> {
        let (width, channels) = (self.width, self.channels);
        (0..width * self.height * channels)
            .map(|i| self.texel(i / channels % width, i / channels / width, i % channels))
            .collect()
    }

    /// The largest value of each channel; of one, three times the same.
    pub fn brightest(&self) -> [f32; 3] {
        let mut most = [0.0_f32; 3];
        for y in 0..self.height {
            for x in 0..self.width {
                (0..self.channels).for_each(|c| most[c] = most[c].max(self.texel(x, y, c)));
            }
        }
        if self.channels == 1 { [most[0]; 3] } else { most }
    }

    /// Coordinates in texels, of whose centres the first has (0, 0).
    #[inline]
    pub(super) fn in_texels(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let place = |c: f64, n: usize| {
            let texels = c * n as f64 - 0.5;
            if texels.is_nan() { 0.0 } else { texels.clamp(-FARTHEST, FARTHEST) }
        };
        [place(u, self.width), place(v, self.height)]
    }

    /// The values at texture coordinates, interpolated between the four nearest texels; one per channel.
    #[inline]
    pub fn at(&self, coordinates: [f64; 2]) -> [f32; 3] {
        let [x, y] = self.in_texels(coordinates);
        let (left, top) = (x.floor(), y.floor());
        let (a, b) = ((x - left) as f32, (y - top) as f32);
        let column = |i| self.wrap[0].index(left as i64 + i, self.width);
        let row = |j| self.wrap[1].index(top as i64 + j, self.height);
        let ([x0, x1], [y0, y1]) = ([column(0), column(1)], [row(0), row(1)]);
        let mut values = [0.0; 3];
        for (c, value) in values.iter_mut().enumerate().take(self.channels) {
            let along = |y| (1.0 - a) * self.texel(x0, y, c) + a * self.texel(x1, y, c);
            *value = (1.0 - b) * along(y0) + b * along(y1);
        }
        if self.channels == 1 { [values[0]; 3] } else { values }
    }

    /// The sums that means are found from.
    pub(super) fn sums(&self) -> &RowSums {
        self.sums.get_or_init(|| Arc::new(RowSums::new(self)))
    }
}

impl std::fmt::Debug for Raster {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Raster({} x {} x {})", self.width, self.height, self.channels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(wrap: Wrap) -> Raster {
        Raster::of_values([2, 2], 1, vec![0.0, 0.25, 0.5, 1.0]).with_wrap([wrap; 2])
    }

    #[test]
    fn centres_of_texels_have_their_values_and_between_them_it_is_linear() {
        let raster = raster(Wrap::Clamp);
        for (uv, value) in [([0.25, 0.25], 0.0), ([0.75, 0.25], 0.25), ([0.25, 0.75], 0.5), ([0.5, 0.5], 0.4375)] {
            assert_eq!(raster.at(uv), [value; 3], "{uv:?}");
        }
    }

    #[test]
    fn edges_repeat_clamp_and_mirror() {
        let along = |wrap| [-0.75, -0.25, 1.25, 1.75].map(|u| raster(wrap).at([u, 0.25])[0]);
        assert_eq!(along(Wrap::Repeat), [0.0, 0.25, 0.0, 0.25]);
        assert_eq!(along(Wrap::Clamp), [0.0, 0.0, 0.25, 0.25]);
        assert_eq!(along(Wrap::Mirror), [0.25, 0.0, 0.25, 0.0]);
    }

    #[test]
    fn gain_is_limited_to_one() {
        let table: [f32; 256] = std::array::from_fn(|level| level as f32 / 256.0);
        let raster = Raster::of_levels([1, 1], 3, vec![32, 64, 255], Arc::new(table)).with_gain([2.0, 2.0, 2.0]);
        assert_eq!(raster.at([0.3, 7.0]), [0.25, 0.5, 1.0]);
        assert_eq!(raster.brightest(), [0.25, 0.5, 1.0]);
    }

    #[test]
    fn places_that_are_no_places_are_no_harm() {
        for wild in [f64::MAX, f64::INFINITY, -f64::INFINITY, f64::NAN] {
            assert!((0.0..=1.0).contains(&raster(Wrap::Mirror).at([wild, -wild])[0]));
        }
    }
}
