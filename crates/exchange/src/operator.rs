//! The symmetric operator that samples add up to.

use crate::elements::Elements;
use crate::enclosure::Enclosure;
use crate::luminaires::{LightSample, Luminaire};
use crate::samples::Samples;
use crate::shots::Shot;
use radiosity_operator::{Csr, Operator};
use rayon::prelude::*;

/// Everything measured about the exchange of an enclosure, and the operators it gives on any choice of elements.
pub struct Measured<'a> {
    /// The geometry.
    pub enclosure: &'a Enclosure,
    /// Rows by rays.
    pub shots: &'a Samples<Shot>,
    /// What `lights` refer to.
    pub luminaires: &'a [Luminaire],
    /// Columns of the luminaires by area sampling.
    pub lights: &'a Samples<LightSample>,
    /// At most this many rays per replicate of a side enter the operator.
    pub most_shots: &'a (dyn Fn(usize) -> usize + Sync),
    /// At most this many light samples per replicate of a side enter the operator.
    pub most_lights: &'a (dyn Fn(usize) -> usize + Sync),
}

/// What the rays of an element say about it as a whole.
#[derive(Clone, Copy, Debug, Default)]
struct Census {
    shots: u32,
    landed: u32,
    buried: u32,
    lights: u32,
}

/// An operator on elements with what a solver needs beside it.
pub struct ElementExchange {
    /// G, m2.
    pub operator: Csr,
    /// Area that takes part in the exchange, m2: the part not buried under solids that stand on it.
    pub exposed_area: Vec<f64>,
    /// The share of each element's rays that land on a side: its row sum if the samples were all there are.
    pub landed: Vec<f64>,
    /// The operator's row sums over exposed area, before balancing.
    pub raw_closure: Vec<f64>,
    /// The worst relative deviation from the row-sum targets left by balancing; zero if not balanced.
    pub imbalance: f64,
}

/// A pair's rays from both ends count together, each hit by the inverse of the two ray densities' sum: the
/// inverse-variance mean of the two estimates of G_ij, and exactly symmetric.
fn shot_value(density: &[f64], i: usize, j: usize) -> f32 {
    (1.0 / (density[i] + density[j])) as f32
}

impl Measured<'_> {
    /// Builds the operator on elements; balances its rows when told how well and how long to try.
    pub fn on(&self, elements: &Elements, balance: Option<(f64, usize)>) -> ElementExchange {
        let census = self.census(elements);
        let (offsets, entries) = self.entries(elements, &census);
        let mut operator = Csr::new(offsets, entries);
        let n = elements.len();
        let (mut exposed_area, mut landed) = (vec![0.0; n], vec![0.0; n]);
        for side in 0..elements.sides() {
            let range = elements.of(side);
            let area = self.enclosure.diffuse_area(side) / range.len() as f64;
            let whole = census[range.clone()].iter().fold(Census::default(), |a, b| a.plus(b));
            for e in range {
                let (buried, lands) = census[e].shares(&whole);
                exposed_area[e] = area * (1.0 - buried);
                landed[e] = lands;
            }
        }
        let mut raw_closure = operator.row_sums();
        raw_closure.iter_mut().zip(&exposed_area).for_each(|(r, a)| *r = if *a > 0.0 { *r / a } else { 0.0 });
        let imbalance = balance.map_or(0.0, |(tolerance, iterations)| {
            let targets: Vec<f64> = exposed_area.iter().zip(&landed).map(|(a, c)| a * c).collect();
            operator.balance(&targets, &exposed_area, tolerance, iterations)
        });
        ElementExchange { operator, exposed_area, landed, raw_closure, imbalance }
    }

    /// The rays of a side that enter the operator.
    fn shots_of(&self, side: usize) -> impl Iterator<Item = &Shot> {
        self.shots.first(side, (self.most_shots)(side))
    }

    /// The light samples of a side that enter the operator.
    fn lights_of(&self, side: usize) -> impl Iterator<Item = &LightSample> {
        self.lights.first(side, (self.most_lights)(side))
    }

    /// Marks the sides that are luminaires: pairs with them are measured by area, not by rays.
    fn lamp_sides(&self) -> Vec<bool> {
        let mut lamps = vec![false; self.enclosure.sides()];
        for luminaire in self.luminaires {
            if let Luminaire::Side(side) = luminaire {
                lamps[*side as usize] = true;
            }
        }
        lamps
    }

    fn census(&self, elements: &Elements) -> Vec<Census> {
        let per_side: Vec<Vec<Census>> = (0..elements.sides())
            .into_par_iter()
            .with_min_len(16)
            .map(|side| {
                let first = elements.of(side).start;
                let mut census = vec![Census::default(); elements.of(side).len()];
                for shot in self.shots_of(side) {
                    let c = &mut census[elements.at(side, shot.origin_cell) - first];
                    c.shots += 1;
                    c.landed += u32::from(shot.landed());
                    c.buried += u32::from(shot.target() == Shot::BURIED);
                }
                for sample in self.lights_of(side) {
                    census[elements.at(side, sample.origin_cell) - first].lights += 1;
                }
                census
            })
            .collect();
        per_side.concat()
    }

    /// Compressed rows: each pair's entry stands in both rows with one value.
    fn entries(&self, elements: &Elements, census: &[Census]) -> (Vec<usize>, Vec<(u32, f32)>) {
        let lamps = self.lamp_sides();
        let density: Vec<f64> = (0..elements.sides())
            .flat_map(|side| {
                let range = elements.of(side);
                let area = self.enclosure.diffuse_area(side) / range.len() as f64;
                census[range].iter().map(move |c| if area > 0.0 { f64::from(c.shots) / area } else { 0.0 })
            })
            .collect();
        // Every side lists its pairs once; the lists of all sides are then dealt out to both rows of each pair.
        let pairs: Vec<Vec<(u32, u32, f32)>> = (0..elements.sides())
            .into_par_iter()
            .with_min_len(16)
            .map(|side| self.pairs(elements, census, &density, &lamps, side))
            .collect();
        deal(elements.len(), &pairs)
    }

    fn pairs(
        &self,
        elements: &Elements,
        census: &[Census],
        density: &[f64],
        lamps: &[bool],
        side: usize,
    ) -> Vec<(u32, u32, f32)> {
        let mut pairs = Vec::new();
        let area = self.enclosure.diffuse_area(side) / elements.of(side).len() as f64;
        if area == 0.0 {
            return pairs;
        }
        for shot in self.shots_of(side).filter(|s| s.landed()) {
            let target = shot.target() as usize;
            if shot.is_beyond_images() || !(lamps[side] || lamps[target]) {
                let i = elements.at(side, shot.origin_cell);
                let j = elements.at(target, shot.target_cell);
                pairs.push((i as u32, j as u32, shot_value(density, i, j)));
            }
        }
        for sample in self.lights_of(side).filter(|s| s.weight > 0.0) {
            if let Luminaire::Side(lamp) = self.luminaires[sample.luminaire as usize] {
                let i = elements.at(side, sample.origin_cell);
                let j = elements.of(lamp as usize).start;
                // Two lamps sample each other from both ends: each estimate counts half.
                let half = if lamps[side] { 0.5 } else { 1.0 };
                let value = half * area * f64::from(sample.weight) / f64::from(census[i].lights);
                pairs.push((i as u32, j as u32, value as f32));
            }
        }
        pairs
    }
}

impl Census {
    fn plus(self, other: &Census) -> Census {
        Census {
            shots: self.shots + other.shots,
            landed: self.landed + other.landed,
            buried: self.buried + other.buried,
            lights: self.lights + other.lights,
        }
    }

    /// The buried share of the rays, and the share of the others that land; the latter drawn a little toward the
    /// whole side's where rays are few.
    fn shares(&self, side: &Census) -> (f64, f64) {
        const PRIOR: f64 = 4.0;
        let ratio = |a: u32, b: u32| if b > 0 { f64::from(a) / f64::from(b) } else { 0.0 };
        let landed = ratio(side.landed, side.shots - side.buried);
        let open = f64::from(self.shots - self.buried);
        (ratio(self.buried, self.shots), (f64::from(self.landed) + PRIOR * landed) / (open + PRIOR))
    }
}

/// Deals pairs out to compressed rows, in the order of the lists, on any number of threads alike.
fn deal(rows: usize, pairs: &[Vec<(u32, u32, f32)>]) -> (Vec<usize>, Vec<(u32, f32)>) {
    let mut offsets = vec![0usize; rows + 1];
    for &(i, j, _) in pairs.iter().flatten() {
        offsets[i as usize + 1] += 1;
        offsets[j as usize + 1] += 1;
    }
    for k in 0..rows {
        offsets[k + 1] += offsets[k];
    }
    let mut entries = vec![(0, 0.0); offsets[rows]];
    // Each task owns a range of rows with about the same number of entries and scans all pairs for its own.
    let tasks = rayon::current_num_threads().max(1);
    let cuts: Vec<usize> =
        (0..=tasks).map(|t| offsets.partition_point(|&o| o < offsets[rows] * t / tasks).min(rows)).collect();
    let mut rest = entries.as_mut_slice();
    let mut slices = Vec::with_capacity(tasks);
    for t in 0..tasks {
        let end = if t + 1 == tasks { rows } else { cuts[t + 1] };
        let (head, tail) = std::mem::take(&mut rest).split_at_mut(offsets[end] - offsets[cuts[t]]);
        slices.push((cuts[t]..end, head));
        rest = tail;
    }
    slices.into_par_iter().for_each(|(range, slice)| {
        let base = offsets[range.start];
        let mut next: Vec<usize> = offsets[range.clone()].to_vec();
        for &(i, j, value) in pairs.iter().flatten() {
            for (row, column) in [(i, j), (j, i)] {
                if range.contains(&(row as usize)) {
                    let at = &mut next[row as usize - range.start];
                    slice[*at - base] = (column, value);
                    *at += 1;
                }
            }
        }
    });
    (offsets, entries)
}
