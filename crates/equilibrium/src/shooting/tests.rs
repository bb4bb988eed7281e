use super::*;
use crate::lighting::Lamp;
use glam::DVec3;
use radiosity_geometry::Patches;

/// A closed box of squares of side `1 / n`, all facing in.
fn closed_box(n: usize) -> Enclosure {
    let mut polygons = Vec::new();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for axis in 0..3 {
        let (u, v) = (axes[(axis + 1) % 3] / n as f64, axes[(axis + 2) % 3] / n as f64);
        for (i, j) in (0..n * n).map(|k| ((k % n) as f64, (k / n) as f64)) {
            let corner = i * u + j * v;
            polygons.push([corner, corner + u, corner + u + v, corner + v]);
            polygons.push([corner, corner + v, corner + u + v, corner + u].map(|p| p + axes[axis]));
        }
    }
    let count = polygons.len();
    Enclosure::new(Patches::new(polygons, vec![0; count], (0..count as u32).collect(), vec![false; count]))
}

fn uniform(enclosure: &Enclosure, reflectance: &[f64], emission: &[f64]) -> Lighting {
    let n = enclosure.patches().len();
    Lighting {
        bands: reflectance.len(),
        reflectance: reflectance.repeat(n),
        emission: emission.repeat(n),
        ..Lighting::default()
    }
}

fn settings(accuracy: f64) -> ShootingSettings {
    ShootingSettings { accuracy, seed: 3, max_rays: 1 << 18, time_limit: f64::INFINITY, memory_limit: u64::MAX }
}

#[test]
fn a_furnace_has_its_closed_form() {
    let enclosure = closed_box(4);
    let lighting = uniform(&enclosure, &[0.5, 0.95], &[1.0, 2.0]);
    let solution = shoot(&enclosure, &lighting, &settings(0.02), None, &Control::default()).unwrap();
    // B = E / (1 - rho) everywhere, and all that is emitted arrives.
    let truth = [2.0, 40.0];
    let square: f64 = solution.irradiance.iter().enumerate().map(|(k, h)| (h - truth[k % 2]).powi(2)).sum();
    let relative = (square / solution.irradiance.len() as f64).sqrt() / 21.0;
    assert!(relative < 2.0 * solution.report.estimated_error && relative < 0.03, "{relative}");
    assert!(solution.report.energy.imbalance.abs() < 1e-12);
}

#[test]
fn power_balances_where_it_escapes_and_ends_on_backs() {
    // Half a box, lit by a point; a plate in it turns its back.
    let mut patches = closed_box(2).patches().clone();
    patches.polygons.truncate(12);
    let h = 0.7;
    patches.polygons.push([
        DVec3::new(0.2, h, 0.2),
        DVec3::new(0.2, h, 0.8),
        DVec3::new(0.8, h, 0.8),
        DVec3::new(0.8, h, 0.2),
    ]);
    let n = patches.polygons.len();
    let enclosure = Enclosure::new(Patches::new(patches.polygons, vec![0; n], vec![0; n], vec![false; n]));
    let mut lighting = uniform(&enclosure, &[0.6, 0.2, 0.9], &[0.0, 0.1, 0.0]);
    let luminaire = Luminaire::Point { position: DVec3::new(0.4, 0.5, 0.6) };
    lighting.lamps.push(Lamp { luminaire, strength: vec![3.0, 1.0, 1e-3] });
    let report = shoot(&enclosure, &lighting, &settings(0.05), None, &Control::default()).unwrap().report;
    assert!(report.energy.imbalance.abs() < 1e-12);
    assert!(report.energy.escaped.iter().all(|&e| e > 0.0) && report.energy.lost_on_backs.iter().all(|&l| l > 0.0));
}

#[test]
fn going_on_is_asking_at_once() {
    let enclosure = closed_box(3);
    let mut lighting = uniform(&enclosure, &[0.7], &[0.0]);
    lighting.emission[7] = 10.0;
    let control = Control::default();
    let rough = shoot(&enclosure, &lighting, &settings(0.2), None, &control).unwrap();
    let parts = rough.state.to_parts();
    let state = Shooting::from_parts(parts.clone()).unwrap();
    assert_eq!(&state, rough.state.as_ref());
    let on = shoot(&enclosure, &lighting, &settings(0.01), Some(&state), &control).unwrap();
    let at_once = shoot(&enclosure, &lighting, &settings(0.01), None, &control).unwrap();
    assert!(on.report.rounds > rough.report.rounds);
    assert_eq!((on.irradiance, on.error), (at_once.irradiance, at_once.error));
    let shorter = Parts { landed: parts.landed[1..].to_vec(), ..parts };
    assert!(Shooting::from_parts(shorter).is_err());
}

#[test]
fn the_bytes_do_not_depend_on_threads() {
    let enclosure = closed_box(3);
    let mut lighting = uniform(&enclosure, &[0.7, 0.4], &[0.0, 0.3]);
    lighting.emission[8] = 10.0;
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shoot(&enclosure, &lighting, &settings(0.03), None, &Control::default()).unwrap().irradiance)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn what_does_not_fit_is_not_begun() {
    let enclosure = closed_box(2);
    let lighting = uniform(&enclosure, &[0.5], &[1.0]);
    let tight = ShootingSettings { memory_limit: 1000, ..settings(0.1) };
    assert!(matches!(shoot(&enclosure, &lighting, &tight, None, &Control::default()), Err(Failure::Memory { .. })));
}

#[test]
fn counts_go_on_where_sequences_are_even() {
    let counts: Vec<u32> = std::iter::successors(Some(0), |&n| Some(more(n))).take(9).collect();
    assert_eq!(counts, [0, 4, 8, 12, 16, 24, 32, 48, 64]);
}
