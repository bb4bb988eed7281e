//! Links: the exchange of two clusters as a block of rank one.

use super::Settings;
use super::clusters::Clusters;
use crate::enclosure::Enclosure;
use crate::facets::{Facet, Node};
use glam::DVec3;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::mix;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

/// Facets of the other end that unoccluded sums are taken over, at most: the kernel is smooth between distant clusters.
const MOST_SUMMED: usize = 64;

/// Facets whose radii are below this share of their distance are summed from middle to middle.
const MIDDLES_BELOW: f64 = 0.1;

/// Rays of a link at least.
const LEAST_RAYS: usize = 16;

/// Rays of a link at most, for each facet.
const MOST_RAYS_A_FACET: usize = 256;

/// One end of a link: facets, and what each exchanges with all of the other end, m2.
#[derive(Default)]
struct End {
    range: Range<usize>,
    sums: Vec<f64>,
    /// Sums up to each facet, for drawing facets by them.
    upto: Vec<f64>,
    /// Rays of each facet, and those of them that arrived.
    drawn: Vec<u32>,
    seen: Vec<u32>,
    weights: Vec<f32>,
}

/// Facets that stand for all of a cluster, coordinate by coordinate.
#[derive(Default)]
struct Sample([Vec<f64>; 7]);

/// The link at hand, and buffers.
#[derive(Default)]
pub struct Far {
    ends: [End; 2],
    sample: Sample,
    rays: Vec<Ray>,
    facets: Vec<[u32; 2]>,
    occluded: Vec<bool>,
}

impl Far {
    /// Takes two clusters and finds what they exchange if nothing is between; false if nothing at all.
    pub fn unoccluded(&mut self, clusters: &Clusters, a: &Node, b: &Node) -> bool {
        let is_fine = self.needs_points(a, b);
        for (k, (own, other)) in [(a, b), (b, a)].into_iter().enumerate() {
            self.sample.take(clusters, other.range.clone(), is_fine);
            let end = &mut self.ends[k];
            end.range = own.range.clone();
            end.sums.clear();
            let sample = &self.sample;
            end.sums.extend(own.range.clone().map(|i| {
                let [x, y, z, n, m, l, area] = clusters.middles.each_ref().map(|m| m[i]);
                if !is_fine {
                    return sample.exchange([x, y, z, n, m, l, area]);
                }
                let points = points(&clusters.facets.list[i]);
                let share = area / points.len() as f64;
                points.iter().map(|p| sample.exchange([p.x, p.y, p.z, n, m, l, share])).sum()
            }));
        }
        self.ends.iter().all(|end| end.sums.iter().any(|s| *s > 0.0))
    }

    /// Whether facets are so near for their size that their middles do not tell enough.
    fn needs_points(&self, a: &Node, b: &Node) -> bool {
        let radii = a.radii.1 + b.radii.1;
        let are_few = a.range.len().max(b.range.len()) <= MOST_SUMMED;
        are_few && radii * radii > MIDDLES_BELOW * MIDDLES_BELOW * a.bounds.distances_squared(&b.bounds).0
    }

    /// Takes off what rays find hidden; the number of rays.
    pub fn occlude(
        &mut self,
        enclosure: &Enclosure,
        clusters: &Clusters,
        nodes: (usize, usize),
        settings: &Settings,
    ) -> usize {
        let count = self.ray_count(clusters, settings.ray_share);
        self.ends.iter_mut().for_each(End::prepare);
        self.cast(enclosure, clusters, nodes, settings.seed, count);
        for (facets, occluded) in self.facets.iter().zip(&self.occluded) {
            for (end, &k) in self.ends.iter_mut().zip(facets) {
                end.drawn[k as usize] += 1;
                end.seen[k as usize] += u32::from(!occluded);
            }
        }
        count
    }

    /// Leaves of the sums of each end what rays saw.
    pub fn attenuate(&mut self) {
        self.ends.iter_mut().for_each(End::attenuate);
    }

    /// The greater form factor of one whole end to the other, weighed by what matters.
    pub fn factor(&self, clusters: &Clusters) -> f64 {
        let [a, b] = &self.ends;
        let factor = |end: &End, other: &End| {
            let area: f64 = clusters.middles[6][end.range.clone()].iter().sum();
            end.sums.iter().sum::<f64>() / area * importance(other, clusters).max(1.0)
        };
        factor(a, b).max(factor(b, a))
    }

    /// Whether the rays say that halves of one end see the halves of the other so differently that more than `allowed`
    /// of a form factor is at stake: then the block is not the product of what each facet sees.
    pub fn is_mixed(&self, clusters: &Clusters, nodes: [&Node; 2], allowed: f64) -> bool {
        let factor = self.factor(clusters);
        if factor <= allowed {
            return false;
        }
        let halves = nodes.map(|node| match node.children {
            Some([_, second]) => clusters.facets.nodes[second].range.start - node.range.start,
            None => node.range.len() / 2,
        });
        let mut seen = [[(0.0f64, 0.0f64); 2]; 2];
        for (&[i, j], occluded) in self.facets.iter().zip(&self.occluded) {
            let cell = &mut seen[usize::from(i as usize >= halves[0])][usize::from(j as usize >= halves[1])];
            cell.0 += 1.0;
            cell.1 += f64::from(u8::from(!occluded));
        }
        let share = |(count, seen): (f64, f64)| if count > 0.0 { seen / count } else { 0.0 };
        // Of the mean: never quite nothing, as of few rays alike.
        let variance = |(count, seen): (f64, f64)| {
            let p = (seen + 0.5) / (count + 1.0);
            p * (1.0 - p) / (count + 1.0)
        };
        let [[p, q], [r, s]] = seen.map(|row| row.map(share));
        let mixture = (p * s - q * r).abs();
        let [[vp, vq], [vr, vs]] = seen.map(|row| row.map(variance));
        let deviation = (s * s * vp + p * p * vs + r * r * vq + q * q * vr).sqrt();
        let is_sure = mixture > 2.0 * deviation;
        is_sure && mixture * factor > allowed
    }

    /// As many rays as the form factors of either end have shares, of what matters.
    fn ray_count(&self, clusters: &Clusters, share: f64) -> usize {
        let factors = |end: &End| {
            end.sums.iter().zip(&clusters.middles[6][end.range.clone()]).map(|(s, area)| s / area).sum::<f64>()
        };
        let [a, b] = &self.ends;
        let most = MOST_RAYS_A_FACET * a.sums.len().max(b.sums.len());
        let wanted = (factors(a) * importance(b, clusters)).max(factors(b) * importance(a, clusters)) / share;
        (wanted.ceil() as usize).clamp(LEAST_RAYS, most)
    }

    /// Draws pairs of facets in proportion to what they exchange, evenly on both ends, and a line for each.
    fn cast(&mut self, enclosure: &Enclosure, clusters: &Clusters, nodes: (usize, usize), seed: u64, count: usize) {
        self.rays.clear();
        self.facets.clear();
        let mut hash = mix(seed ^ ((nodes.0 as u64) << 32 | nodes.1 as u64));
        let turn = (hash >> 11) as f64 / (1u64 << 53) as f64;
        let [a, b] = &self.ends;
        let mut i = 0;
        for k in 0..count {
            // Points of a lattice (Korobov; golden ratio), turned at random.
            let p = (k as f64 + 0.5) / count as f64;
            let q = (k as f64 * GOLDEN + turn).fract();
            while i + 1 < a.upto.len() && a.upto[i] < p {
                i += 1;
            }
            let j = b.upto.partition_point(|&u| u < q).min(b.upto.len() - 1);
            let mut point = |facet: usize| {
                hash = mix(hash);
                let (s, t) = ((hash & 0xffff_ffff) as f64 + 0.5, (hash >> 32) as f64 + 0.5);
                let side = clusters.facets.list[facet].side as usize;
                enclosure.point_off(side, s / TWO_32, t / TWO_32)
            };
            let (x, y) = (point(a.range.start + i), point(b.range.start + j));
            self.rays.push(enclosure.segment(x, y));
            self.facets.push([i as u32, j as u32]);
        }
        self.occluded.clear();
        self.occluded.resize(count, false);
        enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
    }

    /// Makes of both ends' sums the weights of the block; false if there is nothing in it.
    pub fn balance(&mut self) -> bool {
        let totals = self.ends.each_ref().map(|end| end.sums.iter().sum::<f64>());
        let total = 0.5 * (totals[0] + totals[1]);
        if !(totals[0] > 0.0 && totals[1] > 0.0) {
            return false;
        }
        for (end, scale) in self.ends.iter_mut().zip([1.0, 1.0 / total]) {
            end.weights.clear();
            end.weights.extend(end.sums.iter().map(|s| (s * scale) as f32));
        }
        true
    }

    /// The weights of the rows.
    pub fn rows(&self) -> &[f32] {
        &self.ends[0].weights
    }

    /// The weights of the columns.
    pub fn columns(&self) -> &[f32] {
        &self.ends[1].weights
    }
}

const TWO_32: f64 = 4_294_967_296.0;

/// How much more than the mean what an end sends to the other matters.
fn importance(end: &End, clusters: &Clusters) -> f64 {
    match clusters.importance.get(end.range.clone()) {
        Some(all) if !all.is_empty() => {
            end.sums.iter().zip(all).map(|(s, w)| s * w).sum::<f64>() / end.sums.iter().sum::<f64>()
        }
        _ => 1.0,
    }
}

/// Three or four points.
#[derive(Clone, Copy)]
struct Few([DVec3; 4], usize);

fn few(points: &[DVec3]) -> Few {
    let mut all = [DVec3::ZERO; 4];
    all[..points.len()].copy_from_slice(points);
    Few(all, points.len())
}

impl std::ops::Deref for Few {
    type Target = [DVec3];

    fn deref(&self) -> &[DVec3] {
        &self.0[..self.1]
    }
}

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Points of a facet that integrate quadratic functions, all of one weight: Gauss points of a quadrilateral by its
/// bilinear map, exact if it is a parallelogram, and three of a triangle (Strang and Fix 1973).
fn points(facet: &Facet) -> Few {
    let near = 0.5 - 0.5 / 3f64.sqrt();
    match *facet.corners() {
        [a, b, c] => {
            let middle = (a + b + c) / 6.0;
            few(&[middle + 0.5 * a, middle + 0.5 * b, middle + 0.5 * c])
        }
        [a, b, c, d] => {
            let along = |t: f64| (a + t * (b - a), d + t * (c - d));
            let on = |s: f64, t: f64| {
                let (low, high) = along(s);
                low + t * (high - low)
            };
            few(&[on(near, near), on(1.0 - near, near), on(1.0 - near, 1.0 - near), on(near, 1.0 - near)])
        }
        _ => unreachable!("facets have three or four corners"),
    }
}

impl End {
    fn prepare(&mut self) {
        let total: f64 = self.sums.iter().sum();
        let mut sum = 0.0;
        self.upto.clear();
        self.upto.extend(self.sums.iter().map(|s| {
            sum += s / total;
            sum
        }));
        for counts in [&mut self.drawn, &mut self.seen] {
            counts.clear();
            counts.resize(self.sums.len(), 0);
        }
    }

    /// Leaves of each facet's sum what its rays saw; facets without a ray share those of their neighbours.
    fn attenuate(&mut self) {
        let n = self.sums.len();
        let mut start = 0;
        let mut before = 1.0;
        while start < n {
            let (mut end, mut drawn, mut seen) = (start, 0, 0);
            while end < n && drawn == 0 {
                drawn += self.drawn[end];
                seen += self.seen[end];
                end += 1;
            }
            let share = if drawn > 0 { f64::from(seen) / f64::from(drawn) } else { before };
            self.sums[start..end].iter_mut().for_each(|s| *s *= share);
            (start, before) = (end, share);
        }
    }
}

impl Sample {
    /// Every so many-th facet of a range, with the area of all; or some points of every one.
    fn take(&mut self, clusters: &Clusters, range: Range<usize>, is_fine: bool) {
        if is_fine {
            return self.take_points(&clusters.facets.list[range]);
        }
        let step = range.len().div_ceil(MOST_SUMMED);
        for (to, from) in self.0.iter_mut().zip(&clusters.middles) {
            to.clear();
            to.extend(from[range.clone()].iter().skip(step / 2).step_by(step));
        }
        let areas = &clusters.middles[6][range];
        let scale = areas.iter().sum::<f64>() / self.0[6].iter().sum::<f64>();
        self.0[6].iter_mut().for_each(|a| *a *= scale);
        self.fill_lanes();
    }

    fn take_points(&mut self, facets: &[Facet]) {
        self.0.iter_mut().for_each(Vec::clear);
        for facet in facets {
            let (points, n) = (points(facet), facet.normal);
            for p in points.iter() {
                let entry = [p.x, p.y, p.z, n.x, n.y, n.z, facet.area / points.len() as f64];
                self.0.iter_mut().zip(entry).for_each(|(to, v)| to.push(v));
            }
        }
        self.fill_lanes();
    }

    /// Repeats the last entry, without area.
    fn fill_lanes(&mut self) {
        let whole = self.0[0].len().next_multiple_of(LANES);
        for (k, to) in self.0.iter_mut().enumerate() {
            let last = if k == 6 { 0.0 } else { to[to.len() - 1] };
            to.resize(whole, last);
        }
    }

    /// What a facet exchanges with the sample, m2.
    fn exchange(&self, facet: [f64; 7]) -> f64 {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.exchange_avx2(facet) };
        }
        self.exchange_plain(facet)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn exchange_avx2(&self, facet: [f64; 7]) -> f64 {
        self.exchange_plain(facet)
    }

    /// From middle to middle. The same bits with every instruction set: nothing is fused.
    #[inline(always)]
    fn exchange_plain(&self, [x, y, z, n, m, l, area]: [f64; 7]) -> f64 {
        let count = self.0[0].len();
        let [xs, ys, zs, ns, ms, ls, areas] = std::array::from_fn(|k| &self.0[k][..count]);
        let lanes = |v: &[f64], k: usize| -> [f64; LANES] { *v[k..].first_chunk().expect("whole lanes") };
        let mut sums = [0.0; LANES];
        for k in (0..count).step_by(LANES) {
            let (xs, ys, zs) = (lanes(xs, k), lanes(ys, k), lanes(zs, k));
            let (ns, ms, ls, areas) = (lanes(ns, k), lanes(ms, k), lanes(ls, k), lanes(areas, k));
            for i in 0..LANES {
                let (rx, ry, rz) = (xs[i] - x, ys[i] - y, zs[i] - z);
                let r2 = rx * rx + ry * ry + rz * rz;
                let here = (n * rx + m * ry + l * rz).max(0.0);
                let there = (-(ns[i] * rx + ms[i] * ry + ls[i] * rz)).max(0.0);
                sums[i] += areas[i] * (here * there) / (r2 * r2);
            }
        }
        area * FRAC_1_PI * (sums[0] + sums[1] + sums[2] + sums[3])
    }
}

/// Terms summed together.
const LANES: usize = 4;
