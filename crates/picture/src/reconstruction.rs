//! Radiosity at the corners of patches, for smooth shading.

use radiosity_geometry::{Corners, Patches};

use crate::backs::{Sheets, matching_corners};

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
    /// keep their sharp edges. `reflectance` has one spectrum per surface; so has `transmittance`, what passes diffusely
    /// from a patch to the one that is its back, or it is empty.
    ///
    /// # Panics
    /// If the slices do not fit the patches.
    pub fn corner_radiosity<R: AsRef<[f64]>>(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: &[R],
        transmittance: &[R],
        bands: usize,
    ) -> Vec<f64> {
        let of = |patch: usize, band: usize| reflectance[self.patches.surface[patch] as usize].as_ref()[band];
        let is_opaque = transmittance.iter().all(|tau| tau.as_ref().iter().all(|&t| t == 0.0));
        let passes = |&surface: &u32| {
            let spectrum = transmittance[surface as usize].as_ref();
            (0..bands).map(move |band| spectrum.get(band).copied().unwrap_or(0.0))
        };
        let through: Vec<f64> =
            if is_opaque { Vec::new() } else { self.patches.surface.iter().flat_map(passes).collect() };
        self.corner_radiosity_by(radiosity, irradiance, of, &through, bands)
    }

    /// The same where every patch has paint of its own: `reflectance` is `n_patches x bands`, and `transmittance` too or
    /// empty.
    ///
    /// # Panics
    /// If the slices do not fit the patches.
    pub fn corner_radiosity_of_patches(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: &[f64],
        transmittance: &[f64],
        bands: usize,
    ) -> Vec<f64> {
        assert_eq!(reflectance.len(), irradiance.len(), "one value per patch and band");
        let of = |patch: usize, band: usize| reflectance[patch * bands + band];
        self.corner_radiosity_by(radiosity, irradiance, of, transmittance, bands)
    }

    fn corner_radiosity_by(
        &self,
        radiosity: &[f64],
        irradiance: &[f64],
        reflectance: impl Fn(usize, usize) -> f64,
        transmittance: &[f64],
        bands: usize,
    ) -> Vec<f64> {
        assert_eq!(radiosity.len(), irradiance.len(), "one value per patch and band");
        let mut corners = self.corners.field(irradiance, bands);
        let excess = self.passed_excess(&corners, irradiance, transmittance, bands);
        for (i, value) in corners.iter_mut().enumerate() {
            let (patch, band) = (i / bands / 4, i % bands);
            let own = patch * bands + band;
            // B = E + rho H + tau H', so that what the light at the corner adds to the patch's own B is rho times its excess,
            // and tau times that on the other side.
            let passed = excess.get(i).unwrap_or(&0.0);
            *value = (radiosity[own] + reflectance(patch, band) * (*value - irradiance[own]) + passed).max(0.0);
        }
        corners
    }

    /// What the light at the corners of the other sides of sheets exceeds that of the whole sides by and passes; empty if
    /// nothing does.
    fn passed_excess(&self, field: &[f64], irradiance: &[f64], transmittance: &[f64], bands: usize) -> Vec<f64> {
        if transmittance.is_empty() {
            return Vec::new();
        }
        assert_eq!(transmittance.len(), irradiance.len(), "one value per patch and band");
        let mut excess = vec![0.0; field.len()];
        for (front, back) in Sheets::new(self.patches).pairs() {
            for (own, other) in [(front, back), (back, front)] {
                let places = matching_corners(&self.patches.polygons[own], &self.patches.polygons[other]);
                for (corner, place) in places.into_iter().enumerate() {
                    for band in 0..bands {
                        let beyond = field[(4 * other + place) * bands + band] - irradiance[other * bands + band];
                        excess[(4 * own + corner) * bands + band] = transmittance[own * bands + band] * beyond;
                    }
                }
            }
        }
        excess
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
        let corners = smoother.corner_radiosity(&radiosity, &irradiance, &[vec![0.5], vec![0.25]], &[], 1);
        assert_eq!(corners, [11.0, 13.0, 13.0, 11.0, 1.5, 2.5, 2.5, 1.5]);
    }

    #[test]
    fn what_passes_a_sheet_varies_as_the_light_on_its_other_side() {
        // A strip of two quads and its back, the second of which begins at another corner.
        let strip = sheet(2, 1);
        let [a, b, c, d] = strip.polygons[0];
        let [e, f, g, h] = strip.polygons[1];
        let polygons = vec![strip.polygons[0], strip.polygons[1], [d, c, b, a], [e, h, g, f]];
        let patches = Patches::new(polygons, vec![0, 0, 1, 1], vec![0; 4], vec![false; 4]);
        // Even light on the front; on the back it is 8 x + 2 at x, from 2 to 10.
        let irradiance = [3.0, 3.0, 4.0, 8.0];
        let (rho, tau) = (0.5, 0.25);
        let radiosity = [0, 1, 2, 3].map(|i: usize| rho * irradiance[i] + tau * irradiance[(i + 2) % 4]);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_radiosity(
            &radiosity,
            &irradiance,
            &[[rho], [rho]],
            &[[tau], [tau]],
            1,
        );
        for (corner, value) in patches.polygons.iter().flatten().zip(&corners).enumerate() {
            let back = 8.0 * value.0.x + 2.0;
            let wanted = if corner < 8 { rho * 3.0 + tau * back } else { rho * back + tau * 3.0 };
            assert!((value.1 - wanted).abs() < 1e-12, "{corner}: {} {wanted}", value.1);
        }
    }

    #[test]
    fn nothing_is_negative() {
        let patches = sheet(3, 1);
        let corners = Smoother::new(&patches, CREASE_ANGLE).corner_values(&[0.0, 1.0, 9.0], 1);
        assert!(corners.iter().all(|&c| c >= 0.0) && corners[0] == 0.0, "{corners:?}");
    }
}
