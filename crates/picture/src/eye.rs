//! What a camera sees: the points that its rays show, and what they show of the light there.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec3, Vec3};
use radiosity_exchange::Enclosure;
use radiosity_exchange::enclosure::Sight;
use radiosity_exchange::images::survival;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_paths::{Tracer, Way};
use radiosity_scene::Camera;

use crate::beyond::{Beyond, Shown};
use crate::metals::{Choice, Metal};
use crate::render::side_of;
use crate::view::{Frame, Visible};

/// What surfaces show of what arrives: sides x bands each. Textures, which the tracer knows, stand for the reflectance of
/// the sides that have them.
#[derive(Clone, Copy, Debug)]
pub enum Surfaces<'a> {
    /// Radiance, W/(m2 sr).
    Radiance {
        /// Radiant exitance, W/m2.
        emission: &'a [f32],
        /// Diffuse reflectance.
        reflectance: &'a [f32],
        /// Diffuse transmittance to the other side; empty where nothing passes.
        transmittance: &'a [f32],
    },
    /// Irradiance, W/m2.
    Irradiance,
}

/// A camera before a scene.
pub(crate) struct Eye<'a> {
    tracer: &'a Tracer<'a>,
    enclosure: &'a Enclosure,
    bands: usize,
    surfaces: Surfaces<'a>,
    visible: Visible,
    /// If mirrors and panes show what is beyond.
    beyond: Option<Beyond<'a>>,
    frame: Frame,
}

/// A point that is seen, or that light passes through from to one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// What of it is seen, over the probability of that.
    pub weight: f32,
    /// The same of what is emitted there.
    glow: f32,
    /// The metal that shows it.
    tint: Option<Tint>,
    /// The way that the ray which shows it came along last.
    direction: Vec3,
    /// Whether it is on the other side of what is seen.
    pub is_across: bool,
    pub side: u32,
    /// Just off the side, metres.
    pub at: DVec3,
    /// What the corners of its patch count there.
    pub corners: [f32; 4],
}

/// A metal colours what it shows.
#[derive(Clone, Copy, Debug)]
struct Tint {
    side: u32,
    at: DVec3,
    way: Way,
}

/// What a random choice at a pixel is keyed by: its key, the number of the point, the round.
pub(crate) type Draw = ((u32, u32), u32);

/// The stream of the sequences that choose what is seen by metals in mirrors and through panes.
const SPECULAR_IN_METALS: u32 = 15;

impl<'a> Eye<'a> {
    /// A camera whose picture has so many pixels in a row and rows. With `culls_backs` the backs of one-sided patches let
    /// the view through; else they are black.
    ///
    /// # Panics
    /// If `surfaces` do not fit the sides and bands.
    pub fn new(
        tracer: &'a Tracer<'a>,
        surfaces: Surfaces<'a>,
        camera: &Camera,
        (width, height): (usize, usize),
        culls_backs: bool,
    ) -> Self {
        let (enclosure, bands) = (tracer.enclosure(), tracer.bands());
        if let Surfaces::Radiance { emission, reflectance, transmittance } = surfaces {
            let count = enclosure.sides() * bands;
            assert_eq!((emission.len(), reflectance.len()), (count, count), "values fit the sides and bands");
            assert!(transmittance.is_empty() || transmittance.len() == count, "values fit the sides and bands");
        }
        let beyond = enclosure.specular().map(|specular| Beyond { enclosure, specular, culls_backs });
        let is_glass = |patch: usize| beyond.is_some_and(|beyond| beyond.specular.transmittance(patch) > 0.0);
        Self {
            tracer,
            enclosure,
            bands,
            surfaces,
            visible: Visible::new(enclosure.patches(), camera.position, culls_backs, is_glass),
            beyond: beyond.filter(|_| matches!(surfaces, Surfaces::Radiance { .. })),
            frame: Frame::new(camera, width, height),
        }
    }

    /// The ray through a point of the picture, in pixels from its upper left corner.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        self.frame.ray(x, y)
    }

    /// What such rays meet.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.visible.bvh.closest_hits(rays, hits);
    }

    /// The point that a ray shows; numbers in (0, 1) choose its way by mirrors and panes.
    pub fn seen(&self, ray: &Ray, hit: &Hit, survival: impl Fn(u32) -> f64) -> Option<Point> {
        let facet = self.visible.facet(hit)?;
        let (patch, on) = (facet.patch as usize, facet.point(self.enclosure.patches(), hit));
        let first = side_of(self.enclosure, &facet).map(|side| {
            let point = self.enclosure.off(side, on);
            let direction = ray.direction.as_dvec3();
            Shown::Side { side, point, corners: facet.corner_weights(hit), direction }
        });
        let (weight, shown) = match self.beyond.filter(|beyond| beyond.is_of(patch)) {
            None => (1.0, first?),
            Some(beyond) => beyond.one((patch, first), (on, ray.direction), |side| self.is_dark(side), survival)?,
        };
        self.shown(weight, shown)
    }

    fn shown(&self, weight: f64, shown: Shown) -> Option<Point> {
        let Shown::Side { side, point, corners, direction } = shown else { return None };
        let (weight, corners) = (weight as f32, corners.map(|weight| weight as f32));
        let (side, direction) = (side as u32, direction.as_vec3());
        Some(Point { weight, glow: weight, tint: None, direction, is_across: false, side, at: point, corners })
    }

    /// What a point shows if it is of a rough metal: what paint shows, or what is seen by a facet, as it happens; the point
    /// itself elsewhere. What the metal emits and what lamps show in it is added to `glow`, one value a band.
    pub fn by_metal(&self, point: Point, draw: Draw, glow: &mut [f32]) -> Option<Point> {
        let Surfaces::Radiance { emission, .. } = self.surfaces else { return Some(point) };
        let (side, tracer) = (point.side as usize, self.tracer);
        let Some(metal) = Metal::new(tracer, side, point.at, point.direction.as_dvec3()) else { return Some(point) };
        let f0 = self.reflectance_at(point.side, point.at);
        let mut sums: Vec<f64> = self.emitted(&point).map(f64::from).collect();
        metal.add_highlights(tracer, &f0, f64::from(point.weight), &mut sums);
        let (number, round) = draw;
        if let Some((lamp, weight, way)) = metal.lamp(tracer, number, round) {
            let scale = f64::from(point.weight) * weight * FRAC_1_PI;
            for (band, (sum, &e)) in sums.iter_mut().zip(self.of_side(emission, lamp as u32)).enumerate() {
                *sum += scale * way.fresnel(f64::from(f0(band))) * f64::from(e);
            }
        }
        glow.iter_mut().zip(&sums).for_each(|(glow, &sum)| *glow += sum as f32);
        let tint = |way| Some(Tint { side: point.side, at: point.at, way });
        match metal.choose(tracer, number, round) {
            Choice::Paint => Some(Point { glow: 0.0, ..point }),
            Choice::Spread(way) => Some(Point { glow: 0.0, tint: tint(way), ..point }),
            Choice::Along(way) => {
                let sequence = Sequence::new(tracer.seed(), number.0, round, SPECULAR_IN_METALS);
                let there = self.seen_from(point.at, way.direction, |met| survival(&sequence, number.1, met))?;
                let weight = point.weight * there.weight;
                let glow = weight * metal.weight(tracer, &way, (there.side as usize, there.at)) as f32;
                Some(Point { weight, glow, tint: tint(way), ..there })
            }
        }
    }

    /// What a ray from a point of a surface shows.
    fn seen_from(&self, point: DVec3, direction: Vec3, survival: impl Fn(u32) -> f64) -> Option<Point> {
        let ray = self.enclosure.ray(point, direction);
        if let Some(beyond) = &self.beyond {
            let (weight, shown) = beyond.along(ray, |side| self.is_dark(side), survival)?;
            return self.shown(weight, shown);
        }
        let hit = self.enclosure.bvh().closest_hit(&ray);
        let Sight::Side(side, s, t) = self.enclosure.sight(ray.direction, &hit) else { return None };
        let side = side as usize;
        let (point, corners) = (self.enclosure.point_off(side, s, t), self.enclosure.corner_weights(side, s, t));
        self.shown(1.0, Shown::Side { side, point, corners, direction: direction.as_dvec3() })
    }

    /// What a metal leaves of each band of what it shows.
    fn tint(&self, point: &Point) -> impl Fn(usize) -> f32 {
        let of = point.tint.map(|tint| (tint.way, self.reflectance_at(tint.side, tint.at)));
        move |band| of.as_ref().map_or(1.0, |(way, f0)| way.fresnel(f64::from(f0(band))) as f32)
    }

    /// What a side reflects diffusely of each band at a point of it.
    fn reflectance_at(&self, side: u32, at: DVec3) -> impl Fn(usize) -> f32 {
        let own = match self.surfaces {
            Surfaces::Radiance { reflectance, .. } => self.of_side(reflectance, side),
            Surfaces::Irradiance => &[],
        };
        let texture = if own.is_empty() { None } else { self.tracer.texture_at(side as usize, at) };
        move |band| texture.map_or_else(|| own.get(band).copied().unwrap_or(1.0), |texture| texture.band(band))
    }

    /// Whether light passes through anything diffusely.
    pub fn is_translucent(&self) -> bool {
        !self.transmittance().is_empty()
    }

    /// The point on the other side of what is seen at one, if light passes through there.
    pub fn across(&self, point: &Point) -> Option<Point> {
        if !self.of_side(self.transmittance(), point.side).iter().any(|&tau| tau > 0.0) {
            return None;
        }
        let side = self.enclosure.opposite(point.side as usize)? as u32;
        Some(Point { is_across: true, side, at: self.enclosure.across(point.side as usize, point.at), ..*point })
    }

    fn transmittance(&self) -> &'a [f32] {
        match self.surfaces {
            Surfaces::Radiance { transmittance, .. } => transmittance,
            Surfaces::Irradiance => &[],
        }
    }

    /// The normal of what is seen at a point.
    pub fn normal(&self, point: &Point) -> DVec3 {
        self.enclosure.normal(point.side as usize)
    }

    /// What a point shows that is emitted there, per band.
    pub fn emitted(&self, point: &Point) -> impl Iterator<Item = f32> {
        let values = match self.surfaces {
            Surfaces::Radiance { emission, .. } if !point.is_across => self.of_side(emission, point.side),
            _ => &[],
        };
        let (scale, tint) = (point.glow * FRAC_1_PI as f32, self.tint(point));
        (0..self.bands).map(move |band| values.get(band).map_or(0.0, |e| scale * tint(band) * e))
    }

    /// What a point shows of a unit of irradiance there, per band.
    pub fn shares(&self, point: &Point) -> impl Iterator<Item = f32> {
        let scale = match self.surfaces {
            Surfaces::Irradiance => point.weight,
            Surfaces::Radiance { .. } => point.weight * FRAC_1_PI as f32,
        };
        // Of both sides of a patch the same passes.
        let passed = point.is_across.then(|| self.of_side(self.transmittance(), point.side));
        let (reflected, tint) = (self.reflectance_at(point.side, point.at), self.tint(point));
        (0..self.bands).map(move |band| scale * tint(band) * passed.map_or_else(|| reflected(band), |tau| tau[band]))
    }

    /// Whether a point shows anything of what arrives there.
    pub fn reflects(&self, point: &Point) -> bool {
        self.shares(point).any(|share| share > 0.0)
    }

    /// Whether a side neither emits nor reflects diffusely.
    fn is_dark(&self, side: usize) -> bool {
        match self.surfaces {
            Surfaces::Irradiance => false,
            Surfaces::Radiance { emission, reflectance, transmittance } => {
                let is_zero = |values| self.of_side(values, side as u32).iter().all(|&v| v == 0.0);
                is_zero(emission) && is_zero(reflectance) && is_zero(transmittance)
            }
        }
    }

    /// The values of a side; none where there are none of any.
    fn of_side<'b>(&self, values: &'b [f32], side: u32) -> &'b [f32] {
        values.get(side as usize * self.bands..).map_or(&[], |values| &values[..self.bands.min(values.len())])
    }
}
