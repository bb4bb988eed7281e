//! What every tree and every kernel must do.

mod agreement;
mod hardness;
mod watertight;

use super::{Bvh, BvhParams, Hit, Kernel, Ray};
use glam::{Mat3, Vec3};
use proptest::prelude::*;

type Triangle = [Vec3; 3];

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// The same tree with each kernel that runs here.
fn with_all_kernels(bvh: &Bvh) -> Vec<Bvh> {
    Kernel::available().iter().map(|&kernel| bvh.clone().with_kernel(kernel)).collect()
}

fn all_params() -> [BvhParams; 3] {
    [BvhParams::default(), BvhParams::fast_build(), BvhParams::fast_rays()]
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

/// Triangles of up to `size` scattered over a cube of half-edge 10; some flat, some in planes of the axes.
fn soup(size: f32) -> impl Strategy<Value = Vec<Triangle>> {
    let triangle = (vector(10.0), vector(size), vector(size), 0..8_usize).prop_map(|(a, p, q, kind)| match kind {
        0 => [a, a + p, a + p],
        axis @ 1..=3 => [a, a + p, a + q].map(|mut corner| {
            corner[axis - 1] = a[axis - 1].round();
            corner
        }),
        _ => [a, a + p, a + q],
    });
    prop::collection::vec(triangle, 0..300)
}

/// Rays through the cube of the soup, some along axes, some of finite length.
fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let ray = (vector(12.0), vector(1.0), 0..7_usize, 0.0..4.0_f32, prop::option::of(4.0..30.0_f32)).prop_map(
        |(origin, mut direction, zeros, t_min, t_max)| {
            (0..3).filter(|axis| zeros >> axis & 1 == 1).for_each(|axis| direction[axis] = 0.0);
            Ray { origin, direction, t_min, t_max: t_max.unwrap_or(f32::INFINITY) }
        },
    );
    prop::collection::vec(ray, 1..200)
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn float(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn below(&mut self, n: usize) -> usize {
        (self.float() * n as f32) as usize
    }

    /// Uniform in the cube of half-edge one.
    fn vector(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.float(), self.float(), self.float()) - 1.0
    }
}

/// Triangles given by shared corners, so that neighbours agree about them to the bit.
#[derive(Default)]
struct Mesh {
    corners: Vec<Vec3>,
    faces: Vec<[usize; 3]>,
}

impl Mesh {
    /// A closed box whose walls are cut along the given lines, conformingly also around its edges.
    fn add_box(&mut self, lines: &[Vec<f32>; 3]) {
        for axis in 0..3 {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [lines[axis][0], lines[axis][lines[axis].len() - 1]] {
                let start = self.corners.len();
                let columns = lines[k].len();
                for &s in &lines[j] {
                    for &t in &lines[k] {
                        let mut corner = Vec3::ZERO;
                        (corner[axis], corner[j], corner[k]) = (side, s, t);
                        self.corners.push(corner);
                    }
                }
                for row in 0..lines[j].len() - 1 {
                    for column in 0..columns - 1 {
                        self.add_quad(start + row * columns + column, columns);
                    }
                }
            }
        }
    }

    /// Cuts a quad of a grid along one of its diagonals.
    fn add_quad(&mut self, first: usize, columns: usize) {
        let [p, q, r, s] = [first, first + 1, first + columns + 1, first + columns];
        let faces = if first.is_multiple_of(3) { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] };
        self.faces.extend(faces);
    }

    fn transformed(mut self, matrix: Mat3, shift: Vec3) -> Self {
        self.corners.iter_mut().for_each(|corner| *corner = matrix * *corner + shift);
        self
    }

    fn triangles(&self) -> Vec<Triangle> {
        self.faces.iter().map(|face| face.map(|corner| self.corners[corner])).collect()
    }
}

/// Lines from `from` to `to`, most of them evenly spaced, some so close that slivers come about.
fn lines(from: f32, to: f32, n: usize) -> Vec<f32> {
    let mut lines: Vec<f32> = (0..=n).map(|i| from + (to - from) * i as f32 / n as f32).collect();
    lines.push(from + 0.43 * (to - from));
    lines.push(from + 0.430_02 * (to - from));
    lines.sort_by(f32::total_cmp);
    lines.dedup();
    lines
}
