//! How long all pairs take: cubes, a room with a box, a rough terrain.
//!
//!     cargo run --release -p radiosity-exchange --example pairs_speed [SCENE [TOLERANCE ...]]

mod shapes;

use radiosity_exchange::Enclosure;
use radiosity_exchange::pairs::{Kernel, Settings, measure};
use radiosity_operator::{Control, Operator};
use shapes::{cube, terrain};
use std::time::Instant;

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
