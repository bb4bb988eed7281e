//! Generated scenes and rays for benchmarks. The same numbers on every machine that rounds sines alike.

use radiosity_geometry::Vec3;
use radiosity_geometry::bvh::Ray;
use std::f32::consts::{PI, TAU};

/// Three corners.
pub type Triangle = [Vec3; 3];

/// Triangles whose right-hand normals point into the free space.
pub struct Scene {
    /// A short name for tables.
    pub name: &'static str,
    /// All triangles.
    pub triangles: Vec<Triangle>,
}

/// The scenes, smallest first.
pub fn all() -> Vec<Scene> {
    vec![coarse(), cornell(), room(), bumpy()]
}

/// A closed box with two blocks in it, barely cut up: 60 triangles.
pub fn coarse() -> Scene {
    Scene { name: "coarse box", triangles: box_with_blocks(1, 2) }
}

/// The same in regular tessellation, about 4,000 triangles.
pub fn cornell() -> Scene {
    Scene { name: "tessellated box", triangles: box_with_blocks(16, 8) }
}

/// A furnished room: tables, chairs, lamps, shelves with books; about 100,000 triangles of all sizes.
pub fn room() -> Scene {
    let mut mesh = Mesh::default();
    mesh.cuboid(Vec3::ZERO, Vec3::new(8.0, 3.0, 6.0), 40, Side::Inside);
    let mut random = Random(7);
    for table in 0..4 {
        let corner = Vec3::new(1.0 + 1.7 * table as f32, 0.0, 1.5 + random.float());
        mesh.table(corner, Vec3::new(1.2, 0.75, 0.7), 12);
        for chair in 0..4 {
            let offset = Vec3::new(0.15 + 0.55 * (chair % 2) as f32, 0.0, -0.5 + 1.3 * (chair / 2) as f32);
            mesh.table(corner + offset, Vec3::new(0.4, 0.45, 0.4), 6);
        }
        mesh.ball(corner + Vec3::new(0.6, 1.8, 0.35), 0.2, 64, |_| 1.0);
        mesh.ball(corner + Vec3::new(0.3, 0.9, 0.3), 0.12, 48, |d| 1.0 + 0.3 * (9.0 * d.x).sin());
    }
    for shelf in 0..5 {
        let height = 0.4 + 0.45 * shelf as f32;
        mesh.cuboid(Vec3::new(0.5, height, 5.6), Vec3::new(7.5, height + 0.03, 5.95), 10, Side::Outside);
        let mut x = 0.55;
        while x < 7.4 {
            let width = 0.015 + 0.04 * random.float();
            let top = height + 0.04 + 0.2 + 0.15 * random.float();
            let front = 5.65 + 0.08 * random.float();
            mesh.cuboid(Vec3::new(x, height + 0.04, front), Vec3::new(x + width, top, 5.9), 2, Side::Outside);
            x += width + 0.002;
        }
    }
    Scene { name: "furnished room", triangles: mesh.triangles }
}

/// A bumpy ball in a bare box, about 280,000 triangles.
pub fn bumpy() -> Scene {
    let mut mesh = Mesh::default();
    mesh.cuboid(Vec3::splat(-2.0), Vec3::splat(2.0), 1, Side::Inside);
    mesh.ball(Vec3::new(0.1, -0.2, 0.05), 1.0, 374, |d| {
        let wave = (11.0 * d.x).sin() * (13.0 * d.y).sin() * (12.0 * d.z).sin();
        1.0 + 0.3 * wave + 0.02 * (90.0 * d.x).sin() * (80.0 * d.y).sin()
    });
    Scene { name: "bumpy ball", triangles: mesh.triangles }
}

fn box_with_blocks(walls: usize, blocks: usize) -> Vec<Triangle> {
    let mut mesh = Mesh::default();
    mesh.cuboid(Vec3::ZERO, Vec3::splat(5.5), walls, Side::Inside);
    for (angle, base, size) in [
        (0.3_f32, Vec3::new(3.6, 0.01, 1.8), Vec3::new(1.6, 1.65, 1.6)),
        (-0.3, Vec3::new(1.8, 0.01, 3.6), Vec3::new(1.6, 3.3, 1.6)),
    ] {
        let start = mesh.triangles.len();
        let half = Vec3::new(size.x / 2.0, 0.0, size.z / 2.0);
        mesh.cuboid(-half, half + Vec3::Y * size.y, blocks, Side::Outside);
        let (sine, cosine) = angle.sin_cos();
        for corner in mesh.triangles[start..].iter_mut().flatten() {
            let turned = Vec3::new(corner.x * cosine - corner.z * sine, corner.y, corner.x * sine + corner.z * cosine);
            *corner = base + turned;
        }
    }
    mesh.triangles
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Inside,
    Outside,
}

#[derive(Default)]
struct Mesh {
    triangles: Vec<Triangle>,
}

impl Mesh {
    /// A grid of `n` by `n` quads over a bent parallelogram.
    fn grid(&mut self, n: [usize; 2], at: impl Fn(f32, f32) -> Vec3, flip: bool) {
        let point = |i: usize, j: usize| at(i as f32 / n[0] as f32, j as f32 / n[1] as f32);
        for i in 0..n[0] {
            for j in 0..n[1] {
                let [p, q, r, s] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                for [a, b, c] in [[p, q, r], [p, r, s]] {
                    self.triangles.push(if flip { [a, c, b] } else { [a, b, c] });
                }
            }
        }
    }

    /// Six walls of `n` by `n` quads, seen from one side.
    fn cuboid(&mut self, min: Vec3, max: Vec3, n: usize, side: Side) {
        for axis in 0..3 {
            for upper in [false, true] {
                let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
                let at = |s: f32, t: f32| {
                    let mut p = if upper { max } else { min };
                    p[j] = min[j] + s * (max[j] - min[j]);
                    p[k] = min[k] + t * (max[k] - min[k]);
                    p
                };
                self.grid([n, n], at, upper == (side == Side::Inside));
            }
        }
    }

    /// A top on four legs.
    fn table(&mut self, corner: Vec3, size: Vec3, n: usize) {
        let top = Vec3::new(0.0, size.y - 0.03, 0.0);
        self.cuboid(corner + top, corner + size, n, Side::Outside);
        for (x, z) in [(0.02, 0.02), (0.94, 0.02), (0.02, 0.94), (0.94, 0.94)] {
            let foot = corner + Vec3::new(x * size.x, 0.0, z * size.z);
            self.cuboid(foot, foot + Vec3::new(0.04, size.y - 0.04, 0.04), n / 3, Side::Outside);
        }
    }

    /// A ball of 2 n by n quads whose radius varies with direction.
    fn ball(&mut self, centre: Vec3, radius: f32, n: usize, scale: impl Fn(Vec3) -> f32) {
        let at = |s: f32, t: f32| {
            let (longitude, latitude) = (TAU * s, PI * t);
            let direction =
                Vec3::new(latitude.sin() * longitude.cos(), latitude.cos(), latitude.sin() * longitude.sin());
            centre + radius * scale(direction) * direction
        };
        self.grid([n, n], at, true);
    }
}

/// Rays as a radiosity solver shoots them.
pub struct Rays<'a> {
    triangles: &'a [Triangle],
    /// Running sum of areas.
    area: Vec<f32>,
}

impl<'a> Rays<'a> {
    /// Rays that start on `triangles`.
    pub fn new(triangles: &'a [Triangle]) -> Self {
        let mut sum = 0.0;
        let area = triangles.iter().map(|triangle| {
            sum += normal(triangle).length();
            sum
        });
        Self { triangles, area: area.collect() }
    }

    /// Rays from random points, half of them uniform in area and half in triangles, cosine distributed.
    pub fn incoherent(&self, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Random(seed);
        (0..count)
            .map(|_| {
                let (origin, normal) = self.point(&mut random);
                let direction = cosine(normal, random.float(), random.float());
                Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
            })
            .collect()
    }

    /// Segments between random points.
    pub fn occlusion(&self, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Random(seed);
        (0..count)
            .map(|_| {
                let (origin, _) = self.point(&mut random);
                let (target, _) = self.point(&mut random);
                Ray { origin, direction: target - origin, t_min: 0.0, t_max: 1.0 }
            })
            .collect()
    }

    /// Rows of 1,024 rays, each row from one point, in the order of their strata.
    pub fn rows(&self, count: usize, seed: u64) -> Vec<Ray> {
        const SIDE: usize = 32;
        let mut random = Random(seed);
        let mut rays = Vec::with_capacity(count);
        while rays.len() < count {
            let (origin, normal) = self.point(&mut random);
            for stratum in 0..SIDE * SIDE {
                let (i, j) = (stratum / SIDE, stratum % SIDE);
                let j = if i % 2 == 0 { j } else { SIDE - 1 - j };
                let [s, t] = [i, j].map(|k| (k as f32 + random.float()) / SIDE as f32);
                rays.push(Ray { origin, direction: cosine(normal, s, t), t_min: 0.0, t_max: f32::INFINITY });
            }
        }
        rays.truncate(count);
        rays
    }

    /// A point slightly above a surface, and the normal there.
    fn point(&self, random: &mut Random) -> (Vec3, Vec3) {
        let count = self.triangles.len();
        let index = if random.float() < 0.5 {
            let position = random.float() * self.area[count - 1];
            self.area.partition_point(|&area| area < position).min(count - 1)
        } else {
            (random.float() * count as f32) as usize
        };
        let triangle = &self.triangles[index.min(count - 1)];
        let (s, t) = (random.float().sqrt(), random.float());
        let [a, b, c] = *triangle;
        let normal = normal(triangle).normalize_or(Vec3::Y);
        (a * (1.0 - s) + b * (s * (1.0 - t)) + c * (s * t) + 1e-4 * normal, normal)
    }
}

fn normal([a, b, c]: &Triangle) -> Vec3 {
    (b - a).cross(c - a)
}

/// A cosine-distributed direction about `normal` from two numbers in the unit interval.
fn cosine(normal: Vec3, s: f32, t: f32) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (sine, cosine) = (TAU * t).sin_cos();
    let radius = s.sqrt();
    x * (radius * cosine) + y * (radius * sine) + normal * (1.0 - s).max(0.0).sqrt()
}

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn float(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}
