//! What a camera sees: the points that its rays show, and what they show of the light there.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use radiosity_exchange::Enclosure;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_paths::Tracer;
use radiosity_scene::Camera;

use crate::beyond::{Beyond, Shown};
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
    /// Whether it is on the other side of what is seen.
    pub is_across: bool,
    pub side: u32,
    /// Just off the side, metres.
    pub at: DVec3,
    /// What the corners of its patch count there.
    pub corners: [f32; 4],
}

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
            Shown::Side { side, point, corners: facet.corner_weights(hit) }
        });
        let (weight, shown) = match self.beyond.filter(|beyond| beyond.is_of(patch)) {
            None => (1.0, first?),
            Some(beyond) => beyond.one((patch, first), (on, ray.direction), |side| self.is_dark(side), survival)?,
        };
        let Shown::Side { side, point, corners } = shown else { return None };
        let corners = corners.map(|weight| weight as f32);
        Some(Point { weight: weight as f32, is_across: false, side: side as u32, at: point, corners })
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
        let (scale, values) = match self.surfaces {
            Surfaces::Radiance { emission, .. } => {
                (point.weight * FRAC_1_PI as f32, self.of_side(emission, point.side))
            }
            Surfaces::Irradiance => (0.0, &[][..]),
        };
        (0..self.bands).map(move |band| values.get(band).map_or(0.0, |e| scale * e))
    }

    /// What a point shows of a unit of irradiance there, per band.
    pub fn shares(&self, point: &Point) -> impl Iterator<Item = f32> {
        let (scale, values, texture) = match self.surfaces {
            Surfaces::Irradiance => (point.weight, &[][..], None),
            // Of both sides of a patch the same passes.
            Surfaces::Radiance { transmittance, .. } if point.is_across => {
                (point.weight * FRAC_1_PI as f32, self.of_side(transmittance, point.side), None)
            }
            Surfaces::Radiance { reflectance, .. } => {
                let texture = self.tracer.texture_at(point.side as usize, point.at);
                (point.weight * FRAC_1_PI as f32, self.of_side(reflectance, point.side), texture)
            }
        };
        let own = move |band: usize| values.get(band).copied().unwrap_or(1.0);
        (0..self.bands).map(move |band| scale * texture.map_or_else(|| own(band), |texture| texture.band(band)))
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
