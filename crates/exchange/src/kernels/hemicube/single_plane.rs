//! The single plane: the hemicube's cheaper relative.
//!
//! Sillion and Puech 1989, *A general two-pass method integrating specular and diffuse reflection*: one plane above the
//! source, so wide that what passes beneath it hardly counts, takes the place of five faces. Everything is drawn once
//! and nothing falls on two faces; what is lost is known, see [`single_plane_share`].

use super::delta::{Strips, top_corner};
use super::{Scene, Settings};
use crate::enclosure::Enclosure;
use crate::rows::Rows;
use radiosity_geometry::bvh::Kernel;
use radiosity_operator::{Cancelled, Control};

/// The rows of some sides by a plane of `resolution` by `resolution` pixels that reaches `half_width` to either side at
/// distance 1; as [`super::rows_of`] otherwise.
///
/// Rows of a closed room sum to [`single_plane_share`]: nothing makes up for what passes beneath the plane. Pixels are
/// `half_width` times as wide as a hemicube's.
///
/// # Panics
/// If a field of `settings` is out of its range, or `half_width` is not positive.
pub fn single_plane_rows_of(
    enclosure: &Enclosure,
    sides: &[usize],
    half_width: f64,
    settings: &Settings,
    control: &Control,
) -> Result<Rows, Cancelled> {
    settings.check();
    assert!(half_width > 0.0 && half_width.is_finite(), "a plane needs a width, not {half_width}");
    let strips = Strips::plane(settings.resolution, half_width);
    let scene = Scene { strips, faces: 1, half_width, ..Scene::new(enclosure, settings, Kernel::detect()) };
    scene.rows_of(sides, control)
}

/// The form factor of the whole plane: 0.55 for a half width of 1, 0.968 for 5, 0.992 for 10.
pub fn single_plane_share(half_width: f64) -> f64 {
    4.0 * top_corner(half_width, half_width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::point_to_polygon::point_to_polygon;
    use glam::DVec3;
    use radiosity_geometry::Patches;

    /// A floor, and a lid above it that hides all the rest of the plane.
    fn lid(half_edge: f64) -> Enclosure {
        let square = |r: f64, z: f64| [(-r, -r), (r, -r), (r, r), (-r, r)].map(|(x, y)| DVec3::new(x, y, z));
        let [a, b, c, d] = square(half_edge, 1.0);
        Enclosure::new(Patches::new(vec![square(0.5, 0.0), [d, c, b, a]], vec![0; 2], vec![0, 1], vec![false; 2]))
    }

    fn row(enclosure: &Enclosure, half_width: f64, resolution: usize) -> f64 {
        let settings = Settings { resolution, ..Settings::default() };
        let rows = single_plane_rows_of(enclosure, &[0], half_width, &settings, &Control::default()).unwrap();
        rows.entries.iter().map(|(_, f)| f).sum()
    }

    #[test]
    fn a_full_plane_sums_to_its_share() {
        for (half_width, about) in [(1.0, 0.5541), (5.0, 0.9683), (10.0, 0.9919)] {
            let share = single_plane_share(half_width);
            assert!((share - about).abs() < 1e-4, "{half_width}: {share}");
            let sum = row(&lid(20.0), half_width, 64);
            assert!((sum - share).abs() < 1e-12, "{half_width}: {sum} {share}");
        }
    }

    #[test]
    fn what_is_well_within_the_plane_has_its_closed_form() {
        let enclosure = lid(0.5);
        let expected = point_to_polygon(DVec3::ZERO, DVec3::Z, enclosure.patches().corners(1));
        let found = row(&enclosure, 4.0, 1024);
        // Pixels are 4 * 2/1024 wide: an edge of length 1 off by half of that, at less than 1/pi, four times.
        assert!((found - expected).abs() < 2.0 * 8.0 / 1024.0 / std::f64::consts::PI, "{found} {expected}");
    }
}
