//! The share of an exchange that blockers hide, by rays: where moderate accuracy is asked of many pairs.
//!
//! A line joins a point of one facet to a point of the other; both come from one four-dimensional sequence. The
//! unoccluded exchange is known exactly, so that only the hidden share is estimated: blocked over all, each line weighed
//! by its kernel. Lines are doubled until the share is known well enough; most pairs are all hidden or all in view, and
//! a few lines tell.

use super::hidden::{End, Estimate};
use crate::enclosure::Enclosure;
use crate::facets::Facet;
use glam::DVec3;
use radiosity_geometry::Chart;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::Sequence;

/// The most lines between two facets: more cost more than to integrate what is visible.
const MOST_RAYS: usize = 512;

/// The fewest.
const LEAST_RAYS: usize = 4;

/// Lines whose ends are kept with the facets.
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

/// The error of a share by so many lines: that of points in sequence, which falls faster than the square root.
fn error_of(share: f64, rays: usize) -> f64 {
    let m = rays as f64;
    let p = (share * m + 0.5) / (m + 1.0);
    (p * (1.0 - p)).sqrt() * m.powf(-RATE)
}

/// Measured on discontinuities in four dimensions, which have 5/8; the tests of form factors by rays hold it to 0.6.
const RATE: f64 = 0.625;

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

/// Weights of lines, all and those blocked.
#[derive(Clone, Copy, Default)]
struct Sums {
    all: f64,
    blocked: f64,
}

impl Sums {
    fn share(&self) -> f64 {
        if self.all > 0.0 { self.blocked / self.all } else { 0.0 }
    }
}

impl Rays {
    /// Whether a first few lines may be enough for an error relative to the unoccluded exchange.
    pub fn may_do(error: f64) -> bool {
        error_of(0.0, MOST_RAYS) <= error
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
        let (mut sums, mut done) = (Sums::default(), 0);
        let mut wanted = LEAST_RAYS;
        loop {
            self.add(enclosure, points, pair, done..wanted, &mut sums);
            done = wanted;
            let error = whole * error_of(sums.share(), done);
            if error <= allowed {
                return Some(Estimate { value: sums.share() * whole, error });
            }
            // The lines it will take if the share stays as it is.
            let needed = done as f64 * (error / allowed).powf(1.0 / RATE);
            if needed > MOST_RAYS as f64 && done >= KEPT || done >= MOST_RAYS {
                return None;
            }
            wanted = 2 * done;
        }
    }

    /// Casts lines and adds their weights.
    fn add(
        &mut self,
        enclosure: &Enclosure,
        points: &Points,
        pair: Pair,
        lines: std::ops::Range<usize>,
        sums: &mut Sums,
    ) {
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
        let count = lines.len();
        if let Some((i, j)) = pair.numbers
            && lines.end <= KEPT
        {
            let ends = |k: usize| k * KEPT + lines.start..k * KEPT + lines.end;
            points.ends[0][ends(i)].iter().zip(&points.ends[1][ends(j)]).for_each(|(x, y)| line(*x, *y));
        } else {
            let sequence = Sequence::new(points.seed, a.side, b.side, STREAM_OF_PAIRS);
            let (here, there) = (chart(pair.first.polygon), chart(pair.second.polygon));
            for k in lines {
                let [s, t, u, v] = sequence.point(k as u32);
                let (x, y) = (here.point(s, t), there.point(u, v));
                line(enclosure.off(a.side as usize, x), enclosure.off(b.side as usize, y));
            }
        }
        self.cast += count as u64;
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
        for (weight, occluded) in self.weights.iter().zip(&self.occluded) {
            sums.all += weight;
            sums.blocked += if *occluded { *weight } else { 0.0 };
        }
    }
}

/// The chart of a polygon of three or four corners.
fn chart(polygon: &[DVec3]) -> Chart {
    Chart::new(&[polygon[0], polygon[1], polygon[2], polygon[polygon.len() - 1]])
}
