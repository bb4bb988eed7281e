//! Images as PNG and OpenEXR files.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, LayerAttributes, Text, WritableImage,
};

use crate::{Image, Rgb8};
use radiosity_store::files::{FileError, Output, atomic_write, invalid};

/// Writes a picture as PNG, marked as sRGB.
///
/// # Errors
/// If the picture is empty or the file cannot be written; then nothing is left behind.
pub fn write_png(path: &Path, picture: &Rgb8) -> Result<(), FileError> {
    atomic_write(path, |out| encode_png(picture, out))
}

fn encode_png(picture: &Rgb8, out: &mut Output) -> io::Result<()> {
    let [width, height] = size(picture.width, picture.height)?;
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(png_error)?;
    writer.write_image_data(&picture.pixels).map_err(png_error)?;
    writer.finish().map_err(png_error)
}

/// The error of the system where there is one: its number would be lost in the library's own conversion.
fn png_error(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => other.into(),
    }
}

fn size(width: usize, height: usize) -> io::Result<[u32; 2]> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err(invalid(format!("a picture of {width} by {height} pixels is no picture"))),
    }
}

/// Writes a linear image as OpenEXR with one 32-bit channel per band, which has the band's name.
///
/// # Errors
/// If the image is empty, the names do not fit the bands, or the file cannot be written; then nothing is left behind.
pub fn write_exr<S: AsRef<str>>(path: &Path, image: &Image, bands: &[S]) -> Result<(), FileError> {
    atomic_write(path, |out| encode_exr(image, bands, out))
}

fn encode_exr<S: AsRef<str>>(image: &Image, bands: &[S], out: &mut Output) -> io::Result<()> {
    size(image.width, image.height)?;
    let names: HashSet<&str> = bands.iter().map(AsRef::as_ref).collect();
    if image.bands == 0 || bands.len() != image.bands || names.len() != image.bands {
        return Err(invalid(format!("{} bands need as many different names", image.bands)));
    }
    let channel = |(band, name): (usize, &S)| {
        let name = Text::new_or_none(name.as_ref()).filter(|text| !text.as_slice().is_empty());
        let name = name.ok_or_else(|| invalid("a band has a name that OpenEXR cannot hold"))?;
        let samples = image.iter().map(|pixel| pixel[band]).collect();
        Ok(AnyChannel::new(name, FlatSamples::F32(samples)))
    };
    let channels = bands.iter().enumerate().map(channel).collect::<io::Result<_>>()?;
    let layer = Layer::new(
        (image.width, image.height),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    ExrImage::from_layer(layer).write().non_parallel().to_buffered(out).map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other),
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn png_goes_there_and_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let picture = Rgb8 { width: 2, height: 1, pixels: vec![1, 2, 3, 250, 251, 252] };
        write_png(&path, &picture).unwrap();
        let mut reader = png::Decoder::new(io::BufReader::new(fs::File::open(&path).unwrap())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height, pixels), (2, 1, picture.pixels));
        assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
    }

    #[test]
    fn exr_keeps_every_bit_and_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for names in [&["R", "G", "B"][..], &["1-2 um", "2-5 um"], &["Y"]] {
            let n = names.len();
            let pixels: Vec<f32> = (0..6 * n).map(|i| (i as f32).exp() - 1.1).collect();
            let image = Image { width: 3, height: 2, bands: n, pixels };
            write_exr(&path, &image, names).unwrap();
            let read = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
            for channel in &read.layer_data.channel_data.list {
                let band = names.iter().position(|name| channel.name.eq(name)).unwrap();
                let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
                assert_eq!(samples, image.iter().map(|pixel| pixel[band]).collect::<Vec<_>>());
            }
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_keeps_the_number_of_its_error() {
        const NO_SPACE: i32 = 28;
        let path = Path::new("/dev/full");
        // Noise, so that compressed it is still larger than the buffer.
        let noise: Vec<u32> = (0..30_000u32).map(|i| i.wrapping_mul(2_654_435_761).rotate_left(i % 31)).collect();
        let pixels: Vec<f32> = noise.iter().map(|n| f32::from_bits(n >> 2)).collect();
        let exr = write_exr(path, &Image { width: 300, height: 100, bands: 1, pixels }, &["Y"]).unwrap_err();
        let pixels = noise.iter().map(|n| (n >> 9) as u8).collect();
        let png = write_png(path, &Rgb8 { width: 100, height: 100, pixels }).unwrap_err();
        assert_eq!((exr.source.raw_os_error(), png.source.raw_os_error()), (Some(NO_SPACE), Some(NO_SPACE)));
    }

    #[test]
    fn what_cannot_be_written_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let image = Image { width: 1, height: 1, bands: 2, pixels: vec![0.0; 2] };
        for names in [&["a"][..], &["a", "a"], &["a", ""], &["a", "日"]] {
            assert!(write_exr(&path, &image, names).is_err(), "{names:?}");
        }
        assert!(write_exr(&path, &Image::default(), &[""; 0]).is_err());
        assert!(write_png(&path, &Rgb8::default()).is_err());
        assert!(write_png(&path, &Rgb8 { width: 5, height: 5, pixels: vec![0; 3] }).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
