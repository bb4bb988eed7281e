//! How wrong an answer is, from the answer itself.
//!
//! Four parts add in squares. The spread of the replicates is the standard error of a side's own samples. The same
//! spread, sent through the interreflections, is what the noise of other sides adds (first-order perturbation:
//! `dH = dF B + F rho dH`). Power that the balance cannot explain is an error of the whole. What replacing sides by elements changed bounds what still finer elements would change.

use crate::answer::{Answer, Task, ratio};
use crate::energy::Energy;
use crate::lighting::mean;
use crate::plan::RATE;
use radiosity_exchange::Enclosure;
use radiosity_operator::{Cancelled, Operator};

/// Noise is followed through this many bounces at most, and no further once it changes by less than this share.
const MOST_BOUNCES: usize = 60;
const SETTLED: f64 = 0.03;

/// Error estimates per side.
pub(crate) struct Estimate {
    /// Standard error of irradiance, sides x bands.
    pub standard_error: Vec<f64>,
    /// Variance of the mean of the samples by rays, averaged over bands, per side.
    pub ray_variance: Vec<f64>,
    /// The same of the samples by lights.
    pub light_variance: Vec<f64>,
    /// Root mean square over area and bands, relative to the mean irradiance: all causes.
    pub relative: f64,
    /// The part of `relative` that more samples reduce.
    pub relative_sampling: f64,
    /// The part of `relative` that finer elements reduce.
    pub relative_elements: f64,
    /// Area-weighted mean irradiance over bands.
    pub mean_irradiance: f64,
    /// The balance of power.
    pub energy: Energy,
}

pub(crate) fn estimate(task: &Task, answer: &Answer) -> Result<Estimate, Cancelled> {
    let bands = task.lighting.bands;
    let replicates = task.measurement.transport.shots().replicates();
    let sides = task.measurement.transport.enclosure().sides();
    let width = replicates * bands;
    let (mut own, mut ray_variance, mut light_variance) =
        (vec![0.0; sides * bands], vec![0.0; sides], vec![0.0; sides]);
    // Deviation of each replicate from the mean, averaged over bands: sides x replicates.
    let mut deviation = vec![0.0; sides * replicates];
    for side in 0..sides {
        let rays = &answer.by_rays[side * width..][..width];
        let lights = &answer.by_lights[side * width..][..width];
        let both: Vec<f64> = rays.iter().zip(lights).map(|(a, b)| a + b).collect();
        for b in 0..bands {
            own[side * bands + b] = variance_of_mean(&both, bands, b);
            ray_variance[side] += variance_of_mean(rays, bands, b) / bands as f64;
            light_variance[side] += variance_of_mean(lights, bands, b) / bands as f64;
        }
        for k in 0..replicates {
            deviation[side * replicates + k] = mean(&both[k * bands..][..bands]) - mean(&both);
        }
    }
    let carried = carry(task, &deviation, replicates)?;
    let area = |side: usize| task.measurement.transport.enclosure().area(side);
    let total_area: f64 = (0..sides).map(area).sum();
    let energy = Energy::of(task, answer);
    let (mut all, mut sampling, mut elements, mut level) = (0.0, 0.0, 0.0, 0.0);
    let mut standard_error = vec![0.0; sides * bands];
    for (side, carried) in carried.iter().enumerate() {
        let weight = area(side) / (total_area * bands as f64);
        for b in 0..bands {
            let k = side * bands + b;
            let by_sampling = own[k] + carried;
            let by_elements = answer.by_elements[k].powi(2);
            let unexplained = (energy.imbalance * answer.irradiance[k]).powi(2);
            standard_error[k] = (by_sampling + by_elements + unexplained).sqrt();
            all += weight * (by_sampling + by_elements + unexplained);
            sampling += weight * by_sampling;
            elements += weight * by_elements;
            level += weight * answer.irradiance[k];
        }
    }
    Ok(Estimate {
        standard_error,
        ray_variance,
        light_variance,
        relative: ratio(all.sqrt(), level),
        relative_sampling: ratio(sampling.sqrt(), level),
        relative_elements: ratio(elements.sqrt(), level),
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
    let area = &task.measurement.exchange.exposed_area;
    let mut carried = vec![0.0; deviation.len()];
    for _ in 0..MOST_BOUNCES {
        task.control.check()?;
        let reflected: Vec<f64> =
            (0..deviation.len()).map(|k| reflectance[k / replicates] * (deviation[k] + carried[k])).collect();
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
        let area = enclosure.area(k / bands);
        squares += area * error(k).powi(2);
        level += area * h;
        whole += area;
    }
    ratio((squares * whole).sqrt(), level)
}
