//! Reflectance and emission as files give them.

use std::f64::consts::PI;

use radiosity_geometry::texture::Raster;

use super::names::Roll;

/// The highest reflectance taken from a file.
///
/// Files commonly carry a base colour of 1, which no paint has and with which light in a closed room never settles.
pub(super) const MAX_REFLECTANCE: f64 = 0.95;

/// What stands for a colour that is missing: a mid grey.
pub(super) const UNKNOWN_REFLECTANCE: f64 = 0.5;

/// Limits a reflectance in [0, 1] and says so.
pub(super) fn limited(reflectance: [f64; 3], material: &str, roll: &mut Roll) -> [f64; 3] {
    if reflectance.iter().any(|&rho| rho > MAX_REFLECTANCE) {
        let message = "the base colour is above 0.95 and was limited to 0.95; give it the reflectance of a real paint, \
                       such as 0.8";
        roll.warn("reflectance-limited", "material", material, message);
    }
    reflectance.map(|rho| rho.clamp(0.0, MAX_REFLECTANCE))
}

/// Limits a reflectance that multiplies an image whose channels reach `brightest`, and says so where both together are
/// above. Returns it, and whether the image is to be [`with_less_light`] for it.
pub(super) fn limited_with(factor: [f64; 3], brightest: [f32; 3], material: &str, roll: &mut Roll) -> ([f64; 3], bool) {
    if (0..3).any(|band| factor[band] * f64::from(brightest[band]) > MAX_REFLECTANCE) {
        let message = "the base colour texture is above 0.95 in places and was limited to 0.95 there";
        roll.note("texture-limited", "material", material, message);
    }
    let is_limited = factor.iter().any(|&f| f > MAX_REFLECTANCE);
    let share = if is_limited { MAX_REFLECTANCE } else { 1.0 };
    (factor.map(|f| share * f.clamp(0.0, 1.0)), is_limited)
}

/// An image whose texels are limited to 0.95 and that is then as bright again for a reflectance that was made less.
pub(super) fn with_less_light(image: &Raster) -> Raster {
    image.clone().with_gain([(1.0 / MAX_REFLECTANCE) as f32; 3])
}

/// How far exporters in single precision miss 0 and 1.
const SLACK: f64 = 1e-6;

/// Whether all components lie in [0, 1], but for rounding; [`limited`] takes care of that.
pub(super) fn is_fraction(colour: [f64; 3]) -> bool {
    colour.iter().all(|c| (-SLACK..=1.0 + SLACK).contains(c))
}

/// Whether all components are finite and not negative.
pub(super) fn is_power(colour: [f64; 3]) -> bool {
    colour.iter().all(|c| c.is_finite() && *c >= 0.0)
}

/// Componentwise product.
pub(super) fn times(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// How bright a linear colour is (Rec. 709).
pub(super) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Whether the components differ by more than one level of an 8-bit image.
pub(super) fn is_coloured(colour: [f64; 3]) -> bool {
    let (least, most) = colour.iter().fold((f64::INFINITY, 0.0), |(l, m): (f64, f64), &c| (l.min(c), m.max(c)));
    most - least > 1.0 / 255.0
}

/// Exitance of a Lambertian surface of the given radiance.
pub(super) fn exitance(radiance: [f64; 3]) -> [f64; 3] {
    radiance.map(|l| PI * l)
}
