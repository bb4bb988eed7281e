//! Faces back to back, and the two sides of one sheet.
//!
//! Lit models hold the back of a two-sided patch as a patch of its own: the same polygon, the other way round. Rays take
//! a sheet for one thing with two sides.

use std::collections::HashMap;

use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_geometry::corners::{PositionBits, bits};

/// Patches without those that are the back of another, and whose values each side has.
pub struct Sheets {
    /// Two-sided where another patch was their back.
    pub patches: Patches,
    /// The given patch that each side is: fronts of all, then backs.
    pub patch_of_side: Vec<u32>,
}

impl Sheets {
    /// Finds patches that are the same polygon in reverse, to the bit. What is two-sided itself stays as it is, with the
    /// same values on both sides. Obstructions stay.
    pub fn new(given: &Patches) -> Self {
        let mut unpaired: HashMap<[PositionBits; 4], usize> = HashMap::new();
        let (mut fronts, mut back_of) = (Vec::new(), HashMap::new());
        for (patch, polygon) in given.polygons.iter().enumerate() {
            let is_single = !given.two_sided[patch] && given.area[patch] > 0.0;
            match unpaired.remove(&key(&reversed(polygon))).filter(|_| is_single) {
                Some(front) => {
                    back_of.insert(front, patch);
                }
                None => {
                    fronts.push(patch);
                    if is_single {
                        unpaired.insert(key(polygon), patch);
                    }
                }
            }
        }
        let pick = |of: &[u32]| fronts.iter().map(|&i| of[i]).collect();
        let patches = Patches::new(
            fronts.iter().map(|&i| given.polygons[i]).collect(),
            pick(&given.surface),
            pick(&given.face),
            fronts.iter().map(|i| given.two_sided[*i] || back_of.contains_key(i)).collect(),
        );
        let backs = fronts.iter().filter_map(|i| back_of.get(i).copied().or(given.two_sided[*i].then_some(*i)));
        let patch_of_side = fronts.iter().copied().chain(backs).map(|i| i as u32).collect();
        Self { patches: patches.with_obstructions(given.obstructions.clone()), patch_of_side }
    }

    /// Given patches that are the two sides of one sheet, front and back.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let n = self.patches.len();
        let fronts = (0..n).filter(|&i| self.patches.two_sided[i]);
        fronts.map(|front| self.patch_of_side[front] as usize).zip(self.patch_of_side[n..].iter().map(|&i| i as usize))
    }

    /// Values of given patches, one each, as values of patches.
    pub fn of_patches(&self, values: &[f64]) -> Vec<f64> {
        self.patch_of_side[..self.patches.len()].iter().map(|&patch| values[patch as usize]).collect()
    }

    /// Values of given patches, n x bands, as values of sides, in single precision.
    pub fn of_sides(&self, values: &[f64], bands: usize) -> Vec<f32> {
        let own = |&patch: &u32| &values[patch as usize * bands..][..bands];
        self.patch_of_side.iter().flat_map(own).map(|&v| v as f32).collect()
    }

    /// Values at corners of given patches, n x 4 x bands, as values of sides in the order of the corners of the fronts.
    pub fn corners_of_sides(&self, given: &Patches, values: &[f64], bands: usize) -> Vec<f32> {
        let n = self.patches.len();
        let mut fronts_of_backs = (0..n).filter(|&i| self.patches.two_sided[i]);
        let mut out = Vec::with_capacity(4 * bands * self.patch_of_side.len());
        for (side, &patch) in self.patch_of_side.iter().enumerate() {
            let front = if side < n { side } else { fronts_of_backs.next().expect("a front for each back") };
            for k in matching_corners(&self.patches.polygons[front], &given.polygons[patch as usize]) {
                out.extend(values[(4 * patch as usize + k) * bands..][..bands].iter().map(|&v| v as f32));
            }
        }
        out
    }
}

/// For each corner of a polygon, the corner of another with the same corners that is in its place.
pub(crate) fn matching_corners(own: &[DVec3; 4], other: &[DVec3; 4]) -> [usize; 4] {
    own.map(|corner| other.iter().position(|c| bits(*c) == bits(corner)).expect("the same corners"))
}

/// A polygon seen from behind: corners the other way round.
fn reversed(polygon: &[DVec3; 4]) -> [DVec3; 4] {
    let [a, b, c, d] = *polygon;
    if c == d { [c, b, a, a] } else { [d, c, b, a] }
}

/// The corners by their bits, from the least on.
fn key(polygon: &[DVec3; 4]) -> [PositionBits; 4] {
    let corners = polygon.map(bits);
    let count = if corners[2] == corners[3] { 3 } else { 4 };
    let least = (0..count).min_by_key(|&k| corners[k]).unwrap_or(0);
    [0, 1, 2, 3].map(|k| corners[(least + k.min(count - 1)) % count])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> [DVec3; 4] {
        [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]
    }

    #[test]
    fn backs_find_their_fronts_and_keep_their_values() {
        let [a, b, c, d] = corners();
        let (quad, triangle) = ([a, b, c, d], [a + DVec3::Z, b + DVec3::Z, c + DVec3::Z, c + DVec3::Z]);
        // The back of the quad begins at another corner; the single one has no back.
        let single = quad.map(|p| p + 2.0 * DVec3::Z);
        let polygons = vec![quad, triangle, single, [b, a, d, c], reversed(&triangle)];
        let given = Patches::new(polygons, vec![0, 1, 2, 3, 4], vec![0; 5], vec![false; 5]);
        let sheets = Sheets::new(&given);
        assert_eq!(sheets.patches.two_sided, [true, true, false]);
        assert_eq!(sheets.patch_of_side, [0, 1, 2, 3, 4]);
        assert_eq!(sheets.of_sides(&[1.0, 2.0, 3.0, 4.0, 5.0], 1), [1.0, 2.0, 3.0, 4.0, 5.0]);
        // Each corner has the x coordinate of where it is.
        let x: Vec<f64> = given.polygons.iter().flatten().map(|p| p.x).collect();
        let expected: Vec<f32> = [0, 1, 2, 0, 1].iter().flat_map(|&i| given.polygons[i]).map(|p| p.x as f32).collect();
        assert_eq!(sheets.corners_of_sides(&given, &x, 1), expected);
    }

    #[test]
    fn two_sided_patches_have_the_same_on_both_sides() {
        let given = Patches::new(vec![corners()], vec![0], vec![0], vec![true]);
        let sheets = Sheets::new(&given);
        assert_eq!(sheets.patch_of_side, [0, 0]);
        assert_eq!(sheets.corners_of_sides(&given, &[1.0, 2.0, 3.0, 4.0], 1), [1., 2., 3., 4., 1., 2., 3., 4.]);
    }
}
