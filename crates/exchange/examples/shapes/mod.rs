//! Scenes of any size.
#![allow(dead_code)]

use glam::DVec3;
use radiosity_geometry::Patches;

/// The inside of the unit cube, `n x n` squares a face.
pub fn cube(n: usize) -> Patches {
    let p = DVec3::new;
    let faces = [
        (p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.)),
        (p(0., 0., 0.), p(0., 1., 0.), p(0., 0., 1.)),
        (p(0., 0., 0.), p(0., 0., 1.), p(1., 0., 0.)),
        (p(1., 1., 1.), p(0., -1., 0.), p(-1., 0., 0.)),
        (p(1., 1., 1.), p(0., 0., -1.), p(0., -1., 0.)),
        (p(1., 1., 1.), p(-1., 0., 0.), p(0., 0., -1.)),
    ];
    let cells = |&(o, u, v): &(DVec3, DVec3, DVec3)| {
        let (u, v) = (u / n as f64, v / n as f64);
        (0..n * n).map(move |c| {
            let a = o + (c % n) as f64 * u + (c / n) as f64 * v;
            [a, a + u, a + u + v, a + v]
        })
    };
    all(faces.iter().flat_map(cells).collect())
}

/// A height field of `n x n` cells with craters and roughness, two triangles a cell.
pub fn terrain(n: usize, roughness: f64) -> Patches {
    let noise = |k: usize| {
        let x = (k as f64 * 12.9898).sin() * 43758.5453;
        x - x.floor()
    };
    let height = |i: usize, j: usize| {
        let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
        let bowl = |cx: f64, cy: f64, r: f64| {
            let d = ((x - cx).powi(2) + (y - cy).powi(2)).sqrt() / r;
            if d < 1.3 { r * 0.4 * ((d * d - 1.0).min(0.15 * (1.3 - d) / 0.3)) } else { 0.0 }
        };
        let craters: f64 = (0..8).map(|k| bowl(noise(3 * k), noise(3 * k + 1), 0.05 + 0.25 * noise(3 * k + 2))).sum();
        craters + roughness / n as f64 * noise(1000 + i * (n + 1) + j)
    };
    let at = |i: usize, j: usize| DVec3::new(i as f64 / n as f64, j as f64 / n as f64, height(i, j));
    let cells = (0..n * n).flat_map(|c| {
        let (i, j) = (c % n, c / n);
        let (a, b, d, e) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, d, d], [a, d, e, e]]
    });
    all(cells.collect())
}

fn all(polygons: Vec<[DVec3; 4]>) -> Patches {
    let n = polygons.len();
    Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![false; n])
}

/// The inside of a cube with `n x n` squares a face, and `boxes` closed boxes standing in it, cut as finely.
pub fn room(n: usize, boxes: usize) -> Patches {
    let noise = |k: usize| {
        let x = (k as f64 * 12.9898).sin() * 43758.5453;
        x - x.floor()
    };
    let p = DVec3::new;
    let (mut polygons, mut face) = (cube(n).polygons, Vec::new());
    face.extend((0..polygons.len()).map(|k| (k / (n * n)) as u32));
    for k in 0..boxes {
        let size = p(0.08 + 0.2 * noise(7 * k), 0.08 + 0.2 * noise(7 * k + 1), 0.05 + 0.35 * noise(7 * k + 2));
        let low = p((0.98 - size.x) * noise(7 * k + 3) + 0.01, (0.98 - size.y) * noise(7 * k + 4) + 0.01, 0.0);
        let (x, y, z) = (p(size.x, 0., 0.), p(0., size.y, 0.), p(0., 0., size.z));
        for (f, (o, u, v)) in
            [(low + z, x, y), (low, x, z), (low, z, y), (low + y, z, x), (low + x, y, z)].into_iter().enumerate()
        {
            let (a, b) = ((u.length() * n as f64).ceil() as usize, (v.length() * n as f64).ceil() as usize);
            let (u, v) = (u / a as f64, v / b as f64);
            for c in 0..a * b {
                let at = o + (c % a) as f64 * u + (c / a) as f64 * v;
                polygons.push([at, at + u, at + u + v, at + v]);
                face.push((6 + 5 * k + f) as u32);
            }
        }
    }
    let count = polygons.len();
    Patches::new(polygons, vec![0; count], face, vec![false; count])
}
