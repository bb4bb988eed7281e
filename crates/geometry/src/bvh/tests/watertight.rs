//! No ray leaves a closed room.

use super::*;

/// A closed room with closed boxes in it, in some position, and a point from which rays start.
struct Room {
    mesh: Mesh,
    matrix: Mat3,
    shift: Vec3,
}

impl Room {
    fn new(matrix: Mat3, shift: Vec3) -> Self {
        let mut mesh = Mesh::default();
        mesh.add_box(&[lines(-1.0, 1.0, 13), lines(-1.0, 1.0, 7), lines(-1.0, 1.0, 16)]);
        mesh.add_box(&[lines(0.2, 0.6, 3), lines(-0.9, 0.1, 4), lines(0.3, 0.7, 5)]);
        mesh.add_box(&[lines(-0.7, -0.3, 2), lines(-1.0, 0.3, 5), lines(-0.7, 0.2, 3)]);
        Self { mesh: mesh.transformed(matrix, shift), matrix, shift }
    }

    /// A ray from inside, often aimed at a corner, at an edge, or along an axis.
    fn ray(&self, random: &mut Random) -> Ray {
        let mut origin = self.matrix * (0.99 * random.vector()) + self.shift;
        let corners = &self.mesh.corners;
        let face = self.mesh.faces[random.below(self.mesh.faces.len())];
        let [a, b] = [corners[face[0]], corners[face[1]]];
        let direction = match random.below(8) {
            0 => a - origin,
            1 => a + (b - a) * random.float() - origin,
            2 => 0.5 * (a + b) - origin,
            3 => {
                // Along an axis of the world, from a line of the tessellation.
                let axis = random.below(3);
                let other = (axis + 1 + random.below(2)) % 3;
                let kept = origin;
                origin[other] = a[other];
                if !self.is_inside(origin) {
                    origin = kept;
                }
                let mut direction = Vec3::ZERO;
                direction[axis] = if random.float() < 0.5 { -1.0 } else { 1.0 };
                direction
            }
            4 => {
                // In a plane of two axes, one of them with the sign of a negative zero.
                let mut direction = random.vector();
                direction[random.below(3)] = -0.0;
                direction
            }
            _ => random.vector(),
        };
        ray(origin, direction)
    }

    fn is_inside(&self, point: Vec3) -> bool {
        (self.matrix.inverse() * (point - self.shift)).abs().max_element() < 0.99
    }
}

/// Three rooms: along the axes, turned, and turned far from the origin.
fn rooms() -> [Room; 3] {
    let turn = Mat3::from_rotation_y(0.7) * Mat3::from_rotation_x(-0.4);
    [
        Room::new(Mat3::from_diagonal(Vec3::new(3.0, 1.4, 2.5)), Vec3::new(0.0, 0.25, 1.0)),
        Room::new(turn * 2.3, Vec3::ZERO),
        Room::new(turn * 4.0, Vec3::new(210.0, -35.0, 90.0)),
    ]
}

/// Casts so many rays in each room and returns those that got out.
fn leaks(count: usize, seed: u64, kernels: &[Kernel]) -> Vec<Ray> {
    const BATCH: usize = 4096;
    let mut leaks = Vec::new();
    for room in rooms() {
        let bvh = Bvh::build(&room.mesh.triangles(), &BvhParams::default());
        bvh.validate().unwrap();
        let mut random = Random(seed);
        for batch in 0..count.div_ceil(BATCH) {
            let bvh = bvh.clone().with_kernel(kernels[batch % kernels.len()]);
            let rays: Vec<Ray> = (0..BATCH).map(|_| room.ray(&mut random)).collect();
            let (mut hits, mut occluded) = (vec![Hit::MISS; BATCH], vec![false; BATCH]);
            bvh.closest_hits(&rays, &mut hits);
            bvh.occlusions(&rays, &mut occluded);
            let out = rays.iter().enumerate().filter(|&(i, _)| hits[i].is_miss() || !occluded[i]);
            leaks.extend(out.map(|(_, ray)| *ray));
        }
    }
    leaks
}

#[test]
fn no_ray_leaves_a_closed_room() {
    let leaks = leaks(100_000, 1, Kernel::available());
    assert!(leaks.is_empty(), "{} leaks, such as {:?}", leaks.len(), leaks[0]);
}

#[test]
#[ignore = "24 million rays"]
fn no_ray_of_many_leaves_a_closed_room() {
    let leaks = leaks(8_000_000, 2, &[Kernel::detect()]);
    assert!(leaks.is_empty(), "{} leaks, such as {:?}", leaks.len(), leaks[0]);
}
