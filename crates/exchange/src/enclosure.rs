//! The patches as rays see them.
//!
//! Every patch has a front side, whose id is the patch's; a two-sided patch also has a back side, numbered after all
//! fronts. A side is what sends and receives. The back of a one-sided patch is opaque and black.

use crate::specular::Specular;
use glam::{DVec3, Vec3};
use radiosity_geometry::bvh::{Bvh, BvhParams, Hit, Ray};
use radiosity_geometry::corners::corner_weights;
use radiosity_geometry::sampling::Frame;
use radiosity_geometry::{Chart, Patches};
use std::sync::Arc;

/// No side: what stands where a patch has no back side.
const NO_SIDE: u32 = u32::MAX;

/// What a ray found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// Nothing.
    Escaped,
    /// The black back of a one-sided patch, or an obstruction.
    Back,
    /// A side, at chart coordinates of its patch.
    Side(u32, f64, f64),
}

/// What a ray found, but not where on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landing {
    /// Nothing.
    Escaped,
    /// The black back of a one-sided patch, or an obstruction.
    Back,
    /// A side.
    Side(u32),
}

/// Patches, their charts and the hierarchy that rays traverse.
pub struct Enclosure {
    patches: Arc<Patches>,
    charts: Vec<Chart>,
    /// Tangent frames of the front sides.
    frames: Vec<Frame>,
    bvh: Bvh,
    /// Triangle of the hierarchy -> patch * 2 + which half of its polygon. Obstructions are numbered after all patches.
    owner: Vec<u32>,
    back_side: Vec<u32>,
    side_patch: Vec<u32>,
    /// Coordinates are taken relative to the middle of the scene, where single precision is finest.
    middle: DVec3,
    /// How far single precision may move a point of the scene, metres.
    margin: f64,
    /// Per patch: the factor toward the centroid that keeps a point off the edges by the margin.
    inset: Vec<f64>,
    /// Mirrors and clear glass, if there are any.
    specular: Option<Specular>,
}

/// Rounding of a vertex, of an origin and of their difference, each half a unit in the last place, with a factor of
/// two in hand: how far off its plane the end of a single-precision ray can be, relative to the largest coordinate
/// that the ray starts from, which may be any in the scene.
const PLANE_ROUNDING: f64 = 3.0 * f32::EPSILON as f64;

impl Enclosure {
    /// Builds the hierarchy over all patches and obstructions. Patches without area are never hit and send nothing.
    pub fn new(patches: impl Into<Arc<Patches>>) -> Self {
        let patches: Arc<Patches> = patches.into();
        let (low, high) = bounds(&patches);
        let middle = 0.5 * (low + high);
        let single = |p: DVec3| (p - middle).as_vec3();
        let (mut triangles, mut owner) = (Vec::with_capacity(2 * patches.len()), Vec::with_capacity(2 * patches.len()));
        for (i, polygon) in patches.polygons.iter().chain(&patches.obstructions).enumerate() {
            let [a, b, c, d] = polygon.map(single);
            triangles.push([a, b, c]);
            owner.push(2 * i as u32);
            if polygon[2] != polygon[3] {
                triangles.push([a, c, d]);
                owner.push(2 * i as u32 + 1);
            }
        }
        let (mut back_side, mut side_patch) =
            (vec![NO_SIDE; patches.len()], (0..patches.len() as u32).collect::<Vec<_>>());
        for (patch, back) in back_side.iter_mut().enumerate().filter(|(i, _)| patches.two_sided[*i]) {
            *back = side_patch.len() as u32;
            side_patch.push(patch as u32);
        }
        let margin = PLANE_ROUNDING * 0.5 * (high - low).max_element();
        let inset = (0..patches.len()).map(|i| inset(&patches, i, margin)).collect();
        Self {
            charts: patches.polygons.iter().map(Chart::new).collect(),
            frames: patches.normal.iter().map(|&n| Frame::new(n)).collect(),
            bvh: Bvh::build(&triangles, &BvhParams::default()),
            owner,
            back_side,
            side_patch,
            middle,
            margin,
            inset,
            specular: None,
            patches,
        }
    }

    /// The same patches, of which some are mirrors or let light through: parts of what meets each of them.
    ///
    /// # Panics
    /// If there is not one of each per patch, or they are not parts of one whole.
    pub fn with_specular(self, reflectance: Vec<f64>, transmittance: Vec<f64>) -> Self {
        Self { specular: Specular::new(&self.patches, reflectance, transmittance), ..self }
    }

    /// Mirrors and clear glass, if there are any.
    pub fn specular(&self) -> Option<&Specular> {
        self.specular.as_ref()
    }

    /// The part of a side that is neither mirror nor pane.
    pub fn diffuse_share(&self, side: usize) -> f64 {
        self.specular.as_ref().map_or(1.0, |specular| specular.diffuse_share(self.patch_of(side)))
    }

    /// What of the area of a side is neither mirror nor pane, m2.
    pub fn diffuse_area(&self, side: usize) -> f64 {
        self.area(side) * self.diffuse_share(side)
    }

    /// The area of a side where errors of its light count: none of a perfect mirror or pane, which takes no light.
    pub fn counted_area(&self, side: usize) -> f64 {
        if self.diffuse_share(side) > 0.0 { self.area(side) } else { 0.0 }
    }

    /// A ball around the scene: middle and radius, metres.
    pub fn ball(&self) -> (DVec3, f64) {
        let (low, high) = bounds(&self.patches);
        (self.middle, 0.5 * (high - low).length())
    }

    /// How far single precision may move a point of the scene, metres.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The patches.
    pub fn patches(&self) -> &Patches {
        &self.patches
    }

    /// The ray hierarchy.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The number of sides: patches plus two-sided patches.
    pub fn sides(&self) -> usize {
        self.side_patch.len()
    }

    /// The patch a side belongs to.
    pub fn patch_of(&self, side: usize) -> usize {
        self.side_patch[side] as usize
    }

    /// The back side of a two-sided patch.
    pub fn back_of(&self, patch: usize) -> Option<usize> {
        let side = self.back_side[patch];
        (side != NO_SIDE).then_some(side as usize)
    }

    /// The other side of a two-sided patch. Chart coordinates are those of the patch, so that a place has the same on both.
    pub fn opposite(&self, side: usize) -> Option<usize> {
        let patch = self.patch_of(side);
        if self.is_front(side) { self.back_of(patch) } else { Some(patch) }
    }

    /// A point just off the other side, from one just off a side as [`Enclosure::off`] gives it.
    pub fn across(&self, side: usize, off: DVec3) -> DVec3 {
        off - 2.0 * self.margin * self.normal(side)
    }

    /// Whether a side is the front of its patch.
    pub fn is_front(&self, side: usize) -> bool {
        side < self.patches.len()
    }

    /// The area of a side, m2.
    pub fn area(&self, side: usize) -> f64 {
        self.patches.area[self.patch_of(side)]
    }

    /// The outward unit normal of a side.
    pub fn normal(&self, side: usize) -> DVec3 {
        let n = self.patches.normal[self.patch_of(side)];
        if self.is_front(side) { n } else { -n }
    }

    /// The tangent frame about the normal of a side.
    pub fn frame(&self, side: usize) -> Frame {
        let front = self.frames[self.patch_of(side)];
        if self.is_front(side) {
            front
        } else {
            Frame { tangent: front.bitangent, bitangent: front.tangent, normal: -front.normal }
        }
    }

    /// A point just off a side at chart coordinates `(s, t)`: on the outer side of its plane and inside its edges
    /// even after rounding to single precision.
    #[inline]
    pub fn point_off(&self, side: usize, s: f64, t: f64) -> DVec3 {
        self.off(side, self.charts[self.patch_of(side)].point(s, t))
    }

    /// A point just off a side from one on it, as [`Enclosure::point_off`].
    #[inline]
    pub fn off(&self, side: usize, on: DVec3) -> DVec3 {
        let patch = self.patch_of(side);
        on + self.inset[patch] * (self.patches.centre[patch] - on) + self.margin * self.normal(side)
    }

    /// A point just before one of a surface that looks along the unit `normal` there, which need not be a patch's.
    #[inline]
    pub fn before(&self, on: DVec3, normal: DVec3) -> DVec3 {
        on + self.margin * normal
    }

    /// What each corner of a side's patch counts at chart coordinates in its interpolation.
    #[inline]
    pub fn corner_weights(&self, side: usize, s: f64, t: f64) -> [f64; 4] {
        corner_weights(&self.charts[self.patch_of(side)], s, t)
    }

    /// A point just off the front or the back of a patch, which need not be a side.
    pub(crate) fn off_patch(&self, patch: usize, front: bool, on: DVec3) -> DVec3 {
        let away = if front { self.margin } else { -self.margin };
        on + self.inset[patch] * (self.patches.centre[patch] - on) + away * self.patches.normal[patch]
    }

    /// Where a ray starts, metres.
    pub(crate) fn origin(&self, ray: &Ray) -> DVec3 {
        ray.origin.as_dvec3() + self.middle
    }

    /// Where a ray met something, metres.
    pub fn point(&self, ray: &Ray, hit: &Hit) -> DVec3 {
        self.origin(ray) + f64::from(hit.t) * ray.direction.as_dvec3()
    }

    /// The ray from a point along a direction, without end.
    #[inline]
    pub fn ray(&self, from: DVec3, direction: Vec3) -> Ray {
        Ray { origin: self.single(from), direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The ray that is occluded when anything stands between two points.
    pub fn segment(&self, from: DVec3, to: DVec3) -> Ray {
        let (a, b) = (self.single(from), self.single(to));
        Ray { origin: a, direction: b - a, t_min: 0.0, t_max: 1.0 }
    }

    fn single(&self, p: DVec3) -> Vec3 {
        (p - self.middle).as_vec3()
    }

    /// The patch that was hit, or the obstruction, which are numbered after all patches.
    pub fn polygon(&self, hit: &Hit) -> Option<u32> {
        (!hit.is_miss()).then(|| self.owner[hit.triangle as usize] >> 1)
    }

    /// What a hit of the hierarchy means.
    pub fn sight(&self, direction: Vec3, hit: &Hit) -> Sight {
        match self.landing(direction, hit) {
            Landing::Escaped => Sight::Escaped,
            Landing::Back => Sight::Back,
            Landing::Side(side) => {
                let half = (self.owner[hit.triangle as usize] & 1) as usize;
                let chart = &self.charts[self.patch_of(side as usize)];
                let (s, t) = chart.coordinates(half, f64::from(hit.u), f64::from(hit.v));
                Sight::Side(side, s, t)
            }
        }
    }

    /// As [`Enclosure::sight`], but not where on the side.
    #[inline]
    pub fn landing(&self, direction: Vec3, hit: &Hit) -> Landing {
        if hit.is_miss() {
            return Landing::Escaped;
        }
        let patch = (self.owner[hit.triangle as usize] >> 1) as usize;
        if patch >= self.patches.len() {
            return Landing::Back;
        }
        let front = direction.as_dvec3().dot(self.patches.normal[patch]) < 0.0;
        match if front { patch as u32 } else { self.back_side[patch] } {
            NO_SIDE => Landing::Back,
            side => Landing::Side(side),
        }
    }

    /// Whether a hit is of a black back, or an obstruction, that lets nothing through.
    pub(crate) fn is_opaque_back(&self, direction: Vec3, hit: &Hit) -> bool {
        let passes = |specular| self.meeting(specular, direction, hit).is_some_and(|m| m.passes > 0.0);
        self.landing(direction, hit) == Landing::Back && !self.specular.as_ref().is_some_and(passes)
    }

    /// The patch at a point of a surface whose front looks along `normal`, and what its corners count in the
    /// interpolation there; looked for from `reach` before the surface to as far behind it.
    pub fn locate(&self, point: DVec3, normal: DVec3, reach: f64) -> Option<(usize, [f64; 4])> {
        let normal = normal.normalize_or_zero();
        let ray = self.segment(point + reach * normal, point - reach * normal);
        let hit = self.bvh.closest_hit(&ray);
        match self.sight(ray.direction, &hit) {
            Sight::Side(side, s, t) if self.is_front(side as usize) => {
                Some((side as usize, corner_weights(&self.charts[side as usize], s, t)))
            }
            _ => None,
        }
    }

    /// Bytes held by patches and hierarchy.
    pub fn memory_bytes(&self) -> usize {
        self.bvh.memory_bytes() + self.patches.len() * (96 + 24 * 4 + 8 * 4 + size_of::<Chart>() + 72)
    }
}

fn bounds(patches: &Patches) -> (DVec3, DVec3) {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for p in patches.polygons.iter().chain(&patches.obstructions).flatten() {
        low = low.min(*p);
        high = high.max(*p);
    }
    if patches.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (low, high) }
}

/// The inset that moves a point on any edge inward by the margin: the margin over the distance of the centroid from
/// its nearest edge.
fn inset(patches: &Patches, i: usize, margin: f64) -> f64 {
    let corners = patches.corners(i);
    let centre = patches.centre[i];
    let nearest = (0..corners.len())
        .map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            (b - a).cross(centre - a).length() / (b - a).length().max(f64::MIN_POSITIVE)
        })
        .fold(f64::INFINITY, f64::min);
    if nearest > 0.0 { (margin / nearest).min(0.5) } else { 0.0 }
}
