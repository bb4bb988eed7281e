//! The share of an exchange that blockers hide, by rays: where moderate accuracy is asked of many pairs.
//!
//! A line joins a point of one facet to a point of the other; both come from one four-dimensional sequence. The
//! unoccluded exchange is known exactly, so that only the hidden share is estimated: blocked over all, each line weighed
//! by its kernel.
//!
//! How many lines are cast does not depend on what they find. Were they added until they agree, those that happen to
//! agree would end it, and what little is hidden or visible would be missed in one direction (Kirk and Arvo 1991,
//! *Unbiased sampling techniques for image synthesis*). So a first few, which do not count, tell how many others to cast.

use super::hidden::{End, Estimate};
use crate::enclosure::Enclosure;
use crate::facets::Facet;
use glam::DVec3;
use radiosity_geometry::Chart;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::Sequence;

/// The most lines between two facets: more cost more than to integrate what is visible.
const MOST_RAYS: usize = 1024;

/// Lines that tell of what hardly matters whether it is dark altogether.
const RAYS_OF_LITTLE: usize = 4;

/// The fewest.
const LEAST_RAYS: usize = 1;

/// Lines whose ends are kept with the facets: all that are cast where few do, else those that do not count.
const KEPT: usize = 32;

/// Ends of the first lines between facets.
pub struct Points {
    /// `KEPT` a facet, as first and as second of a pair.
    ends: [Vec<DVec3>; 2],
    seed: u64,
}

/// The streams of the sequences that feed lines: those kept, and those made for one pair.
const STREAM: u32 = 3;
const STREAM_OF_PAIRS: u32 = 4;

impl Points {
    /// Places the points.
    pub fn new(enclosure: &Enclosure, facets: &[Facet], seed: u64) -> Self {
        let mut ends = [Vec::with_capacity(KEPT * facets.len()), Vec::with_capacity(KEPT * facets.len())];
        for facet in facets {
            let side = facet.side as usize;
            let sequence = Sequence::new(seed, facet.side, 0, STREAM);
            for k in 0..KEPT as u32 {
                let [s, t, u, v] = sequence.point(k);
                ends[0].push(enclosure.point_off(side, s, t));
                ends[1].push(enclosure.point_off(side, u, v));
            }
        }
        Self { ends, seed }
    }

    /// Bytes that the points of so many facets take.
    pub fn forecast(facets: usize) -> usize {
        2 * KEPT * size_of::<DVec3>() * facets
    }
}

/// The error of a share falls with this power of the number of lines: discontinuities in four dimensions have 5/8, and
/// few lines less; tests of form factors by rays hold it to 0.6.
const RATE: f64 = 0.58;

/// The standard deviation of whether a line is blocked, over pairs of which nothing is known.
const UNKNOWN: f64 = 0.45;

/// Lines for an error of a share, by the standard deviation of one.
fn enough(deviation: f64, error: f64) -> f64 {
    (deviation / error).powf(1.0 / RATE)
}

/// The standard deviation of one line, by so many: never quite nothing.
fn deviation(share: f64, rays: usize) -> f64 {
    let p = (share * rays as f64 + 0.5) / (rays as f64 + 1.0);
    (p * (1.0 - p)).sqrt()
}

/// Buffers kept between pairs.
#[derive(Default)]
pub struct Rays {
    rays: Vec<Ray>,
    weights: Vec<f64>,
    occluded: Vec<bool>,
    /// Lines cast for all pairs.
    pub cast: u64,
}

/// Two polygons of facets.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    /// The numbers of the facets, if the polygons are all of them.
    pub numbers: Option<(usize, usize)>,
    /// One.
    pub first: End<'a>,
    /// The other; of three or four corners both.
    pub second: End<'a>,
}

impl Rays {
    /// Whether lines may be enough for an error relative to the unoccluded exchange, if nearly all agree.
    pub fn may_do(error: f64) -> bool {
        enough(deviation(0.0, KEPT), error) <= MOST_RAYS as f64
    }

    /// The hidden part of an exchange of `whole` m2, to an error of `allowed`; none if it takes too many lines.
    pub fn hidden(
        &mut self,
        enclosure: &Enclosure,
        points: &Points,
        pair: Pair,
        whole: f64,
        allowed: f64,
    ) -> Option<Estimate> {
        if pair.first.polygon.len() > 4 || pair.second.polygon.len() > 4 {
            return None;
        }
        let error = allowed / whole;
        let few = enough(UNKNOWN, error).ceil() as usize;
        let (count, kept) = if few <= KEPT {
            (few.max(LEAST_RAYS), true)
        } else {
            let share = self.share(enclosure, points, pair, KEPT, true)?;
            let count = enough(deviation(share, KEPT), error).ceil();
            if count > MOST_RAYS as f64 {
                return None;
            }
            ((count as usize).max(KEPT), false)
        };
        let share = self.share(enclosure, points, pair, count, kept)?;
        let error = deviation(share, count) * (count as f64).powf(-RATE);
        Some(Estimate { value: share * whole, error: error * whole, is_all: share == 1.0 })
    }

    /// The hidden part of an exchange so small that it may be wrong altogether, by very few lines. Of polygons of more
    /// than four corners some part is looked at.
    pub fn hidden_of_little(&mut self, enclosure: &Enclosure, points: &Points, pair: Pair, whole: f64) -> Estimate {
        let share = self.share(enclosure, points, pair, RAYS_OF_LITTLE, true).unwrap_or(0.5);
        Estimate { value: share * whole, error: 0.5 * whole, is_all: share == 1.0 }
    }

    /// The blocked share of so many lines: of those kept, or of others. None if no line counts: all of them leave or
    /// arrive behind a horizon, and of what is before it nothing is known.
    fn share(&mut self, enclosure: &Enclosure, points: &Points, pair: Pair, count: usize, kept: bool) -> Option<f64> {
        let (a, b) = (pair.first.facet, pair.second.facet);
        self.rays.clear();
        self.weights.clear();
        let mut line = |x: DVec3, y: DVec3| {
            let r = y - x;
            let r2 = r.length_squared();
            let kernel = a.normal.dot(r).max(0.0) * (-b.normal.dot(r)).max(0.0) / (r2 * r2);
            if kernel > 0.0 {
                self.weights.push(kernel);
                self.rays.push(enclosure.segment(x, y));
            }
        };
        if let (Some((i, j)), true) = (pair.numbers, kept) {
            let ends = |k: usize| k * KEPT..k * KEPT + count;
            points.ends[0][ends(i)].iter().zip(&points.ends[1][ends(j)]).for_each(|(x, y)| line(*x, *y));
        } else {
            let stream = if kept { STREAM } else { STREAM_OF_PAIRS };
            let sequence = Sequence::new(points.seed, a.side, b.side, stream);
            let (here, there) = (chart(pair.first.polygon), chart(pair.second.polygon));
            for k in 0..count {
                let [s, t, u, v] = sequence.point(k as u32);
                let (x, y) = (here.point(s, t), there.point(u, v));
                line(enclosure.off(a.side as usize, x), enclosure.off(b.side as usize, y));
            }
        }
        self.cast += count as u64;
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
        let all: f64 = self.weights.iter().sum();
        let blocked: f64 = self.weights.iter().zip(&self.occluded).filter(|(_, o)| **o).map(|(w, _)| w).sum();
        (all > 0.0).then(|| blocked / all)
    }
}

/// The chart of a polygon of three or four corners.
fn chart(polygon: &[DVec3]) -> Chart {
    Chart::new(&[polygon[0], polygon[1], polygon[2], polygon[polygon.len() - 1]])
}
