//! Light that passes through patches diffusely: `B = E + rho H + tau H'`, where H' is the irradiance of the other side.
//!
//! With P, which swaps the sides of patches, the operator is `I - (rho + tau P) F`, and has no symmetric positive definite
//! form where more passes than is reflected. So a solver that knows reflection alone is asked again for what it left:
//! iterative refinement by the regular splitting into `I - rho F` and `tau P F`, which converges since rho + tau < 1 (Varga
//! 1962, *Matrix iterative analysis*, theorem 3.13). A pass leaves at most `tau / (1 - rho)`.

use crate::answer::{Solver, ratio};
use crate::lighting::Lighting;
use radiosity_exchange::Enclosure;
use radiosity_operator::{Cancelled, Control};
use radiosity_solvers::{History, Problem, SolveOptions, SolveReport, Stop};

/// What a pass may leave of its own problem: it need not be solved better than the passes converge.
const LEFT_BY_PASS: f64 = 0.1;

/// A residual of so many first bounces never comes back.
const DIVERGED: f64 = 1e6;

/// The sides that light passes through.
pub(crate) struct Translucency<'a> {
    sides: Vec<Passage<'a>>,
}

/// What leaves a side of what meets the other.
struct Passage<'a> {
    side: usize,
    other: usize,
    transmittance: &'a [f64],
}

impl<'a> Translucency<'a> {
    /// One-sided patches let nothing through.
    pub fn new(enclosure: &Enclosure, lighting: &'a Lighting) -> Self {
        if lighting.diffuse_transmittance.is_empty() {
            return Self { sides: Vec::new() };
        }
        let passage = |side| {
            let transmittance = lighting.diffuse_transmittance_of(enclosure.patch_of(side))?;
            Some(Passage { side, other: enclosure.opposite(side)?, transmittance })
        };
        Self { sides: (0..enclosure.sides()).filter_map(passage).collect() }
    }

    /// Adds `tau H'` to values of sides, sides x bands, where `irradiance` counts what is buried as dark.
    pub fn add(&self, irradiance: &[f64], values: &mut [f64]) {
        for Passage { side, other, transmittance } in &self.sides {
            let bands = transmittance.len();
            let arriving = &irradiance[other * bands..][..bands];
            let own = values[side * bands..][..bands].iter_mut();
            own.zip(*transmittance).zip(arriving).for_each(|((v, tau), h)| *v += tau * h);
        }
    }

    /// Solves for the radiosity of sides. The residual is that of the equation, root mean square over area, relative to
    /// the first bounce. `exposure` is the share of a side that is not buried.
    pub fn solve(
        &self,
        problem: &Problem,
        exposure: impl Fn(usize) -> f64,
        solver: Solver,
        options: &SolveOptions,
        control: &Control,
    ) -> Result<(Vec<f64>, SolveReport), Cancelled> {
        let (mut radiosity, mut report) = solver(problem, options, control)?;
        if self.sides.is_empty() {
            return Ok((radiosity, report));
        }
        let nothing = vec![0.0; radiosity.len()];
        let scale = squares(problem, &self.scattered(problem, &exposure, problem.emission));
        while report.stop == Stop::Converged {
            let mut left = self.scattered(problem, &exposure, &radiosity);
            left.iter_mut().zip(problem.emission).zip(&radiosity).for_each(|((l, e), b)| *l += e - b);
            report.products += 1.0;
            note(&mut report, worst_ratio(&squares(problem, &left), &scale));
            if report.residual <= options.tolerance {
                break;
            }
            if report.residual.is_nan() || report.residual > DIVERGED {
                report.stop = Stop::Diverged;
                break;
            }
            let max_iterations = options.max_iterations.saturating_sub(report.iterations);
            let pass = Problem { emission: &left, incident: &nothing, ..*problem };
            let loosely = SolveOptions { tolerance: LEFT_BY_PASS, max_iterations, observer: None };
            let (more, of_pass) = solver(&pass, &loosely, control)?;
            radiosity.iter_mut().zip(&more).for_each(|(b, m)| *b += m);
            report.iterations += of_pass.iterations.max(1);
            report.products += of_pass.products;
            report.stop = of_pass.stop;
        }
        Ok((radiosity, report))
    }

    /// `(rho + tau P) (F B + H0)`, sides x bands. What takes no part scatters nothing.
    fn scattered(&self, problem: &Problem, exposure: &impl Fn(usize) -> f64, radiosity: &[f64]) -> Vec<f64> {
        let bands = problem.bands;
        let mut irradiance = vec![0.0; radiosity.len()];
        problem.exchange.apply(radiosity, &mut irradiance, bands);
        for (k, h) in irradiance.iter_mut().enumerate() {
            *h = if problem.area[k / bands] > 0.0 { *h / problem.area[k / bands] + problem.incident[k] } else { 0.0 };
        }
        let mut scattered: Vec<f64> = problem.reflectance.iter().zip(&irradiance).map(|(rho, h)| rho * h).collect();
        irradiance.iter_mut().enumerate().for_each(|(k, h)| *h *= exposure(k / bands));
        self.add(&irradiance, &mut scattered);
        let takes_part = |k: usize| problem.area[k / bands] > 0.0;
        scattered.iter_mut().enumerate().filter(|(k, _)| !takes_part(*k)).for_each(|(_, s)| *s = 0.0);
        scattered
    }
}

fn note(report: &mut SolveReport, residual: f64) {
    report.residual = residual;
    if report.history.iterations.len() < History::MOST {
        report.history.iterations.push(report.iterations);
        report.history.residuals.push(residual);
    }
}

/// Per band the sum over sides of the area times the square of `values`.
fn squares(problem: &Problem, values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; problem.bands];
    for (values, area) in values.chunks_exact(problem.bands).zip(problem.area) {
        sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += area * v * v);
    }
    sums
}

fn worst_ratio(squares: &[f64], scale: &[f64]) -> f64 {
    squares.iter().zip(scale).map(|(e, s)| ratio(*e, *s).sqrt()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use radiosity_geometry::Patches;
    use radiosity_operator::dense::Dense;
    use radiosity_solvers::{conjugate_gradient, gauss_seidel, jacobi};

    /// Three patches of area 1, of which the last two have backs: sides 3 and 4.
    fn enclosure() -> Enclosure {
        let square = |z: f64| {
            let p = |x: f64, y: f64| DVec3::new(x, y, z);
            [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]
        };
        let polygons = vec![square(0.0), square(1.0), square(2.0)];
        Enclosure::new(Patches::new(polygons, vec![0; 3], vec![0; 3], vec![false, true, true]))
    }

    /// Two bands: one in which more is reflected than passes, one in which less is.
    fn lighting() -> Lighting {
        Lighting {
            bands: 2,
            reflectance: vec![0.8, 0.3, 0.5, 0.1, 0.6, 0.2],
            emission: vec![1.0, 2.0, 0.0, 0.0, 0.5, 0.1],
            diffuse_transmittance: vec![0.0, 0.0, 0.3, 0.8, 0.2, 0.7],
            ..Lighting::default()
        }
    }

    /// Any exchange of five sides whose rows sum to one.
    fn exchange() -> Dense {
        let mut values = vec![0.0; 25];
        for i in 0..5 {
            for j in 0..i {
                let value = 0.05 + 0.03 * ((i + 2 * j) % 5) as f64;
                (values[5 * i + j], values[5 * j + i]) = (value, value);
            }
        }
        for i in 0..5 {
            values[6 * i] = 1.0 - values[5 * i..5 * i + 5].iter().sum::<f64>();
        }
        Dense::new(5, values)
    }

    #[test]
    fn any_solver_finds_what_bounces_add_up_to() {
        let (enclosure, lighting, exchange) = (enclosure(), lighting(), exchange());
        let of = |block: &[f64]| [0, 1, 2, 1, 2].into_iter().flat_map(|p| [block[2 * p], block[2 * p + 1]]).collect();
        let (reflectance, emission): (Vec<f64>, Vec<f64>) = (of(&lighting.reflectance), of(&lighting.emission));
        let (area, incident) = ([1.0; 5], [0.25; 10]);
        let problem: Problem = Problem {
            exchange: &exchange,
            area: &area,
            reflectance: &reflectance,
            emission: &emission,
            incident: &incident,
            bands: 2,
        };
        let sheets = Translucency::new(&enclosure, &lighting);
        let mut truth = emission.clone();
        for _ in 0..2000 {
            let scattered = sheets.scattered(&problem, &|_| 1.0, &truth);
            truth = emission.iter().zip(&scattered).map(|(e, s)| e + s).collect();
        }
        let options = SolveOptions { tolerance: 1e-10, ..SolveOptions::default() };
        for solver in [conjugate_gradient as Solver, jacobi, gauss_seidel] {
            let (found, report) = sheets.solve(&problem, |_| 1.0, solver, &options, &Control::default()).unwrap();
            assert!(report.stop == Stop::Converged && report.residual <= 1e-10, "{report:?}");
            assert!(found.iter().zip(&truth).all(|(f, t)| (f / t - 1.0).abs() < 1e-8), "{found:?} {truth:?}");
            assert_eq!(report.history.residuals.last(), Some(&report.residual));
        }
        // Where iterations end it, it says so.
        let few = SolveOptions { max_iterations: 8, ..options };
        let (_, report) = sheets.solve(&problem, |_| 1.0, jacobi, &few, &Control::default()).unwrap();
        assert_eq!(report.stop, Stop::MaxIterations);
    }

    #[test]
    fn where_nothing_passes_the_solver_alone_decides() {
        let enclosure = enclosure();
        for diffuse_transmittance in [vec![], vec![0.0; 6]] {
            let lighting = Lighting { diffuse_transmittance, ..lighting() };
            assert!(Translucency::new(&enclosure, &lighting).sides.is_empty());
            assert_eq!(lighting.highest_reflectance(), 0.8);
            assert!(lighting.demand_opaque("a test").is_ok());
        }
        let refusal = lighting().demand_opaque("a test").unwrap_err().to_string();
        assert!(refusal.starts_with("patch 1 lets light through diffusely, which a test cannot follow"), "{refusal}");
        assert!((lighting().highest_reflectance() - 0.9).abs() < 1e-12);
    }
}
