//! Materials: what is diffuse of them, to either side, and of smooth ones what is a mirror or clear.

use ::gltf::json;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::texture;
use ::gltf::json::validation::Checked;

use super::buffers::Document;
use super::geometry::Primitive;
use super::textures::{self, Images, Painted};
use crate::formats::colour::{self, UNKNOWN_REFLECTANCE, times};
use crate::formats::folder::Folder;
use crate::formats::names::Roll;
use crate::formats::texture::{Mean, NO_ROOM};
use crate::model::{Finding, Gloss, Material, SceneError, Texture};

/// The materials of a file, each read when first met.
pub(super) struct Materials<'a> {
    document: &'a Document<'a>,
    known: Vec<Option<Optics>>,
    images: Images<'a>,
    findings: Vec<Finding>,
    roll: Roll,
}

/// A material before vertex colours.
#[derive(Clone)]
struct Optics {
    name: String,
    reflectance: [f64; 3],
    /// What goes on as from a mirror.
    mirrored: [f64; 3],
    /// What goes on straight.
    passed: [f64; 3],
    emission: [f64; 3],
    two_sided: bool,
    /// What leaves the other side diffusely.
    diffused: [f64; 3],
    /// The image that goes with the diffuse reflectance in place of its mean.
    painted: Option<Painted>,
    gloss: Gloss,
}

/// What is reflected diffusely, as from a mirror, let through, and let through diffusely.
struct Parts {
    reflectance: [f64; 3],
    mirrored: [f64; 3],
    passed: [f64; 3],
    diffused: [f64; 3],
    painted: Option<Painted>,
    gloss: Gloss,
}

/// The greatest roughness of mirrors and clear glass: its square, the width of the lobe (Walter et al. 2007), is then
/// 0.01, half a degree or so, and what is seen in it is seen sharply from most of a room.
const SMOOTH: f64 = 0.1_f32 as f64; // files are read in single precision

/// One level of an 8-bit texture is noise.
const NOISE: f64 = 1.0 / 255.0;

impl<'a> Materials<'a> {
    pub fn new(document: &'a Document<'a>, folder: &'a Folder) -> Self {
        Self {
            document,
            known: vec![None; document.root.materials.len()],
            images: Images::new(document, folder),
            findings: Vec::new(),
            roll: Roll::default(),
        }
    }

    /// The material of a primitive, vertex colours included, and its texture.
    pub fn of(&mut self, primitive: &Primitive) -> Result<(Material, Option<Texture>), SceneError> {
        let optics = match primitive.material {
            Some(index) => self.optics(index)?,
            None => self.without_material(),
        };
        let tint = primitive.colour.unwrap_or([1.0; 3]);
        let (reflectance, texture) = match self.laid(&optics, primitive) {
            Some((painted, coordinates)) => {
                let factor = times(painted.factor, tint);
                let (reflectance, is_limited) =
                    colour::limited_with(factor, painted.brightest, &optics.name, &mut self.roll);
                (reflectance, Some(Texture { image: self.images.wrapped(painted, is_limited), coordinates }))
            }
            None => (colour::limited(times(optics.reflectance, tint), &optics.name, &mut self.roll), None),
        };
        let specular = self.grey(times(optics.mirrored, tint), &optics.name);
        let transmittance = self.grey(times(optics.passed, tint), &optics.name);
        let diffused = colour::limited(times(optics.diffused, tint), &optics.name, &mut self.roll);
        let material =
            Material::new(optics.name, &reflectance, &optics.emission).with_specular(specular, transmittance);
        let material = Material { two_sided: optics.two_sided, gloss: optics.gloss, ..material };
        let is_translucent = diffused != [0.0; 3];
        let material = if is_translucent { material.with_diffuse_transmittance(&diffused) } else { material };
        Ok((self.limited(material), texture))
    }

    /// The image of a material and where the vertices of a primitive are on it.
    fn laid<'b>(&mut self, optics: &'b Optics, primitive: &Primitive) -> Option<(&'b Painted, Vec<[f64; 2]>)> {
        let painted = optics.painted.as_ref()?;
        let found = primitive.coordinates.as_ref().and_then(|coordinates| painted.transformed(coordinates));
        if found.is_none() {
            let message = "surfaces have no sound texture coordinates for its base colour, and the mean of the image was \
                           taken; export them along with the mesh";
            self.roll.warn("no-texture-coordinates", "material", &optics.name, message);
        }
        found.map(|coordinates| (painted, coordinates))
    }

    /// Mirrors and glass have one value for all bands.
    fn grey(&mut self, colour: [f64; 3], name: &str) -> f64 {
        if colour::is_coloured(colour) {
            let message = "its mirror reflectance or transmittance is coloured, and mirrors and glass are grey here; the \
                           luminance was taken";
            self.roll.note("coloured-mirror", "material", name, message);
        }
        colour::luminance(colour).clamp(0.0, 1.0)
    }

    /// The same, with something left to absorb unless it is nothing but mirror and glass.
    fn limited(&mut self, material: Material) -> Material {
        let diffuse = (0..material.reflectance.len()).map(|band| material.scattered(band)).fold(0.0, f64::max);
        let going_on = material.specular + material.transmittance;
        let is_ideal = diffuse == 0.0 && !material.emits() && going_on <= 1.0;
        if is_ideal || diffuse + going_on <= colour::MAX_REFLECTANCE {
            return material;
        }
        let message = "what it reflects, mirrors and lets through was limited to 0.95 together; darken its base colour";
        self.roll.note("mirror-limited", "material", &material.name, message);
        let share = colour::MAX_REFLECTANCE / (diffuse + going_on);
        let scaled = |spectrum: &[f64]| spectrum.iter().map(|part| share * part).collect();
        let reflectance = scaled(&material.reflectance);
        let diffuse_transmittance = scaled(&material.diffuse_transmittance);
        let (specular, transmittance) = (share * material.specular, share * material.transmittance);
        Material { reflectance, specular, transmittance, diffuse_transmittance, ..material }
    }

    pub fn into_findings(mut self) -> Vec<Finding> {
        self.findings.extend(self.roll.into_findings());
        self.findings
    }

    /// glTF's default is a white metal, which reflects nothing diffusely: surely not what was meant.
    fn without_material(&mut self) -> Optics {
        let message = "surfaces without material were given reflectance 0.5; assign one";
        self.roll.warn("no-material", "material", "none", message);
        Optics {
            name: "none".into(),
            reflectance: [UNKNOWN_REFLECTANCE; 3],
            mirrored: [0.0; 3],
            passed: [0.0; 3],
            emission: [0.0; 3],
            two_sided: false,
            diffused: [0.0; 3],
            painted: None,
            gloss: Gloss::default(),
        }
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
        let Parts { reflectance, mirrored, passed, diffused, painted, gloss } = self.parts(source, &name)?;
        let emission = self.emission(source, &name)?;
        let two_sided = source.double_sided;
        Ok(Optics { name, reflectance, mirrored, passed, emission, two_sided, diffused, painted, gloss })
    }

    fn fail(&self, name: &str, message: impl Into<String>) -> SceneError {
        self.document.fail(format!("material '{name}'"), message)
    }

    fn warn_of_transparency(&mut self, name: &str) {
        let message = "of transparency only transmission is modelled, of roughness up to 0.1, and they were read as opaque \
                       and diffuse; remove panes that should let light through, or give them that";
        self.roll.warn("transparent-material", "material", name, message);
    }

    fn parts(&mut self, source: &json::Material, name: &str) -> Result<Parts, SceneError> {
        let blends = source.alpha_mode != Checked::Valid(AlphaMode::Opaque);
        let wanted = self.transmission(source, name)?;
        let glossy = source.extensions.as_ref().and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
        if let Some(glossy) = glossy {
            if blends || wanted > 0.0 {
                self.warn_of_transparency(name);
            }
            let (reflectance, painted) = self.diffuse(rgb(glossy.diffuse_factor.0), source, name)?;
            let (diffused, gloss) = ([0.0; 3], Gloss::default());
            return Ok(Parts { reflectance, mirrored: [0.0; 3], passed: [0.0; 3], diffused, painted, gloss });
        }
        let pbr = &source.pbr_metallic_roughness;
        let (base, painted) = self.diffuse(rgb(pbr.base_color_factor.0), source, name)?;
        let metallic = self.metallic(pbr, name)?;
        let asks = metallic > NOISE || wanted > NOISE;
        let roughness = if asks { self.roughness(pbr, name)? } else { 1.0 };
        let is_smooth = asks && roughness <= SMOOTH;
        let mut gloss = Gloss::default();
        if metallic > NOISE && !is_smooth {
            gloss = Gloss { metallic: metallic.clamp(0.0, 1.0), roughness: roughness.clamp(0.0, 1.0) };
            let message = "metals rougher than 0.1 are diffuse in the solve, and their gloss shows where pictures of mode \
                           gather or path look at them; set metallic to 0 if paint is meant, for glTF's default is 1";
            self.roll.note("metallic-material", "material", name, message);
        }
        if blends || (wanted > NOISE && !is_smooth) {
            self.warn_of_transparency(name);
        }
        let (mirrors, passes) = if is_smooth { (metallic, wanted) } else { (0.0, 0.0) };
        let diffuse = if gloss.metallic > 0.0 { 1.0 } else { (1.0 - metallic) * (1.0 - passes) };
        // No light passes through metal.
        let (share, colour) = self.diffuse_transmission(source, name)?;
        let share = share * (1.0 - gloss.metallic);
        let part = |share: f64| base.map(|c| c * share);
        let diffused = colour.map(|c| c * share * diffuse);
        let (mirrored, passed) = (part(mirrors), part((1.0 - metallic) * passes));
        let back = diffuse * (1.0 - share);
        let painted = painted.filter(|_| back > 0.0).map(|painted| painted.dimmed(back));
        Ok(Parts { reflectance: part(back), mirrored, passed, diffused, painted, gloss })
    }

    /// The share of what is diffuse that leaves the other side, and its colour; the texture of the one keeps it in its
    /// alpha channel.
    fn diffuse_transmission(&mut self, source: &json::Material, name: &str) -> Result<(f64, [f64; 3]), SceneError> {
        let others = source.extensions.as_ref().map(|extensions| &extensions.others);
        let Some(value) = others.and_then(|others| others.get("KHR_materials_diffuse_transmission")) else {
            return Ok((0.0, [1.0; 3]));
        };
        let extension: DiffuseTransmission = serde_json::from_value(value.clone()).map_err(|fault| {
            self.fail(name, format!("its KHR_materials_diffuse_transmission is malformed: {fault}"))
        })?;
        let factor = self.fraction(extension.factor, "diffuse transmission factor", name)?;
        if factor == 0.0 {
            return Ok((0.0, [1.0; 3]));
        }
        let what = "diffuse transmission";
        let share = extension.texture.map_or(1.0, |info| self.mean(&info, name, what, 0.0).alpha);
        let tint = extension.colour.map(f64::from);
        if !colour::is_fraction(tint) {
            return Err(self.fail(name, format!("its {what} colour {tint:?} must lie within 0 and 1; correct it")));
        }
        let texture = extension.colour_texture;
        let mean =
            texture.map(|info| self.mean(&info, name, "diffuse transmission colour", UNKNOWN_REFLECTANCE).colour);
        Ok((factor * share, mean.map_or(tint, |mean| times(tint, mean))))
    }

    /// The share of light that enters and passes; the texture keeps it in its red channel.
    fn transmission(&mut self, source: &json::Material, name: &str) -> Result<f64, SceneError> {
        let extension = source.extensions.as_ref().and_then(|extensions| extensions.transmission.as_ref());
        let Some(extension) = extension else { return Ok(0.0) };
        let factor = self.fraction(extension.transmission_factor.0, "transmission factor", name)?;
        let texture = extension.transmission_texture.as_ref().filter(|_| factor > 0.0);
        Ok(factor * texture.map_or(1.0, |info| self.mean(info, name, "transmission", 0.0).data[0]))
    }

    /// How rough it is on average; the texture keeps it in its green channel.
    fn roughness(&mut self, pbr: &json::material::PbrMetallicRoughness, name: &str) -> Result<f64, SceneError> {
        let factor = self.fraction(pbr.roughness_factor.0, "roughness factor", name)?;
        let texture = pbr.metallic_roughness_texture.as_ref().filter(|_| factor > 0.0);
        Ok(factor * texture.map_or(1.0, |info| self.mean(info, name, "roughness", 1.0).data[1]))
    }

    fn fraction(&self, factor: f32, what: &str, name: &str) -> Result<f64, SceneError> {
        let factor = f64::from(factor);
        if colour::is_fraction([factor; 3]) {
            Ok(factor)
        } else {
            Err(self.fail(name, format!("its {what} {factor} must lie within 0 and 1; correct it")))
        }
    }

    /// The mean of the base colour, and its image if there is one.
    fn diffuse(
        &mut self,
        factor: [f64; 3],
        source: &json::Material,
        name: &str,
    ) -> Result<([f64; 3], Option<Painted>), SceneError> {
        if !colour::is_fraction(factor) {
            return Err(self.fail(name, format!("its base colour {factor:?} must lie within 0 and 1; correct it")));
        }
        let Some(info) = textures::of_base_colour(source).filter(|_| factor != [0.0; 3]) else {
            return Ok((factor, None));
        };
        match self.images.painted(info, factor) {
            Ok((mean, painted)) => {
                if painted.is_none() {
                    let element = format!("material '{name}', base colour texture");
                    self.findings.push(Finding::warning("texture-averaged", element, NO_ROOM));
                }
                Ok((times(factor, mean), painted))
            }
            Err(fault) => {
                self.cannot_read(&fault, name, "base colour", UNKNOWN_REFLECTANCE);
                Ok((times(factor, [UNKNOWN_REFLECTANCE; 3]), None))
            }
        }
    }

    /// How metallic it is on average; the texture keeps it in its blue channel.
    fn metallic(&mut self, pbr: &json::material::PbrMetallicRoughness, name: &str) -> Result<f64, SceneError> {
        let factor = self.fraction(pbr.metallic_factor.0, "metallic factor", name)?;
        let texture = pbr.metallic_roughness_texture.as_ref().filter(|_| factor > 0.0);
        Ok(factor * texture.map_or(1.0, |info| self.mean(info, name, "metalness", 0.0).data[2]))
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
        self.images.mean(info).unwrap_or_else(|fault| {
            self.cannot_read(&fault, material, what, otherwise);
            Mean { colour: [otherwise; 3], data: [otherwise; 3], alpha: otherwise }
        })
    }

    fn cannot_read(&mut self, fault: &str, material: &str, what: &str, otherwise: f64) {
        self.findings.push(Finding::warning(
            "unreadable-texture",
            format!("material '{material}', {what} texture"),
            format!("{fault}; {otherwise} was taken for it; supply it as PNG or JPEG next to the scene"),
        ));
    }
}

/// The extension KHR_materials_diffuse_transmission.
#[derive(serde::Deserialize)]
#[serde(default)]
struct DiffuseTransmission {
    #[serde(rename = "diffuseTransmissionFactor")]
    factor: f32,
    #[serde(rename = "diffuseTransmissionTexture")]
    texture: Option<texture::Info>,
    #[serde(rename = "diffuseTransmissionColorFactor")]
    colour: [f32; 3],
    #[serde(rename = "diffuseTransmissionColorTexture")]
    colour_texture: Option<texture::Info>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self { factor: 0.0, texture: None, colour: [1.0; 3], colour_texture: None }
    }
}

fn rgb([r, g, b, _]: [f32; 4]) -> [f64; 3] {
    [r, g, b].map(f64::from)
}
