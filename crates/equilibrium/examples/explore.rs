use radiosity_equilibrium::*;
use radiosity_exchange::Enclosure;
use std::sync::Arc;
fn main() {
    let scene = radiosity_scene::builtin::cornell_box(radiosity_scene::builtin::CornellVariant::Rgb);
    let patches = radiosity_scene::builtin::cornell_patches();
    let e: Vec<f64> = std::fs::read("/tmp/E.bin")
        .unwrap()
        .chunks_exact(8)
        .map(|c| f64::from_le_bytes(c.try_into().unwrap()))
        .collect();
    let n = patches.len();
    let mut l = Lighting { bands: 3, ..Default::default() };
    for i in 0..n {
        let m = &scene.surfaces[patches.surface[i] as usize].material;
        l.reflectance.extend(&m.reflectance);
        l.emission.extend(&m.emission);
    }
    let area = patches.area.clone();
    let enclosure = Arc::new(Enclosure::new(patches));
    let acc: f64 = std::env::args().nth(1).map_or(0.01, |a| a.parse().unwrap());
    let reps: u64 = std::env::args().nth(2).map_or(5, |a| a.parse().unwrap());
    let mut sums = [0.0; 8];
    for seed in 0..reps {
        let t = std::time::Instant::now();
        let s =
            solve(enclosure.clone(), &l, &Settings { accuracy: acc, seed, ..Settings::default() }, &Default::default())
                .unwrap();
        let dt = t.elapsed().as_secs_f64();
        let (mut err, mut lev, mut a) = (0.0, 0.0, 0.0);
        for i in 0..n {
            if l.emission[3 * i] > 0.0 {
                continue;
            }
            a += area[i];
            for b in 0..3 {
                err += area[i] * (s.irradiance[3 * i + b] - e[3 * i + b]).powi(2) / 3.0;
                lev += area[i] * e[3 * i + b] / 3.0;
            }
        }
        let true_err = (err / a).sqrt() / (lev / a);
        let r = &s.report;
        for (o, v) in sums.iter_mut().zip([
            dt,
            true_err * 100.,
            r.estimated_error * 100.,
            r.discretisation_error * 100.,
            r.rays as f64,
            r.shadow_rays as f64,
            r.seconds.sampling,
            r.seconds.solving,
        ]) {
            *o += v / reps as f64;
        }
    }
    println!(
        "acc {acc}: time {:.3} true {:.3}% est {:.3}% disc {:.3}% rays {:.0} shadow {:.0} sampling {:.3} solving {:.3}",
        sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7]
    );
}
