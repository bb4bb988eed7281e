//! The furnace: a closed room whose answer everyone can work out.

use glam::DVec3;

use super::rectangle::{cuboid, inside_out};
use crate::model::{Material, Scene, band_names};

/// A closed box of 4 m x 3 m x 5 m around two floating boxes, all of one material.
///
/// Whatever the shapes, the radiosity of every point is E / (1 - rho) and its irradiance is the same, because a
/// uniform B sees itself in all directions. The boxes float, so that no patch is hidden by a contact.
///
/// `reflectance` and `emission` hold one value per band.
///
/// # Panics
/// If they differ in length.
///
/// # Example
/// ```
/// let scene = radiosity_scene::builtin::furnace(&[0.5], &[1.0]);
/// assert_eq!(scene.face_count(), 18);
/// ```
pub fn furnace(reflectance: &[f64], emission: &[f64]) -> Scene {
    assert_eq!(reflectance.len(), emission.len(), "one reflectance and one emission per band");
    let glowing = Material::new("glowing", reflectance, emission);
    let block = |name, low: [f64; 3], high: [f64; 3]| cuboid(name, low.into(), high.into(), &glowing);
    Scene {
        name: "furnace".into(),
        bands: band_names(reflectance.len()),
        surfaces: vec![
            inside_out(cuboid("walls", DVec3::ZERO, DVec3::new(4.0, 3.0, 5.0), &glowing)),
            block("left box", [0.5, 0.4, 1.0], [1.6, 1.7, 2.2]),
            block("right box", [2.2, 0.9, 2.6], [3.3, 2.4, 4.2]),
        ],
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn furnace_is_sound() {
        assert_eq!(furnace(&[0.5, 0.9], &[1.0, 2.0]).findings(), vec![]);
    }

    #[test]
    fn walls_look_inward() {
        let scene = furnace(&[0.5], &[1.0]);
        let walls = &scene.surfaces[0];
        let centre = DVec3::new(2.0, 1.5, 2.5);
        for &face in &walls.faces {
            let [a, b, c, d] = walls.corners(face);
            assert!((c - a).cross(d - b).dot(a - centre) < 0.0);
        }
    }
}
