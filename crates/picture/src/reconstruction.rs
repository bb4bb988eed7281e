//! Values at the corners of patches for smooth shading.

use std::f64::consts::PI;

use glam::DVec3;
use radiosity_geometry::Patches;
use rayon::prelude::*;

/// Which corners of patches belong together: they meet in a point and are joined by edges that are no creases.
///
/// Two patches are joined by an edge that they share to the bit if their normals differ by less than the crease angle
/// and no third patch stands on that edge, as a wall does on a floor that continues behind it.
///
/// Corner values are `n_patches x 4 x bands`, in order of the corners of each polygon; a triangle repeats its last.
#[derive(Clone, Debug)]
pub struct Smoother<'a> {
    patches: &'a Patches,
    /// For each corner the first one that it belongs together with.
    leader: Vec<u32>,
    /// The angle of each corner; zero for the fourth of a triangle.
    weight: Vec<f64>,
}

/// Creases are edges of at least this angle unless said otherwise: 30 degrees, in radians.
pub const CREASE_ANGLE: f64 = PI / 6.0;

impl<'a> Smoother<'a> {
    /// Finds the corners that belong together; `crease_angle` is in radians.
    ///
    /// # Panics
    /// With more than 2^30 patches.
    pub fn new(patches: &'a Patches, crease_angle: f64) -> Self {
        assert!(patches.len() <= 1 << 30, "corners are numbered by 32 bits");
        let corners = corners_by_position(patches);
        let flattest = crease_angle.cos();
        let groups: Vec<_> = corners.chunk_by(|a, b| a.0 == b.0).collect();
        let leaders: Vec<Vec<(u32, u32)>> =
            groups.par_iter().with_min_len(256).map(|group| leaders(patches, group, flattest)).collect();
        let mut leader: Vec<u32> = (0..4 * patches.len() as u32).collect();
        for (corner, first) in leaders.into_iter().flatten() {
            leader[corner as usize] = first;
        }
        let weight = (0..4 * patches.len()).map(|corner| angle(patches, corner)).collect();
        Self { patches, leader, weight }
    }

    /// The mean at each corner of the values of the patches that belong together there, weighted by angle.
    ///
    /// # Panics
    /// If `values` is not `n_patches x bands`.
    pub fn corner_values(&self, values: &[f64], bands: usize) -> Vec<f64> {
        let n = self.patches.len();
        assert_eq!(values.len(), n * bands, "one value per patch and band");
        let (mut sums, mut weights) = (vec![0.0; 4 * n * bands], vec![0.0; 4 * n]);
        for corner in 0..4 * n {
            let (leader, weight) = (self.leader[corner] as usize, self.weight[corner]);
            weights[leader] += weight;
            let value = &values[corner / 4 * bands..][..bands];
            for (sum, v) in sums[leader * bands..][..bands].iter_mut().zip(value) {
                *sum += weight * v;
            }
        }
        let mut corners = vec![0.0; 4 * n * bands];
        for corner in 0..4 * n {
            let leader = self.leader[corner] as usize;
            let own = &values[corner / 4 * bands..][..bands];
            for band in 0..bands {
                let mean = sums[leader * bands + band] / weights[leader];
                // A patch without area has no angles.
                corners[corner * bands + band] = if weights[leader] > 0.0 { mean } else { own[band] };
            }
        }
        corners
    }

    /// Corner values of radiosity that keep what differs from surface to surface apart.
    ///
    /// Irradiance is smooth where emission and reflectance are not: a lamp in a ceiling or the squares of a chessboard
    /// keep their sharp edges. `reflectance` has one spectrum per surface.
    ///
    /// # Panics
    /// If the slices do not fit the patches.
    pub fn corner_radiosity<R: AsRef<[f64]>>(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: &[R],
        bands: usize,
    ) -> Vec<f64> {
        assert_eq!(radiosity.len(), irradiance.len(), "one value per patch and band");
        let mut corners = self.corner_values(irradiance, bands);
        for (i, value) in corners.iter_mut().enumerate() {
            let (patch, band) = (i / bands / 4, i % bands);
            let rho = reflectance[self.patches.surface[patch] as usize].as_ref()[band];
            let own = patch * bands + band;
            // B = E + rho H, so that what the light at the corner adds to the patch's own B is rho times its excess.
            *value = (radiosity[own] + rho * (*value - irradiance[own])).max(0.0);
        }
        corners
    }

    /// Shifts corner values so that their interpolation has the patch's value as its mean.
    ///
    /// A patch whose corners would become negative stays as it is. The price is small steps between patches, so this
    /// is for what integrates, not for what is looked at.
    ///
    /// # Panics
    /// If the slices do not fit the patches.
    pub fn keep_means(&self, corners: &mut [f64], values: &[f64], bands: usize) {
        assert_eq!(values.len(), self.patches.len() * bands, "one value per patch and band");
        assert_eq!(corners.len(), 4 * values.len(), "four corners per patch");
        if bands == 0 {
            return;
        }
        for (patch, corners) in corners.chunks_exact_mut(4 * bands).enumerate() {
            let weights = mean_weights(self.patches, patch);
            for band in 0..bands {
                let mean: f64 = (0..4).map(|k| weights[k] * corners[k * bands + band]).sum();
                let shift = values[patch * bands + band] - mean;
                if (0..4).all(|k| corners[k * bands + band] + shift >= 0.0) {
                    (0..4).for_each(|k| corners[k * bands + band] += shift);
                }
            }
        }
    }
}

type PositionBits = [u64; 3];

fn bits(p: DVec3) -> PositionBits {
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

/// The leader of each corner of a group that meets in one point.
fn leaders(patches: &Patches, group: &[(PositionBits, u32)], flattest: f64) -> Vec<(u32, u32)> {
    let mut edges: Vec<(PositionBits, usize)> = Vec::with_capacity(2 * group.len());
    for (member, &(_, corner)) in group.iter().enumerate() {
        let polygon = patches.corners(corner as usize / 4);
        let (n, k) = (polygon.len(), corner as usize % 4);
        edges.extend([(bits(polygon[(k + 1) % n]), member), (bits(polygon[(k + n - 1) % n]), member)]);
    }
    edges.sort_unstable();
    let mut parent: Vec<usize> = (0..group.len()).collect();
    let normal = |member: usize| patches.normal[group[member].1 as usize / 4];
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
    let mut leaders: Vec<(u32, u32)> = (0..group.len()).map(|m| (group[m].1, group[root(&parent, m)].1)).collect();
    // A triangle's repeated corner has the value of the one before it.
    let repeated = |&(corner, leader): &(u32, u32)| {
        (corner % 4 == 2 && patches.corners(corner as usize / 4).len() == 3).then_some((corner + 1, leader))
    };
    leaders.extend(leaders.iter().filter_map(repeated).collect::<Vec<_>>());
    leaders
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

/// What each corner counts in the mean of the bilinear interpolation over a patch.
fn mean_weights(patches: &Patches, patch: usize) -> [f64; 4] {
    if patches.corners(patch).len() == 3 {
        return [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0];
    }
    let p = &patches.polygons[patch];
    // The Jacobian is bilinear itself, so that its values at the corners say all.
    let jacobian = [0, 1, 2, 3].map(|k| {
        let (next, before) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        next.cross(before).dot(patches.normal[patch])
    });
    let total: f64 = jacobian.iter().sum();
    if total <= 0.0 {
        return [0.25; 4];
    }
    // Integrals of products of bilinear shape functions: 1/9 with itself, 1/18 with a neighbour, 1/36 across.
    [0, 1, 2, 3].map(|k: usize| {
        let [own, next, across, before] = [0, 1, 2, 3].map(|d: usize| jacobian[(k + d) % 4]);
        (own / 9.0 + (next + before) / 18.0 + across / 36.0) / (total / 4.0)
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_scenes::{cube, patches_of, sheet};

    fn assert_close(values: &[f64], expected: &[f64]) {
        assert_eq!(values.len(), expected.len());
        let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        assert!(values.iter().zip(expected).all(is_close), "{values:?}, not {expected:?}");
    }

    #[test]
    fn the_mean_where_patches_meet() {
        let patches = sheet(2, 2);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_values(&[1.0, 2.0, 3.0, 4.0], 1);
        assert_close(&corners[..4], &[1.0, 1.5, 2.5, 2.0]);
        assert_close(&corners[12..], &[2.5, 3.0, 4.0, 3.5]);
    }

    #[test]
    fn creases_keep_sides_apart() {
        let patches = cube(3);
        let side: Vec<f64> = patches.face.iter().map(|&f| f64::from(f)).collect();
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_values(&side, 1);
        assert_close(&corners, &(0..4 * side.len()).map(|i| side[i / 4]).collect::<Vec<_>>());
        let smooth = Smoother::new(&patches, PI).corner_values(&side, 1);
        assert_ne!(smooth, corners);
    }

    #[test]
    fn a_wall_on_an_edge_is_a_crease() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let floor = [[DVec3::ZERO, x, x + y, y], [x, 2.0 * x, 2.0 * x + y, x + y]];
        let wall = [x, x + y, x + y + z, x + z];
        let open = Smoother::new(&patches_of(&floor), CREASE_ANGLE).corner_values(&[1.0, 3.0], 1);
        assert_close(&open, &[1.0, 2.0, 2.0, 1.0, 2.0, 3.0, 3.0, 2.0]);
        let patches = patches_of(&[floor[0], floor[1], wall]);
        let split = Smoother::new(&patches, CREASE_ANGLE).corner_values(&[1.0, 3.0, 7.0], 1);
        assert_close(&split, &[1.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 7.0]);
    }

    #[test]
    fn the_backs_of_double_walls_do_not_shine_through() {
        let (x, y) = (DVec3::X, DVec3::Y);
        let front = [DVec3::ZERO, x, x + y, y];
        let patches = patches_of(&[front, [y, x + y, x, DVec3::ZERO]]);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_values(&[1.0, 5.0], 1);
        assert_close(&corners, &[1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn reflectance_and_emission_keep_sharp_edges() {
        let mut patches = sheet(2, 1);
        patches.surface = vec![0, 1];
        // One surface glows with 10 and reflects half, the other reflects a quarter.
        let (irradiance, radiosity) = ([4.0, 8.0], [12.0, 2.0]);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_radiosity(
            &radiosity,
            &irradiance,
            &[vec![0.5], vec![0.25]],
            1,
        );
        assert_close(&corners, &[12.0, 13.0, 13.0, 12.0, 1.5, 2.0, 2.0, 1.5]);
    }

    #[test]
    fn degenerate_patches_keep_their_values() {
        let patches = patches_of(&[[DVec3::ZERO, DVec3::X, DVec3::X, DVec3::X], [DVec3::ZERO; 4]]);
        assert_eq!(Smoother::new(&patches, 0.5).corner_values(&[1.0, 2.0], 1)[..], [1., 1., 1., 1., 2., 2., 2., 2.]);
        assert!(Smoother::new(&Patches::default(), 0.5).corner_values(&[], 3).is_empty());
    }

    #[test]
    fn the_mean_of_a_trapezoid_counts_its_shape() {
        let v = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let patches = patches_of(&[[v(0.0, 0.0), v(3.0, 0.0), v(2.0, 1.0), v(1.0, 1.0)]]);
        let weights = mean_weights(&patches, 0);
        // The function y is bilinear on it; its mean is the centroid's height.
        assert!((weights[2] + weights[3] - patches.centre[0].y).abs() < 1e-15);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn means_are_kept(values in prop::collection::vec(0.0..1.0f64, 24)) {
            let patches = cube(2);
            let smoother = Smoother::new(&patches, CREASE_ANGLE);
            let mut corners = smoother.corner_values(&values, 1);
            let before = corners.clone();
            smoother.keep_means(&mut corners, &values, 1);
            prop_assert!(corners.iter().all(|&c| c >= 0.0));
            for (patch, corner) in corners.chunks(4).enumerate() {
                let mean = corner.iter().sum::<f64>() / 4.0;
                prop_assert!((mean - values[patch]).abs() < 1e-12 || corner == &before[4 * patch..][..4]);
            }
            let (least, most) = (values.iter().copied().fold(1.0, f64::min), values.iter().copied().fold(0.0, f64::max));
            prop_assert!(before.iter().all(|&c| c >= least - 1e-12 && c <= most + 1e-12));
        }
    }
}
