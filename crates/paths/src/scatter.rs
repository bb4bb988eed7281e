//! How light goes on from a point of a surface: the one place that knows what surfaces are made of.

use glam::{DVec3, Vec3};
use radiosity_geometry::sampling::{Frame, cosine_hemisphere};

/// Draws the direction that a path looks along next by two numbers in (0, 1), a unit vector.
///
/// Its density is that of the reflection, so that what the ray finds needs no further weight than the reflectance. All
/// that is scattered diffusely is also looked for on lamps, and weighed against that where the ray lands; what a mirror
/// shows only rays can find, so whoever adds mirrors must say here which it was.
#[inline]
pub(crate) fn scatter(normal: DVec3, u: f64, v: f64) -> Vec3 {
    cosine_hemisphere(&Frame::new(normal), u, v)
}

/// Reflectance per side and band; none where paths end at the first side that they meet.
pub(crate) struct Reflectance {
    values: Vec<f32>,
    bands: usize,
}

impl Reflectance {
    /// Sides x bands.
    pub fn new(values: Vec<f32>, bands: usize) -> Self {
        Self { values, bands }
    }

    /// Takes what a side absorbs out of a path; returns what is left in its best band.
    #[inline]
    pub fn filter(&self, side: u32, throughput: &mut [f32]) -> f32 {
        let own = &self.values[side as usize * self.bands..][..self.bands];
        throughput.iter_mut().zip(own).fold(0.0, |most: f32, (left, rho)| {
            *left *= rho;
            most.max(*left)
        })
    }
}
