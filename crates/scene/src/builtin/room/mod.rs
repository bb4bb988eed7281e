//! A furnished living room.

mod furniture;
mod paint;
mod shape;
mod shell;

use glam::DVec3;

use crate::model::{Camera, Scene, band_names};

/// A living room of 6 m x 2.7 m x 4.5 m with a window, lamps, table and chairs, sofa, books and a plant.
///
/// The shell is closed and seen from inside; y points up. Higher `detail` rounds what is round and multiplies books,
/// folds and leaves: 0 makes some 1,000 faces, 1 some 1,900 and 8, the most, some 7,200. Daylight comes through the
/// window, whose panes emit, and lamplight from a pendant and a floor lamp.
///
/// # Example
/// ```
/// let room = radiosity_scene::builtin::furnished_room(0);
/// assert!(room.validate().is_ok());
/// assert_eq!(room.cameras[0].name, "living room");
/// ```
pub fn furnished_room(detail: u32) -> Scene {
    // Beyond this, faces only get smaller than any patch.
    let detail = detail.min(8);
    let mut surfaces = shell::shell(detail);
    surfaces.extend(furniture::furniture(detail));
    Scene {
        name: "furnished-room".into(),
        bands: band_names(3),
        surfaces,
        cameras: vec![
            camera("living room", [5.6, 1.55, 0.35], [1.9, 0.95, 3.4], 52.0),
            camera("window", [5.3, 1.5, 3.3], [0.0, 1.2, 1.9], 50.0),
            camera("door", [0.6, 1.5, 0.5], [5.2, 0.9, 3.0], 52.0),
        ],
        ..Scene::default()
    }
}

fn camera(name: &str, from: [f64; 3], to: [f64; 3], degrees: f64) -> Camera {
    let position = DVec3::from_array(from);
    let forward = (DVec3::from_array(to) - position).normalize();
    let up = (DVec3::Y - DVec3::Y.dot(forward) * forward).normalize();
    Camera { name: name.into(), position, forward, up, vertical_fov: degrees.to_radians(), aspect: Some(1.5) }
}

#[cfg(test)]
mod tests;
