//! Times Embree and our own engine on the same triangles and rays in one run, and prints the ratio.
//!
//! Engines take turns on short slices of the rays, and of each slice the lower quartile of its times counts: a machine
//! with other things to do slows some turns of every engine, not all turns of one.

mod embree;
#[path = "../../../crates/geometry/benches/scenes/mod.rs"]
mod scenes;

use embree::{Embree, PeerRay};
use radiosity_geometry::bvh::{Bvh, BvhParams, Hit, Kernel, Ray};
use scenes::{Rays, Scene};
use std::time::Instant;

const RAYS: usize = 1 << 17;
/// Rays that are timed together.
const SLICE: usize = 1 << 12;
/// Rays that one call of an engine gets.
const BATCH: usize = 1 << 10;

fn main() {
    let turns = argument(1, 12);
    let most_threads = argument(2, 2);
    let wanted = std::env::args().nth(3).unwrap_or_default();
    for scene in scenes::all().iter().filter(|scene| scene.name.contains(&wanted)) {
        compare(scene, turns, most_threads);
    }
}

fn argument(position: usize, default: usize) -> usize {
    std::env::args().nth(position).and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn compare(scene: &Scene, turns: usize, most_threads: usize) {
    let triangles = &scene.triangles;
    println!("\n## {}, {} triangles\n", scene.name, triangles.len());
    report_builds(scene, turns);

    let bvh = Bvh::build(triangles, &BvhParams::default());
    println!(
        "tree: expected cost {:.1}, {:.1} MB, detected kernel {:?}\n",
        bvh.sah_cost(),
        bvh.memory_bytes() as f64 / 1e6,
        Kernel::detect()
    );
    let slow = bvh.clone().with_kernel(Kernel::available()[Kernel::available().len().saturating_sub(2)]);
    let better = Bvh::build(triangles, &BvhParams::fast_rays());
    let engines: [(&str, &dyn Engine); 5] = [
        ("embree", &Embree::build(triangles, false, most_threads)),
        ("embree robust", &Embree::build(triangles, true, most_threads)),
        ("ours", &bvh),
        ("ours, fast_rays", &better),
        ("ours, next kernel", &slow),
    ];
    let generator = Rays::new(triangles);
    println!("| rays | threads | {} | ratio to embree | to robust |", engines.map(|e| e.0).join(" | "));
    println!("|---|---|{}---|---|", "---|".repeat(engines.len()));
    for (name, rays, query) in [
        ("closest, incoherent", generator.incoherent(RAYS, 1), Query::Closest),
        ("closest, rows", generator.rows(RAYS, 2), Query::Closest),
        ("occlusion", generator.occlusion(RAYS, 3), Query::Occlusion),
    ] {
        let rays = Prepared::new(rays);
        for threads in 1..=most_threads {
            let speeds = speeds(&engines.map(|e| e.1), &rays, query, threads, turns);
            let columns: Vec<String> = speeds.iter().map(|speed| format!("{speed:.2}")).collect();
            println!(
                "| {name} | {threads} | {} | {:.2} | {:.2} |",
                columns.join(" | "),
                speeds[2] / speeds[0],
                speeds[2] / speeds[1]
            );
        }
        check(engines[1].1, engines[2].1, &rays, query);
    }
}

/// Times each build in turn, all threads.
fn report_builds(scene: &Scene, turns: usize) {
    let triangles = &scene.triangles;
    let mut times = [vec![], vec![], vec![], vec![]];
    for _ in 0..turns {
        for (i, params) in [BvhParams::default(), BvhParams::fast_build(), BvhParams::fast_rays()].iter().enumerate() {
            times[i].push(1e3 * seconds(|| drop(Bvh::build(triangles, params))));
        }
        times[3].push(1e3 * seconds(|| drop(Embree::build(triangles, false, 2))));
    }
    let [default, fast_build, fast_rays, peer] = times.map(|times| quantile(times.into_iter(), 0.25));
    println!("build, ms: default {default:.2}, fast_build {fast_build:.2}, fast_rays {fast_rays:.2}, embree {peer:.2}");
}

#[derive(Clone, Copy, PartialEq)]
enum Query {
    Closest,
    Occlusion,
}

/// The same rays as each engine wants them, so that no conversion is timed.
struct Prepared {
    ours: Vec<Ray>,
    peers: Vec<PeerRay>,
}

/// Some of the rays.
pub struct Batch<'a> {
    ours: &'a [Ray],
    peers: &'a [PeerRay],
}

impl Prepared {
    fn new(ours: Vec<Ray>) -> Self {
        let peers = ours.iter().map(PeerRay::new).collect();
        Self { ours, peers }
    }

    fn batches(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = Batch<'_>> {
        let batches = self.ours[range.clone()].chunks(BATCH).zip(self.peers[range].chunks(BATCH));
        batches.map(|(ours, peers)| Batch { ours, peers })
    }
}

/// What is timed: both queries on a batch of rays. A distance is infinite for a miss.
pub trait Engine: Sync {
    /// Distances of the closest hits.
    fn closest(&self, rays: &Batch, t: &mut [f32; BATCH]);
    /// Whether there is any hit.
    fn occluded(&self, rays: &Batch, occluded: &mut [bool; BATCH]);
}

impl Engine for Bvh {
    fn closest(&self, rays: &Batch, t: &mut [f32; BATCH]) {
        let mut hits = [Hit::MISS; BATCH];
        self.closest_hits(rays.ours, &mut hits);
        for (t, hit) in t.iter_mut().zip(&hits) {
            *t = hit.t;
        }
    }
    fn occluded(&self, rays: &Batch, occluded: &mut [bool; BATCH]) {
        self.occlusions(rays.ours, occluded);
    }
}

/// Millions of rays per second of each engine.
fn speeds<const N: usize>(
    engines: &[&dyn Engine; N],
    rays: &Prepared,
    query: Query,
    threads: usize,
    turns: usize,
) -> [f64; N] {
    let slices = rays.ours.len() / SLICE;
    let mut times = vec![vec![Vec::new(); slices]; N];
    for turn in 0..=turns {
        for (engine, times) in engines.iter().zip(&mut times) {
            let turn_times = cast(*engine, rays, query, threads);
            // The first turn warms up.
            if turn > 0 {
                times.iter_mut().zip(turn_times).for_each(|(times, time)| times.push(time));
            }
        }
    }
    let total = |times: &Vec<Vec<f64>>| times.iter().map(|times| quantile(times.iter().copied(), 0.25)).sum::<f64>();
    std::array::from_fn(|i| (threads * rays.ours.len()) as f64 / total(&times[i]) * 1e-6)
}

/// Casts all rays and returns the seconds that each slice took.
fn cast(engine: &dyn Engine, rays: &Prepared, query: Query, threads: usize) -> Vec<f64> {
    let slices = rays.ours.len() / SLICE;
    let mut times = vec![0.0; slices];
    std::thread::scope(|scope| {
        let share = slices.div_ceil(threads);
        for (thread, times) in times.chunks_mut(share).enumerate() {
            scope.spawn(move || {
                for (slice, time) in times.iter_mut().enumerate() {
                    let first = (thread * share + slice) * SLICE;
                    *time = seconds(|| cast_slice(engine, rays, first, query));
                }
            });
        }
    });
    times
}

fn cast_slice(engine: &dyn Engine, rays: &Prepared, first: usize, query: Query) {
    let (mut t, mut occluded) = ([0.0; BATCH], [false; BATCH]);
    for batch in rays.batches(first..first + SLICE) {
        match query {
            Query::Closest => engine.closest(&batch, &mut t),
            Query::Occlusion => engine.occluded(&batch, &mut occluded),
        }
    }
    std::hint::black_box((&t, &occluded));
}

/// Says how many answers differ between Embree's robust mode and ours.
fn check(peer: &dyn Engine, ours: &dyn Engine, rays: &Prepared, query: Query) {
    let (mut different, mut misses) = (0, [0, 0]);
    for batch in rays.batches(0..rays.ours.len()) {
        let [p, q] = [peer, ours].map(|engine| answers(engine, &batch, query));
        for (p, q) in p.into_iter().zip(q) {
            misses[0] += usize::from(p.is_infinite());
            misses[1] += usize::from(q.is_infinite());
            let same = p == q || (p - q).abs() <= 1e-4 * p.abs().max(1e-2);
            different += usize::from(!same);
        }
    }
    println!("<!-- {different} answers differ; misses: embree robust {}, ours {} -->", misses[0], misses[1]);
}

/// Distances, or one and infinity for yes and no.
fn answers(engine: &dyn Engine, batch: &Batch, query: Query) -> [f32; BATCH] {
    let (mut t, mut occluded) = ([0.0; BATCH], [false; BATCH]);
    match query {
        Query::Closest => engine.closest(batch, &mut t),
        Query::Occlusion => {
            engine.occluded(batch, &mut occluded);
            t = occluded.map(|occluded| if occluded { 1.0 } else { f32::INFINITY });
        }
    }
    t
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn quantile(times: impl Iterator<Item = f64>, quantile: f64) -> f64 {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    times[(times.len() as f64 * quantile) as usize]
}
