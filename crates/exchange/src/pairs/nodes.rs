//! Gauss points of all facets, laid out so that a row of pairs is summed four points at a time.

use crate::facets::Facet;
use crate::kernels::areas::{ORDERS, rule};
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

/// Points summed together.
const LANES: usize = 4;

/// The points of one order: `stride` a facet, the last ones without weight where they fill up the lanes.
struct Layer {
    points: usize,
    stride: usize,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    weight: Vec<f64>,
}

/// The points of all orders.
pub struct Nodes {
    layers: Vec<Layer>,
    normals: Vec<[f64; 3]>,
    /// Middle, normal and area of all facets coordinate by coordinate: order 1 has one point a facet.
    middles: [Vec<f64>; 7],
}

impl Nodes {
    /// Places the points of every order on every facet.
    pub fn new(facets: &[Facet]) -> Self {
        let layers = (0..ORDERS.len()).map(|order| Layer::new(facets, order)).collect();
        let coordinate = |k: usize| {
            let of = |f: &Facet| match k {
                0..3 => f.centre[k],
                3..6 => f.normal[k - 3],
                _ => f.area,
            };
            facets.iter().map(of).collect()
        };
        let normals = facets.iter().map(|f| f.normal.to_array()).collect();
        Self { layers, normals, middles: std::array::from_fn(coordinate) }
    }

    /// Bytes that the points of so many facets take.
    pub fn forecast(facets: usize) -> usize {
        ORDERS.iter().map(|n| 32 * (n * n).next_multiple_of(LANES)).sum::<usize>() * facets
    }

    /// Writes the unoccluded exchange of facet `i` with each of `pairs`, `(facet, order)`, to `out`.
    ///
    /// The same bits with every instruction set: nothing is fused.
    pub fn row(&self, i: usize, pairs: &[(u32, u8)], out: &mut [f64]) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.row_avx2(i, pairs, out) };
        }
        self.row_plain(i, pairs, out);
    }

    /// The same with consecutive facets, all by one order.
    pub fn run(&self, i: usize, facets: Range<usize>, order: usize, out: &mut [f64]) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.run_avx2(i, facets, order, out) };
        }
        self.run_plain(i, facets, order, out);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn row_avx2(&self, i: usize, pairs: &[(u32, u8)], out: &mut [f64]) {
        self.row_plain(i, pairs, out);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn run_avx2(&self, i: usize, facets: Range<usize>, order: usize, out: &mut [f64]) {
        self.run_plain(i, facets, order, out);
    }

    #[inline(always)]
    fn row_plain(&self, i: usize, pairs: &[(u32, u8)], out: &mut [f64]) {
        for (&(j, order), out) in pairs.iter().zip(out) {
            *out = self.layers[order as usize].pair(i, j as usize, self.normals[i], self.normals[j as usize]);
        }
    }

    #[inline(always)]
    fn run_plain(&self, i: usize, facets: Range<usize>, order: usize, out: &mut [f64]) {
        if ORDERS[order] == 1 {
            return self.middles_plain(i, facets, out);
        }
        let layer = &self.layers[order];
        for (j, out) in facets.zip(out) {
            *out = layer.pair(i, j, self.normals[i], self.normals[j]);
        }
    }

    /// From middle to middle, several facets at a time.
    #[inline(always)]
    fn middles_plain(&self, i: usize, facets: Range<usize>, out: &mut [f64]) {
        let [xi, yi, zi, ni, mi, li, ai] = std::array::from_fn(|k| self.middles[k][i]);
        let [x, y, z, n, m, l, a] = std::array::from_fn(|k| &self.middles[k][facets.clone()]);
        let scale = ai * FRAC_1_PI;
        for (k, out) in out[..facets.len()].iter_mut().enumerate() {
            let (rx, ry, rz) = (x[k] - xi, y[k] - yi, z[k] - zi);
            let r2 = rx * rx + ry * ry + rz * rz;
            let here = ni * rx + mi * ry + li * rz;
            let there = n[k] * rx + m[k] * ry + l[k] * rz;
            *out = -scale * a[k] * (here * there) / (r2 * r2);
        }
    }
}

impl Layer {
    fn new(facets: &[Facet], order: usize) -> Self {
        let points = ORDERS[order] * ORDERS[order];
        let stride = points.next_multiple_of(LANES);
        let zeros = || Vec::with_capacity(stride * facets.len());
        let mut layer = Self { points, stride, x: zeros(), y: zeros(), z: zeros(), weight: zeros() };
        for facet in facets {
            let mut last = facet.centre;
            let mut push = |p: glam::DVec3, w: f64| {
                layer.x.push(p.x);
                layer.y.push(p.y);
                layer.z.push(p.z);
                layer.weight.push(w);
                last = p;
            };
            if points == 1 {
                push(facet.centre, facet.area);
            } else {
                rule(order).on(facet.corners(), &mut push);
            }
            (points..stride).for_each(|_| push(facet.centre, 0.0));
        }
        layer
    }

    #[inline(always)]
    fn pair(&self, i: usize, j: usize, n: [f64; 3], m: [f64; 3]) -> f64 {
        let (first, second) = (i * self.stride, j * self.stride);
        let lanes =
            |v: &[f64], k: usize| -> [f64; LANES] { *v[k..].first_chunk::<LANES>().expect("a stride of lanes") };
        let mut sum = [0.0; LANES];
        for a in first..first + self.points {
            let (xa, ya, za, wa) = (self.x[a], self.y[a], self.z[a], self.weight[a]);
            let mut part = [0.0; LANES];
            for k in (second..second + self.stride).step_by(LANES) {
                let (x, y, z, w) = (lanes(&self.x, k), lanes(&self.y, k), lanes(&self.z, k), lanes(&self.weight, k));
                for l in 0..LANES {
                    let (rx, ry, rz) = (x[l] - xa, y[l] - ya, z[l] - za);
                    let r2 = rx * rx + ry * ry + rz * rz;
                    let here = n[0] * rx + n[1] * ry + n[2] * rz;
                    let there = m[0] * rx + m[1] * ry + m[2] * rz;
                    part[l] -= w[l] * (here * there) / (r2 * r2);
                }
            }
            for l in 0..LANES {
                sum[l] += wa * part[l];
            }
        }
        (sum[0] + sum[1] + sum[2] + sum[3]) * FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::Enclosure;
    use crate::facets::{Facets, Grouping, LEAF};
    use radiosity_geometry::{DVec3, Patches};

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let polygons = vec![
            [at(0., 0., 0.), at(1., 0., 0.), at(1., 1., 0.), at(0., 1.1, 0.)],
            [at(0., 0., 3.), at(0.1, 1., 3.), at(1., 0.2, 3.), at(1., 0.2, 3.)],
            [at(2., 0., 2.), at(2., 1., 2.), at(2., 1., 3.), at(2., 0.3, 3.)],
        ];
        let patches = Patches::new(polygons, vec![0; 3], vec![0; 3], vec![false; 3]);
        let facets = Facets::new(&Enclosure::new(patches), Grouping::OF_PAIRS, LEAF).list;
        let nodes = Nodes::new(&facets);
        for (order, &points) in ORDERS.iter().enumerate() {
            let (mut plain, mut row, mut run) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            nodes.run_plain(0, 0..3, order, &mut plain);
            nodes.run(0, 0..3, order, &mut run);
            nodes.row(0, &[0, 1, 2].map(|j| (j, order as u8)), &mut row);
            let bits = |values: [f64; 3]| [values[1].to_bits(), values[2].to_bits()];
            assert_eq!(bits(plain), bits(run));
            // One point is summed in another way when it is summed alone.
            let alike = (1..3).all(|k| (row[k] - run[k]).abs() <= 1e-15 * run[k].abs());
            assert!(if points == 1 { alike } else { bits(plain) == bits(row) });
        }
    }
}
