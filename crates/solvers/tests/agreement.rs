//! Every solver gives the answer of a direct solve, on closed and open exchanges.

use radiosity_operator::{Control, Dense};
use radiosity_solvers::{Problem, SolveOptions, Stop, conjugate_gradient, jacobi};

const N: usize = 24;
const BANDS: usize = 3;

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// A symmetric exchange and areas such that rows sum to `closure` of the area.
fn exchange(closure: f64, state: &mut u64) -> (Vec<f64>, Vec<f64>) {
    let mut g = vec![0.0; N * N];
    for i in 0..N {
        for j in 0..i {
            let v = random(state);
            g[i * N + j] = v;
            g[j * N + i] = v;
        }
    }
    let area = (0..N).map(|i| g[i * N..(i + 1) * N].iter().sum::<f64>() / closure).collect();
    (g, area)
}

/// Gaussian elimination of one band of `A B - rho G B = A E + rho A H0`.
fn direct(g: &[f64], problem: &Problem, band: usize) -> Vec<f64> {
    let at = |x: &[f64], i: usize| x[i * BANDS + band];
    let mut m: Vec<Vec<f64>> = (0..N)
        .map(|i| {
            let (area, rho) = (problem.area[i], at(problem.reflectance, i));
            let mut row: Vec<f64> = (0..N).map(|j| if i == j { area } else { 0.0 } - rho * g[i * N + j]).collect();
            row.push(area * (at(problem.emission, i) + rho * at(problem.incident, i)));
            row
        })
        .collect();
    for p in 0..N {
        let pivot = m[p].clone();
        for (_, row) in m.iter_mut().enumerate().filter(|(i, _)| *i != p) {
            let f = row[p] / pivot[p];
            row.iter_mut().zip(&pivot).for_each(|(x, v)| *x -= f * v);
        }
    }
    (0..N).map(|i| m[i][N] / m[i][i]).collect()
}

#[test]
fn solvers_agree_with_elimination() {
    let mut state = 1;
    for (closure, highest) in [(1.0, 0.5), (1.0, 0.99), (0.6, 0.9), (0.1, 0.99)] {
        let (g, area) = exchange(closure, &mut state);
        let mut block = |scale: f64| (0..N * BANDS).map(|_| scale * random(&mut state)).collect::<Vec<_>>();
        let (mut reflectance, mut emission, incident) = (block(highest), block(10.0), block(1.0));
        // A black element, a dark one, and a band without any emission.
        reflectance[..BANDS].fill(0.0);
        emission[BANDS..2 * BANDS].fill(0.0);
        emission.iter_mut().skip(2).step_by(BANDS).for_each(|e| *e = 0.0);
        let dense = Dense::new(N, g.clone());
        let problem = Problem {
            exchange: &dense,
            area: &area,
            reflectance: &reflectance,
            emission: &emission,
            incident: &incident,
            bands: BANDS,
        };
        problem.validate().unwrap();
        let options = SolveOptions { tolerance: 1e-12, max_iterations: 20_000 };
        let (cg, cg_report) = conjugate_gradient(&problem, &options, &Control::default()).unwrap();
        let (ja, ja_report) = jacobi(&problem, &options, &Control::default()).unwrap();
        assert_eq!((cg_report.stop, ja_report.stop), (Stop::Converged, Stop::Converged));
        assert!(cg_report.iterations < ja_report.iterations);
        for band in 0..BANDS {
            for (i, b) in direct(&g, &problem, band).into_iter().enumerate() {
                for (name, x) in [("conjugate gradient", &cg), ("jacobi", &ja)] {
                    let error = (x[i * BANDS + band] - b).abs() / b.abs().max(1e-3);
                    assert!(error < 1e-9, "{name}: element {i} band {band}: {} {b}", x[i * BANDS + band]);
                }
            }
        }
    }
}

#[test]
fn a_solver_says_when_it_did_not_converge() {
    let (g, area) = exchange(1.0, &mut 3);
    let dense = Dense::new(N, g);
    let (rho, emission, incident) = (vec![0.99; N], (0..N).map(|i| i as f64).collect::<Vec<_>>(), vec![0.0; N]);
    let problem = Problem {
        exchange: &dense,
        area: &area,
        reflectance: &rho,
        emission: &emission,
        incident: &incident,
        bands: 1,
    };
    let options = SolveOptions { tolerance: 1e-12, max_iterations: 3 };
    for (_, report) in [
        conjugate_gradient(&problem, &options, &Control::default()).unwrap(),
        jacobi(&problem, &options, &Control::default()).unwrap(),
    ] {
        assert_eq!(report.stop, Stop::MaxIterations);
        assert_eq!(report.iterations, 3);
        assert!(report.residuals.last().unwrap() > &1e-12);
    }
}

#[test]
fn bad_problems_are_named() {
    let dense = Dense::new(1, vec![0.0]);
    let problem = |rho, emission| Problem {
        exchange: &dense,
        area: &[1.0],
        reflectance: rho,
        emission,
        incident: &[0.0],
        bands: 1,
    };
    assert_eq!(
        problem(&[1.0], &[0.0]).validate().unwrap_err().to_string(),
        "element 0, band 0: reflectance 1 is outside [0, 1)"
    );
    assert_eq!(problem(&[0.5], &[f64::NAN]).validate().unwrap_err().to_string(), "emission of element 0 is not finite");
    assert!(problem(&[0.5], &[]).validate().unwrap_err().to_string().contains("0 values, 1 are needed"));
}
