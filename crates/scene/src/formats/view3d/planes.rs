//! Surfaces of the form `F 3a`: figures in planes that are given by origin, azimuth and tilt.

use glam::DVec3;

/// A plane of the form `F 3a`. Seen from its front, x runs to the right and y upward or along the slope.
pub(super) struct Plane {
    origin: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Plane {
    /// Azimuth in degrees clockwise from y (north), tilt 0 for what faces up, 90 for walls, 180 for what faces down.
    pub fn new(origin: DVec3, azimuth: f64, tilt: f64) -> Self {
        let ((sin, cos), (rise, lean)) = (degrees(azimuth), degrees(tilt));
        Self { origin, right: DVec3::new(-cos, sin, 0.0), up: DVec3::new(-lean * sin, -lean * cos, rise) }
    }

    /// A point of the plane in space.
    pub fn at(&self, x: f64, y: f64) -> DVec3 {
        self.origin + x * self.right + y * self.up
    }
}

/// Sine and cosine, exact for right angles.
fn degrees(angle: f64) -> (f64, f64) {
    let exact = |value: f64| if value.abs() < 1e-15 { 0.0 } else { value };
    let (sin, cos) = angle.to_radians().sin_cos();
    (exact(sin), exact(cos))
}
