//! Piecewise linear fields on patches, from one value a patch.
//!
//! Patches carry means. What varies over them is seen from their neighbours: each patch takes the slope that fits the
//! values around it best (least squares, exact for linear fields, also one-sided along borders), and a corner takes the
//! mean of what the patches that belong together there say of it. So values at creases and borders are those that the
//! field tends to there, and not those of half a patch away.

use std::f64::consts::PI;
use std::ops::Deref;

use glam::DVec2;
use rayon::prelude::*;

use crate::{Chart, DVec3, Patches};

/// Which corners of patches belong together: they meet in a point and are joined by edges that are no creases.
///
/// Two patches are joined by an edge that they share to the bit if their normals differ by less than the crease angle
/// and no third patch stands on that edge, as a wall does on a floor that continues behind it.
///
/// Corner values are `n_patches x 4 x columns`, in order of the corners of each polygon; a triangle repeats its last.
#[derive(Clone, Debug)]
pub struct Corners<P> {
    patches: P,
    /// For each corner the number of its group.
    group: Vec<u32>,
    /// Where the members of each group begin in `members`.
    offsets: Vec<u32>,
    /// Corners, group by group; the fourth of a triangle is in none.
    members: Vec<u32>,
    /// The angle of each member.
    angles: Vec<f64>,
}

/// Creases are edges of at least this angle unless said otherwise: 30 degrees, in radians.
pub const CREASE_ANGLE: f64 = PI / 6.0;

impl<P: Deref<Target = Patches> + Sync> Corners<P> {
    /// Finds the corners that belong together; `crease_angle` is in radians.
    ///
    /// # Panics
    /// With more than 2^30 patches.
    pub fn new(patches: P, crease_angle: f64) -> Self {
        assert!(patches.len() <= 1 << 30, "corners are numbered by 32 bits");
        let corners = corners_by_position(&patches);
        let flattest = crease_angle.cos();
        let places: Vec<_> = corners.chunk_by(|a, b| a.0 == b.0).collect();
        let leaders: Vec<Vec<(u32, u32)>> =
            places.par_iter().with_min_len(256).map(|place| leaders(&patches, place, flattest)).collect();
        let mut pairs: Vec<(u32, u32)> =
            leaders.into_iter().flatten().map(|(corner, leader)| (leader, corner)).collect();
        pairs.par_sort_unstable();
        let mut group = vec![u32::MAX; 4 * patches.len()];
        let mut offsets = vec![0u32];
        for together in pairs.chunk_by(|a, b| a.0 == b.0) {
            for &(_, corner) in together {
                group[corner as usize] = offsets.len() as u32 - 1;
            }
            offsets.push(offsets[offsets.len() - 1] + together.len() as u32);
        }
        // A triangle's repeated corner has the value of the one before it.
        for corner in (3..group.len()).step_by(4).filter(|&corner| group[corner] == u32::MAX).collect::<Vec<_>>() {
            group[corner] = group[corner - 1];
        }
        let members: Vec<u32> = pairs.into_iter().map(|(_, corner)| corner).collect();
        let angles = members.par_iter().map(|&corner| angle(&patches, corner as usize)).collect();
        Self { patches, group, offsets, members, angles }
    }

    /// Values at the corners of the continuous, piecewise linear field through values of patches, for each column.
    ///
    /// # Panics
    /// If `values` is not `n_patches x columns`.
    pub fn field(&self, values: &[f64], columns: usize) -> Vec<f64> {
        let n = self.patches.len();
        assert_eq!(values.len(), n * columns, "one value per patch and column");
        if columns == 0 {
            return Vec::new();
        }
        let mut slopes = vec![DVec3::ZERO; n * columns];
        slopes.par_chunks_mut(columns).enumerate().with_min_len(256).for_each(|(patch, slopes)| {
            self.slopes_of(patch, values, slopes);
        });
        let groups = self.offsets.len() - 1;
        let mut of_group = vec![0.0; groups * columns];
        of_group.par_chunks_mut(columns).enumerate().with_min_len(256).for_each(|(group, sums)| {
            let mut weight = 0.0;
            for (corner, angle) in self.members_of(group) {
                let (patch, place) = (corner / 4, self.place(corner));
                weight += angle;
                for (k, sum) in sums.iter_mut().enumerate() {
                    let row = patch * columns + k;
                    *sum += angle * (values[row] + slopes[row].dot(place - self.patches.centre[patch]));
                }
            }
            // A patch without area has no angles.
            sums.iter_mut().for_each(|sum| *sum = if weight > 0.0 { *sum / weight } else { f64::NAN });
        });
        let mut corners = vec![0.0; 4 * n * columns];
        corners.par_chunks_mut(columns).enumerate().with_min_len(1024).for_each(|(corner, out)| {
            let shared = &of_group[self.group[corner] as usize * columns..][..columns];
            let own = &values[corner / 4 * columns..][..columns];
            for ((out, shared), own) in out.iter_mut().zip(shared).zip(own) {
                *out = if shared.is_nan() { *own } else { *shared };
            }
        });
        corners
    }

    /// The patches around each that belong together with it at a corner, itself among them, one after another.
    pub fn around(&self, patch: usize) -> impl Iterator<Item = usize> + '_ {
        let corners = self.patches.corners(patch).len();
        (4 * patch..4 * patch + corners)
            .flat_map(|corner| self.members_of(self.group[corner] as usize).map(|(other, _)| other / 4))
    }

    /// The corners of a group, each with its angle.
    fn members_of(&self, group: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.offsets[group] as usize..self.offsets[group + 1] as usize;
        self.members[range.clone()].iter().map(|&corner| corner as usize).zip(self.angles[range].iter().copied())
    }

    fn place(&self, corner: usize) -> DVec3 {
        self.patches.polygons[corner / 4][corner % 4]
    }

    /// The slopes in the plane of a patch that fit the values around it best; near ones count more.
    ///
    /// Near and far are measured by the patch's own shape. What is much nearer than its corners, as slivers are, says
    /// little of its slope, and where nothing else lies in a direction there is none.
    fn slopes_of(&self, patch: usize, values: &[f64], slopes: &mut [DVec3]) {
        let columns = slopes.len();
        let Some(shape) = Shape::of(&self.patches, patch) else { return };
        let mut spread = Symmetric::default();
        // Patches that share an edge come twice, as they should: they tell more than those that share a corner.
        for other in self.around(patch).filter(|&other| other != patch && self.patches.area[other] > 0.0) {
            let d = shape.measured(self.patches.centre[other] - self.patches.centre[patch]);
            let weight = 1.0 / d.length_squared().max(TOO_NEAR * TOO_NEAR);
            spread.add(weight, d);
            for (k, slope) in slopes.iter_mut().enumerate() {
                let rise = values[other * columns + k] - values[patch * columns + k];
                *slope += (weight * rise * d).extend(0.0);
            }
        }
        let inverse = spread.pseudoinverse(LEAST_SPREAD);
        for slope in slopes {
            *slope = shape.slope(inverse.times(slope.truncate()));
        }
    }
}

/// Neighbours whose centres are nearer than this, in distances of the patch's own corners, count less.
const TOO_NEAR: f64 = 0.25;

/// Neighbours in a direction, at such distances that each counts one, must count at least this together.
const LEAST_SPREAD: f64 = 0.1;

/// What makes the corners of a patch lie one from its centre, on average in every direction.
struct Shape {
    u: DVec3,
    v: DVec3,
    /// The inverse of the lower triangular root of the corners' covariance: its first column, and the last entry.
    inverse: [f64; 3],
}

impl Shape {
    /// None if the patch has no area.
    fn of(patches: &Patches, patch: usize) -> Option<Self> {
        if patches.area[patch] <= 0.0 {
            return None;
        }
        let (u, v) = patches.normal[patch].any_orthonormal_pair();
        let corners = patches.corners(patch);
        let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
        for corner in corners {
            let d = *corner - patches.centre[patch];
            let (x, y) = (d.dot(u), d.dot(v));
            uu += x * x / corners.len() as f64;
            uv += x * y / corners.len() as f64;
            vv += y * y / corners.len() as f64;
        }
        let first = uu.sqrt();
        let last = (vv - uv * uv / uu).sqrt();
        // Slivers may be too thin for rounding.
        (last > 0.0).then(|| Self { u, v, inverse: [1.0 / first, -uv / (uu * last), 1.0 / last] })
    }

    /// A vector in this measure.
    fn measured(&self, d: DVec3) -> DVec2 {
        let (x, y) = (d.dot(self.u), d.dot(self.v));
        let [a, b, c] = self.inverse;
        DVec2::new(a * x, b * x + c * y)
    }

    /// The slope in space of a slope in this measure.
    fn slope(&self, s: DVec2) -> DVec3 {
        let [a, b, c] = self.inverse;
        (a * s.x + b * s.y) * self.u + c * s.y * self.v
    }
}

/// A symmetric matrix of two rows.
#[derive(Clone, Copy, Debug, Default)]
struct Symmetric {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Symmetric {
    /// Adds `weight d d^T`.
    fn add(&mut self, weight: f64, d: DVec2) {
        self.xx += weight * d.x * d.x;
        self.xy += weight * d.x * d.y;
        self.yy += weight * d.y * d.y;
    }

    fn times(&self, d: DVec2) -> DVec2 {
        DVec2::new(self.xx * d.x + self.xy * d.y, self.xy * d.x + self.yy * d.y)
    }

    /// The inverse on the directions whose eigenvalue is at least `least`, zero on others.
    fn pseudoinverse(&self, least: f64) -> Self {
        let mean = 0.5 * (self.xx + self.yy);
        let half = 0.5 * (self.xx - self.yy);
        let radius = half.hypot(self.xy);
        let of = |eigenvalue: f64| if eigenvalue >= least { 1.0 / eigenvalue } else { 0.0 };
        let (large, small) = (of(mean + radius), of(mean - radius));
        if radius == 0.0 {
            return Self { xx: large, xy: 0.0, yy: large };
        }
        let (mean, half_difference) = (0.5 * (large + small), 0.5 * (large - small) / radius);
        Self { xx: mean + half_difference * half, xy: half_difference * self.xy, yy: mean - half_difference * half }
    }
}

/// What each corner of a patch counts at chart coordinates `(s, t)` in its interpolation.
pub fn corner_weights(chart: &Chart, s: f64, t: f64) -> [f64; 4] {
    match *chart {
        Chart::Parallelogram { .. } => in_square(s, t),
        Chart::Triangle { .. } => {
            let (b1, b2) = chart.barycentric(s, t);
            in_triangle(b1, b2)
        }
        Chart::Quad { split, .. } => {
            let (b1, b2) = chart.barycentric(s, t);
            in_half(usize::from(s >= split), b1, b2)
        }
    }
}

/// The same in a triangle, where its second and third corner count `u` and `v`.
pub fn in_triangle(u: f64, v: f64) -> [f64; 4] {
    [1.0 - u - v, u, v, 0.0]
}

/// The same in the first (`half` 0) or the second triangle of a quad.
///
/// A quad is the unit square mapped affinely on either side of its diagonal, with bilinear values: bilinear itself on
/// parallelograms, and on others continuous across all edges, which two triangles with linear values are too, but
/// without their ridge along the diagonal.
pub fn in_half(half: usize, u: f64, v: f64) -> [f64; 4] {
    if half == 0 { in_square(u + v, v) } else { in_square(u, u + v) }
}

fn in_square(s: f64, t: f64) -> [f64; 4] {
    [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
}

/// A point by the bits of its coordinates, by which meshes know that corners meet.
pub type PositionBits = [u64; 3];

/// The bits of a point.
pub fn bits(p: DVec3) -> PositionBits {
    // Adding zero makes a negative zero positive.
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// All corners, sorted by position.
fn corners_by_position(patches: &Patches) -> Vec<(PositionBits, u32)> {
    let of_patch = |i: usize| (0u32..).zip(patches.corners(i)).map(move |(k, &p)| (bits(p), 4 * i as u32 + k));
    let mut corners: Vec<_> = (0..patches.len()).into_par_iter().flat_map_iter(of_patch).collect();
    corners.par_sort_unstable();
    corners
}

/// The leader of each corner of those that meet in one point.
fn leaders(patches: &Patches, place: &[(PositionBits, u32)], flattest: f64) -> Vec<(u32, u32)> {
    let mut edges: Vec<(PositionBits, usize)> = Vec::with_capacity(2 * place.len());
    for (member, &(_, corner)) in place.iter().enumerate() {
        let polygon = patches.corners(corner as usize / 4);
        let (n, k) = (polygon.len(), corner as usize % 4);
        edges.extend([(bits(polygon[(k + 1) % n]), member), (bits(polygon[(k + n - 1) % n]), member)]);
    }
    edges.sort_unstable();
    let mut parent: Vec<usize> = (0..place.len()).collect();
    let normal = |member: usize| patches.normal[place[member].1 as usize / 4];
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        for (i, &(_, a)) in edge.iter().enumerate() {
            let stands_out = edge.iter().any(|&(_, c)| normal(a).dot(normal(c)).abs() < flattest);
            for &(_, b) in edge[i + 1..].iter().filter(|_| !stands_out) {
                if normal(a).dot(normal(b)) >= flattest {
                    join(&mut parent, a, b);
                }
            }
        }
    }
    (0..place.len()).map(|m| (place[m].1, place[root(&parent, m)].1)).collect()
}

fn root(parent: &[usize], mut member: usize) -> usize {
    while parent[member] != member {
        member = parent[member];
    }
    member
}

fn join(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b)] = a.min(b);
}

/// The angle of a patch at one of its corners.
fn angle(patches: &Patches, corner: usize) -> f64 {
    let (polygon, k) = (patches.corners(corner / 4), corner % 4);
    let n = polygon.len();
    if k >= n || patches.area[corner / 4] <= 0.0 {
        return 0.0;
    }
    let (p, q) = (polygon[(k + 1) % n] - polygon[k], polygon[(k + n - 1) % n] - polygon[k]);
    p.cross(q).length().atan2(p.dot(q))
}

#[cfg(test)]
mod tests;
