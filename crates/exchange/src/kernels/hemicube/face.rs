//! The five faces of a hemicube and their pixels.
//!
//! In the frame of the source, z along its normal, the hemicube is the upper half of the cube of half edge 1. A pixel
//! stands for the direction through its centre, `(u, v)` on its face.

/// Which face, as an index: the top and four sides.
pub(super) const TOP: usize = 0;

/// How many faces there are.
pub(super) const FACES: usize = 5;

/// Coordinates of a vector on a face: along `u`, along `v` and along the axis out of the face.
///
/// The direction of the pixel `(u, v)` is the one for which this is `(u, v, 1)`; the product of two vectors is not
/// changed by it. Faces in order: +z, +x, -x, +y, -y; `v` is height on all but the first.
#[inline(always)]
pub(super) fn on_face(face: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match face {
        TOP => [x, y, z],
        1 => [y, z, x],
        2 => [y, z, -x],
        3 => [x, z, y],
        _ => [x, z, -y],
    }
}

/// Whether [`on_face`] makes left hands of right ones.
#[inline(always)]
pub(super) fn mirrored(face: usize) -> bool {
    matches!(face, 2 | 3)
}

/// The inverse of [`on_face`].
pub(super) fn from_face(face: usize, [u, v, w]: [f64; 3]) -> [f64; 3] {
    match face {
        TOP => [u, v, w],
        1 => [w, u, v],
        2 => [-w, u, v],
        3 => [u, w, v],
        _ => [u, -w, v],
    }
}

/// How the pixels of a face lie: pixel `(i, j)` is at `u = (i + 0.5) step - 1`, `v = (j + 0.5) step + lowest`.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    /// Pixels along `u`.
    pub columns: usize,
    /// Pixels along `v`.
    pub rows: usize,
    /// The width of a pixel.
    pub step: f64,
    /// Pixels to a unit length: the inverse of `step`.
    pub scale: f64,
    /// Where `v` begins: -1 on the top, the horizon on sides.
    pub lowest: f64,
}

impl Grid {
    #[inline(always)]
    pub fn new(face: usize, resolution: usize) -> Self {
        let half = resolution / 2;
        let (rows, lowest) = if face == TOP { (resolution, -1.0) } else { (half, 0.0) };
        Self { columns: resolution, rows, step: 1.0 / half as f64, scale: half as f64, lowest }
    }

    /// `u` in pixels: whole numbers are centres.
    #[inline(always)]
    pub fn column(&self, u: f64) -> f64 {
        (u + 1.0) * self.scale - 0.5
    }

    /// `v` in pixels.
    #[inline(always)]
    pub fn row(&self, v: f64) -> f64 {
        (v - self.lowest) * self.scale - 0.5
    }

    /// The centre of a column.
    #[inline(always)]
    pub fn u(&self, column: f64) -> f64 {
        (column + 0.5) * self.step - 1.0
    }

    /// The centre of a row.
    #[inline(always)]
    pub fn v(&self, row: f64) -> f64 {
        (row + 0.5) * self.step + self.lowest
    }
}

/// A rectangle of pixels, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub columns: [u16; 2],
    pub rows: [u16; 2],
}

impl Window {
    #[inline(always)]
    pub fn all(grid: &Grid) -> Self {
        Self { columns: [0, grid.columns as u16], rows: [0, grid.rows as u16] }
    }

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.columns[0] >= self.columns[1] || self.rows[0] >= self.rows[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_isometries_and_face_outward() {
        for face in 0..FACES {
            let (p, q) = ([1.0, -2.0, 3.0], [0.5, 4.0, -7.0]);
            assert_eq!(from_face(face, on_face(face, p)), p);
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            assert_eq!(dot(on_face(face, p), on_face(face, q)), dot(p, q));
            let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| on_face(face, axis));
            let volume = glam::DVec3::from(x).cross(y.into()).dot(z.into());
            assert_eq!(volume, if mirrored(face) { -1.0 } else { 1.0 });
        }
    }

    #[test]
    fn rows_and_columns_invert_centres() {
        for face in [TOP, 1] {
            let grid = Grid::new(face, 16);
            for k in 0..8 {
                assert_eq!(grid.column(grid.u(k as f64)), k as f64);
                assert_eq!(grid.row(grid.v(k as f64)), k as f64);
            }
        }
    }
}
