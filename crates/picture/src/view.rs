//! What a viewpoint can see, and the rays that see it.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use radiosity_geometry::Patches;
use radiosity_geometry::bvh::{Bvh, BvhParams, Hit, Ray};
use radiosity_geometry::corners::{in_half, in_triangle};
use radiosity_scene::Camera;

/// One triangle of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub patch: u32,
    /// Whether the back is seen, of a patch that has two sides or is glass.
    pub is_back: bool,
    part: Part,
}

#[derive(Clone, Copy, Debug)]
enum Part {
    /// The patch is this triangle.
    Whole,
    /// Corners 0, 1 and 2 of a quad.
    First,
    /// Corners 0, 2 and 3 of a quad.
    Second,
}

impl Facet {
    /// The weights of the patch's corners where a ray met the facet.
    pub fn corner_weights(&self, hit: &Hit) -> [f64; 4] {
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        match self.part {
            Part::Whole => in_triangle(u, v),
            Part::First => in_half(0, u, v),
            Part::Second => in_half(1, u, v),
        }
    }

    /// Where a ray met the facet.
    pub fn point(&self, patches: &Patches, hit: &Hit) -> DVec3 {
        let [a, b, c, d] = patches.polygons[self.patch as usize];
        let (p, q) = if matches!(self.part, Part::Second) { (c, d) } else { (b, c) };
        a + f64::from(hit.u) * (p - a) + f64::from(hit.v) * (q - a)
    }
}

/// The facets that a viewpoint can see, and a tree to find them by.
///
/// Which side of a plane a viewpoint sees is known before any ray is shot, so backs need no care during traversal, and
/// of two faces back to back at the same place the right one is seen. Coordinates are relative to the viewpoint: 32
/// bits resolve best what is near.
pub(crate) struct Visible {
    pub bvh: Bvh,
    facets: Vec<Facet>,
    /// Facets from this one on show their black backs.
    first_black: u32,
}

impl Visible {
    /// Backs of one-sided patches that `is_glass` are seen, though nothing is lit on them.
    pub fn new(patches: &Patches, eye: DVec3, culls_backs: bool, is_glass: impl Fn(usize) -> bool) -> Self {
        let (mut fronts, mut backs) = (Vec::new(), Vec::new());
        for patch in 0..patches.len() {
            for (part, triangle) in parts(patches, patch) {
                let [a, b, c] = triangle.map(|p| p - eye);
                let is_back = (b - a).cross(c - a).dot(a) >= 0.0;
                let is_lit = patches.two_sided[patch] || !is_back || is_glass(patch);
                if is_lit || !culls_backs {
                    let facet = Facet { patch: patch as u32, is_back, part };
                    let list = if is_lit { &mut fronts } else { &mut backs };
                    list.push((facet, [a.as_vec3(), b.as_vec3(), c.as_vec3()]));
                }
            }
        }
        let first_black = fronts.len() as u32;
        // Of facets at the same distance the first is hit, so fronts come first.
        let (facets, triangles): (Vec<_>, Vec<_>) = fronts.into_iter().chain(backs).unzip();
        Self { bvh: Bvh::build(&triangles, &BvhParams::default()), facets, first_black }
    }

    /// The facet whose light a ray sees; none where it met nothing or a black back.
    pub fn facet(&self, hit: &Hit) -> Option<Facet> {
        (hit.triangle < self.first_black).then(|| self.facets[hit.triangle as usize])
    }
}

/// The triangles of a patch.
fn parts(patches: &Patches, patch: usize) -> impl Iterator<Item = (Part, [DVec3; 3])> {
    let [a, b, c, d] = patches.polygons[patch];
    let parts = if c == d {
        [Some((Part::Whole, [a, b, c])), None]
    } else {
        [Some((Part::First, [a, b, c])), Some((Part::Second, [a, c, d]))]
    };
    parts.into_iter().flatten()
}

/// The plane of the picture, at distance one from the eye.
pub(crate) struct Frame {
    /// Its upper left corner.
    corner: DVec3,
    /// One pixel to the right.
    right: DVec3,
    /// One pixel down.
    down: DVec3,
}

impl Frame {
    pub fn new(camera: &Camera, width: usize, height: usize) -> Self {
        let forward = camera.forward.normalize_or(DVec3::NEG_Z);
        let right = forward.cross(camera.up).normalize_or(forward.any_orthonormal_vector());
        let down = forward.cross(right);
        let pixel = 2.0 * (0.5 * camera.vertical_fov.clamp(1e-6, PI - 1e-6)).tan() / height as f64;
        let (right, down) = (pixel * right, pixel * down);
        Self { corner: forward - 0.5 * (width as f64 * right + height as f64 * down), right, down }
    }

    /// The ray through a point of the picture, in pixels from its upper left corner.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let direction = (self.corner + x * self.right + y * self.down).normalize().as_vec3();
        Ray { origin: Vec3::ZERO, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}
