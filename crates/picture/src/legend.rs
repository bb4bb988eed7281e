//! A colour bar with values beside a picture in false colours.

use font8x8::{BASIC_FONTS, LATIN_FONTS, UnicodeFonts};

use crate::Rgb8;
use crate::tone::{ColourMap, ColourScale};

/// Pixels of a letter, each way, before it is enlarged.
const LETTER: usize = 8;

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [0; 3];

/// The picture with a legend on its right: lines of text over a bar of the colours, with round values marked. Letters
/// that the font does not have, which is all beyond Latin-1, are left out.
pub fn with_legend(picture: &Rgb8, scale: &ColourScale, map: ColourMap, title: &str) -> Rgb8 {
    // Letters of one fiftieth of the picture's height, in whole multiples.
    let zoom = (picture.height / 400).clamp(1, 8);
    let letter = LETTER * zoom;
    let lines: Vec<&str> = title.lines().collect();
    let (top, bottom) = (letter + 2 * letter * lines.len(), picture.height.saturating_sub(letter).max(1));
    let bar = Bar { left: picture.width + letter, top: top.min(bottom - 1), bottom, width: 2 * letter };
    let marks = marks(scale, (bar.bottom - bar.top) / (3 * letter));
    let letters = |text: &str| text.chars().count() * letter;
    let widest_label = marks.iter().map(|(_, label)| letters(label)).max().unwrap_or(0);
    let widest_line = lines.iter().map(|line| letters(line)).max().unwrap_or(0);
    let panel = widest_line.max(bar.width + letter + widest_label) + 2 * letter;
    let mut sheet = Sheet::beside(picture, panel, zoom);
    for (k, line) in lines.iter().enumerate() {
        sheet.write(picture.width + letter, letter + 2 * letter * k, line);
    }
    bar.draw(&mut sheet, map);
    for (value, label) in &marks {
        bar.mark(&mut sheet, scale.position(*value), label);
    }
    sheet.page
}

/// Where the colours are.
struct Bar {
    left: usize,
    top: usize,
    bottom: usize,
    width: usize,
}

impl Bar {
    fn draw(&self, sheet: &mut Sheet, map: ColourMap) {
        let height = self.bottom - self.top;
        for y in 0..height {
            let colour = map.colour(1.0 - (y as f64 + 0.5) / height as f64);
            sheet.fill(self.left, self.top + y, self.width, 1, colour);
        }
    }

    /// A line at a place from 0, the lowest, to 1, with a label whose middle is level with it.
    fn mark(&self, sheet: &mut Sheet, position: f64, label: &str) {
        let letter = LETTER * sheet.zoom;
        let y = self.top + ((1.0 - position) * (self.bottom - self.top - 1) as f64).round() as usize;
        sheet.fill(self.left + self.width, y, letter / 2, sheet.zoom, INK);
        sheet.write(self.left + self.width + letter, (y + sheet.zoom / 2).saturating_sub(letter / 2), label);
    }
}

/// A page to draw on.
struct Sheet {
    page: Rgb8,
    zoom: usize,
}

impl Sheet {
    /// The picture with white paper on its right.
    fn beside(picture: &Rgb8, panel: usize, zoom: usize) -> Self {
        let width = picture.width + panel;
        let mut pixels = Vec::with_capacity(3 * width * picture.height);
        for row in 0..picture.height {
            pixels.extend_from_slice(&picture.pixels[3 * row * picture.width..3 * (row + 1) * picture.width]);
            pixels.resize(3 * (row + 1) * width, PAPER[0]);
        }
        Self { page: Rgb8 { width, height: picture.height, pixels }, zoom }
    }

    /// Fills a rectangle, as far as it is on the page.
    fn fill(&mut self, left: usize, top: usize, width: usize, height: usize, colour: [u8; 3]) {
        let right = (left + width).min(self.page.width);
        for y in top..(top + height).min(self.page.height) {
            for x in left..right {
                self.page.pixels[3 * (y * self.page.width + x)..][..3].copy_from_slice(&colour);
            }
        }
    }

    /// Writes a line of text.
    fn write(&mut self, left: usize, top: usize, text: &str) {
        for (k, character) in text.chars().enumerate() {
            let glyph = BASIC_FONTS.get(character).or_else(|| LATIN_FONTS.get(character)).unwrap_or([0; LETTER]);
            let left = left + k * LETTER * self.zoom;
            for (row, bits) in glyph.into_iter().enumerate() {
                for column in (0..LETTER).filter(|column| bits >> column & 1 == 1) {
                    let (x, y) = (left + column * self.zoom, top + row * self.zoom);
                    self.fill(x, y, self.zoom, self.zoom, INK);
                }
            }
        }
    }
}

/// Round values within a scale, about so many at most, and how they are written.
fn marks(scale: &ColourScale, most: usize) -> Vec<(f64, String)> {
    let most = most.clamp(2, 10);
    if !(scale.low.is_finite() && scale.high.is_finite() && scale.high > scale.low) {
        return vec![(scale.low, label(scale.low, scale.low.abs()))];
    }
    if scale.is_logarithmic {
        let (first, last) = (scale.low.log10().ceil() as i32, scale.high.log10().floor() as i32);
        let every = ((last - first).max(0) as usize / most + 1) as i32;
        return (first..=last).step_by(every as usize).map(|k| 10f64.powi(k)).map(|v| (v, label(v, v))).collect();
    }
    let step = round_step((scale.high - scale.low) / most as f64);
    // A little beyond, as sums of steps are not exact.
    let (first, last) = ((scale.low / step - 1e-9).ceil() as i64, (scale.high / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).map(|v| (v, label(v, step))).collect()
}

/// The least of 1, 2 and 5 times a power of ten that is not below.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|s| *s >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A value to the digits that tell it from its neighbours, a step away.
fn label(value: f64, step: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let largest = value.abs().max(step);
    if !(1e-3..1e6).contains(&largest) {
        let digits = (value.abs().log10().floor() - step.log10().floor()).clamp(0.0, 6.0) as usize;
        return format!("{value:.digits$e}");
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, is_logarithmic: bool) -> Vec<String> {
        marks(&ColourScale { low, high, is_logarithmic }, 6).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn marks_are_round_and_within_the_scale() {
        assert_eq!(labels(0.0, 5.3, false), ["0", "1", "2", "3", "4", "5"]);
        assert_eq!(labels(0.0, 0.6, false), ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
        assert_eq!(labels(100.0, 1100.0, false), ["200", "400", "600", "800", "1000"]);
        assert_eq!(labels(0.0, 3e-5, false), ["0", "5e-6", "1.0e-5", "1.5e-5", "2.0e-5", "2.5e-5", "3.0e-5"]);
        assert_eq!(labels(0.01, 20.0, true), ["0.01", "0.1", "1", "10"]);
        assert_eq!(labels(2.0, 2.0, false), ["2"]);
        assert_eq!(labels(f64::NAN, 2.0, false).len(), 1);
    }

    #[test]
    fn the_picture_stays_and_the_bar_has_the_colours_of_its_values() {
        let picture = Rgb8 { width: 30, height: 200, pixels: vec![7; 3 * 30 * 200] };
        let scale = ColourScale { low: 0.0, high: 2.0, is_logarithmic: false };
        let page = with_legend(&picture, &scale, ColourMap::Viridis, "light\nW/m²");
        assert!(page.width > 30 + 5 * 8 && page.height == 200);
        let at = |x: usize, y: usize| &page.pixels[3 * (y * page.width + x)..][..3];
        assert!((0..200).all(|y| at(0, y) == [7; 3] && at(29, y) == [7; 3] && at(page.width - 1, y) == PAPER));
        // The ends of viridis, within the step of half a pixel: #440154 and #fde725.
        let near = |a: &[u8], b: [u8; 3]| a.iter().zip(b).all(|(&a, b)| a.abs_diff(b) <= 2);
        let column: Vec<usize> = (0..200).filter(|&y| at(30 + 8 + 8, y) != PAPER).collect();
        assert!(near(at(46, 191), [68, 1, 84]), "{:?}", at(46, 191));
        let top = column.iter().copied().find(|&y| near(at(46, y), [253, 231, 37])).unwrap();
        assert!(top < 60, "{top}");
        assert!((0..30).any(|y| (38..100).any(|x| at(x, y) == INK)), "a title");
    }

    #[test]
    fn the_smallest_pictures_have_legends_too() {
        for (width, height) in [(0, 0), (1, 1), (3, 20), (2000, 3000)] {
            let picture = Rgb8 { width, height, pixels: vec![0; 3 * width * height] };
            let scale = ColourScale { low: 0.0, high: 1.0, is_logarithmic: false };
            let page = with_legend(&picture, &scale, ColourMap::Grey, "a title\nof two lines");
            assert_eq!(page.pixels.len(), 3 * page.width * page.height);
        }
    }
}
