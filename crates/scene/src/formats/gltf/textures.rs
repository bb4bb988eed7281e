//! Textures: images, how they are wrapped, and where they are on a surface.

use std::sync::Arc;

use ::gltf::json;
use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::texture::{self, WrappingMode};
use ::gltf::json::validation::Checked;
use radiosity_geometry::texture::{Raster, Wrap};

use super::buffers::Document;
use crate::formats::folder::{Folder, abbreviated};
use crate::formats::texture::{MOST_BYTES, Mean, Texture, Wrapped, mean, texture};

/// Image files larger than this are not read.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The images of a file, each read when first asked for.
pub(super) struct Images<'a> {
    document: &'a Document<'a>,
    folder: &'a Folder,
    means: Vec<Option<Result<Mean, String>>>,
    textures: Vec<Option<Result<Texture, String>>>,
    wrapped: Wrapped<usize>,
    /// Bytes left for textures.
    room: usize,
}

/// The image of a material before it is on a surface.
#[derive(Clone)]
pub(super) struct Painted {
    index: usize,
    image: Raster,
    wrap: [Wrap; 2],
    /// The largest value of each channel.
    pub brightest: [f32; 3],
    /// What multiplies it.
    pub factor: [f64; 3],
    transform: Option<TextureTransform>,
}

/// The texture of the base colour of a material.
pub(super) fn of_base_colour(source: &json::Material) -> Option<&texture::Info> {
    let glossy = source.extensions.as_ref().and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
    match glossy {
        Some(glossy) => glossy.diffuse_texture.as_ref(),
        None => source.pbr_metallic_roughness.base_color_texture.as_ref(),
    }
}

/// Which of the texture coordinates of a mesh a texture goes by.
pub(super) fn coordinate_set(info: &texture::Info) -> u32 {
    transform(info).and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord)
}

fn transform(info: &texture::Info) -> Option<&TextureTransform> {
    info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref())
}

impl<'a> Images<'a> {
    pub fn new(document: &'a Document<'a>, folder: &'a Folder) -> Self {
        let count = document.root.images.len();
        let (means, textures) = (vec![None; count], vec![None; count]);
        Self { document, folder, means, textures, wrapped: Wrapped::default(), room: MOST_BYTES }
    }

    /// The mean of a texture.
    pub fn mean(&mut self, info: &texture::Info) -> Result<Mean, String> {
        let (index, image, _) = self.source(info)?;
        if let Some(Ok(texture)) = &self.textures[index] {
            return Ok(texture.mean);
        }
        if self.means[index].is_none() {
            self.means[index] = Some(self.bytes(index, image, mean));
        }
        self.means[index].clone().expect("it was just read")
    }

    /// The mean of a texture, and its image times a factor, if there is room.
    pub fn painted(&mut self, info: &texture::Info, factor: [f64; 3]) -> Result<([f64; 3], Option<Painted>), String> {
        let (index, image, wrap) = self.source(info)?;
        if self.textures[index].is_none() {
            let mut room = self.room;
            self.textures[index] = Some(self.bytes(index, image, |bytes| texture(bytes, &mut room)));
            self.room = room;
        }
        let Texture { mean, image, brightest } = self.textures[index].clone().expect("it was just read")?;
        let transform = transform(info).cloned();
        let painted = image.map(|image| Painted { index, image, wrap, brightest, factor, transform });
        Ok((mean.colour, painted))
    }

    /// The image as surfaces share it.
    pub fn wrapped(&mut self, painted: &Painted, is_limited: bool) -> Arc<Raster> {
        self.wrapped.get(painted.index, &painted.image, painted.wrap, is_limited)
    }

    /// The image of a texture, its index, and how it is wrapped.
    fn source(&self, info: &texture::Info) -> Result<(usize, &'a json::Image, [Wrap; 2]), String> {
        let root = self.document.root;
        let texture = root.get(info.index).ok_or(format!("texture {} does not exist", info.index.value()))?;
        let index = texture.source.value();
        let image = root.images.get(index).ok_or("it has no image in a format that is read")?;
        let sampler = texture.sampler.and_then(|sampler| root.samplers.get(sampler.value()));
        let wrap = sampler.map_or([Wrap::Repeat; 2], |sampler| [sampler.wrap_s, sampler.wrap_t].map(wrap));
        Ok((index, image, wrap))
    }

    /// Reads an image from the bytes of its file.
    fn bytes<T>(
        &self,
        index: usize,
        image: &json::Image,
        read: impl FnOnce(&[u8]) -> Result<T, String>,
    ) -> Result<T, String> {
        let label = image.uri.as_deref().map_or_else(|| format!("image {index}"), abbreviated);
        let found = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => self.folder.read_uri(uri, MAX_IMAGE_BYTES).and_then(|bytes| read(&bytes)),
            (None, Some(view)) => self.document.view(view).and_then(|(bytes, _)| read(bytes)),
            (None, None) => Err("it has no data".into()),
        };
        found.map_err(|fault| format!("{label} cannot be read ({fault})"))
    }
}

/// A mode that is unknown is the default.
fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

impl Painted {
    /// The same with less of it.
    pub fn dimmed(self, share: f64) -> Self {
        Self { factor: self.factor.map(|f| share * f), ..self }
    }

    /// Coordinates on the image, by KHR_texture_transform: scaled, turned counter-clockwise as one looks at the image,
    /// whose v points down, and moved. None if any is not finite.
    pub fn transformed(&self, coordinates: &[[f64; 2]]) -> Option<Vec<[f64; 2]>> {
        let Some(transform) = &self.transform else { return Some(coordinates.to_vec()) };
        let [scale, offset] = [transform.scale.0, transform.offset.0].map(|pair| pair.map(f64::from));
        let (sine, cosine) = f64::from(transform.rotation.0).sin_cos();
        let moved = |&[u, v]: &[f64; 2]| {
            let (u, v) = (scale[0] * u, scale[1] * v);
            [cosine * u + sine * v + offset[0], cosine * v - sine * u + offset[1]]
        };
        let found: Vec<_> = coordinates.iter().map(moved).collect();
        found.iter().flatten().all(|c| c.is_finite()).then_some(found)
    }
}
