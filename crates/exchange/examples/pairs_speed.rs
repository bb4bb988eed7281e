//! How long all pairs take: cubes, a room with a box, a rough terrain.
//!
//!     cargo run --release -p radiosity-exchange --example pairs_speed [SCENE [TOLERANCE ...]]

use glam::DVec3;
use radiosity_exchange::Enclosure;
use radiosity_exchange::pairs::{Kernel, Settings, measure};
use radiosity_geometry::Patches;
use radiosity_operator::{Control, Operator};
use std::time::Instant;

fn cube(n: usize) -> Patches {
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
fn terrain(n: usize, roughness: f64) -> Patches {
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

fn main() {
    let only = std::env::args().nth(1).unwrap_or_default();
    let tolerances: Vec<f64> = std::env::args().skip(2).map(|a| a.parse().expect("a tolerance")).collect();
    let tolerances = if tolerances.is_empty() { vec![1e-3] } else { tolerances };
    for (name, patches) in [
        ("cube-2400", cube(20)),
        ("cube-6144", cube(32)),
        ("cube-15000", cube(50)),
        ("smooth-2048", terrain(32, 0.0)),
        ("rough-2048", terrain(32, 0.8)),
        ("smooth-10082", terrain(71, 0.0)),
    ] {
        if !name.contains(&only) {
            continue;
        }
        let n = patches.len();
        let area = patches.area.clone();
        let enclosure = Enclosure::new(patches);
        for &tolerance in &tolerances {
            let start = Instant::now();
            let settings = Settings { kernel: Kernel::Auto, tolerance, seed: 0 };
            let (g, tally) = measure(&enclosure, &settings, &Control::default()).expect("not cancelled");
            let seconds = start.elapsed().as_secs_f64();
            let sums: Vec<f64> = g.row_sums().iter().zip(&area).map(|(s, a)| s / a).collect();
            let (low, high) = sums.iter().fold((1e9f64, 0f64), |(l, h), s| (l.min(*s), h.max(*s)));
            println!(
                "{name} {n} patches, tolerance {tolerance}: {seconds:.3} s, {:.0} MB, rows {low:.6} to {high:.6}\n  {tally:?}",
                g.memory_bytes() as f64 / 1e6
            );
        }
    }
}
