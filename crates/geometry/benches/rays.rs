//! Rays per second and build times on generated scenes, for each kernel that runs here.

mod scenes;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use radiosity_geometry::bvh::{Bvh, BvhParams, Hit, Kernel};
use scenes::{Rays, Scene};

const RAYS: usize = 1 << 14;

fn rays(criterion: &mut Criterion) {
    for scene in scenes::all() {
        bench_build(criterion, &scene);
        bench_rays(criterion, &scene);
    }
}

fn bench_build(criterion: &mut Criterion, scene: &Scene) {
    let mut group = criterion.benchmark_group(format!("build/{}", scene.name));
    group.sample_size(10).throughput(Throughput::Elements(scene.triangles.len() as u64));
    let presets = [
        ("default", BvhParams::default()),
        ("fast_build", BvhParams::fast_build()),
        ("fast_rays", BvhParams::fast_rays()),
    ];
    for (name, params) in presets {
        group.bench_function(name, |bencher| bencher.iter(|| Bvh::build(&scene.triangles, &params)));
    }
}

fn bench_rays(criterion: &mut Criterion, scene: &Scene) {
    let bvh = Bvh::build(&scene.triangles, &BvhParams::default());
    let generator = Rays::new(&scene.triangles);
    let mut group = criterion.benchmark_group(format!("rays/{}", scene.name));
    group.sample_size(20).throughput(Throughput::Elements(RAYS as u64));
    for &kernel in Kernel::available() {
        let bvh = bvh.clone().with_kernel(kernel);
        let mut hits = vec![Hit::MISS; RAYS];
        for (name, rays) in [("incoherent", generator.incoherent(RAYS, 1)), ("rows", generator.rows(RAYS, 2))] {
            group.bench_function(BenchmarkId::new(name, format!("{kernel:?}")), |bencher| {
                bencher.iter(|| bvh.closest_hits(&rays, &mut hits));
            });
        }
        let rays = generator.occlusion(RAYS, 3);
        let mut occluded = vec![false; RAYS];
        group.bench_function(BenchmarkId::new("occlusion", format!("{kernel:?}")), |bencher| {
            bencher.iter(|| bvh.occlusions(&rays, &mut occluded));
        });
    }
}

criterion_group!(benches, rays);
criterion_main!(benches);
