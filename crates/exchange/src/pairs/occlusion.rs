//! How much of a pair's exchange is hidden.
//!
//! Rays tell where facets are apart and moderate accuracy is enough; else what is visible is integrated. Both are poor
//! where facets are near for their size, or where much stands between: then the larger is cut in four and each part is
//! judged anew, with what stands between it and the other. Of parts that could not matter a few rays tell.

use super::{FEW_RAYS_ERROR, Kernel, Scene, Task};
use crate::convex::quarters;
use crate::visibility::hidden::{End, Estimate};
use crate::visibility::rays::{Pair, Rays};
use crate::visibility::shaft::Sight;
use glam::DVec3;

/// Parts of parts are cut no further.
const MOST_DEPTH: usize = 7;

/// More blockers than these between two polygons are fewer between each part of them.
const MANY_BLOCKERS: usize = 24;

/// How often a pair is cut for no other reason than that much stands between.
const CUTS_FOR_BLOCKERS: usize = 3;

/// The share of the allowed error that a part may take that is wrong by half of it.
const NEGLIGIBLE: f64 = 0.2;

/// A pair of polygons, and what is known of it.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    /// The numbers of the facets.
    pub numbers: (usize, usize),
    pub first: End<'a>,
    pub second: End<'a>,
    /// The exchange if nothing stood between, m2.
    pub whole: f64,
    /// Whether they are well apart for their size.
    pub are_apart: bool,
    /// The error allowed, m2.
    pub allowed: f64,
}

impl Task<'_> {
    /// The hidden part of an exchange.
    pub(super) fn hidden(&mut self, ends: &Ends, candidates: &[u32]) -> Estimate {
        // Where a few rays may do they cost less than to find out whether any are needed.
        if ends.allowed > FEW_RAYS_ERROR * ends.whole
            && let Some(estimate) = self.hidden_by_rays(ends, true)
        {
            self.tally.partial += 1;
            return estimate;
        }
        self.hidden_by(ends, candidates)
    }

    fn hidden_by_rays(&mut self, ends: &Ends, are_whole: bool) -> Option<Estimate> {
        if !(ends.are_apart && self.rays_are_exact_enough(ends)) {
            return None;
        }
        let Scene { enclosure, points, .. } = self.scene;
        // Lines kept with the facets are none of a polygon that a horizon cuts.
        let is_uncut = |end: End| end.polygon == end.facet.corners();
        let are_whole = are_whole && is_uncut(ends.first) && is_uncut(ends.second);
        let pair = Pair { numbers: are_whole.then_some(ends.numbers), first: ends.first, second: ends.second };
        let estimate = self.scratch.rays.hidden(enclosure, points, pair, ends.whole, ends.allowed)?;
        self.tally.by_rays += 1;
        Some(estimate)
    }

    fn rays_are_exact_enough(&self, ends: &Ends) -> bool {
        matches!(self.scene.settings.kernel, Kernel::Auto) && Rays::may_do(ends.allowed / ends.whole)
    }

    /// What is hidden of a pair of whole facets, once it is known what may be between.
    fn hidden_by(&mut self, ends: &Ends, candidates: &[u32]) -> Estimate {
        let mut kept = self.scratch.take_list();
        let sight = self.between(ends.first, ends.second, candidates, &mut kept);
        self.tally.count(sight);
        let estimate = match sight {
            Sight::Full => Estimate::default(),
            Sight::None => Estimate::all(ends.whole),
            Sight::Partial => self.partly_hidden(ends, &kept, 0),
        };
        self.scratch.lists.push(kept);
        estimate
    }

    fn partly_hidden(&mut self, ends: &Ends, blockers: &[u32], depth: usize) -> Estimate {
        if depth > 0 && 0.5 * ends.whole <= NEGLIGIBLE * ends.allowed {
            // A few lines keep the dark dark: half of a little is light where there must be none.
            let Scene { enclosure, points, .. } = self.scene;
            let pair = Pair { numbers: None, first: ends.first, second: ends.second };
            return self.scratch.rays.hidden_of_little(enclosure, points, pair, ends.whole);
        }
        let are_whole = depth == 0;
        if let Some(estimate) = self.hidden_by_rays(ends, are_whole) {
            return estimate;
        }
        let is_near = !ends.are_apart && depth < MOST_DEPTH && self.rays_are_exact_enough(ends);
        if is_near || (blockers.len() > MANY_BLOCKERS && depth < CUTS_FOR_BLOCKERS) {
            return self.by_parts(ends, blockers, depth);
        }
        let list = &self.scene.blockers;
        let hidden = &mut self.scratch.hidden;
        let estimate = hidden.exchange(ends.first, ends.second, &list.list, blockers, ends.allowed, list.contact);
        self.tally.unresolved += u64::from(estimate.error > 1.01 * ends.allowed);
        estimate
    }

    /// Cuts the larger polygon and adds up what is hidden of the parts.
    fn by_parts(&mut self, ends: &Ends, blockers: &[u32], depth: usize) -> Estimate {
        let (a, b) = (ends.first, ends.second);
        let cut_first = size(a.polygon) > size(b.polygon);
        let mut sum = Estimate { is_all: true, ..Estimate::default() };
        let mut variance = 0.0;
        for part in parts(if cut_first { a.polygon } else { b.polygon }) {
            let (first, second) =
                if cut_first { (End { polygon: &part, ..a }, b) } else { (a, End { polygon: &part, ..b }) };
            let hidden = self.hidden_of_part(ends, (first, second), blockers, depth + 1);
            sum.value += hidden.value;
            sum.is_all &= hidden.is_all;
            variance += hidden.error * hidden.error;
        }
        Estimate { error: variance.sqrt(), ..sum }
    }

    /// What is hidden of a part. Only where something is between is it worth knowing how much that part exchanges.
    fn hidden_of_part(&mut self, of: &Ends, (first, second): (End, End), blockers: &[u32], depth: usize) -> Estimate {
        let mut kept = self.scratch.take_list();
        let sight = self.between(first, second, blockers, &mut kept);
        let mut estimate = Estimate::default();
        if sight != Sight::Full {
            let (whole, are_apart) = self.unoccluded_by(&Kernel::Auto, first, second, 0.1 * of.allowed);
            estimate = match sight {
                Sight::Partial if whole > 0.0 => {
                    // As errors of parts add up in squares.
                    let allowed = of.allowed * (whole / of.whole).sqrt().min(1.0);
                    self.partly_hidden(&Ends { first, second, whole, are_apart, allowed, ..*of }, &kept, depth)
                }
                _ => Estimate::all(whole.max(0.0)),
            };
        }
        self.scratch.lists.push(kept);
        estimate
    }
}

/// The square of the longest edge.
fn size(polygon: &[DVec3]) -> f64 {
    (0..polygon.len()).map(|k| polygon[k].distance_squared(polygon[(k + 1) % polygon.len()])).fold(0.0, f64::max)
}

/// A convex polygon in four: at the middles of its edges, or from corner to corner where it has more than four.
fn parts(polygon: &[DVec3]) -> Vec<Vec<DVec3>> {
    match polygon {
        [a, b, c] => quarters(&[*a, *b, *c]).map(|triangle| triangle.to_vec()).to_vec(),
        [a, b, c, d] => {
            let (ab, bc, cd, da) = (0.5 * (*a + *b), 0.5 * (*b + *c), 0.5 * (*c + *d), 0.5 * (*d + *a));
            // On both lines between opposite middles, so that the parts are planar and tile.
            let middle = 0.25 * (*a + *b + *c + *d);
            vec![vec![*a, ab, middle, da], vec![ab, *b, bc, middle], vec![middle, bc, *c, cd], vec![da, middle, cd, *d]]
        }
        [a, rest @ ..] => rest.windows(2).map(|pair| vec![*a, pair[0], pair[1]]).collect(),
        [] => Vec::new(),
    }
}
