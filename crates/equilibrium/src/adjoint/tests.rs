use super::*;
use crate::lighting::Lamp;
use crate::solve::{Closure, Settings, relight, solve};
use crate::{solve_linked, solve_on_demand};
use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_operator::Dense;
use std::sync::Arc;

/// G of three elements and their areas; rows sum to less. The last has no area, but is seen.
const EXCHANGE: [f64; 9] = [0.0, 0.5, 0.1, 0.5, 0.2, 0.2, 0.1, 0.2, 0.0];
const AREA: [f64; 3] = [1.0, 2.0, 0.0];
const REFLECTANCE: [f64; 6] = [0.5, 0.8, 0.3, 0.1, 0.9, 0.9];

fn radiosity(emission: &[f64]) -> Vec<f64> {
    let exchange = Dense::new(3, EXCHANGE.to_vec());
    let problem: Problem = Problem {
        exchange: &exchange,
        area: &AREA,
        reflectance: &REFLECTANCE,
        emission,
        incident: &[0.0; 6],
        bands: 2,
    };
    conjugate_gradient(&problem, &options(0.9), &Control::default()).unwrap().0
}

#[test]
fn a_solve_and_its_transpose_agree() {
    let exchange = Dense::new(3, EXCHANGE.to_vec());
    let sides = Sides::new(&exchange, &AREA, &REFLECTANCE, 2);
    let (worth, emission) = ([1.0, -2.0, 0.5, 3.0, 0.7, -0.2], [2.0, 1.0, 0.0, 4.0, 3.0, 0.5]);
    let sent = sides.transposed(&worth, &Control::default()).unwrap();
    let radiosity = radiosity(&emission);
    for band in 0..2 {
        let dot = |a: &[f64], b: &[f64]| -> f64 { (0..3).map(|i| a[2 * i + band] * b[2 * i + band]).sum() };
        assert!((dot(&worth, &radiosity) - dot(&sent, &emission)).abs() < 1e-9);
    }
}

#[test]
fn no_equilibrium_has_no_derivatives() {
    // Rows sum to twice the area.
    let exchange = Dense::new(2, vec![0.0, 2.0, 2.0, 0.0]);
    let sides = Sides::new(&exchange, &[1.0; 2], &[0.9; 2], 1);
    assert_eq!(sides.transposed(&[1.0, 1.0], &Control::default()), Err(Failure::Diverged));
}

/// A box of squares, four to a face, with a two-sided plate in it and a lamp below that.
fn room() -> Arc<Enclosure> {
    let mut polygons = Vec::new();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for axis in 0..3 {
        let (u, v) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        for corner in [DVec3::ZERO, u, v, u + v] {
            polygons.push([corner, corner + u, corner + u + v, corner + v]);
            polygons.push([corner, corner + v, corner + u + v, corner + u].map(|p| p + 2.0 * axes[axis]));
        }
    }
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    polygons.push([at(0.3, 1.0, 0.3), at(0.3, 1.0, 1.5), at(1.5, 1.0, 1.5), at(1.5, 1.0, 0.3)]);
    polygons.push([at(0.9, 0.4, 0.9), at(0.9, 0.4, 1.1), at(1.1, 0.4, 1.1), at(1.1, 0.4, 0.9)]);
    let count = polygons.len();
    let two_sided = (0..count).map(|i| i == count - 2).collect();
    let surface = (0..count).map(|i| if i < 24 { 0 } else { i as u32 }).collect();
    Arc::new(Enclosure::new(Patches::new(polygons, surface, (0..count as u32).collect(), two_sided)))
}

/// Bright lamp, faint plate, a bulb.
fn lighting() -> Lighting {
    let patches = 26;
    let mut emission = vec![0.0; 2 * patches];
    emission[48..].copy_from_slice(&[1.0, 2.0, 300.0, 200.0]);
    Lighting {
        bands: 2,
        reflectance: (0..2 * patches).map(|k| 0.1 + 0.7 * (k % 7) as f64 / 6.0).collect(),
        emission,
        lamps: vec![Lamp {
            luminaire: Luminaire::Point { position: DVec3::new(1.7, 1.6, 0.4) },
            strength: vec![5.0, 9.0],
        }],
        ..Lighting::default()
    }
}

fn weights() -> Vec<f64> {
    (0..52).map(|k| ((k * 37 + 11) % 19) as f64 / 19.0 - 0.3).collect()
}

fn settings() -> Settings {
    Settings { accuracy: 0.05, closure: Closure::Exact, ..Settings::default() }
}

fn sums(solution: &Solution, weights: &[f64]) -> [f64; 2] {
    [0, 1].map(|band| (band..52).step_by(2).map(|k| weights[k] * solution.irradiance[k]).sum())
}

/// On samples, and on blocks.
fn solutions() -> [Solution; 2] {
    let (lighting, control) = (lighting(), Control::default());
    let linked = Settings { accuracy: 1e-3, ..settings() };
    [
        solve(room(), &lighting, &settings(), &control).unwrap(),
        solve_linked(&room(), &lighting, &linked, None, &control).unwrap(),
    ]
}

#[test]
fn light_is_the_sum_of_what_it_owes_to_each_lamp() {
    // Irradiance is linear and homogeneous in what shines (Euler).
    let (lighting, weights) = (lighting(), weights());
    for (solution, tolerance) in solutions().iter().zip([1e-8, 1e-4]) {
        let found = &gradients(solution, &lighting, std::slice::from_ref(&weights), &Control::default()).unwrap()[0];
        for (band, sum) in sums(solution, &weights).into_iter().enumerate() {
            let owed: f64 = (band..52).step_by(2).map(|k| found.emission[k] * lighting.emission[k]).sum();
            let owed = owed + found.lamps[band] * lighting.lamps[0].strength[band];
            assert!((owed - sum).abs() < tolerance * sum.abs(), "{owed} {sum}");
        }
    }
}

#[test]
fn paint_does_what_its_derivatives_say() {
    let (lighting, weights, control) = (lighting(), weights(), Control::default());
    let tight = Settings { accuracy: 1e-7, ..settings() };
    for solution in solutions() {
        let solution = relight(&solution.source, &lighting, &tight, &control).unwrap();
        let found = &gradients(&solution, &lighting, std::slice::from_ref(&weights), &control).unwrap()[0];
        for patch in [3, 24, 25] {
            let painted = |step: f64| {
                let mut lighting = lighting.clone();
                lighting.reflectance[2 * patch..2 * patch + 2].iter_mut().for_each(|rho| *rho += step);
                sums(&relight(&solution.source, &lighting, &tight, &control).unwrap(), &weights)
            };
            let (up, down) = (painted(1e-3), painted(-1e-3));
            for band in 0..2 {
                let (derivative, difference) = (found.reflectance[2 * patch + band], (up[band] - down[band]) / 2e-3);
                // The step leaves a part of its square, 1e-6, and the solver 1e-9 over the step.
                assert!((derivative - difference).abs() < 1e-5 * derivative.abs(), "{derivative} {difference}");
            }
        }
    }
}

#[test]
fn sums_together_are_sums_apart() {
    let (lighting, control) = (lighting(), Control::default());
    let (one, two) = (weights(), vec![1.0; 52]);
    for solution in solutions() {
        let alone =
            |weights: &Vec<f64>| gradients(&solution, &lighting, std::slice::from_ref(weights), &control).unwrap();
        let together = gradients(&solution, &lighting, &[one.clone(), two.clone()], &control).unwrap();
        assert_eq!(together, [alone(&one), alone(&two)].concat());
    }
}

#[test]
fn rows_on_demand_have_none() {
    let settings = Settings { accuracy: 0.1, method: crate::Method::Southwell, ..settings() };
    let solution = solve_on_demand(&room(), &lighting(), &settings, None, &Control::default()).unwrap();
    let found = gradients(&solution, &lighting(), &[weights()], &Control::default());
    assert_eq!(found, Err(Failure::OnDemand));
}
