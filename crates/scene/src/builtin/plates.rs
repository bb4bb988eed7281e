//! Two parallel plates, the first configuration of every catalogue of view factors.

use glam::DVec3;

use super::rectangle::{Rectangle, surface};
use crate::model::{Material, Scene, band_names};

/// Two equal parallel rectangles that face each other: `width` along x, `depth` along y, `gap` along z, metres.
///
/// The lower plate lies at z = 0 and looks up. The form factor between them is catalogue entry C-11 of Howell,
/// "A catalog of radiation heat transfer configuration factors".
///
/// # Example
/// ```
/// use radiosity_scene::{Material, builtin::two_plates};
/// let (hot, cold) = (Material::new("hot", &[0.2], &[100.0]), Material::new("cold", &[0.8], &[0.0]));
/// assert!(two_plates(1.0, 2.0, 0.5, hot, cold).validate().is_ok());
/// ```
pub fn two_plates(width: f64, depth: f64, gap: f64, lower: Material, upper: Material) -> Scene {
    let (x, y) = ([width, 0.0, 0.0], [0.0, depth, 0.0]);
    let bottom = Rectangle::new([0.0; 3], x, y);
    let top = Rectangle::new([0.0, 0.0, gap], x, y).facing(-DVec3::Z);
    Scene {
        name: "two-plates".into(),
        bands: band_names(lower.reflectance.len()),
        surfaces: vec![surface("lower", &[bottom.corners()], &lower), surface("upper", &[top.corners()], &upper)],
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_face_each_other() {
        let plate = Material::new("plate", &[0.5], &[1.0]);
        let scene = two_plates(1.0, 2.0, 3.0, plate.clone(), plate);
        assert_eq!(scene.findings(), vec![]);
        let normal = |i: usize| {
            let [a, b, c, d] = scene.surfaces[i].corners(scene.surfaces[i].faces[0]);
            0.5 * (c - a).cross(d - b)
        };
        assert_eq!(normal(0), DVec3::new(0.0, 0.0, 2.0));
        assert_eq!(normal(1), DVec3::new(0.0, 0.0, -2.0));
    }
}
