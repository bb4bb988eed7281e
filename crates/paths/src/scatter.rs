//! How light goes on from a point of a surface: the one place that knows what surfaces are made of.
//!
//! Of what meets a side, parts are scattered diffusely, back or to the other side, or absorbed, and mirrors and clear glass send parts on. Where a
//! ray lands is drawn with these parts for probabilities, and what leaves a side where one has landed counts over the
//! probability of that, as in the exchange (`radiosity_exchange::specular`).

use glam::{DVec3, Vec3};
use radiosity_exchange::enclosure::Sight;
use radiosity_exchange::specular::{MOST_MEETINGS, Step};
use radiosity_exchange::{Enclosure, Specular};
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::{Frame, cosine_hemisphere};
use radiosity_geometry::texture::Values;

/// Draws the direction that a path looks along next by two numbers in (0, 1), a unit vector.
///
/// Its density is that of the reflection, so that what the ray finds needs no further weight than the reflectance. All
/// that is scattered diffusely is also looked for on lamps, and weighed against that where the ray lands; what a mirror
/// shows only rays can find.
#[inline]
pub(crate) fn scatter(normal: DVec3, u: f64, v: f64) -> Vec3 {
    cosine_hemisphere(&Frame::new(normal), u, v)
}

/// Where a ray has landed.
pub(crate) struct Landed {
    /// Side and chart coordinates.
    pub on: (u32, f64, f64),
    /// The way it came along last, a unit vector.
    pub direction: DVec3,
    /// All its way, metres.
    pub distance: f64,
    /// The probability of landing there and not going on.
    pub share: f32,
    /// Whether a mirror was on the way, so that whoever looked for a lamp there in a straight line looked in vain.
    pub by_mirror: bool,
}

impl Landed {
    /// Where a ray that hit something lands; none if nowhere, or on a black back.
    #[inline]
    pub fn of(enclosure: &Enclosure, ray: &Ray, hit: &Hit) -> Option<Self> {
        let Sight::Side(side, s, t) = enclosure.sight(ray.direction, hit) else { return None };
        let (direction, distance) = (ray.direction.as_dvec3(), f64::from(hit.t));
        Some(Self { on: (side, s, t), direction, distance, share: 1.0, by_mirror: false })
    }

    /// The same where there are mirrors and panes: `survival` draws for each of them a number in (0, 1). Rays shot are
    /// added to `rays`.
    pub fn beyond(
        (enclosure, specular): (&Enclosure, &Specular),
        (mut ray, mut hit): (Ray, Hit),
        survival: impl Fn(u32) -> f64,
        rays: &mut u64,
    ) -> Option<Self> {
        let (mut distance, mut by_mirror) = (0.0, false);
        for met in 0..MOST_MEETINGS {
            distance += f64::from(hit.t);
            match enclosure.step(specular, &ray, &hit, || survival(met)) {
                Step::End(_) => {
                    let landed = Self::of(enclosure, &ray, &hit)?;
                    let share = enclosure.diffuse_share(landed.on.0 as usize) as f32;
                    return (share > 0.0).then_some(Self { distance, share, by_mirror, ..landed });
                }
                Step::On { ray: next, reflected } => {
                    by_mirror |= reflected;
                    ray = next;
                    hit = enclosure.bvh().closest_hit(&ray);
                    *rays += 1;
                }
            }
        }
        None
    }
}

/// Reflectance per side and band; none where paths end at the first side that they meet.
pub(crate) struct Reflectance {
    values: Vec<f32>,
    /// Diffuse transmittance, likewise; empty where nothing passes.
    through: Vec<f32>,
    bands: usize,
}

impl Reflectance {
    /// Sides x bands.
    pub fn new(values: Vec<f32>, bands: usize) -> Self {
        Self { values, through: Vec::new(), bands }
    }

    /// The same with diffuse transmittance, sides x bands.
    pub fn with_transmittance(self, through: Vec<f32>) -> Self {
        Self { through, ..self }
    }

    /// What is reflected, sides x bands.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Takes what a side absorbs out of a path, by the texture where it has landed if there is one; returns what is left
    /// in its best band, and whether the path goes on from the other side: by a number in (0, 1), in proportion to what
    /// goes either way in the best band.
    #[inline]
    pub fn filter(&self, side: u32, texture: Option<Values>, choice: f64, throughput: &mut [f32]) -> (f32, bool) {
        let of_side = |values: &[f32], band: usize| values[side as usize * self.bands + band];
        let reflected = |band| texture.map_or_else(|| of_side(&self.values, band), |values| values.band(band));
        let passed = |band| if self.through.is_empty() { 0.0 } else { of_side(&self.through, band) };
        let passing = best(passed, throughput);
        if passing == 0.0 {
            return (filter(reflected, 1.0, throughput), false);
        }
        let share = passing / (passing + best(reflected, throughput));
        if choice < f64::from(share) {
            (filter(passed, share, throughput), true)
        } else {
            (filter(reflected, 1.0 - share, throughput), false)
        }
    }
}

/// What of a path is left in its best band.
#[inline]
fn best(part: impl Fn(usize) -> f32, throughput: &[f32]) -> f32 {
    throughput.iter().enumerate().fold(0.0, |most: f32, (band, left)| most.max(left * part(band)))
}

/// Leaves a part of a path, for those that the choice of this part, of such a probability, stands for.
#[inline]
fn filter(part: impl Fn(usize) -> f32, probability: f32, throughput: &mut [f32]) -> f32 {
    throughput.iter_mut().enumerate().fold(0.0, |most: f32, (band, left)| {
        *left *= part(band) / probability;
        most.max(*left)
    })
}
