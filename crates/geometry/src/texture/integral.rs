//! Means of an image over polygons, exact but for rounding.
//!
//! By Green's theorem the integral of f over a polygon is that of F dy along its outline, where F is the integral of f
//! along x. Between centres of texels f is bilinear, so that F is a quadratic in x and linear in y, and two Gauss points
//! on each piece of the outline are exact. So the effort goes with the texels along the outline, not with those within,
//! and polygons that share an edge add up to what they cover.

use super::raster::{Raster, Wrap};

/// Texels between two sums that are kept.
const BLOCK: usize = 8;

/// Sums of texels of every row up to each block.
pub(super) struct RowSums {
    /// Rows x blocks x channels.
    sums: Vec<f64>,
    blocks: usize,
}

impl RowSums {
    pub fn new(raster: &Raster) -> Self {
        let ([width, height], channels) = (raster.size(), raster.channels());
        let blocks = width / BLOCK + 1;
        let mut sums = Vec::with_capacity(height * blocks * channels);
        for y in 0..height {
            let mut sum = [0.0; 3];
            for x in 0..width {
                if x % BLOCK == 0 {
                    sums.extend(&sum[..channels]);
                }
                (0..channels).for_each(|c| sum[c] += f64::from(raster.texel(x, y, c)));
            }
            if width % BLOCK == 0 {
                sums.extend(&sum[..channels]);
            }
        }
        Self { sums, blocks }
    }

    /// The sum of the first `count` texels of a row.
    fn of_first(&self, raster: &Raster, (count, row, channel): (usize, usize, usize)) -> f64 {
        let block = count / BLOCK;
        let kept = self.sums[(row * self.blocks + block) * raster.channels() + channel];
        kept + (block * BLOCK..count).map(|x| f64::from(raster.texel(x, row, channel))).sum::<f64>()
    }

    /// The sum of the texels from the first up to one that may lie beyond the edges; less than nothing to the left.
    fn up_to(&self, raster: &Raster, (end, row, channel): (i64, usize, usize)) -> f64 {
        let width = raster.size()[0];
        let of_first = |count: usize| self.of_first(raster, (count, row, channel));
        let n = width as i64;
        match raster.wrap()[0] {
            Wrap::Repeat => end.div_euclid(n) as f64 * of_first(width) + of_first(end.rem_euclid(n) as usize),
            Wrap::Clamp => {
                let inside = end.clamp(0, n);
                let edge = if end < 0 { 0 } else { width - 1 };
                of_first(inside as usize) + (end - inside) as f64 * f64::from(raster.texel(edge, row, channel))
            }
            Wrap::Mirror => {
                let (whole, rest) = (end.div_euclid(2 * n) as f64, end.rem_euclid(2 * n));
                let all = of_first(width);
                let part =
                    if rest <= n { of_first(rest as usize) } else { 2.0 * all - of_first((2 * n - rest) as usize) };
                2.0 * whole * all + part
            }
        }
    }
}

/// A stretch of an outline within one square between four centres of texels.
struct Piece {
    /// The centre at its upper left.
    square: [i64; 2],
    /// The Gauss points, from that centre.
    points: [[f64; 2]; 2],
    /// What half of it is along y.
    weight: f64,
}

/// Outlines that pass more texels are left to samples.
const MOST_PIECES: f64 = (1 << 20) as f64;

/// A polygon thinner than this beside its length is a line, whose area says nothing.
const THINNEST: f64 = 1e-6;

impl Raster {
    /// The mean of each channel over a polygon of texture coordinates; `None` if it is too thin or too large for it to be
    /// found along its outline.
    pub(super) fn mean_over(&self, polygon: &[[f64; 2]]) -> Option<[f64; 3]> {
        let corners: Vec<[f64; 2]> = polygon.iter().map(|&uv| self.in_texels(uv)).collect();
        let edges = || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&p, &q)| (p, q));
        let area = 0.5 * edges().map(|([x0, y0], [x1, y1])| (x1 - x0) * (y0 + y1)).sum::<f64>();
        let length: f64 = edges().map(|([x0, y0], [x1, y1])| (x1 - x0).abs() + (y1 - y0).abs()).sum();
        if !(length < MOST_PIECES && area.abs() > THINNEST * length * length) {
            return None;
        }
        let mut sum = [0.0; 3];
        edges().for_each(|(p, q)| self.add_edge(p, q, &mut sum));
        // The area above was taken along x, and this goes along y: the other way round.
        let mut means = sum.map(|sum| -sum / area);
        if self.channels() == 1 {
            means = [means[0]; 3];
        }
        Some(means.map(|mean| mean.clamp(0.0, 1.0)))
    }

    /// Adds the integral of F dy along an edge to the sum of each channel.
    fn add_edge(&self, p: [f64; 2], q: [f64; 2], sums: &mut [f64; 3]) {
        if p[1] == q[1] {
            return;
        }
        pieces(p, q, |piece| {
            let rows = [0, 1].map(|j| self.wrap()[1].index(piece.square[1] + j, self.size()[1]));
            for (channel, sum) in sums.iter_mut().enumerate().take(self.channels()) {
                let [upper, lower] = rows.map(|row| self.along_row(piece.square[0], row, channel));
                for [a, b] in piece.points {
                    let at = |[whole, first, slope]: [f64; 3]| whole + a * (first + 0.5 * a * slope);
                    *sum += piece.weight * ((1.0 - b) * at(upper) + b * at(lower));
                }
            }
        });
    }

    /// The integral along a row up to the centre of a texel, but for what is the same for all of them; the value there;
    /// and how much more it is at the next.
    fn along_row(&self, column: i64, row: usize, channel: usize) -> [f64; 3] {
        let value = |i| f64::from(self.texel(self.wrap()[0].index(i, self.size()[0]), row, channel));
        let (here, next) = (value(column), value(column + 1));
        [self.sums().up_to(self, (column, row, channel)) + 0.5 * here, here, next - here]
    }
}

/// Cuts an edge where it crosses lines through centres of texels.
fn pieces(p: [f64; 2], q: [f64; 2], mut visit: impl FnMut(&Piece)) {
    const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
    let by = [q[0] - p[0], q[1] - p[1]];
    let point = |t: f64| [p[0] + t * by[0], p[1] + t * by[1]];
    // The next line that is crossed along each axis.
    let mut line = [0, 1].map(|k| if by[k] > 0.0 { p[k].floor() + 1.0 } else { p[k].ceil() - 1.0 });
    let mut begin = 0.0;
    while begin < 1.0 {
        let crossing = [0, 1].map(|k| if by[k] == 0.0 { f64::INFINITY } else { (line[k] - p[k]) / by[k] });
        let end = crossing[0].min(crossing[1]).clamp(begin, 1.0);
        let square = point(0.5 * (begin + end)).map(f64::floor);
        let points = GAUSS.map(|g| point(begin + g * (end - begin))).map(|[x, y]| [x - square[0], y - square[1]]);
        let weight = 0.5 * (end - begin) * by[1];
        visit(&Piece { square: square.map(|c| c as i64), points, weight });
        for k in 0..2 {
            if crossing[k] <= end {
                line[k] += by[k].signum();
            }
        }
        begin = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(width: usize, height: usize, wrap: Wrap) -> Raster {
        let values = (0..width * height).map(|i| ((i * 7919) % 101) as f32 / 101.0).collect();
        Raster::of_values([width, height], 1, values).with_wrap([wrap; 2])
    }

    /// By many points.
    fn sampled(raster: &Raster, [a, b, c]: [[f64; 2]; 3]) -> f64 {
        let n = 700;
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..n {
            for j in 0..n - i {
                let (s, t) = ((f64::from(i) + 1.0 / 3.0) / f64::from(n), (f64::from(j) + 1.0 / 3.0) / f64::from(n));
                let at = [0, 1].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                sum += f64::from(raster.at(at)[0]);
                count += 1.0;
            }
        }
        sum / count
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn the_mean_over_the_whole_image_is_that_of_its_texels() {
        for (width, height) in [(1, 1), (2, 3), (16, 5), (33, 17)] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                let raster = raster(width, height, wrap);
                let values = raster.values();
                let expected = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
                for turned in [false, true] {
                    let mut square = SQUARE;
                    if turned {
                        square.reverse();
                    }
                    let found = raster.mean_over(&square).unwrap()[0];
                    assert!((found - expected).abs() < 1e-12, "{width} x {height} {wrap:?}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn means_over_triangles_are_those_of_many_points_beyond_the_edges_too() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            let raster = raster(19, 6, wrap);
            for triangle in [[[0.1, 0.2], [0.7, 0.3], [0.4, 0.9]], [[-1.3, -0.4], [0.2, 2.9], [1.7, -1.1]]] {
                let (found, expected) = (raster.mean_over(&triangle).unwrap()[0], sampled(&raster, triangle));
                // A grid of so many points on a function with kinks.
                assert!((found - expected).abs() < 2e-4, "{wrap:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn parts_add_up_to_the_whole() {
        let raster = raster(13, 29, Wrap::Repeat);
        let (middle, mut sum) = ([0.37, 0.61], 0.0);
        for k in 0..4 {
            let (p, q) = (SQUARE[k], SQUARE[(k + 1) % 4]);
            let area = 0.5 * ((q[0] - p[0]) * (middle[1] - p[1]) - (q[1] - p[1]) * (middle[0] - p[0]));
            sum += area * raster.mean_over(&[p, q, middle]).unwrap()[0];
        }
        assert!((sum - raster.mean_over(&SQUARE).unwrap()[0]).abs() < 1e-12);
    }

    #[test]
    fn lines_and_what_passes_too_many_texels_have_none() {
        let raster = raster(4, 4, Wrap::Repeat);
        for polygon in [[[0.0; 2]; 3], [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], [[0.0, 0.0], [1e9, 0.0], [0.0, 1e9]]] {
            assert!(raster.mean_over(&polygon).is_none());
        }
    }
}
