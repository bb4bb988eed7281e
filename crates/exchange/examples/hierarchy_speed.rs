//! How long a hierarchical exchange takes, how large it is, and how wrong its products are.
//!
//!     cargo run --release -p radiosity-exchange --example hierarchy_speed SCENE N TOLERANCE [SEPARATION SHARE NEAR]
//!
//! SCENE: cube, room, smooth, rough. Errors are those of products with radiosities from 0 to 1, root mean square over
//! area: against all pairs where there are few, else against rows by rays.

mod shapes;

use radiosity_exchange::hierarchy::{self, Settings};
use radiosity_exchange::pairs::{self, Kernel};
use radiosity_exchange::{Enclosure, Samples, Shot, shots};
use radiosity_operator::{Control, Operator, Symmetric};
use shapes::{cube, room, terrain};
use std::time::Instant;

/// More patches than these are not measured from centroid to centroid.
const MOST_CENTROIDS: usize = 12_000;

/// More patches than these are compared by rows.
const MOST_PAIRS: usize = 2_000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments.get(k).map(|a| a.parse::<f64>().expect("a number"));
    let n = number(1).unwrap_or(32.0) as usize;
    let patches = match arguments.first().map_or("smooth", String::as_str) {
        "cube" => cube(n),
        "room" => room(n, 12),
        "rough" => terrain(n, 0.8),
        _ => terrain(n, 0.0),
    };
    let count = patches.len();
    let start = Instant::now();
    let enclosure = Enclosure::new(patches);
    let bvh = start.elapsed().as_secs_f64();
    let mut settings = Settings::new(number(2).unwrap_or(1e-2), 0);
    settings.separation = number(3).unwrap_or(settings.separation);
    settings.ray_share = number(4).unwrap_or(settings.ray_share);
    settings.near = number(5).unwrap_or(settings.near);
    let start = Instant::now();
    let (operator, tally, of_pairs) =
        hierarchy::measure(&enclosure, &settings, &[], &Control::default()).expect("not cancelled");
    let seconds = start.elapsed().as_secs_f64();
    let fields = fields(&enclosure);
    let mut product = vec![0.0; count];
    operator.apply(&fields[0].1, &mut product, 1);
    let start = Instant::now();
    (0..10).for_each(|_| operator.apply(&fields[0].1, &mut product, 1));
    let once = 0.1 * start.elapsed().as_secs_f64();
    println!(
        "{count} patches: rays' tree {bvh:.2} s, build {seconds:.3} s, {:.0} bytes a patch, {:.1} links and {:.1} near pairs a patch, product {:.1} ms\n  {tally:?}\n  {of_pairs:?}",
        operator.memory_bytes() as f64 / count as f64,
        operator.links() as f64 / count as f64,
        operator.pairs() as f64 / count as f64,
        1e3 * once
    );
    let start = Instant::now();
    let check = hierarchy::Check::new(&enclosure, settings.tolerance, 0, &Control::default()).expect("not cancelled");
    let arriving: Vec<f64> = product.iter().enumerate().map(|(i, g)| g / enclosure.area(i)).collect();
    let found = check.deviations(&fields[0].1, &arriving, 1)[0];
    println!("  check in {:.2} s: error {:.2e}, mean {:.4}", start.elapsed().as_secs_f64(), found.error, found.mean);
    let rows: Vec<usize> =
        if count <= MOST_PAIRS { (0..count).collect() } else { (0..200).map(|k| (k * 7919 + 13) % count).collect() };
    let truth = truth(&enclosure, &rows, &fields);
    if count <= MOST_CENTROIDS {
        from_centroid_to_centroid(&enclosure, &rows, &fields, &truth);
    }
    for ((name, x), truth) in fields.iter().zip(truth) {
        operator.apply(x, &mut product, 1);
        print_error(&enclosure, name, &rows, &product, &truth);
    }
}

fn print_error(enclosure: &Enclosure, name: &str, rows: &[usize], product: &[f64], truth: &[f64]) {
    let (mut error, mut mean, mut area) = (0.0, 0.0, 0.0);
    for (&i, t) in rows.iter().zip(truth) {
        let a = enclosure.area(i);
        error += a * (product[i] / a - t).powi(2);
        mean += a * t;
        area += a;
    }
    let (rms, mean) = ((error / area).sqrt(), mean / area);
    println!("  {name:8} error {rms:.2e} of 1, {:.2} % of the mean {mean:.3}", 100.0 * rms / mean);
}

/// What form factors make of it that take the kernel and one ray from centroid to centroid, as Potter et al. (2022) do
/// before they compress: how long they take, their product as a plain sparse matrix, and their error.
fn from_centroid_to_centroid(enclosure: &Enclosure, rows: &[usize], fields: &[(&str, Vec<f64>)], truth: &[Vec<f64>]) {
    use rayon::prelude::*;
    let start = Instant::now();
    let n = enclosure.sides();
    let point = |i: usize| enclosure.off(i, enclosure.patches().centre[i]);
    let upper: Vec<Vec<(u32, f64)>> = (0..n)
        .into_par_iter()
        .map(|i| {
            let (x, normal) = (point(i), enclosure.normal(i));
            let (mut rays, mut row) = (Vec::new(), Vec::new());
            for j in i + 1..n {
                let r = enclosure.patches().centre[j] - enclosure.patches().centre[i];
                let (here, there) = (normal.dot(r), -enclosure.normal(j).dot(r));
                if here > 0.0 && there > 0.0 {
                    let kernel = here * there / (std::f64::consts::PI * r.length_squared().powi(2));
                    row.push((j as u32, kernel * enclosure.area(i) * enclosure.area(j)));
                    rays.push(enclosure.segment(x, point(j)));
                }
            }
            let mut occluded = vec![false; rays.len()];
            enclosure.bvh().occlusions(&rays, &mut occluded);
            row.into_iter().zip(occluded).filter(|(_, o)| !o).map(|(entry, _)| entry).collect()
        })
        .collect();
    let matrix = Symmetric::from_sparse_rows(&upper);
    let seconds = start.elapsed().as_secs_f64();
    let mut product = vec![0.0; n];
    matrix.apply(&fields[0].1, &mut product, 1);
    let start = Instant::now();
    (0..10).for_each(|_| matrix.apply(&fields[0].1, &mut product, 1));
    println!(
        "  centroids in {seconds:.2} s, {:.0} bytes a patch, product {:.2} ms",
        matrix.memory_bytes() as f64 / n as f64,
        100.0 * start.elapsed().as_secs_f64()
    );
    for ((name, x), truth) in fields.iter().zip(truth) {
        matrix.apply(x, &mut product, 1);
        print_error(enclosure, name, rows, &product, truth);
    }
}

/// Radiosities from 0 to 1: even, noise, a gradient, and lit from aside.
fn fields(enclosure: &Enclosure) -> Vec<(&'static str, Vec<f64>)> {
    let of = |f: &dyn Fn(usize) -> f64| (0..enclosure.sides()).map(f).collect::<Vec<f64>>();
    let sun = glam::DVec3::new(0.8, 0.3, 0.5).normalize();
    vec![
        ("even", of(&|_| 1.0)),
        ("noise", of(&|i| ((i as f64 * 78.233).sin() * 43758.5453).rem_euclid(1.0))),
        (
            "gradient",
            of(&|i| (0.5 * (enclosure.patches().centre[i].x + enclosure.patches().centre[i].z)).clamp(0.0, 1.0)),
        ),
        ("lit", of(&|i| enclosure.normal(i).dot(sun).max(0.0))),
    ]
}

/// What rows make of fields: by all pairs, or by rays.
fn truth(enclosure: &Enclosure, rows: &[usize], fields: &[(&str, Vec<f64>)]) -> Vec<Vec<f64>> {
    let start = Instant::now();
    let products = if enclosure.sides() <= MOST_PAIRS {
        let settings = pairs::Settings { kernel: Kernel::Auto, tolerance: 2e-3, seed: 1 };
        let (operator, _) = pairs::measure(enclosure, &settings, &Control::default()).expect("not cancelled");
        println!("  all pairs: {:.2} s, {:.0} MB", start.elapsed().as_secs_f64(), operator.memory_bytes() as f64 / 1e6);
        let product = |x: &Vec<f64>| {
            let mut y = vec![0.0; x.len()];
            operator.apply(x, &mut y, 1);
            rows.iter().map(|&i| y[i] / enclosure.area(i)).collect()
        };
        fields.iter().map(|f| product(&f.1)).collect()
    } else {
        let mut samples = Samples::<Shot>::new(enclosure.sides(), 1);
        let mut wanted = vec![0; enclosure.sides()];
        rows.iter().for_each(|&i| wanted[i] = 1 << 15);
        shots::shoot(enclosure, &mut samples, &wanted, 1, &Control::default()).expect("not cancelled");
        let mean = |x: &Vec<f64>, i: usize| {
            samples.of(i).flatten().filter(|s| s.landed()).map(|s| x[s.target() as usize]).sum::<f64>()
                / f64::from(1 << 15)
        };
        fields.iter().map(|f| rows.iter().map(|&i| mean(&f.1, i)).collect()).collect()
    };
    println!("  truth in {:.1} s", start.elapsed().as_secs_f64());
    products
}
