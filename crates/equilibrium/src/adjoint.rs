//! Derivatives of sums of irradiance by all that shines and reflects, from one more solve.
//!
//! With `B = E + rho H` and `H = F B + H0`, a sum `T` of `w H` changes by `lambda dE + lambda H d rho + (w + rho lambda)
//! dH0`, where `lambda = G (w / A) + G (rho lambda / A)` is what radiosity is worth: the adjoint equation. As G is
//! symmetric, `lambda / A` is the irradiance of a scene that emits `w / A`, and the solver of the one is that of the
//! other (for radiosity: Smits, Arvo and Salesin 1992, *An importance-driven radiosity algorithm*, who split patches by
//! it). The bands are apart, so a sum of one band has derivatives in that band alone.
//!
//! These are derivatives of the discrete equations as they are, on the exchange at hand: differences of answers on it,
//! relit, are the same but for what the solver leaves.

use crate::answer::{Task, ratio};
use crate::incident::Incident;
use crate::lighting::Lighting;
use crate::solve::{MOST_ITERATIONS, Measurement, Solution, Source};
use radiosity_exchange::{Enclosure, FormFactors, Luminaire};
use radiosity_operator::{Cancelled, Control, Operator};
use radiosity_solvers::{Problem, SolveOptions, SolveReport, Stop, conjugate_gradient};

/// Derivatives of one sum, per band.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// By emission, patches x bands: both sides of a two-sided patch emit it.
    pub emission: Vec<f64>,
    /// By reflectance, likewise.
    pub reflectance: Vec<f64>,
    /// By the strength of lights without area, lights x bands.
    pub lamps: Vec<f64>,
}

/// Why there are no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// Stopped on request.
    #[error("stopped on request")]
    Cancelled,
    /// The exchange was not kept.
    #[error("rows of the exchange were drawn when they shot and are not symmetric: solve on samples or form factors")]
    OnDemand,
    /// Neither is this light an equilibrium.
    #[error(
        "the equations of this solution cannot be solved: rows of the exchange sum to more than 1 over reflectance"
    )]
    Diverged,
    /// There are no derivatives through sheets.
    #[error(
        "patches let light through diffusely, and derivatives cannot follow it: set their diffuse transmittance to 0"
    )]
    Translucent,
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Failure::Cancelled
    }
}

impl Failure {
    pub(crate) fn unless_converged(report: &SolveReport) -> Result<(), Failure> {
        if report.stop == Stop::Converged { Ok(()) } else { Err(Failure::Diverged) }
    }
}

/// Derivatives of sums of irradiance of fronts; of each the weights, patches x bands.
pub fn gradients(
    solution: &Solution,
    lighting: &Lighting,
    weights: &[Vec<f64>],
    control: &Control,
) -> Result<Vec<Gradient>, Failure> {
    lighting.demand_opaque("an adjoint solution").map_err(|_| Failure::Translucent)?;
    let enclosure = solution.source.enclosure();
    let size = enclosure.sides() * lighting.bands;
    // Backs follow fronts.
    let weights: Vec<Vec<f64>> = weights
        .iter()
        .map(|fronts| fronts.iter().copied().chain(std::iter::repeat(0.0)).take(size).collect())
        .collect();
    match &solution.source {
        Source::Given(factors, incident) => {
            OnFactors { factors, incident, lighting, solution, control }.gradients(&weights)
        }
        Source::Measured(measurement) => on_samples(measurement, lighting, &weights, control),
        Source::OnDemand(_) => Err(Failure::OnDemand),
    }
}

/// What the residual may be, relative to the first bounce: far below what any exchange is known to.
const TOLERANCE: f64 = 1e-10;

fn options(highest_reflectance: f64) -> SolveOptions<'static> {
    SolveOptions { tolerance: TOLERANCE * (1.0 - highest_reflectance), max_iterations: MOST_ITERATIONS, observer: None }
}

fn on_samples(
    measurement: &Measurement,
    lighting: &Lighting,
    weights: &[Vec<f64>],
    control: &Control,
) -> Result<Vec<Gradient>, Failure> {
    let enclosure = measurement.transport.enclosure();
    let lighting = &*lighting.of_diffuse_parts(enclosure);
    let options = options(lighting.highest_reflectance());
    let task =
        Task { measurement, lighting, solver: conjugate_gradient, options, as_field: false, importance: &[], control };
    let mut gradients = task.transposed(weights)?;
    if let Some(specular) = enclosure.specular() {
        // From the optics of diffuse parts to those of patches.
        for gradient in &mut gradients {
            for block in [&mut gradient.emission, &mut gradient.reflectance] {
                let share = |k: usize| specular.diffuse_share(k / lighting.bands);
                block.iter_mut().enumerate().for_each(|(k, v)| *v = ratio(*v, share(k)));
            }
        }
    }
    Ok(gradients)
}

/// A solution on form factors. Blocks are sides x bands.
struct OnFactors<'a> {
    factors: &'a FormFactors,
    incident: &'a Incident,
    lighting: &'a Lighting,
    solution: &'a Solution,
    control: &'a Control,
}

impl OnFactors<'_> {
    fn gradients(&self, weights: &[Vec<f64>]) -> Result<Vec<Gradient>, Failure> {
        let (enclosure, bands) = (&self.factors.enclosure, self.lighting.bands);
        let area = self.incident.exposed_areas(enclosure);
        let share = |k: usize| ratio(area[k / bands], enclosure.area(k / bands));
        let reflectance = self.lighting.per_side(enclosure, |patch| self.lighting.reflectance_of(patch));
        let sides = Sides::new(&self.factors.operator, &area, &reflectance, bands);
        // The answer is the mean over all of a side, the equations are of what is exposed.
        let irradiance: Vec<f64> =
            self.solution.irradiance.iter().enumerate().map(|(k, h)| ratio(1.0, share(k)) * h).collect();
        let (mut sent, mut incident) = (Vec::new(), Vec::new());
        for weights in weights {
            let weights: Vec<f64> = weights.iter().enumerate().map(|(k, w)| share(k) * w).collect();
            let found = sides.transposed(&sides.gather_transposed(&weights), self.control)?;
            incident.push(sides.by_incident(&found).iter().zip(&weights).map(|(i, w)| i + w).collect());
            sent.push(found);
        }
        let by_luminaire = self.through_tests(&incident)?;
        let gradient = |(sent, luminaires): (&Vec<f64>, &Vec<f64>)| {
            let (emission, lamps) = self.shared(sent, luminaires);
            let reflected = sides.by_reflectance(sent, &irradiance);
            Gradient::of_patches(enclosure, bands, &emission, &reflected, lamps)
        };
        Ok(sent.iter().zip(&by_luminaire).map(gradient).collect())
    }

    /// From what lamps put on sides to lamps: of each sum, luminaires x bands. All sums at once, as tests take rays.
    fn through_tests(&self, incident: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Cancelled> {
        let (bands, sums) = (self.lighting.bands, incident.len());
        let sides = self.factors.enclosure.sides();
        let rows = |side: usize| incident.iter().flat_map(move |block| &block[side * bands..(side + 1) * bands]);
        let together: Vec<f64> = (0..sides).flat_map(rows).copied().collect();
        let found = self.incident.transposed(&self.factors.enclosure, &together, sums * bands, self.control)?;
        let of = |sum: usize| found.chunks_exact(bands).skip(sum).step_by(sums).flatten().copied().collect();
        Ok((0..sums).map(of).collect())
    }

    /// Emission of sides and strengths of lights: what lamps send that were tested goes no way through the exchange.
    fn shared(&self, sent: &[f64], by_luminaire: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let bands = self.lighting.bands;
        let mut emission = self.incident.left(sent, bands);
        let mut lamps = Vec::with_capacity(self.lighting.lamps.len() * bands);
        for (luminaire, values) in self.incident.luminaires().iter().zip(by_luminaire.chunks_exact(bands)) {
            match luminaire {
                Luminaire::Side(side) => emission[*side as usize * bands..][..bands].copy_from_slice(values),
                _ => lamps.extend_from_slice(values),
            }
        }
        (emission, lamps)
    }
}

impl Gradient {
    /// From sides to patches: what a patch emits and reflects is that of both its sides.
    pub(crate) fn of_patches(
        enclosure: &Enclosure,
        bands: usize,
        emission: &[f64],
        reflectance: &[f64],
        lamps: Vec<f64>,
    ) -> Self {
        let summed = |of_sides: &[f64]| {
            let (fronts, backs) = of_sides.split_at(enclosure.patches().len() * bands);
            let mut sums = fronts.to_vec();
            for (back, values) in (enclosure.patches().len()..).zip(backs.chunks_exact(bands)) {
                let patch = enclosure.patch_of(back);
                sums[patch * bands..][..bands].iter_mut().zip(values).for_each(|(sum, v)| *sum += v);
            }
            sums
        };
        Self { emission: summed(emission), reflectance: summed(reflectance), lamps }
    }
}

/// The equations on sides, to be transposed. Blocks are sides x bands.
pub(crate) struct Sides<'a> {
    exchange: &'a dyn Operator,
    area: &'a [f64],
    reflectance: &'a [f64],
    bands: usize,
}

impl<'a> Sides<'a> {
    pub fn new(exchange: &'a dyn Operator, area: &'a [f64], reflectance: &'a [f64], bands: usize) -> Self {
        Self { exchange, area, reflectance, bands }
    }

    /// `H = F B + H0`.
    pub fn irradiance(&self, radiosity: &[f64], incident: &[f64]) -> Vec<f64> {
        self.product(radiosity).iter().zip(incident).enumerate().map(|(k, (g, h))| self.per_area(k, *g) + h).collect()
    }

    /// What radiosity is worth that is only looked at, where irradiance is worth so much: `G (w / A)`.
    fn gather_transposed(&self, worth: &[f64]) -> Vec<f64> {
        self.product(&worth.iter().enumerate().map(|(k, w)| self.per_area(k, *w)).collect::<Vec<_>>())
    }

    /// What sending light is worth, with all that becomes of it, where radiosity itself is worth so much: the adjoint
    /// equation `lambda = worth + G (rho lambda / A)`. `rho lambda / A` is the radiosity of surfaces that `worth / A`
    /// falls on.
    pub fn transposed(&self, worth: &[f64], control: &Control) -> Result<Vec<f64>, Failure> {
        let incident: Vec<f64> = worth.iter().enumerate().map(|(k, w)| self.per_area(k, *w)).collect();
        let problem: Problem = Problem {
            exchange: self.exchange,
            area: self.area,
            reflectance: self.reflectance,
            emission: &vec![0.0; worth.len()],
            incident: &incident,
            bands: self.bands,
        };
        let highest = self.reflectance.iter().copied().fold(0.0, f64::max);
        let (reflected, report) = conjugate_gradient(&problem, &options(highest), control)?;
        Failure::unless_converged(&report)?;
        Ok(self.product(&reflected).iter().zip(worth).map(|(g, w)| g + w).collect())
    }

    /// What reflectance is worth.
    pub fn by_reflectance(&self, sent: &[f64], irradiance: &[f64]) -> Vec<f64> {
        (0..sent.len()).map(|k| if self.takes_part(k) { sent[k] * irradiance[k] } else { 0.0 }).collect()
    }

    /// What light that falls on sides from outside the exchange is worth to those who reflect it.
    pub fn by_incident(&self, sent: &[f64]) -> Vec<f64> {
        (0..sent.len()).map(|k| if self.takes_part(k) { self.reflectance[k] * sent[k] } else { 0.0 }).collect()
    }

    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.exchange.apply(x, &mut y, self.bands);
        y
    }

    fn takes_part(&self, k: usize) -> bool {
        self.area[k / self.bands] > 0.0
    }

    fn per_area(&self, k: usize, value: f64) -> f64 {
        ratio(value, self.area[k / self.bands])
    }
}

#[cfg(test)]
mod tests;
