//! Radiosity at the corners of patches, for smooth shading.

use radiosity_geometry::{Corners, Patches};

/// Values at the corners of patches from values of patches, `n_patches x 4 x bands`, in order of the corners of each
/// polygon; a triangle repeats its last. None is negative.
#[derive(Clone, Debug)]
pub struct Smoother<'a> {
    patches: &'a Patches,
    corners: Corners<&'a Patches>,
}

impl<'a> Smoother<'a> {
    /// Finds the corners that belong together; `crease_angle` is in radians.
    ///
    /// # Panics
    /// With more than 2^30 patches.
    pub fn new(patches: &'a Patches, crease_angle: f64) -> Self {
        Self { patches, corners: Corners::new(patches, crease_angle) }
    }

    /// The piecewise linear field through values of patches.
    ///
    /// # Panics
    /// If `values` is not `n_patches x bands`.
    pub fn corner_values(&self, values: &[f64], bands: usize) -> Vec<f64> {
        let mut corners = self.corners.field(values, bands);
        corners.iter_mut().for_each(|value| *value = value.max(0.0));
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
        let of = |patch: usize, band: usize| reflectance[self.patches.surface[patch] as usize].as_ref()[band];
        self.corner_radiosity_by(radiosity, irradiance, of, bands)
    }

    /// The same where every patch has paint of its own: `reflectance` is `n_patches x bands`.
    ///
    /// # Panics
    /// If the slices do not fit the patches.
    pub fn corner_radiosity_of_patches(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: &[f64],
        bands: usize,
    ) -> Vec<f64> {
        assert_eq!(reflectance.len(), irradiance.len(), "one value per patch and band");
        self.corner_radiosity_by(radiosity, irradiance, |patch, band| reflectance[patch * bands + band], bands)
    }

    fn corner_radiosity_by(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: impl Fn(usize, usize) -> f64,
        bands: usize,
    ) -> Vec<f64> {
        assert_eq!(radiosity.len(), irradiance.len(), "one value per patch and band");
        let mut corners = self.corners.field(irradiance, bands);
        for (i, value) in corners.iter_mut().enumerate() {
            let (patch, band) = (i / bands / 4, i % bands);
            let own = patch * bands + band;
            // B = E + rho H, so that what the light at the corner adds to the patch's own B is rho times its excess.
            *value = (radiosity[own] + reflectance(patch, band) * (*value - irradiance[own])).max(0.0);
        }
        corners
    }
}

/// E = B - rho H, never negative; all by patch and band.
pub fn emission_of(radiosity: &[f64], irradiance: &[f64], reflectance: &[f64]) -> Vec<f64> {
    let reflected = irradiance.iter().zip(reflectance).map(|(h, rho)| h * rho);
    radiosity.iter().zip(reflected).map(|(b, reflected)| (b - reflected).max(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use radiosity_geometry::corners::CREASE_ANGLE;

    use super::*;
    use crate::test_scenes::sheet;

    #[test]
    fn reflectance_and_emission_keep_sharp_edges() {
        let mut patches = sheet(2, 1);
        patches.surface = vec![0, 1];
        // One surface glows with 10 and reflects half, the other reflects a quarter.
        let (irradiance, radiosity) = ([4.0, 8.0], [12.0, 2.0]);
        let smoother = Smoother::new(&patches, CREASE_ANGLE);
        let corners = smoother.corner_radiosity(&radiosity, &irradiance, &[vec![0.5], vec![0.25]], 1);
        assert_eq!(corners, [11.0, 13.0, 13.0, 11.0, 1.5, 2.5, 2.5, 1.5]);
    }

    #[test]
    fn nothing_is_negative() {
        let patches = sheet(3, 1);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_values(&[0.0, 1.0, 9.0], 1);
        assert!(corners.iter().all(|&c| c >= 0.0) && corners[0] == 0.0, "{corners:?}");
    }
}
