//! From linear values to colours on the screen.

use colorous::Gradient;

use crate::{Image, Rgb8};

/// How bright a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Multiplies by this.
    Factor(f64),
    /// Multiplies by two to this power.
    Stops(f64),
    /// Multiplies so that this share of the lit pixels, such as 0.99, stays below 1.
    Percentile(f64),
    /// Multiplies so that the logarithmic mean of the lit pixels becomes this key; 0.18 is middle grey (Reinhard et
    /// al. 2002, *Photographic tone reproduction for digital images*).
    Key(f64),
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Key(0.18)
    }
}

impl Exposure {
    /// The factor for an image.
    pub fn factor(&self, image: &Image) -> f64 {
        self.factor_of(image.iter().map(|bands| (luminance(rgb(bands)), 1.0)))
    }

    /// The factor for luminances and their weights, which are pixels or square metres. Black ones do not count.
    pub fn factor_of(&self, luminances: impl Iterator<Item = (f32, f64)>) -> f64 {
        let lit = luminances.filter(|&(l, w)| l > 0.0 && l.is_finite() && w > 0.0);
        let factor = match *self {
            Self::Factor(factor) => factor,
            // Beyond these, powers of two are no numbers any more.
            Self::Stops(stops) => stops.clamp(-1000.0, 1000.0).exp2(),
            Self::Percentile(share) => percentile(lit.collect(), share).recip(),
            Self::Key(key) => {
                let (sum, weight) = lit.fold((0.0, 0.0), |(s, w), (l, v)| (s + v * f64::from(l).ln(), w + v));
                key / (sum / weight).exp()
            }
        };
        // A black image stays black with any factor.
        if factor.is_finite() { factor } else { 1.0 }
    }
}

/// The value below which this share of the weight lies; NaN if there is none.
fn percentile(mut weighted: Vec<(f32, f64)>, share: f64) -> f64 {
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = weighted.iter().map(|&(_, w)| w).sum();
    let mut below = 0.0;
    for (value, weight) in &weighted {
        below += weight;
        if below >= share * total {
            return f64::from(*value);
        }
    }
    weighted.last().map_or(f64::NAN, |&(value, _)| f64::from(value))
}

/// How exposed values, any number from zero, become values from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ToneCurve {
    /// Cut off at 1.
    Linear,
    /// Reinhard et al. 2002, equation 4, on the luminance: `white` is the least luminance that becomes 1.
    Reinhard {
        /// Relative to the exposed image.
        white: f32,
    },
    /// An S-curve per channel, steep in the middle and soft in the highlights: Narkowicz 2015, *ACES filmic tone
    /// mapping curve*.
    #[default]
    Filmic,
}

impl ToneCurve {
    /// Maps a linear colour into [0, 1]; NaNs become black.
    pub fn apply(&self, colour: [f32; 3]) -> [f32; 3] {
        let colour = colour.map(|c| c.max(0.0));
        let mapped = match *self {
            Self::Linear => colour,
            Self::Reinhard { white } => {
                let l = luminance(colour);
                colour.map(|c| c * (1.0 + l / (white * white)) / (1.0 + l))
            }
            Self::Filmic => colour.map(filmic),
        };
        // Also takes what infinities became.
        mapped.map(|c| if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) })
    }
}

fn filmic(x: f32) -> f32 {
    // The curve lies on its asymptote here, and squares of what is much larger overflow.
    let x = x.min(1e6);
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Red, green and blue of any bands: three are those, others are shown grey at their mean.
pub fn rgb(bands: &[f32]) -> [f32; 3] {
    match *bands {
        [r, g, b] => [r, g, b],
        [] => [0.0; 3],
        _ => [mean(bands); 3],
    }
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

/// The luminance of linear sRGB, ITU-R BT.709.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Encodes a linear value in [0, 1] as sRGB, IEC 61966-2-1.
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = f64::from(x);
    (if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }) as f32
}

/// Decodes sRGB, IEC 61966-2-1.
pub fn linear_from_srgb(x: f32) -> f32 {
    let x = f64::from(x);
    (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
}

/// The picture of an image that was multiplied by `exposure`.
pub fn developed(image: &Image, exposure: f64, curve: ToneCurve) -> Rgb8 {
    let exposed = |bands: &[f32]| rgb(bands).map(|c| (f64::from(c) * exposure) as f32);
    let eight_bits = |c: f32| (255.0 * srgb_from_linear(c)).round() as u8;
    let pixels = image.iter().flat_map(|bands| curve.apply(exposed(bands)).map(eight_bits)).collect();
    Rgb8 { width: image.width, height: image.height, pixels }
}

/// Colours for a scalar; all but [`ColourMap::Turbo`] rise evenly in lightness, so that they read in grey too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark blue, green, yellow.
    #[default]
    Viridis,
    /// Black, red, yellow.
    Inferno,
    /// Black, purple, cream.
    Magma,
    /// Blue to yellow for the colour blind.
    Cividis,
    /// A rainbow that tells values apart best and orders them worst.
    Turbo,
    /// Black to white.
    Grey,
}

impl ColourMap {
    /// The sRGB colour of `t`, from 0 to 1; what lies outside has the colour of the end.
    pub fn colour(&self, t: f64) -> [u8; 3] {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let gradient: Gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Inferno => colorous::INFERNO,
            Self::Magma => colorous::MAGMA,
            Self::Cividis => colorous::CIVIDIS,
            Self::Turbo => colorous::TURBO,
            Self::Grey => return [(255.0 * t).round() as u8; 3],
        };
        gradient.eval_continuous(t).as_array()
    }
}

/// Which values a colour map spans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    /// The value of the first colour.
    pub low: f64,
    /// The value of the last colour.
    pub high: f64,
    /// Whether equal ratios, not equal differences, are equal steps of colour.
    pub is_logarithmic: bool,
}

impl ColourScale {
    /// From zero, or a thousandth of the top if logarithmic, to what one pixel in two hundred exceeds.
    pub fn automatic(image: &Image, is_logarithmic: bool) -> Self {
        let values = image.iter().map(|bands| (mean(bands), 1.0)).filter(|&(v, _)| v > 0.0 && v.is_finite());
        let high = percentile(values.collect(), 0.995);
        let high = if high > 0.0 { high } else { 1.0 };
        Self { low: if is_logarithmic { 1e-3 * high } else { 0.0 }, high, is_logarithmic }
    }

    /// Where a value lies between `low`, 0, and `high`, 1.
    pub fn position(&self, value: f64) -> f64 {
        let measure = |x: f64| if self.is_logarithmic { x.max(f64::MIN_POSITIVE).ln() } else { x };
        let (low, high) = (measure(self.low), measure(self.high));
        if high > low { (measure(value) - low) / (high - low) } else { 0.0 }
    }
}

/// The mean over the bands of each pixel in false colours.
pub fn false_colours(image: &Image, scale: &ColourScale, map: ColourMap) -> Rgb8 {
    let colour = |bands: &[f32]| map.colour(scale.position(f64::from(mean(bands))));
    Rgb8 { width: image.width, height: image.height, pixels: image.iter().flat_map(colour).collect() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn image(bands: usize, pixels: &[f32]) -> Image {
        Image { width: pixels.len() / bands, height: 1, bands, pixels: pixels.to_vec() }
    }

    #[test]
    fn srgb_has_its_published_values() {
        // IEC 61966-2-1: middle grey of 18 % is 118 of 255; the two branches meet.
        assert_eq!((255.0 * srgb_from_linear(0.18)).round(), 118.0);
        assert_eq!((255.0 * srgb_from_linear(0.5)).round(), 188.0);
        assert_eq!((srgb_from_linear(0.0), srgb_from_linear(1.0)), (0.0, 1.0));
        assert!((12.92 * 0.003_130_8 - srgb_from_linear(0.003_130_9)).abs() < 1e-5);
    }

    #[test]
    fn bands_become_colours() {
        assert_eq!(rgb(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(rgb(&[2.0]), [2.0; 3]);
        assert_eq!(rgb(&[1.0, 2.0, 3.0, 6.0]), [3.0; 3]);
        assert_eq!(rgb(&[]), [0.0; 3]);
    }

    #[test]
    fn exposures() {
        let image = image(1, &[0.0, 1.0, 4.0, 16.0]);
        assert_eq!(Exposure::Factor(3.0).factor(&image), 3.0);
        assert_eq!(Exposure::Stops(-1.0).factor(&image), 0.5);
        assert_eq!(Exposure::Stops(5000.0).factor(&image), 1000f64.exp2());
        assert!((Exposure::Key(0.18).factor(&image) - 0.18 / 4.0).abs() < 1e-6);
        assert!((Exposure::Percentile(0.6).factor(&image) - 0.25).abs() < 1e-6);
        let black = self::image(1, &[0.0, 0.0]);
        assert_eq!(Exposure::default().factor(&black), 1.0);
        assert_eq!(Exposure::Percentile(0.99).factor(&black), 1.0);
    }

    #[test]
    fn curves_stay_in_range_and_rise() {
        for curve in [ToneCurve::Linear, ToneCurve::Reinhard { white: 4.0 }, ToneCurve::Filmic] {
            assert_eq!(curve.apply([0.0; 3]), [0.0; 3]);
            assert_eq!(curve.apply([-1.0; 3]), [0.0; 3]);
            assert_eq!(curve.apply([f32::INFINITY; 3]), [1.0; 3]);
            assert_eq!(curve.apply([1e30; 3]), [1.0; 3]);
            let values: Vec<f32> = (0..400).map(|i| curve.apply([i as f32 * 0.02; 3])[0]).collect();
            assert!(values.is_sorted() && values.iter().all(|v| (0.0..=1.0).contains(v)));
        }
        assert!((ToneCurve::Reinhard { white: 4.0 }.apply([4.0; 3])[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn pictures() {
        let picture = developed(&image(3, &[0.5, 1.0, 0.0, 9.0, 0.09, 0.0]), 2.0, ToneCurve::Linear);
        assert_eq!(picture.pixels, [255, 255, 0, 255, 118, 0]);
        let scale = ColourScale { low: 0.0, high: 10.0, is_logarithmic: false };
        let colours = false_colours(&image(1, &[0.0, 10.0, 99.0, f32::NAN]), &scale, ColourMap::Viridis);
        // The ends of viridis as published: #440154 and #fde725.
        assert_eq!(colours.pixels, [68, 1, 84, 253, 231, 37, 253, 231, 37, 68, 1, 84]);
    }

    #[test]
    fn scales() {
        let scale = ColourScale { low: 1.0, high: 100.0, is_logarithmic: true };
        assert!((scale.position(10.0) - 0.5).abs() < 1e-15 && scale.position(0.0) < 0.0);
        assert_eq!(ColourScale { low: 2.0, high: 2.0, is_logarithmic: false }.position(2.0), 0.0);
        assert_eq!(ColourScale::automatic(&image(1, &[1.0, 5.0]), false).high, 5.0);
        assert_eq!(ColourScale::automatic(&image(1, &[0.0]), true).high, 1.0);
    }

    proptest! {
        #[test]
        fn srgb_goes_there_and_back(x in 0.0f32..1.0) {
            prop_assert!((linear_from_srgb(srgb_from_linear(x)) - x).abs() < 1e-5);
        }
    }
}
