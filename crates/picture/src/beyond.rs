//! What is seen in mirrors and through clear glass.
//!
//! Where a camera looks at a mirror or a pane, its ray goes on. What leaves a patch itself is seen too: L = B / pi +
//! s L(reflected) + t L(straight on). Pictures of a solution follow both ways of every ray, since they are even where
//! the light is; traced pictures, which are noisy anyway, choose a way at random (`radiosity_exchange::specular`).
//!
//! Black backs of one-sided patches let the view through in mirrors if they do before the camera, and so do polygons
//! that only block, which are not shown.

use glam::{DVec3, Vec3};
use radiosity_exchange::enclosure::Sight;
use radiosity_exchange::specular::{MOST_MEETINGS, Meeting};
use radiosity_exchange::{Enclosure, Specular};
use radiosity_geometry::bvh::{Hit, Ray};

/// A ray that has met so many mirrors and panes shows black, where both ways are followed.
const DEEPEST: u32 = 64;

/// And one of which less than this is left: a tenth of a step of eight bits, in sum over all of them.
const LEAST: f64 = 1.0 / 4096.0;

/// So many that show nothing of their own are met for certain where ways are chosen at random.
const SPARED: u32 = 8;

/// Looks on from mirrors and panes.
#[derive(Clone, Copy)]
pub(crate) struct Beyond<'a> {
    pub enclosure: &'a Enclosure,
    pub specular: &'a Specular,
    /// As in [`crate::RenderSettings`].
    pub culls_backs: bool,
}

/// What of a ray shows something.
pub(crate) enum Shown {
    /// What leaves a side at a point just off it toward where a ray came from along a direction, with weights of the
    /// corners of its patch.
    Side { side: usize, point: DVec3, corners: [f64; 4], direction: DVec3 },
    /// What lies behind everything.
    Nothing,
}

/// Where a ray meets a patch.
struct Found {
    /// None on a black back.
    side: Option<Shown>,
    meeting: Meeting,
    on: DVec3,
    direction: DVec3,
}

impl<'a> Beyond<'a> {
    /// Whether a patch is a mirror or a pane.
    pub fn is_of(&self, patch: usize) -> bool {
        self.specular.is_specular(patch)
    }

    /// Follows a ray that came along `direction` and met a patch at `on` both ways, and shows what it finds with its
    /// weight: beyond that patch, not on it.
    pub fn all(&self, patch: usize, on: DVec3, direction: Vec3, mut show: impl FnMut(f64, Shown)) {
        let mut ways = Vec::new();
        let meeting = self.enclosure.meets(self.specular, patch, direction);
        self.part(&meeting, on, direction.as_dvec3(), (1.0, 0), &mut ways);
        while let Some((ray, weight, met)) = ways.pop() {
            match self.look(ray) {
                None => show(weight, Shown::Nothing),
                Some(Found { side, meeting, on, direction }) => {
                    if let Some(shown) = side {
                        show(weight, shown);
                    }
                    self.part(&meeting, on, direction, (weight, met), &mut ways);
                }
            }
        }
    }

    /// Adds the ways that go on from a patch, with what of the ray goes them.
    fn part(
        &self,
        meeting: &Meeting,
        on: DVec3,
        direction: DVec3,
        (weight, met): (f64, u32),
        ways: &mut Vec<(Ray, f64, u32)>,
    ) {
        for (is_reflected, share) in [(true, meeting.reflects), (false, meeting.passes)] {
            if share > 0.0 && weight * share >= LEAST && met < DEEPEST {
                ways.push((self.enclosure.onward(meeting, on, direction, is_reflected), weight * share, met + 1));
            }
        }
    }

    /// Follows such a ray one way, which numbers in (0, 1) for each that it meets choose; returns what it shows over
    /// the probability of that. None is a black back, or a side that `is_dark`. `first` is the side that is met.
    pub fn one(
        &self,
        (patch, first): (usize, Option<Shown>),
        (on, direction): (DVec3, Vec3),
        is_dark: impl Fn(usize) -> bool,
        survival: impl Fn(u32) -> f64,
    ) -> Option<(f64, Shown)> {
        let meeting = self.enclosure.meets(self.specular, patch, direction);
        self.follow(Found { side: first, meeting, on, direction: direction.as_dvec3() }, is_dark, survival)
    }

    /// The same of a ray that has met nothing yet.
    pub fn along(
        &self,
        ray: Ray,
        is_dark: impl Fn(usize) -> bool,
        survival: impl Fn(u32) -> f64,
    ) -> Option<(f64, Shown)> {
        self.follow(self.look(ray)?, is_dark, survival)
    }

    fn follow(
        &self,
        mut found: Found,
        is_dark: impl Fn(usize) -> bool,
        survival: impl Fn(u32) -> f64,
    ) -> Option<(f64, Shown)> {
        let mut weight = 1.0;
        for met in 0..MOST_MEETINGS {
            let Found { side, meeting, on, direction } = found;
            let side = side.filter(|shown| matches!(shown, Shown::Side { side, .. } if !is_dark(*side)));
            let goes_on = meeting.reflects + meeting.passes;
            let share = self.specular.diffuse_share(meeting.patch);
            // What takes all that it does not send on has the first rays go on for certain, with less weight.
            let whole = if side.is_none() && met < SPARED { goes_on } else { 1.0 };
            let u = if goes_on > 0.0 { whole * survival(met) } else { 1.0 };
            if u >= goes_on {
                return side.filter(|_| share > 0.0).map(|shown| (weight / share, shown));
            }
            weight *= whole;
            let ray = self.enclosure.onward(&meeting, on, direction, u < meeting.reflects);
            match self.look(ray) {
                None => return Some((weight, Shown::Nothing)),
                Some(next) => found = next,
            }
        }
        None
    }

    /// What a ray meets that shows.
    fn look(&self, mut ray: Ray) -> Option<Found> {
        let enclosure = self.enclosure;
        loop {
            let hit = enclosure.bvh().closest_hit(&ray);
            if hit.is_miss() {
                return None;
            }
            let found = self.found(&ray, &hit);
            let shows = |found: &Found| found.side.is_some() || found.meeting.passes > 0.0 || !self.culls_backs;
            match found.filter(shows) {
                Some(found) => return Some(found),
                // A little farther than what is looked through, and what lies in its plane.
                None => ray.t_min = hit.t * (1.0 + 4.0 * f32::EPSILON) + enclosure.margin() as f32,
            }
        }
    }

    /// What a hit is of; none if of a polygon that only blocks.
    fn found(&self, ray: &Ray, hit: &Hit) -> Option<Found> {
        let meeting = self.enclosure.meeting(self.specular, ray.direction, hit)?;
        let direction = ray.direction.as_dvec3();
        let on = self.enclosure.point(ray, hit);
        let side = match self.enclosure.sight(ray.direction, hit) {
            Sight::Side(side, s, t) => {
                let side = side as usize;
                let point = self.enclosure.point_off(side, s, t);
                let corners = self.enclosure.corner_weights(side, s, t);
                Some(Shown::Side { side, point, corners, direction })
            }
            _ => None,
        };
        Some(Found { side, meeting, on, direction })
    }
}
