//! How wrong an answer is, from the answer itself.
//!
//! Causes add in squares. The spread of the replicates is the standard error of a side's own samples. The same
//! spread, sent through the interreflections, is what the noise of other sides adds (first-order perturbation:
//! `dH = dF B + F rho dH`, where light passes through patches with what leaves their other sides). Power that the balance cannot explain is an error of the whole. What replacing sides by
//! elements changed bounds what still finer elements would change. Where the answer is wanted as a field, what that
//! leaves of the light within patches counts too (`mesh_error.rs`).
//!
//! What is reported is not the likeliest value of the error but the upper end of an interval that holds it nine times in
//! ten: variances are known from four replicates only, and those of noise that many sides share are known badly.

use crate::answer::{Answer, Task, ratio};
use crate::energy::Energy;
use crate::lighting::mean;
use crate::mesh_error::MeshError;
use crate::plan::RATE;
use crate::report::Cause;
use radiosity_exchange::Enclosure;
use radiosity_operator::{Cancelled, Operator};

/// Noise is followed through this many bounces at most, and no further once it changes by less than this share.
const MOST_BOUNCES: usize = 60;
const SETTLED: f64 = 0.03;

/// Nine in ten of a normal distribution lie within so many standard deviations.
const NINE_IN_TEN: f64 = 1.645;

/// Relative standard deviations of estimated variances: of one side from four replicates, which were .816 if noise were
/// normal, but that of shadows has longer tails; of carried noise, which many sides share, as if from six in all.
const ONE_SIDE: f64 = 1.0;
const SHARED: f64 = 0.577;

/// Error estimates per side.
pub(crate) struct Estimate {
    /// Standard error of irradiance, sides x bands.
    pub standard_error: Vec<f64>,
    /// The same by cause.
    pub causes: Vec<(Cause, Vec<f64>)>,
    /// Variance of the mean of the samples by rays, averaged over bands, per side.
    pub ray_variance: Vec<f64>,
    /// The same of the samples by lights.
    pub light_variance: Vec<f64>,
    /// Mean square of what the field leaves of the light about each side, less its noise, and the variance of that.
    pub mesh: Vec<f64>,
    pub mesh_noise: Vec<f64>,
    /// The upper end of the interval of all parts but the mesh.
    pub relative_but_mesh: f64,
    /// The root mean square over area and bands, relative to the mean irradiance, is between these nine times in ten.
    pub interval: (f64, f64),
    /// The likeliest value without the part of the mesh.
    pub likely_but_mesh: f64,
    /// The part that more samples reduce.
    pub relative_sampling: f64,
    /// The part that finer elements reduce.
    pub relative_elements: f64,
    /// The part that smaller patches reduce, whether it counts or not.
    pub relative_mesh: f64,
    /// The upper end of its interval.
    pub mesh_bound: f64,
    /// Mean irradiance over area and bands.
    pub mean_irradiance: f64,
    /// The balance of power.
    pub energy: Energy,
}

/// A mean square over the scene with how well it is known.
#[derive(Clone, Copy, Default)]
struct Part {
    square: f64,
    /// Of that.
    deviation: f64,
}

impl Part {
    fn high(&self) -> f64 {
        self.square.max(0.0) + NINE_IN_TEN * self.deviation
    }

    fn low(&self) -> f64 {
        (self.square - NINE_IN_TEN * self.deviation).max(0.0)
    }
}

pub(crate) fn estimate(task: &Task, answer: &Answer) -> Result<Estimate, Cancelled> {
    let (bands, enclosure) = (task.lighting.bands, task.measurement.transport.enclosure());
    let replicates = task.measurement.transport.shots().replicates();
    let sides = enclosure.sides();
    let width = replicates * bands;
    let (mut own, mut ray_variance, mut light_variance) =
        (vec![0.0; sides * bands], vec![0.0; sides], vec![0.0; sides]);
    // Deviation of each replicate from the mean, averaged over bands: sides x replicates.
    let mut deviation = vec![0.0; sides * replicates];
    let values: Vec<f64> = answer.by_rays.iter().zip(&answer.by_lights).map(|(a, b)| a + b).collect();
    for side in 0..sides {
        let rays = &answer.by_rays[side * width..][..width];
        let lights = &answer.by_lights[side * width..][..width];
        let both = &values[side * width..][..width];
        for b in 0..bands {
            own[side * bands + b] = variance_of_mean(both, bands, b);
            ray_variance[side] += variance_of_mean(rays, bands, b) / bands as f64;
            light_variance[side] += variance_of_mean(lights, bands, b) / bands as f64;
        }
        for k in 0..replicates {
            deviation[side * replicates + k] = mean(&both[k * bands..][..bands]) - mean(both);
        }
    }
    let carried = carry(task, &deviation, replicates)?;
    let mut mesh = MeshError::of(enclosure, &values, &answer.by_cell, replicates, bands);
    mesh.clear_where(bands, |side| enclosure.counted_area(side) == 0.0 && enclosure.area(side) > 0.0);
    let energy = Energy::of(task, answer);
    let solver = answer.solver.residual / (1.0 - task.lighting.highest_reflectance());
    let unfollowed = energy.unfollowed_share();
    let total_area: f64 = (0..sides).map(|side| task.weight(side)).sum();
    let (mut own_part, mut carried_part, mut mesh_part) = (Part::default(), Part::default(), Part::default());
    let (mut elements, mut systematic, mut level) = (0.0, 0.0, 0.0);
    let mut standard_error = vec![0.0; sides * bands];
    let mut squares: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; sides * bands]);
    for (side, &carried) in carried.iter().enumerate() {
        let share = task.weight(side) / total_area;
        let weight = share / bands as f64;
        let mut of_side = 0.0;
        for b in 0..bands {
            let k = side * bands + b;
            let by_samples = if task.as_field { mesh.variance[k] } else { own[k] };
            let by_elements = answer.by_elements[k].powi(2);
            let unexplained = (energy.imbalance * answer.irradiance[k]).powi(2)
                + (solver * answer.irradiance[k]).powi(2)
                + (unfollowed * answer.irradiance[k]).powi(2);
            let by_cause = [by_samples, carried, by_elements, unexplained, mesh.smooth_square[k].max(0.0)];
            (0..5).for_each(|cause| squares[cause][k] = by_cause[cause].sqrt());
            // Of the mean over the patch, or of the field on it.
            let all = if task.as_field { by_cause.iter().sum() } else { own[k] + carried + by_elements + unexplained };
            standard_error[k] = f64::sqrt(all);
            own_part.square += weight * by_samples;
            of_side += weight * by_samples;
            carried_part.square += weight * carried;
            mesh_part.square += weight * mesh.square[k];
            elements += weight * by_elements;
            systematic += weight * unexplained;
            level += weight * answer.irradiance[k];
        }
        own_part.deviation += (ONE_SIDE * of_side).powi(2);
        mesh_part.deviation += share * share * mesh.noise[side];
    }
    (own_part.deviation, mesh_part.deviation) = (own_part.deviation.sqrt(), mesh_part.deviation.sqrt());
    carried_part.deviation = SHARED * carried_part.square;
    let but_mesh = own_part.high() + carried_part.high() + elements + systematic;
    let counted = if task.as_field { mesh_part } else { Part::default() };
    let likely = own_part.square + carried_part.square + elements + systematic;
    let relative = |square: f64| ratio(square.sqrt(), level);
    let [by_samples, by_others, by_elements, by_rest, by_mesh] = squares;
    Ok(Estimate {
        standard_error,
        causes: vec![
            (Cause::Sampling, by_samples),
            (Cause::Interreflection, by_others),
            (Cause::Transport, by_elements),
            (Cause::Balance, by_rest),
            (Cause::Mesh, by_mesh),
        ],
        ray_variance,
        light_variance,
        mesh: mesh.smooth_square.chunks_exact(bands.max(1)).map(mean).collect(),
        mesh_noise: mesh.smooth_noise,
        relative_but_mesh: relative(but_mesh),
        interval: (relative(own_part.low() + carried_part.low() + counted.low()), relative(but_mesh + counted.high())),
        likely_but_mesh: relative(likely),
        relative_sampling: relative(own_part.square + carried_part.square),
        relative_elements: relative(elements),
        relative_mesh: relative(mesh_part.square.max(0.0)),
        mesh_bound: relative(mesh_part.high()),
        mean_irradiance: level,
        energy,
    })
}

/// The variance of the mean of replicates `values[k * bands + band]`.
fn variance_of_mean(values: &[f64], bands: usize, band: usize) -> f64 {
    let n = (values.len() / bands) as f64;
    let each = || values.iter().skip(band).step_by(bands);
    let mean = each().sum::<f64>() / n;
    each().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n * (n - 1.0))
}

/// The variance that the deviations of other sides' replicates cause at each side through interreflection.
fn carry(task: &Task, deviation: &[f64], replicates: usize) -> Result<Vec<f64>, Cancelled> {
    let enclosure = task.measurement.transport.enclosure();
    let reflectance: Vec<f64> =
        (0..enclosure.sides()).map(|side| mean(task.lighting.reflectance_of(enclosure.patch_of(side)))).collect();
    let through: Vec<_> = (0..enclosure.sides())
        .filter_map(|side| task.through(side).map(|(other, transmittance)| (side, other, mean(transmittance))))
        .collect();
    let area = &task.measurement.exchange.exposed_area;
    let mut carried = vec![0.0; deviation.len()];
    for _ in 0..MOST_BOUNCES {
        task.control.check()?;
        let mut reflected: Vec<f64> =
            (0..deviation.len()).map(|k| reflectance[k / replicates] * (deviation[k] + carried[k])).collect();
        for (side, other, transmittance) in &through {
            for r in 0..replicates {
                let k = other * replicates + r;
                reflected[side * replicates + r] += transmittance * (deviation[k] + carried[k]);
            }
        }
        let mut arriving = vec![0.0; deviation.len()];
        task.measurement.exchange.operator.apply(&reflected, &mut arriving, replicates);
        arriving.iter_mut().enumerate().for_each(|(k, v)| *v = ratio(*v, area[k / replicates]));
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
        let change = norm(&mut arriving.iter().zip(&carried).map(|(a, b)| a - b));
        let size = norm(&mut arriving.iter().zip(deviation).map(|(a, d)| a.abs() + d.abs()));
        carried = arriving;
        if change <= SETTLED * size {
            break;
        }
    }
    // The deviations are those of all rays; the operator, which the carried noise is of, had fewer.
    let thinner = f64::from(task.measurement.thinning).powf(RATE);
    let n = replicates as f64;
    Ok(carried
        .chunks_exact(replicates)
        .map(|c| thinner * c.iter().map(|v| v * v).sum::<f64>() / (n * (n - 1.0)))
        .collect())
}

/// Root mean square over area and bands of an error of irradiance, relative to the mean; blocks of sides x bands.
pub(crate) fn relative_rms(
    enclosure: &Enclosure,
    irradiance: &[f64],
    bands: usize,
    error: impl Fn(usize) -> f64,
) -> f64 {
    let (mut squares, mut level, mut whole): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (k, h) in irradiance.iter().enumerate() {
        let area = enclosure.counted_area(k / bands);
        squares += area * error(k).powi(2);
        level += area * h;
        whole += area;
    }
    ratio((squares * whole).sqrt(), level)
}
