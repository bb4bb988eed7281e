//! Planar mirrors and clear glass, which rays go on from: extended form factors.
//!
//! The shape of it. A patch reflects a part s of what meets it as a plane mirror does and lets a part t straight
//! through; `Specular` holds both per patch, without colour. A ray that meets a patch lands on its diffuse part with the
//! probability 1 - s - t and else goes on, so that a form factor counts all that arrives, straight or by mirrors and
//! panes (Wallace, Cohen and Greenberg 1987; Sillion and Puech 1989). Specular reflection is reciprocal, so that G is
//! symmetric: a side counts as if 1 - s - t of its area were a diffuse surface of radiosity B / (1 - s - t) and the rest
//! were not there. This is all that the operator, the solvers and the balance of power see of it. Chains of rays are cut
//! by survival, drawn from the ray's own sequence (`shots.rs`). Luminaires, which are sampled by area, are sampled
//! through their images in the planes of mirrors too (`images.rs`); what images cover rays leave out, and what they do
//! not cover rays count. A path ends where nothing is left of it or at a cap, and what is lost at the cap is told.
//!
//! A sheet is thin: light that passes is not moved, and passes from behind as it does from before. The back of a
//! one-sided mirror is black, and of one-sided glass black but for what it lets through.

use crate::enclosure::{Enclosure, Sight};
use glam::{DVec3, Vec3};
use radiosity_geometry::Patches;
use radiosity_geometry::bvh::{Hit, Ray};
use std::collections::HashMap;

/// No mirror: what stands where a side does not reflect.
pub const NO_MIRROR: u32 = u32::MAX;

/// A chain that has met so many mirrors and panes is given up: only between two facing ones that absorb next to
/// nothing are there any.
pub const MOST_MEETINGS: u32 = 4096;

/// Less of a side than this is none: what rounding leaves of 1 - s - t.
const NOTHING: f64 = 1e-12;

/// The plane of a mirror, which reflects what is before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Unit normal of the side that reflects.
    pub normal: DVec3,
    /// Distance of the plane from the origin along the normal, metres.
    pub offset: f64,
    /// The greatest mirror reflectance in the plane.
    pub reflectance: f64,
}

impl Mirror {
    /// How far a point is before the plane, metres.
    pub fn height(&self, point: DVec3) -> f64 {
        point.dot(self.normal) - self.offset
    }

    /// The image of a point.
    pub fn image(&self, point: DVec3) -> DVec3 {
        point - 2.0 * self.height(point) * self.normal
    }

    /// The image of a direction.
    pub fn turned(&self, direction: DVec3) -> DVec3 {
        reflected(direction, self.normal)
    }

    /// Whether it is the other side of the same plane.
    pub fn is_back_of(&self, other: &Mirror, margin: f64) -> bool {
        self.normal.dot(other.normal) < -1.0 + 1e-9 && (self.offset + other.offset).abs() <= margin
    }
}

fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// What patches reflect as mirrors do, and let through.
#[derive(Clone, Debug)]
pub struct Specular {
    reflectance: Vec<f64>,
    transmittance: Vec<f64>,
    /// Patch -> the mirror that its front and its back are part of.
    mirror: Vec<[u32; 2]>,
    mirrors: Vec<Mirror>,
}

/// A patch that a ray meets.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Which.
    pub patch: usize,
    /// Whether it is the front that is met.
    pub front: bool,
    /// What of it goes on in the reflected direction.
    pub reflects: f64,
    /// What of it goes on straight.
    pub passes: f64,
    /// The mirror that it is part of, or [`NO_MIRROR`].
    pub mirror: u32,
}

/// What becomes of a ray.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// It ends there.
    End(Sight),
    /// It goes on.
    On {
        /// From where it met the patch.
        ray: Ray,
        /// Whether it was reflected.
        reflected: bool,
    },
}

impl Specular {
    /// Of mirror reflectance and transmittance per patch; nothing where all are zero.
    ///
    /// # Panics
    /// If there is not one of each per patch, or they are not parts of one whole.
    pub fn new(patches: &Patches, reflectance: Vec<f64>, transmittance: Vec<f64>) -> Option<Self> {
        assert!(reflectance.len() == patches.len() && transmittance.len() == patches.len(), "one of each per patch");
        let whole = |(s, t): (&f64, &f64)| *s >= 0.0 && *t >= 0.0 && s + t <= 1.0 + NOTHING;
        assert!(reflectance.iter().zip(&transmittance).all(whole), "mirrors and panes send on at most what they get");
        if reflectance.iter().chain(&transmittance).all(|part| *part == 0.0) {
            return None;
        }
        let (mirror, mirrors) = planes(patches, &reflectance);
        Some(Self { reflectance, transmittance, mirror, mirrors })
    }

    /// Planes of mirrors.
    pub fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// Whether any patch lets light through.
    pub fn has_glass(&self) -> bool {
        self.transmittance.iter().any(|t| *t > 0.0)
    }

    /// A patch that is a mirror or lets light through, the first.
    pub fn first_patch(&self) -> usize {
        let is_specular = |(s, t): (&f64, &f64)| *s > 0.0 || *t > 0.0;
        self.reflectance.iter().zip(&self.transmittance).position(is_specular).unwrap_or(0)
    }

    /// Whether a patch is a mirror or lets light through.
    pub fn is_specular(&self, patch: usize) -> bool {
        self.reflectance[patch] + self.transmittance[patch] > 0.0
    }

    /// What a patch lets through.
    pub fn transmittance(&self, patch: usize) -> f64 {
        self.transmittance[patch]
    }

    /// The part of a patch's sides that is neither mirror nor pane.
    pub fn diffuse_share(&self, patch: usize) -> f64 {
        let share = 1.0 - self.reflectance[patch] - self.transmittance[patch];
        if share < NOTHING { 0.0 } else { share }
    }

    fn meeting(&self, patches: &Patches, patch: usize, direction: Vec3) -> Meeting {
        let front = direction.as_dvec3().dot(patches.normal[patch]) < 0.0;
        let mirror = self.mirror[patch][usize::from(!front)];
        let reflects = if mirror == NO_MIRROR { 0.0 } else { self.reflectance[patch] };
        Meeting { patch, front, reflects, passes: self.transmittance[patch], mirror }
    }
}

/// The oriented planes that patches which reflect lie in, and which of them each front and back is part of.
fn planes(patches: &Patches, reflectance: &[f64]) -> (Vec<[u32; 2]>, Vec<Mirror>) {
    let extent = patches.polygons.iter().flatten().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    let grid = |value: f64, step: f64| (value / step).round() as i64;
    let (mut mirror, mut mirrors) = (vec![[NO_MIRROR; 2]; patches.len()], Vec::<Mirror>::new());
    let mut known: HashMap<[i64; 4], u32> = HashMap::new();
    for patch in (0..patches.len()).filter(|&i| reflectance[i] > 0.0 && patches.area[i] > 0.0) {
        for (back, normal) in [patches.normal[patch], -patches.normal[patch]].into_iter().enumerate() {
            if back == 1 && !patches.two_sided[patch] {
                continue;
            }
            let offset = normal.dot(patches.centre[patch]);
            let [x, y, z] = normal.to_array().map(|n| grid(n, 1e-7));
            let key = [x, y, z, grid(offset, 1e-7 * extent.max(f64::MIN_POSITIVE))];
            let index = *known.entry(key).or_insert_with(|| {
                mirrors.push(Mirror { normal, offset, reflectance: 0.0 });
                mirrors.len() as u32 - 1
            });
            let plane = &mut mirrors[index as usize];
            plane.reflectance = plane.reflectance.max(reflectance[patch]);
            mirror[patch][back] = index;
        }
    }
    (mirror, mirrors)
}

/// What cannot follow rays by mirrors and panes, asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "patch {patch}, of surface {surface}, is a mirror or lets light through, which {way} cannot follow; solve by samples \
     (transport \"sampled\"), or make it diffuse"
)]
pub struct NotFollowed {
    /// The first such patch.
    pub patch: usize,
    /// Index of its surface.
    pub surface: u32,
    /// What cannot.
    pub way: &'static str,
}

impl Enclosure {
    /// Refuses mirrors and clear glass for those who cannot follow them.
    ///
    /// # Errors
    /// If there are any.
    pub fn without_specular(&self, way: &'static str) -> Result<(), NotFollowed> {
        match self.specular() {
            None => Ok(()),
            Some(specular) => {
                let patch = specular.first_patch();
                Err(NotFollowed { patch, surface: self.patches().surface[patch], way })
            }
        }
    }

    /// The mirror or pane, or another patch, that a ray meets.
    pub fn meeting(&self, specular: &Specular, direction: Vec3, hit: &Hit) -> Option<Meeting> {
        let patch = self.polygon(hit)? as usize;
        (patch < self.patches().len()).then(|| specular.meeting(self.patches(), patch, direction))
    }

    /// The same for a patch that is known to be met.
    pub fn meets(&self, specular: &Specular, patch: usize, direction: Vec3) -> Meeting {
        specular.meeting(self.patches(), patch, direction)
    }

    /// What becomes of a ray that hit something, where `u` in (0, 1), drawn if need be, decides whether it survives.
    pub fn step(&self, specular: &Specular, ray: &Ray, hit: &Hit, u: impl FnOnce() -> f64) -> Step {
        let end = || Step::End(self.sight(ray.direction, hit));
        let Some(meeting) = self.meeting(specular, ray.direction, hit) else { return end() };
        if meeting.reflects + meeting.passes == 0.0 {
            return end();
        }
        let u = u();
        let reflected = u < meeting.reflects;
        if !reflected && u >= meeting.reflects + meeting.passes {
            return end();
        }
        let direction = ray.direction.as_dvec3();
        let on = self.crossing(meeting.patch, self.origin(ray), direction);
        Step::On { ray: self.onward(&meeting, on, direction, reflected), reflected }
    }

    /// The ray that goes on from a point of a patch, where one along `direction` met it.
    pub fn onward(&self, meeting: &Meeting, on: DVec3, direction: DVec3, is_reflected: bool) -> Ray {
        let normal = self.patches().normal[meeting.patch];
        let turned = if is_reflected { reflected(direction, normal) } else { direction };
        self.ray(self.beyond(meeting, on, is_reflected), turned.as_vec3())
    }

    /// A point just off a patch that is met, on the side that light goes on from.
    fn beyond(&self, meeting: &Meeting, on: DVec3, is_reflected: bool) -> DVec3 {
        self.off_patch(meeting.patch, meeting.front == is_reflected, on)
    }

    /// Where a line crosses the plane of a patch.
    fn crossing(&self, patch: usize, from: DVec3, direction: DVec3) -> DVec3 {
        let (normal, centre) = (self.patches().normal[patch], self.patches().centre[patch]);
        let along = direction.dot(normal);
        if along == 0.0 { from } else { from + (centre - from).dot(normal) / along * direction }
    }

    /// What is left of light on the way from a point to a luminaire by mirrors, the last first: `aims` are where it
    /// seems to be, from the image in all mirrors to the luminaire itself; or, of parallel light, directions towards it.
    pub fn passage(&self, specular: &Specular, from: DVec3, aims: &[DVec3], mirrors: &[u32], parallel: bool) -> f64 {
        debug_assert_eq!(aims.len(), mirrors.len() + 1);
        let (mut origin, mut left, mut turns) = (from, 1.0, 0);
        for _ in 0..MOST_MEETINGS {
            let aim = aims[turns];
            let (ray, direction) = if parallel {
                (self.ray(origin, aim.as_vec3()), aim)
            } else {
                (self.segment(origin, aim), aim - origin)
            };
            let hit = self.bvh().closest_hit(&ray);
            if hit.is_miss() {
                return if turns == mirrors.len() { left } else { 0.0 };
            }
            let Some(meeting) = self.meeting(specular, ray.direction, &hit) else { return 0.0 };
            let turns_here = turns < mirrors.len() && meeting.mirror == mirrors[turns];
            left *= if turns_here { meeting.reflects } else { meeting.passes };
            if left == 0.0 {
                return 0.0;
            }
            turns += usize::from(turns_here);
            origin = self.beyond(&meeting, self.crossing(meeting.patch, origin, direction), turns_here);
        }
        0.0
    }
}
