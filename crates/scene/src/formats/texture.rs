//! Images of files: as textures, or as their mean.
//!
//! Where an image is averaged, the mean is over all of it, wherever the texture coordinates of a surface may point.

use std::collections::HashMap;
use std::hash::Hash;
use std::io::Cursor;
use std::sync::{Arc, LazyLock};

use image::{DynamicImage, ImageReader, Limits};
use radiosity_geometry::texture::{Raster, Wrap};

use super::colour;

/// No texture of a room needs more; the limit keeps a small file from filling the memory.
const MAX_SIDE: u32 = 16_384;

/// Mean colour of an image, read in two ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean {
    /// For colours: sRGB made linear before averaging.
    pub colour: [f64; 3],
    /// For data such as metalness: averaged as stored.
    pub data: [f64; 3],
    /// The alpha channel as stored; 1 where there is none.
    pub alpha: f64,
}

/// Bytes that the textures of a file may take together; images beyond that are averaged.
pub(super) const MOST_BYTES: usize = 1 << 29;

/// An image, and its mean.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    pub mean: Mean,
    /// Linear, of three channels; none if there was no room.
    pub image: Option<Raster>,
    /// The largest value of each channel.
    pub brightest: [f32; 3],
}

/// What a finding says of an image for which there was no room.
pub(super) const NO_ROOM: &str =
    "the images of the file take more than 512 MiB together, and its mean was taken; make them smaller";

/// Images by number or name with the ways they are wrapped, so that surfaces share them.
#[derive(Default)]
pub(super) struct Wrapped<Key> {
    known: HashMap<(Key, [Wrap; 2], bool), Arc<Raster>>,
}

impl<Key: Eq + Hash> Wrapped<Key> {
    /// The image with these edges, [`colour::with_less_light`] if it is limited.
    pub fn get(&mut self, key: Key, image: &Raster, wrap: [Wrap; 2], is_limited: bool) -> Arc<Raster> {
        let make = || {
            let image = if is_limited { colour::with_less_light(image) } else { image.clone() };
            Arc::new(image.with_wrap(wrap))
        };
        Arc::clone(self.known.entry((key, wrap, is_limited)).or_insert_with(make))
    }
}

/// The mean of a PNG or JPEG image.
pub(super) fn mean(bytes: &[u8]) -> Result<Mean, String> {
    let image = decoded(bytes)?;
    Ok(Mean { alpha: mean_alpha(&image), ..mean_of(&image) })
}

/// A PNG or JPEG image whose texels take no more than so many bytes of `room`, from which they are taken. Alpha is
/// ignored.
pub(super) fn texture(bytes: &[u8], room: &mut usize) -> Result<Texture, String> {
    let image = decoded(bytes)?;
    let mean = Mean { alpha: mean_alpha(&image), ..mean_of(&image) };
    let size = [image.width() as usize, image.height() as usize];
    let texel_bytes = if is_deep(&image) { 12 } else { 3 };
    let Some(left) = room.checked_sub(texel_bytes * size[0] * size[1]) else {
        return Ok(Texture { mean, image: None, brightest: [1.0; 3] });
    };
    *room = left;
    let raster = if is_deep(&image) {
        let values = image.into_rgb16().into_raw();
        let values = values.into_iter().map(|c| linear(f64::from(c) / 65535.0) as f32);
        Raster::of_values(size, 3, values.collect())
    } else {
        srgb(size, 3, image.into_rgb8().into_raw())
    };
    Ok(Texture { mean, brightest: raster.brightest(), image: Some(raster) })
}

/// A linear image from bytes in sRGB, `height x width x channels`.
///
/// # Panics
/// If there are no texels, or not as many as the size says, or not one or three channels.
pub fn srgb(size: [usize; 2], channels: usize, levels: Vec<u8>) -> Raster {
    static LINEAR: LazyLock<Arc<[f32; 256]>> =
        LazyLock::new(|| Arc::new(std::array::from_fn(|level| linear(level as f64 / 255.0) as f32)));
    Raster::of_levels(size, channels, levels, Arc::clone(&LINEAR))
}

fn is_deep(image: &DynamicImage) -> bool {
    use image::ColorType::{L16, La16, Rgb16, Rgba16};
    matches!(image.color(), L16 | La16 | Rgb16 | Rgba16)
}

fn decoded(bytes: &[u8]) -> Result<DynamicImage, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    if reader.format().is_none() {
        return Err("it is neither PNG nor JPEG".into());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| error.to_string())?;
    if image.width() == 0 || image.height() == 0 {
        return Err("it has no pixels".into());
    }
    Ok(image)
}

fn mean_alpha(image: &DynamicImage) -> f64 {
    if !image.color().has_alpha() {
        return 1.0;
    }
    let image = image.to_rgba16();
    let sum: f64 = image.pixels().map(|pixel| f64::from(pixel.0[3]) / 65535.0).sum();
    sum / (f64::from(image.width()) * f64::from(image.height()))
}

fn mean_of(image: &DynamicImage) -> Mean {
    if is_deep(image) {
        return average(image.to_rgb16().pixels().map(|pixel| pixel.0.map(|c| f64::from(c) / 65535.0)));
    }
    match image {
        DynamicImage::ImageRgb8(pixels) => from_histogram(pixels.as_raw()),
        _ => from_histogram(image.to_rgb8().as_raw()),
    }
}

fn average(pixels: impl Iterator<Item = [f64; 3]>) -> Mean {
    let (mut colour, mut data, mut count) = ([0.0; 3], [0.0; 3], 0.0);
    for pixel in pixels {
        for band in 0..3 {
            colour[band] += linear(pixel[band]);
            data[band] += pixel[band];
        }
        count += 1.0;
    }
    Mean { colour: colour.map(|sum| sum / count), data: data.map(|sum| sum / count), alpha: 1.0 }
}

/// Counts the 256 levels of each channel first, which is exact and spares a power per pixel.
fn from_histogram(pixels: &[u8]) -> Mean {
    let mut levels = [[0_u64; 256]; 3];
    for pixel in pixels.chunks_exact(3) {
        for band in 0..3 {
            levels[band][usize::from(pixel[band])] += 1;
        }
    }
    let count = (pixels.len() / 3) as f64;
    let weighted = |value: fn(f64) -> f64| {
        levels.map(|band| {
            let sum: f64 = (0..256).map(|level| band[level] as f64 * value(level as f64 / 255.0)).sum();
            sum / count
        })
    };
    Mean { colour: weighted(linear), data: weighted(|c| c), alpha: 1.0 }
}

/// IEC 61966-2-1, the inverse of the sRGB transfer function.
fn linear(srgb: f64) -> f64 {
    if srgb <= 0.04045 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use image::{ImageFormat, Rgb, RgbImage};

    /// A PNG whose left half has one colour and right half another.
    pub fn two_colour_png(left: [u8; 3], right: [u8; 3]) -> Vec<u8> {
        let image = RgbImage::from_fn(4, 2, |x, _| Rgb(if x < 2 { left } else { right }));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn mean_is_taken_of_linear_light() {
        let mean = mean(&two_colour_png([255, 0, 128], [0, 0, 128])).unwrap();
        assert!((mean.colour[0] - 0.5).abs() < 1e-12, "black and white average to half the light");
        assert_eq!(mean.colour[1], 0.0);
        assert!((mean.colour[2] - 0.215_860_5).abs() < 1e-6, "sRGB 128 is 21.6 % of white");
        assert!((mean.data[2] - 128.0 / 255.0).abs() < 1e-12);
    }

    #[test]
    fn alpha_is_averaged_as_stored() {
        let image = image::RgbaImage::from_fn(4, 2, |x, _| image::Rgba([0, 0, 0, if x < 1 { 255 } else { 51 }]));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        assert!((mean(bytes.get_ref()).unwrap().alpha - (0.25 + 0.75 * 0.2)).abs() < 1e-12);
        assert_eq!(mean(&two_colour_png([1, 2, 3], [4, 5, 6])).unwrap().alpha, 1.0);
    }

    #[test]
    fn sixteen_bit_images_agree_with_eight_bit_ones() {
        let wide = mean_of(&DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(3, 3, Rgb([128 * 257; 3]))));
        let narrow = mean_of(&DynamicImage::ImageRgb8(RgbImage::from_pixel(3, 3, Rgb([128; 3]))));
        assert!((wide.colour[0] - narrow.colour[0]).abs() < 1e-12);
    }

    #[test]
    fn textures_are_linear_and_take_no_more_than_the_room() {
        let png = two_colour_png([255, 0, 128], [0, 0, 128]);
        let mut room = 30;
        let texture = |room: &mut usize| super::texture(&png, room).unwrap();
        let image = texture(&mut room).image.unwrap();
        assert_eq!((image.size(), image.memory_bytes(), room), ([4, 2], 24, 6));
        let [red, green, blue] = image.at([0.25, 0.5]);
        assert!(red == 1.0 && green == 0.0 && (blue - 0.215_860_5).abs() < 1e-6, "{red} {green} {blue}");
        assert!(texture(&mut room).image.is_none() && room == 6);
        assert_eq!(texture(&mut room).mean, mean(&png).unwrap());
    }

    #[test]
    fn deep_images_make_the_same_textures() {
        let wide = DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(3, 3, Rgb([128 * 257; 3])));
        let mut bytes = Cursor::new(Vec::new());
        wide.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let texture = texture(bytes.get_ref(), &mut MOST_BYTES.clone()).unwrap();
        assert!((texture.image.unwrap().texel(1, 1, 2) - 0.215_860_5).abs() < 1e-6);
    }

    #[test]
    fn other_bytes_are_refused() {
        assert!(mean(b"RIFF....WEBPVP8 ").is_err());
        assert!(mean(b"").is_err());
        let whole = two_colour_png([1, 2, 3], [4, 5, 6]);
        assert!(mean(&whole[..whole.len() / 2]).is_err());
    }
}
