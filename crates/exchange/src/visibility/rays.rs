//! The share of an exchange that blockers hide, by rays: where little accuracy is asked of many pairs.
//!
//! Every facet keeps two sets of points, the halves of one four-dimensional sequence: a pair joins the first half of
//! one facet to the second half of the other, point by point. The unoccluded exchange is known exactly, so that only
//! the visible share is estimated: blocked over all, each line weighed by its kernel.

use crate::enclosure::Enclosure;
use crate::facets::Facet;
use glam::DVec3;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::Sequence;
use std::ops::Range;

/// The most lines between two facets.
pub const MOST_RAYS: usize = 64;

/// The fewest.
const LEAST_RAYS: usize = 4;

/// Points on facets.
pub struct Points {
    /// `MOST_RAYS` a facet, as first and as second of a pair.
    ends: [Vec<DVec3>; 2],
}

/// The stream of the sequence that feeds pairs of facets.
const STREAM: u32 = 3;

impl Points {
    /// Places the points.
    pub fn new(enclosure: &Enclosure, facets: &[Facet], seed: u64) -> Self {
        let mut ends = [Vec::with_capacity(MOST_RAYS * facets.len()), Vec::with_capacity(MOST_RAYS * facets.len())];
        for facet in facets {
            let side = facet.side as usize;
            let sequence = Sequence::new(seed, facet.side, 0, STREAM);
            for k in 0..MOST_RAYS as u32 {
                let [s, t, u, v] = sequence.point(k);
                ends[0].push(enclosure.point_off(side, s, t));
                ends[1].push(enclosure.point_off(side, u, v));
            }
        }
        Self { ends }
    }

    /// Bytes that the points of so many facets take.
    pub fn forecast(facets: usize) -> usize {
        2 * MOST_RAYS * size_of::<DVec3>() * facets
    }
}

/// How many rays estimate a visible share to a standard error; none if they are too many.
///
/// The error of a stratified estimate of a share falls faster than the square root: as `0.5 m^-0.65` at worst, from
/// shares near one half (see the tests).
pub fn enough_rays(error: f64) -> Option<usize> {
    let rays = (0.5 / error).powf(1.0 / 0.65).ceil();
    (rays <= MOST_RAYS as f64).then(|| (rays as usize).next_power_of_two().max(LEAST_RAYS))
}

/// The standard error of a share by so many rays.
pub fn error_of(share: f64, rays: usize) -> f64 {
    let m = rays as f64;
    let p = (share * m + 0.5) / (m + 1.0);
    (p * (1.0 - p)).sqrt() * m.powf(-0.65)
}

/// Buffers kept between pairs.
#[derive(Default)]
pub struct Rays {
    rays: Vec<Ray>,
    weights: Vec<f64>,
    occluded: Vec<bool>,
}

impl Rays {
    /// The hidden share of the exchange between facets `i` and `j` of a list.
    pub fn hidden_share(
        &mut self,
        enclosure: &Enclosure,
        points: &Points,
        facets: &[Facet],
        (i, j): (usize, usize),
        rays: usize,
    ) -> f64 {
        let run = |k: usize| -> Range<usize> { k * MOST_RAYS..k * MOST_RAYS + rays };
        let (n, m) = (facets[i].normal, facets[j].normal);
        self.rays.clear();
        self.weights.clear();
        for (x, y) in points.ends[0][run(i)].iter().zip(&points.ends[1][run(j)]) {
            let r = *y - *x;
            let r2 = r.length_squared();
            let kernel = n.dot(r).max(0.0) * (-m.dot(r)).max(0.0) / (r2 * r2);
            if kernel > 0.0 {
                self.weights.push(kernel);
                self.rays.push(enclosure.segment(*x, *y));
            }
        }
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
        let all: f64 = self.weights.iter().sum();
        let blocked: f64 = self.weights.iter().zip(&self.occluded).filter(|(_, o)| **o).map(|(w, _)| w).sum();
        if all > 0.0 { blocked / all } else { 0.0 }
    }
}
