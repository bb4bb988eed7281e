//! What hemicubes of known scenes see.

use super::*;
use crate::kernels::point_to_polygon::point_to_polygon;
use radiosity_geometry::Patches;

const CORNERS: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

/// A box seen from inside or, with its faces turned, from outside.
fn faces(low: DVec3, high: DVec3, inward: bool) -> Vec<[DVec3; 4]> {
    let corner = |k: usize| {
        let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
        DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    CORNERS
        .iter()
        .map(|face| {
            let p = face.map(corner);
            if inward { p } else { [p[3], p[2], p[1], p[0]] }
        })
        .collect()
}

/// Cuts a parallelogram into `n x n`, every other one into triangles.
fn cut(p: [DVec3; 4], n: usize) -> Vec<[DVec3; 4]> {
    let at = |i: usize, j: usize| {
        // Weights of all four corners, so that two faces compute the points of a common edge alike.
        let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
        p[0] * ((1. - s) * (1. - t)) + p[1] * (s * (1. - t)) + p[2] * (s * t) + p[3] * ((1. - s) * t)
    };
    let quad = |k: usize| {
        let (i, j) = (k % n, k / n);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    };
    let halves = |[a, b, c, d]: [DVec3; 4]| [[a, b, c, c], [a, c, d, d]];
    (0..n * n).flat_map(|k| if k % 2 == 0 { vec![quad(k)] } else { halves(quad(k)).to_vec() }).collect()
}

fn patches(polygons: Vec<[DVec3; 4]>, two_sided: bool) -> Patches {
    let n = polygons.len();
    Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![two_sided; n])
}

fn enclosure(polygons: Vec<[DVec3; 4]>) -> Enclosure {
    Enclosure::new(patches(polygons, false))
}

/// A unit cube with blocks that hang in it, nothing parallel to the walls about them.
fn room(n: usize) -> Enclosure {
    let mut polygons: Vec<_> = faces(DVec3::ZERO, DVec3::ONE, true).into_iter().flat_map(|f| cut(f, n)).collect();
    for (k, low) in [DVec3::new(0.3, 0.3, 0.2), DVec3::new(0.6, 0.1, 0.55)].into_iter().enumerate() {
        let turn = glam::DQuat::from_rotation_y(0.3 + k as f64) * glam::DQuat::from_rotation_x(0.2);
        let block = faces(DVec3::ZERO, DVec3::new(0.3, 0.3, 0.2), false);
        let place = |polygon: [DVec3; 4]| polygon.map(|p| low + turn * p);
        polygons.extend(block.into_iter().flat_map(|f| cut(place(f), 2)));
    }
    enclosure(polygons)
}

fn all_rows(enclosure: &Enclosure, settings: &Settings) -> Rows {
    rows(enclosure, settings, &Control::default()).unwrap()
}

fn sum(row: &[(u32, f64)]) -> f64 {
    row.iter().map(|(_, f)| f).sum()
}

fn factor(row: &[(u32, f64)], side: usize) -> f64 {
    row.iter().find(|(to, _)| *to as usize == side).map_or(0.0, |(_, f)| *f)
}

#[test]
fn every_row_of_a_closed_room_sums_to_one() {
    for enclosure in [enclosure(faces(DVec3::ZERO, DVec3::ONE, true)), room(1), room(5)] {
        for (resolution, positions) in [(8, 1), (10, 3), (128, 1), (130, 2)] {
            let rows = all_rows(&enclosure, &Settings { resolution, positions, seed: 5 });
            assert_eq!(rows.len(), enclosure.sides());
            for side in 0..rows.len() {
                let sum = sum(rows.row(side));
                assert!((sum - 1.0).abs() < 1e-12, "{resolution} {positions} {side}: {sum}");
                assert!(rows.row(side).windows(2).all(|w| w[0].0 < w[1].0));
                assert_eq!(factor(rows.row(side), side), 0.0);
            }
        }
    }
}
