//! What paths need to know of a scene.

use glam::DVec3;
use radiosity_exchange::Enclosure;
use radiosity_geometry::texture::{TexturedPatches, Values};

use crate::exitance::Exitance;
use crate::gloss::Gloss;
use crate::lamps::Lamps;
use crate::lights::{Light, Lights};
use crate::scatter::Reflectance;

/// A scene as paths see it, and how they end.
pub struct Tracer<'a> {
    pub(crate) enclosure: &'a Enclosure,
    pub(crate) bands: usize,
    pub(crate) exitance: Exitance,
    pub(crate) lamps: Lamps,
    pub(crate) lights: Lights,
    /// None in a gather.
    pub(crate) reflectance: Option<Reflectance>,
    pub(crate) seed: u64,
    /// Of sides; none where there are none.
    textures: Option<TexturedPatches>,
    /// Of sides, in pictures; none where no side is a rough metal.
    gloss: Option<Gloss>,
}

/// Where a path begins, and what its random numbers are keyed by.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Just off a surface, or in the open.
    pub point: DVec3,
    /// The unit vector that the hemisphere of what arrives is about.
    pub normal: DVec3,
    /// Of the pixel, patch or point that the path is for.
    pub key: u32,
    /// Of the path among all for it in this round.
    pub index: u32,
}

/// A point on a lamp as a point of a surface sees it.
#[derive(Clone, Copy, Debug)]
pub struct LampSight {
    /// The side that it is on.
    pub side: usize,
    /// Toward it, a unit vector.
    pub direction: DVec3,
    /// What of its light panes on the way let through.
    pub left: f64,
    /// Of the directions in which lamps are drawn, per sr.
    pub density: f64,
}

impl<'a> Tracer<'a> {
    /// A gather: paths end where they first land and take what leaves there, which somebody has solved for.
    ///
    /// # Panics
    /// If values do not fit the sides or lights the bands.
    pub fn gather(enclosure: &'a Enclosure, bands: usize, radiosity: Exitance, lights: Vec<Light>, seed: u64) -> Self {
        Self::new(enclosure, bands, radiosity, lights, None, seed)
    }

    /// A path tracer: paths take what sides emit, and go on until nothing is left. `reflectance` is sides x bands, what
    /// is reflected diffusely of all that meets a side, whatever of it mirrors and panes send on.
    ///
    /// # Panics
    /// If values do not fit the sides or lights the bands, or a reflectance is not in [0, 1]. Of 1 a ten-millionth is
    /// taken off: else paths need not end.
    pub fn paths(
        enclosure: &'a Enclosure,
        bands: usize,
        emission: Exitance,
        mut reflectance: Vec<f32>,
        lights: Vec<Light>,
        seed: u64,
    ) -> Self {
        assert_eq!(reflectance.len(), enclosure.sides() * bands, "one reflectance per side and band");
        assert!(reflectance.iter().all(|r| (0.0..=1.0).contains(r)), "reflectances lie in [0, 1]");
        reflectance.iter_mut().for_each(|r| *r = r.min(1.0 - f32::EPSILON));
        Self::new(enclosure, bands, emission, lights, Some(Reflectance::new(reflectance, bands)), seed)
    }

    /// The same path tracer where light passes through sides diffusely: `transmittance`, sides x bands, is what of all
    /// that meets a side leaves the other side of its patch. A gather stays as it is, since what a solution says leaves a
    /// side has it.
    ///
    /// # Panics
    /// If it does not fit the sides and bands, is not in [0, 1] together with the reflectance, or is that of a one-sided
    /// patch.
    pub fn with_diffuse_transmittance(mut self, transmittance: Vec<f32>) -> Self {
        let Some(reflectance) = self.reflectance.take() else { return self };
        let count = self.enclosure.sides() * self.bands;
        assert_eq!(transmittance.len(), count, "one transmittance per side and band");
        let is_part = |k: usize| {
            (0.0..=1.0).contains(&transmittance[k]) && transmittance[k] + reflectance.values()[k] <= 1.0 + f32::EPSILON
        };
        assert!((0..count).all(is_part), "transmittances lie in [0, 1] together with reflectances");
        let has_way = |k: usize| transmittance[k] == 0.0 || self.enclosure.opposite(k / self.bands).is_some();
        assert!((0..count).all(has_way), "light passes to the other side of two-sided patches");
        self.reflectance = Some(reflectance.with_transmittance(transmittance));
        self
    }

    fn new(
        enclosure: &'a Enclosure,
        bands: usize,
        exitance: Exitance,
        lights: Vec<Light>,
        reflectance: Option<Reflectance>,
        seed: u64,
    ) -> Self {
        let (count, each) = exitance.len();
        assert_eq!(count, enclosure.sides() * each * bands, "values fit the sides and bands");
        assert!(lights.iter().all(|light| light.strength.len() == bands), "one strength per band");
        let lamps = Lamps::new(enclosure, &exitance, bands);
        Self {
            enclosure,
            bands,
            exitance,
            lamps,
            lights: Lights::new(enclosure, lights),
            reflectance,
            seed,
            textures: None,
            gloss: None,
        }
    }

    /// The same where some sides have textures, which stand for their reflectance: of paths at every bounce, and of what is
    /// seen of them.
    ///
    /// # Panics
    /// If they do not fit the sides.
    pub fn with_textures(self, textures: Option<TexturedPatches>) -> Self {
        assert!(textures.as_ref().is_none_or(|of| of.len() == self.enclosure.sides()), "textures fit the sides");
        Self { textures: textures.filter(TexturedPatches::any), ..self }
    }

    /// The same where some sides are rough metals, for those who make pictures: paths take all for diffuse.
    ///
    /// # Panics
    /// If it does not fit the sides.
    pub fn with_gloss(self, gloss: Option<Gloss>) -> Self {
        let sides = self.enclosure.sides();
        let fits = |gloss: &Gloss| gloss.metallic.len() == sides && gloss.roughness.len() == sides;
        assert!(gloss.as_ref().is_none_or(fits), "gloss fits the sides");
        Self { gloss, ..self }
    }

    /// What of the reflectance of a side is of a rough metal, if any, and how rough it is.
    #[inline]
    pub fn gloss_of(&self, side: usize) -> Option<(f64, f64)> {
        self.gloss.as_ref()?.of(side)
    }

    /// Visits all lights without area, and their images in mirrors, that reach a point just off a surface: the direction
    /// toward each, what its strength weighs in the irradiance there, and its strength.
    pub fn lights_at(&self, point: DVec3, normal: DVec3, mut visit: impl FnMut(DVec3, f64, &[f32])) {
        for seen in self.lights.all(self.enclosure, point, normal) {
            let left = match self.enclosure.specular() {
                None if self.enclosure.bvh().occluded(&seen.ray) => 0.0,
                None => 1.0,
                Some(specular) => self.lights.passage(self.enclosure, specular, point, seen.place),
            };
            if left > 0.0 {
                let direction = seen.ray.direction.as_dvec3().normalize();
                visit(direction, left * f64::from(seen.weight), self.lights.strength(seen.place));
            }
        }
    }

    /// A point on a lamp for three numbers in (0, 1), as it is seen from a point just off a surface; none if nothing of it
    /// is.
    pub fn lamp_at(&self, point: DVec3, normal: DVec3, [choice, u, v]: [f64; 3]) -> Option<LampSight> {
        let (enclosure, importance) = (self.enclosure, self.lamps.importance(point, normal));
        let (side, density) = self.lamps.side(point, normal, importance, choice)?;
        let there = enclosure.point_off(side, u, v);
        let (direction, distance) = ((there - point).normalize_or_zero(), there.distance(point));
        let cosine = -enclosure.normal(side).dot(direction);
        if cosine <= 0.0 || normal.dot(direction) <= 0.0 {
            return None;
        }
        let left = match enclosure.specular() {
            None if enclosure.bvh().occluded(&enclosure.segment(point, there)) => 0.0,
            None => 1.0,
            Some(specular) => enclosure.passage(specular, point, &[there], &[], false),
        };
        let density = density * distance * distance / cosine;
        (left > 0.0).then_some(LampSight { side, direction, left, density })
    }

    /// The density per sr with which [`Tracer::lamp_at`] draws a direction in which a side is met at a distance; zero
    /// unless it is a lamp.
    pub fn lamp_density(&self, point: DVec3, normal: DVec3, (side, direction, distance): (usize, DVec3, f64)) -> f64 {
        let cosine = -self.enclosure.normal(side).dot(direction);
        let density = self.lamps.density(point, normal, side);
        if cosine > 0.0 { density * distance * distance / cosine } else { 0.0 }
    }

    /// The texture at a point of a side, if it has one.
    #[inline]
    pub fn texture_at(&self, side: usize, point: DVec3) -> Option<Values<'_>> {
        self.textures.as_ref()?.at(side, point)
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The patches as rays see them.
    pub fn enclosure(&self) -> &Enclosure {
        self.enclosure
    }

    /// What the sequences of random numbers are keyed by.
    pub fn seed(&self) -> u64 {
        self.seed
    }
}
