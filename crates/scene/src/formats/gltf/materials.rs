//! Materials: what is diffuse of them.

use ::gltf::json;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::texture;
use ::gltf::json::validation::Checked;

use super::buffers::Document;
use super::geometry::Primitive;
use crate::formats::colour::{self, UNKNOWN_REFLECTANCE, times};
use crate::formats::folder::{Folder, abbreviated};
use crate::formats::names::Roll;
use crate::formats::texture::{Mean, mean};
use crate::model::{Finding, Material, SceneError};

/// Image files larger than this are not read.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The materials of a file, each read when first met.
pub(super) struct Materials<'a> {
    document: &'a Document<'a>,
    folder: &'a Folder,
    known: Vec<Option<Optics>>,
    images: Vec<Option<Result<Mean, String>>>,
    findings: Vec<Finding>,
    roll: Roll,
}

/// A material before vertex colours.
#[derive(Clone)]
struct Optics {
    name: String,
    reflectance: [f64; 3],
    emission: [f64; 3],
    two_sided: bool,
}

impl<'a> Materials<'a> {
    pub fn new(document: &'a Document<'a>, folder: &'a Folder) -> Self {
        Self {
            document,
            folder,
            known: vec![None; document.root.materials.len()],
            images: vec![None; document.root.images.len()],
            findings: Vec::new(),
            roll: Roll::default(),
        }
    }

    /// The material of a primitive, vertex colours included.
    pub fn of(&mut self, primitive: &Primitive) -> Result<Material, SceneError> {
        let optics = match primitive.material {
            Some(index) => self.optics(index)?,
            None => self.without_material(),
        };
        let tinted = times(optics.reflectance, primitive.colour.unwrap_or([1.0; 3]));
        let reflectance = colour::limited(tinted, &optics.name, &mut self.roll);
        let material = Material::new(optics.name, &reflectance, &optics.emission);
        Ok(Material { two_sided: optics.two_sided, ..material })
    }

    pub fn into_findings(mut self) -> Vec<Finding> {
        self.findings.extend(self.roll.into_findings());
        self.findings
    }

    /// glTF's default is a white metal, which reflects nothing diffusely: surely not what was meant.
    fn without_material(&mut self) -> Optics {
        let message = "surfaces without material were given reflectance 0.5; assign one";
        self.roll.warn("no-material", "material", "none", message);
        Optics { name: "none".into(), reflectance: [UNKNOWN_REFLECTANCE; 3], emission: [0.0; 3], two_sided: false }
    }

    fn optics(&mut self, index: usize) -> Result<Optics, SceneError> {
        let Some(slot) = self.known.get(index) else {
            let message = "it does not exist; export the file again";
            return Err(self.document.fail(format!("material {index}"), message));
        };
        if let Some(known) = slot {
            return Ok(known.clone());
        }
        let optics = self.read(index)?;
        self.known[index] = Some(optics.clone());
        Ok(optics)
    }

    fn read(&mut self, index: usize) -> Result<Optics, SceneError> {
        let root = self.document.root;
        let source = &root.materials[index];
        let name = source.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("material {index}"));
        self.note_transparency(source, &name);
        let reflectance = self.reflectance(source, &name)?;
        let emission = self.emission(source, &name)?;
        Ok(Optics { name, reflectance, emission, two_sided: source.double_sided })
    }

    fn fail(&self, name: &str, message: impl Into<String>) -> SceneError {
        self.document.fail(format!("material '{name}'"), message)
    }

    fn note_transparency(&mut self, source: &json::Material, name: &str) {
        let transmission = source.extensions.as_ref().and_then(|extensions| extensions.transmission.as_ref());
        let transmits = transmission.is_some_and(|transmission| transmission.transmission_factor.0 > 0.0);
        if transmits || source.alpha_mode != Checked::Valid(AlphaMode::Opaque) {
            let message = "transparency is not modelled and they were read as opaque and diffuse; remove panes that \
                           should let light through";
            self.roll.warn("transparent-material", "material", name, message);
        }
    }

    fn reflectance(&mut self, source: &json::Material, name: &str) -> Result<[f64; 3], SceneError> {
        let glossy = source.extensions.as_ref().and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
        if let Some(glossy) = glossy {
            let factor = rgb(glossy.diffuse_factor.0);
            return self.diffuse(factor, glossy.diffuse_texture.as_ref(), name);
        }
        let pbr = &source.pbr_metallic_roughness;
        let base = self.diffuse(rgb(pbr.base_color_factor.0), pbr.base_color_texture.as_ref(), name)?;
        let metallic = self.metallic(pbr, name)?;
        Ok(base.map(|c| c * (1.0 - metallic)))
    }

    fn diffuse(
        &mut self,
        factor: [f64; 3],
        texture: Option<&texture::Info>,
        name: &str,
    ) -> Result<[f64; 3], SceneError> {
        if !colour::is_fraction(factor) {
            return Err(self.fail(name, format!("its base colour {factor:?} must lie within 0 and 1; correct it")));
        }
        let texture = texture.map(|info| self.mean(info, name, "base colour", UNKNOWN_REFLECTANCE));
        Ok(texture.map_or(factor, |mean| times(factor, mean.colour)))
    }

    /// How metallic it is on average; the texture keeps it in its blue channel.
    fn metallic(&mut self, pbr: &json::material::PbrMetallicRoughness, name: &str) -> Result<f64, SceneError> {
        let factor = f64::from(pbr.metallic_factor.0);
        if !colour::is_fraction([factor; 3]) {
            return Err(self.fail(name, format!("its metallic factor {factor} must lie within 0 and 1; correct it")));
        }
        let texture = pbr.metallic_roughness_texture.as_ref().filter(|_| factor > 0.0);
        let metallic = factor * texture.map_or(1.0, |info| self.mean(info, name, "metalness", 0.0).data[2]);
        // One level of an 8-bit texture is noise.
        if metallic > 1.0 / 255.0 {
            let message = "mirror reflection is not modelled, and of metals only base colour x (1 - metallic) is left; \
                           set metallic to 0, for glTF's default is 1";
            self.roll.warn("metallic-material", "material", name, message);
        }
        Ok(metallic)
    }

    /// Exitance.
    fn emission(&mut self, source: &json::Material, name: &str) -> Result<[f64; 3], SceneError> {
        let factor = source.emissive_factor.0.map(f64::from);
        let strength = source.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| f64::from(strength.emissive_strength.0));
        let radiance = factor.map(|c| c * strength);
        if !colour::is_power(radiance) {
            return Err(
                self.fail(name, format!("its emission {radiance:?} must be finite and not negative; correct it"))
            );
        }
        let dark = radiance == [0.0; 3];
        let texture = source.emissive_texture.as_ref().filter(|_| !dark);
        let texture = texture.map(|info| self.mean(info, name, "emission", 1.0));
        Ok(colour::exitance(texture.map_or(radiance, |mean| times(radiance, mean.colour))))
    }

    /// The mean of a texture, or `otherwise` and a finding if it cannot be read.
    fn mean(&mut self, info: &texture::Info, material: &str, what: &str, otherwise: f64) -> Mean {
        self.image_of(info).unwrap_or_else(|fault| {
            self.findings.push(Finding::warning(
                "unreadable-texture",
                format!("material '{material}', {what} texture"),
                format!("{fault}; {otherwise} was taken for it; supply it as PNG or JPEG next to the scene"),
            ));
            Mean { colour: [otherwise; 3], data: [otherwise; 3] }
        })
    }

    fn image_of(&mut self, info: &texture::Info) -> Result<Mean, String> {
        let root = self.document.root;
        let texture = root.get(info.index).ok_or(format!("texture {} does not exist", info.index.value()))?;
        let index = texture.source.value();
        let image = root.images.get(index).ok_or("it has no image in a format that is read")?;
        if let Some(Some(known)) = self.images.get(index) {
            return known.clone();
        }
        let label = image.uri.as_deref().map_or_else(|| format!("image {index}"), abbreviated);
        let result = self.decode(image).map_err(|fault| format!("{label} cannot be read ({fault})"));
        self.images[index] = Some(result.clone());
        result
    }

    fn decode(&self, image: &json::Image) -> Result<Mean, String> {
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => mean(&self.folder.read_uri(uri, MAX_IMAGE_BYTES)?),
            (None, Some(view)) => mean(self.document.view(view)?.0),
            (None, None) => Err("it has no data".into()),
        }
    }
}

fn rgb([r, g, b, _]: [f32; 4]) -> [f64; 3] {
    [r, g, b].map(f64::from)
}
