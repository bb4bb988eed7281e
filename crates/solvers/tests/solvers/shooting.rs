//! Progressive refinement: where the power is, how fast light arrives, who may look on.

use crate::random::Room;
use radiosity_operator::{Control, Operator};
use radiosity_solvers::{Flow, History, Overshoot, SolveOptions, SolveReport, Stop, jacobi, southwell};
use std::sync::Mutex;

fn shots(room: &Room, overshoot: Overshoot, most: usize) -> (Vec<f64>, SolveReport) {
    let options = SolveOptions { tolerance: 1e-10, max_iterations: most, observer: None };
    southwell(&room.problem(), overshoot, &options, &Control::default()).unwrap()
}

/// A closed room of equal reflectance in which one element shines.
fn lit_by_one(n: usize, reflectance: f64) -> Room {
    let mut room = Room::new(n, 1, 1.0, 0.0, &mut 1);
    room.reflectance.fill(reflectance);
    room.emission.fill(0.0);
    room.incident.fill(0.0);
    room.emission[3] = 2.0;
    room
}

#[test]
fn no_power_is_lost_from_shot_to_shot() {
    let room = Room::new(30, 3, 0.7, 0.9, &mut 2);
    for overshoot in [Overshoot::None, Overshoot::Ambient] {
        for most in [0, 1, 2, 17, 1000] {
            let (radiosity, report) = shots(&room, overshoot, most);
            let ledger = report.ledger.unwrap();
            for c in 0..3 {
                let power: f64 = (0..30).map(|i| room.area[i] * radiosity[i * 3 + c]).sum();
                // Radiosity is what was shot and what is unshot; what was emitted went three ways.
                assert!((ledger.shot[c] + ledger.unshot[c] - power).abs() < 1e-12 * power);
                let found = ledger.absorbed[c] + ledger.escaped[c] + ledger.unshot[c];
                assert!((found - ledger.emitted[c]).abs() < 1e-12 * ledger.emitted[c], "{found} {}", ledger.emitted[c]);
            }
        }
    }
}

/// In a closed room one shot of the lamp places all it emits, and of that rho is unshot; the next k shots send on the
/// greatest k shares of it.
#[test]
fn the_first_shot_places_all_that_one_lamp_emits() {
    let (n, rho) = (50, 0.5);
    let room = lit_by_one(n, rho);
    let emitted = room.area[3] * 2.0;
    let (radiosity, report) = shots(&room, Overshoot::None, 1);
    let ledger = report.ledger.unwrap();
    assert!((ledger.shot[0] - emitted).abs() < 1e-12 * emitted);
    assert!((ledger.absorbed[0] - (1.0 - rho) * emitted).abs() < 1e-12 * emitted);
    assert!((ledger.unshot[0] - rho * emitted).abs() < 1e-12 * emitted);
    assert_eq!(report.history.unshot[0], 1.0);
    assert!((report.history.unshot[1] - rho).abs() < 1e-12);
    for (j, g) in room.exchange.row(3).iter().enumerate() {
        let expected = if j == 3 { 2.0 } else { rho * g * 2.0 / room.area[j] };
        assert!((radiosity[j] - expected).abs() < 1e-12);
    }
    // Shots of the brightest: no fewer than the mean share each, so k of them leave at most (1 - k/n) of rho and what
    // comes back of k/n, rho^2.
    for k in [5, 10, 25] {
        let (_, report) = shots(&room, Overshoot::None, 1 + k);
        let share = k as f64 / n as f64;
        let most = rho * (1.0 - share) + rho * rho * share;
        assert!(*report.history.unshot.last().unwrap() <= most, "{k} {most} {:?}", report.history.unshot.last());
    }
}

/// With one reflectance in a closed room the ambient term makes the mean radiosity E / (1 - rho) from the first shot on.
#[test]
fn the_ambient_term_completes_the_power_of_a_closed_room() {
    let room = lit_by_one(40, 0.8);
    let whole: f64 = room.area.iter().sum();
    let expected = room.area[3] * 2.0 / (1.0 - 0.8) / whole;
    let means = Mutex::new(Vec::new());
    let observer = |s: &radiosity_solvers::Snapshot| {
        let seen = |i: usize| room.area[i] * (s.radiosity[i] + room.reflectance[i] * s.ambient[0]);
        means.lock().unwrap().push((0..40).map(seen).sum::<f64>() / whole);
        Flow::Continue
    };
    let options = SolveOptions { tolerance: 1e-12, max_iterations: 200, observer: Some(&observer) };
    southwell(&room.problem(), Overshoot::None, &options, &Control::default()).unwrap();
    let means = means.into_inner().unwrap();
    assert_eq!(means.len(), 201);
    assert!(means.iter().all(|m| (m - expected).abs() < 1e-12 * expected));
}

#[test]
fn overshooting_takes_half_the_shots_where_much_is_reflected() {
    let room = lit_by_one(60, 0.95);
    let [plain, over] = [Overshoot::None, Overshoot::Ambient].map(|o| shots(&room, o, 1_000_000).1);
    assert_eq!((plain.stop, over.stop), (Stop::Converged, Stop::Converged));
    assert!(2 * over.iterations < plain.iterations, "{} {}", over.iterations, plain.iterations);
    // A shot is one row of as many as there are elements.
    assert!((plain.products - plain.iterations as f64 / 60.0).abs() < 1e-9);
}

#[test]
fn an_observer_sees_every_iteration_and_may_stop() {
    let room = lit_by_one(20, 0.5);
    let seen = Mutex::new(Vec::new());
    let observer = |s: &radiosity_solvers::Snapshot| {
        seen.lock().unwrap().push((s.iteration, s.residual, s.radiosity.to_vec()));
        if s.iteration == 4 { Flow::Stop } else { Flow::Continue }
    };
    let options = SolveOptions { tolerance: 1e-12, max_iterations: 100, observer: Some(&observer) };
    let (radiosity, report) = jacobi(&room.problem(), &options, &Control::default()).unwrap();
    let seen = seen.into_inner().unwrap();
    assert_eq!((report.stop, report.iterations), (Stop::Observer, 4));
    assert!(seen.iter().map(|s| s.0).eq(0..5));
    assert!(seen.iter().map(|s| s.1).eq(report.history.residuals));
    assert_eq!(seen[4].2, radiosity);
    // Bounce k + 1 of a lamp in a closed room leaves rho^(k + 1) unshot.
    for (k, unshot) in report.history.unshot.iter().enumerate() {
        assert!((unshot - 0.5f64.powi(k as i32 + 1)).abs() < 1e-12);
    }
}

#[test]
fn a_long_history_is_thinned_evenly() {
    let room = lit_by_one(20, 0.99);
    let (_, report) = shots(&room, Overshoot::None, 5000);
    let history = report.history;
    assert!(history.iterations.len() <= History::MOST && history.iterations.len() > History::MOST / 2);
    assert_eq!(history.iterations.len(), history.unshot.len());
    assert_eq!(history.iterations.len(), history.residuals.len());
    let steps: Vec<usize> = history.iterations.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(steps[..steps.len() - 1].iter().all(|&s| s == steps[0]));
    assert_eq!(history.iterations.last(), Some(&report.iterations));
    assert_eq!(room.exchange.len(), 20);
}
