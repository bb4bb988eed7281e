//! Southwell iteration, the progressive refinement of radiosity: the element with most unshot power shoots.
//!
//! Cohen, Chen, Wallace and Greenberg 1988, *A progressive refinement approach to fast radiosity image generation*;
//! as relaxation of the greatest residual Southwell 1946 and Gortler, Cohen and Slusallek 1994. It reads one row of the
//! exchange a shot and needs no product, so rows may be found as they are asked for, and most of the light is there
//! after a few of them.
//!
//! With x what was shot and r what is unshot, both W/m2, the radiosity is `B = x + r = E + rho (G x / A + H0)`. To shoot
//! D from element i is `x_i += D`, `r_i -= D`, `r_j += rho_j G_ij D / A_j`: power is never lost, see [`Ledger`]. The
//! residual is r in the norm weighted by area, relative to its start, which is what is emitted.
//!
//! Shooting the k brightest at once (by one product) was measured to take as many shots in all, or up to a third fewer
//! where reflectances are high; reading rows one by one costs no more than k of them, so it is left out. What pays is to
//! *find* the next rows together where finding costs: [`Rows::batch`].

use crate::problem::{Problem, ratio, worst_ratio};
use crate::report::{Ledger, SolveOptions, SolveReport, Track};
use radiosity_operator::{Cancelled, Control, Rows};

/// Whether to shoot more than there is, for what will still arrive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overshoot {
    /// Shoot what is unshot.
    #[default]
    None,
    /// Shoot also what the ambient term says is still to arrive (Feda and Purgathofer 1992), up to
    /// [`MOST_RELAXATION`] of what is unshot in all: a third to an eighth of the shots at a reflectance of 0.9.
    Ambient,
}

/// A relaxation in (0, 2) brings the solution nearer in the energy norm of a symmetric exchange, and never further away.
/// Without a limit, as in the article, the furnished room at a reflectance of 0.99 diverged.
pub const MOST_RELAXATION: f64 = 1.5;

/// What shooting leaves, elements x bands, W/m2.
#[derive(Clone, Debug)]
pub struct Light {
    /// What leaves.
    pub radiosity: Vec<f64>,
    /// What arrived, from outside the exchange included; of black elements too, whose radiosity does not tell.
    pub irradiance: Vec<f64>,
    /// The part of the radiosity that was sent on.
    pub shot: Vec<f64>,
    /// The part that was not.
    pub unshot: Vec<f64>,
}

/// Solves for the radiosity of every element and band.
pub fn southwell<X: Rows + ?Sized>(
    problem: &Problem<X>,
    overshoot: Overshoot,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let (light, report) = shoot(problem, overshoot, options, control)?;
    Ok((light.radiosity, report))
}

/// Shoots until the residual is as wanted.
pub fn shoot<X: Rows + ?Sized>(
    problem: &Problem<X>,
    overshoot: Overshoot,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Light, SolveReport), Cancelled> {
    let mut shooting = Shooting::new(problem, overshoot);
    let (mut track, mut row) = (Track::new(options, control), Vec::new());
    problem.exchange.begin();
    loop {
        let survey = shooting.survey();
        let unshot = ratio(survey.unshot.iter().sum(), shooting.emitted);
        let residual = worst_ratio(&survey.squares, &shooting.scale);
        if track.note(residual, Some(unshot), || (shooting.radiosity(), shooting.ambient(&survey.unshot)))? {
            let radiosity = shooting.radiosity();
            let ledger = Ledger { unshot: survey.unshot, ..shooting.ledger };
            let light =
                Light { radiosity, irradiance: shooting.irradiance, shot: shooting.shot, unshot: shooting.unshot };
            return Ok((light, track.finish(Some(ledger))));
        }
        let batch = problem.exchange.batch(survey.brightest);
        if batch > 1 {
            problem.exchange.prepare(&shooting.brightest(batch));
        }
        problem.exchange.find_row(survey.brightest, &mut row);
        shooting.shoot(survey.brightest, &row, &survey.unshot);
        track.work(1.0 / problem.len() as f64);
    }
}

/// Where the light is, between two shots. Blocks are elements x bands, W/m2.
struct Shooting<'a, X: ?Sized> {
    problem: &'a Problem<'a, X>,
    overshoot: Overshoot,
    irradiance: Vec<f64>,
    shot: Vec<f64>,
    unshot: Vec<f64>,
    ledger: Ledger,
    /// Power of all bands together at the start, W.
    emitted: f64,
    /// Squares of the norms of the residual at the start, per band.
    scale: Vec<f64>,
    /// Area of all elements, m2.
    whole: f64,
    /// Mean over area, per band.
    mean_reflectance: Vec<f64>,
}

/// What a look at all elements finds.
struct Survey {
    /// Squares of the norms of the residual, per band.
    squares: Vec<f64>,
    /// Unshot power per band, W.
    unshot: Vec<f64>,
    /// The element with most unshot power in all bands together; the first of equals.
    brightest: usize,
}

impl<'a, X: Rows + ?Sized> Shooting<'a, X> {
    fn new(problem: &'a Problem<'a, X>, overshoot: Overshoot) -> Self {
        let source = problem.source();
        let whole: f64 = problem.area.iter().sum();
        let emitted = problem.power(&source);
        let none = vec![0.0; problem.bands];
        Self {
            overshoot,
            irradiance: (0..source.len())
                .map(|k| if problem.area_at(k) > 0.0 { problem.incident[k] } else { 0.0 })
                .collect(),
            shot: vec![0.0; source.len()],
            emitted: emitted.iter().sum(),
            scale: problem.squares(&source),
            mean_reflectance: problem.power(problem.reflectance).iter().map(|p| ratio(*p, whole)).collect(),
            whole,
            ledger: Ledger { emitted, shot: none.clone(), absorbed: none.clone(), escaped: none, unshot: Vec::new() },
            unshot: source,
            problem,
        }
    }

    fn radiosity(&self) -> Vec<f64> {
        let Problem { emission, reflectance, .. } = self.problem;
        emission.iter().zip(*reflectance).zip(&self.irradiance).map(|((e, rho), h)| e + rho * h).collect()
    }

    fn survey(&self) -> Survey {
        let bands = self.problem.bands;
        let mut survey = Survey { squares: vec![0.0; bands], unshot: vec![0.0; bands], brightest: 0 };
        let mut most = -1.0;
        for (i, r) in self.unshot.chunks_exact(bands).enumerate() {
            let area = self.problem.area[i];
            let mut power = 0.0;
            for (c, r) in r.iter().enumerate() {
                survey.squares[c] += area * r * r;
                survey.unshot[c] += area * r;
                power += area * r.abs();
            }
            if power > most {
                (most, survey.brightest) = (power, i);
            }
        }
        survey
    }

    /// The elements with most unshot power, the brightest first.
    fn brightest(&self, count: usize) -> Vec<usize> {
        let bands = self.problem.bands;
        let power = |i: usize| -> f64 {
            self.problem.area[i] * self.unshot[i * bands..][..bands].iter().map(|r| r.abs()).sum::<f64>()
        };
        let mut elements: Vec<(f64, usize)> = (0..self.problem.len()).map(|i| (power(i), i)).collect();
        let before = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if count < elements.len() {
            elements.select_nth_unstable_by(count, before);
            elements.truncate(count);
        }
        elements.sort_unstable_by(before);
        elements.into_iter().filter(|e| e.0 > 0.0).map(|e| e.1).collect()
    }

    /// What is still to arrive per band, if it came evenly everywhere, W/m2.
    ///
    /// Unshot power P in a closed room of area A and mean reflectance rho arrives as P, P rho, P rho^2 ...: P / (1 - rho)
    /// in all, on A. Where a part escapes, only the rest arrives each time; of what was shot that part is known.
    fn ambient(&self, unshot: &[f64]) -> Vec<f64> {
        let of = |c: usize| {
            let kept = 1.0 - ratio(self.ledger.escaped[c], self.ledger.shot[c]).clamp(0.0, 1.0);
            ratio(unshot[c].abs() * kept, self.whole * (1.0 - self.mean_reflectance[c] * kept)).copysign(unshot[c])
        };
        (0..unshot.len()).map(of).collect()
    }

    /// Element `i` shoots through its row of the exchange.
    fn shoot(&mut self, i: usize, row: &[(u32, f64)], unshot: &[f64]) {
        let (problem, bands) = (self.problem, self.problem.bands);
        let ambient = self.ambient(unshot);
        let sent: Vec<f64> = (0..bands).map(|c| self.to_shoot(i, c, ambient[c])).collect();
        for (c, sent) in sent.iter().enumerate() {
            self.shot[i * bands + c] += sent;
            self.unshot[i * bands + c] -= sent;
            self.ledger.shot[c] += problem.area[i] * sent;
        }
        let mut arrived = 0.0;
        for &(j, g) in row.iter().filter(|e| problem.area[e.0 as usize] > 0.0) {
            arrived += g;
            let (here, share) = (j as usize * bands..(j as usize + 1) * bands, g / problem.area[j as usize]);
            let receiver = self.irradiance[here.clone()].iter_mut().zip(&mut self.unshot[here.clone()]);
            let optics = problem.reflectance[here].iter().zip(&mut self.ledger.absorbed).zip(&sent);
            for ((irradiance, unshot), ((rho, absorbed), sent)) in receiver.zip(optics) {
                *irradiance += share * sent;
                *unshot += rho * share * sent;
                *absorbed += (1.0 - rho) * g * sent;
            }
        }
        for (c, sent) in sent.iter().enumerate() {
            self.ledger.escaped[c] += (problem.area[i] - arrived) * sent;
        }
    }

    /// How much element `i` shoots in band `c`, W/m2.
    fn to_shoot(&self, i: usize, c: usize, ambient: f64) -> f64 {
        let k = i * self.problem.bands + c;
        let here = self.unshot[k];
        let expected = self.problem.reflectance[k] * ambient;
        match self.overshoot {
            Overshoot::None => here,
            Overshoot::Ambient => {
                let most = (MOST_RELAXATION - 1.0) * here;
                here + expected.clamp(most.min(0.0), most.max(0.0))
            }
        }
    }
}
