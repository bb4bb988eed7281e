//! Every solver gives the answer of a direct solve, on closed and open exchanges.

use crate::random::Room;
use radiosity_operator::{Cancelled, Control, Dense};
use radiosity_solvers::{
    Overshoot, Problem, SolveOptions, SolveReport, Stop, conjugate_gradient, gauss_seidel, jacobi, over_relaxation,
    southwell,
};

type Solver = fn(&Problem, &SolveOptions, &Control) -> Result<(Vec<f64>, SolveReport), Cancelled>;

const SOLVERS: [(&str, Solver); 6] = [
    ("conjugate gradient", conjugate_gradient),
    ("jacobi", jacobi),
    ("gauss-seidel", gauss_seidel),
    ("over-relaxation", over_relaxation),
    ("southwell", |p, o, c| southwell(p, Overshoot::None, o, c)),
    ("overshooting", |p, o, c| southwell(p, Overshoot::Ambient, o, c)),
];

#[test]
fn solvers_agree_with_elimination() {
    let mut state = 1;
    for (closure, highest) in [(1.0, 0.5), (1.0, 0.99), (0.6, 0.9), (0.1, 0.99)] {
        for bands in [1, 3, 4, 5] {
            let mut room = Room::new(24, bands, closure, highest, &mut state);
            // A black element, a dark one, and where there are several bands one without any light.
            room.reflectance[..bands].fill(0.0);
            room.emission[bands..2 * bands].fill(0.0);
            if bands > 1 {
                room.emission.iter_mut().skip(bands - 1).step_by(bands).for_each(|e| *e = 0.0);
                room.incident.iter_mut().skip(bands - 1).step_by(bands).for_each(|e| *e = 0.0);
            }
            let problem = room.problem();
            problem.validate().unwrap();
            let options = SolveOptions { tolerance: 1e-12, max_iterations: 1_000_000, observer: None };
            let expected = room.eliminated();
            for (name, solver) in SOLVERS {
                let (found, report) = solver(&problem, &options, &Control::default()).unwrap();
                assert_eq!(report.stop, Stop::Converged, "{name}");
                assert!(report.residual <= 1e-12);
                for (k, (b, e)) in found.iter().zip(&expected).enumerate() {
                    let error = (b - e).abs() / e.abs().max(1e-3);
                    assert!(error < 1e-9, "{name}: entry {k} of {bands} bands: {b} {e}");
                }
            }
        }
    }
}

#[test]
fn light_from_outside_alone_is_enough() {
    let mut room = Room::new(24, 2, 0.8, 0.9, &mut 5);
    room.emission.fill(0.0);
    let expected = room.eliminated();
    for (name, solver) in SOLVERS {
        let options = SolveOptions { tolerance: 1e-12, max_iterations: 100_000, observer: None };
        let (found, report) = solver(&room.problem(), &options, &Control::default()).unwrap();
        assert_eq!(report.stop, Stop::Converged, "{name}");
        assert!(found.iter().zip(&expected).all(|(b, e)| (b - e).abs() < 1e-9 * e.abs().max(1e-3)), "{name}");
    }
}

#[test]
fn darkness_is_solved_at_once() {
    let mut room = Room::new(12, 3, 1.0, 0.9, &mut 7);
    room.emission.fill(0.0);
    room.incident.fill(0.0);
    for (name, solver) in SOLVERS {
        let (found, report) = solver(&room.problem(), &SolveOptions::default(), &Control::default()).unwrap();
        assert_eq!((report.stop, report.iterations), (Stop::Converged, 0), "{name}");
        assert!(found.iter().all(|&b| b == 0.0), "{name}");
    }
}

/// The error of B in the norm weighted by area is at most the residual over 1 - rho, as no row sums to more than 1.
#[test]
fn the_tolerance_bounds_the_error() {
    let room = Room::new(40, 1, 1.0, 0.95, &mut 9);
    let (problem, expected) = (room.problem(), room.eliminated());
    let norm = |x: &dyn Fn(usize) -> f64| -> f64 {
        (0..expected.len()).map(|k| room.area[k] * x(k) * x(k)).sum::<f64>().sqrt()
    };
    // What residuals are relative to is at most the norm of what leaves after one bounce.
    let scale = norm(&|k| expected[k]);
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let options = SolveOptions { tolerance, max_iterations: 100_000, observer: None };
        for (name, solver) in SOLVERS {
            let (found, _) = solver(&problem, &options, &Control::default()).unwrap();
            let error = norm(&|k| found[k] - expected[k]);
            assert!(error <= tolerance * scale / (1.0 - 0.95), "{name} at {tolerance}: {error}");
        }
    }
}

#[test]
fn a_solver_says_when_it_did_not_converge() {
    let room = Room::new(24, 1, 1.0, 0.99, &mut 3);
    let options = SolveOptions { tolerance: 1e-12, max_iterations: 3, observer: None };
    for (name, solver) in SOLVERS {
        let (_, report) = solver(&room.problem(), &options, &Control::default()).unwrap();
        assert_eq!((report.stop, report.iterations), (Stop::MaxIterations, 3), "{name}");
        assert!(report.residual > 1e-12);
        assert_eq!(report.history.iterations, [0, 1, 2, 3], "{name}");
        assert_eq!(report.history.residuals.last(), Some(&report.residual));
    }
}

/// Rows that sum to twice the area put out more than they take in: there is no equilibrium to find.
#[test]
fn a_solver_says_when_it_diverged() {
    let mut room = Room::new(24, 1, 2.0, 0.99, &mut 3);
    room.reflectance.fill(0.9);
    for (name, solver) in SOLVERS {
        let options = SolveOptions { tolerance: 1e-9, max_iterations: 100_000, observer: None };
        let (_, report) = solver(&room.problem(), &options, &Control::default()).unwrap();
        assert_eq!(report.stop, Stop::Diverged, "{name}");
    }
}

#[test]
fn gauss_seidel_takes_fewer_sweeps_than_jacobi_and_relaxation_fewer_still() {
    let mut room = Room::new(60, 3, 1.0, 0.0, &mut 11);
    room.reflectance.fill(0.9);
    let sweeps = |solver: Solver| {
        let options = SolveOptions { max_iterations: 10_000, ..SolveOptions::default() };
        solver(&room.problem(), &options, &Control::default()).unwrap().1.iterations
    };
    // Young 1954: Gauss-Seidel reduces the error by mu^2 a sweep where Jacobi does by mu.
    let [jacobi, gauss_seidel, relaxed] = [sweeps(jacobi), sweeps(gauss_seidel), sweeps(over_relaxation)];
    assert!(gauss_seidel as f64 <= 0.6 * jacobi as f64, "{gauss_seidel} {jacobi}");
    assert!(relaxed as f64 <= 0.6 * gauss_seidel as f64, "{relaxed} {gauss_seidel}");
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
