//! Bounce after bounce until little power is left: incremental stochastic Jacobi relaxation.

use super::salvo::{Counts, Losses, Salvo, Sharing};
use super::{Context, Shares};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::Cancelled;
use rayon::prelude::*;

/// Power that is not shot any more, relative to what was there first: what is neglected is about this share.
const SETTLED: f64 = 1e-4;

/// A salvo has at least so many rays.
const FEWEST: u64 = 1024;

/// Reflectance below 0.999 needs fewer.
const MOST_BOUNCES: u32 = 20_000;

/// The streams of the sequences that feed salvos: a fresh one for each, from here on.
const STREAM: u32 = 1 << 16;

/// What bounces brought.
pub(super) struct Bounced {
    /// Irradiance by all bounces, cells x bands.
    pub irradiance: Vec<f64>,
    /// The part of the first that shooting answers for.
    pub shared: Vec<f64>,
    pub shares: Shares,
    pub rays: u64,
    pub bounces: u32,
    /// Power left, relative to the first: the worst band.
    pub left: f64,
}

/// How a replicate shoots.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    pub replicate: u32,
    pub round: u32,
    /// Rays of the first bounce.
    pub first: u64,
    /// Rays per power of the later ones relative to the first.
    pub later: f64,
}

impl Effort {
    /// The stream of salvo `number` and how its shares are rounded.
    fn draw(&self, context: &Context, number: u32) -> (u32, f64) {
        let stream = STREAM + self.round * STREAM + number;
        let [offset, ..] = Sequence::new(context.seed, u32::MAX, self.replicate, stream).point(0);
        (stream, offset)
    }
}

/// Shoots what cells send first (cells x bands, W), then what they reflect, and so on. `gathered` are the rays per m2
/// that gather the first bounce from the other end; `note` is told the salvo that shoots it.
pub(super) fn shoot(
    context: &Context,
    effort: Effort,
    mut power: Vec<f64>,
    gathered: &[f32],
    note: impl FnOnce(&Salvo),
) -> Result<Bounced, Cancelled> {
    let bands = context.lighting.bands;
    let arrived = Counts::new(power.len());
    let first = totals(&power, bands);
    let mut all = Bounced {
        irradiance: vec![0.0; power.len()],
        shared: vec![0.0; power.len()],
        shares: Shares::new(bands),
        rays: 0,
        bounces: 0,
        left: 0.0,
    };
    let mut note = Some(note);
    let mut losses: Vec<Losses> = Vec::new();
    while all.bounces < MOST_BOUNCES {
        let left = relative(&totals(&power, bands), &first);
        all.left = left;
        if left <= SETTLED {
            break;
        }
        let share = if all.bounces == 0 { 1.0 } else { left * effort.later };
        let rays = ((effort.first as f64 * share) as u64).max(FEWEST);
        let (stream, offset) = effort.draw(context, all.bounces);
        let salvo = Salvo::new(&power, bands, rays, offset);
        if let Some(note) = note.take() {
            note(&salvo);
            let counts = Counts::new(power.len());
            let sharing = Sharing { gathered, counts: &counts };
            losses.push(salvo.shoot(context, effort.replicate, stream, &arrived, Some(&sharing))?);
            collect(context, &salvo, &counts, &mut all.shared);
        } else {
            losses.push(salvo.shoot(context, effort.replicate, stream, &arrived, None)?);
        }
        all.rays += salvo.rays();
        all.bounces += 1;
        let units: Vec<f64> = (0..bands).map(|b| salvo.unit(b)).collect();
        drop(salvo);
        reflect(context, &units, &arrived, &mut all.irradiance, &mut power);
    }
    all.shares.add(&losses, &first);
    Ok(all)
}

/// Irradiance by what was counted, added to `irradiance`.
fn collect(context: &Context, salvo: &Salvo, counts: &Counts, irradiance: &mut [f64]) {
    let bands = context.lighting.bands;
    irradiance.par_iter_mut().enumerate().with_min_len(4096).for_each(|(k, h)| {
        let units = counts.take(k);
        if units > 0 {
            *h += units as f64 * salvo.unit(k % bands) / context.cells.area(k / bands);
        }
    });
}

/// Takes what arrived: adds it to irradiance and leaves in `power` what of it is reflected.
fn reflect(context: &Context, units: &[f64], arrived: &Counts, irradiance: &mut [f64], power: &mut [f64]) {
    let bands = context.lighting.bands;
    irradiance.par_iter_mut().zip(power).enumerate().with_min_len(4096).for_each(|(k, (h, power))| {
        let watts = arrived.take(k) as f64 * units[k % bands];
        let (cell, band) = (k / bands, k % bands);
        *power = watts * context.lighting.reflectance_of(context.cells.patch_of(cell))[band];
        if watts > 0.0 {
            *h += watts / context.cells.area(cell);
        }
    });
}

fn totals(power: &[f64], bands: usize) -> Vec<f64> {
    let mut totals = vec![0.0; bands];
    for cell in power.chunks_exact(bands) {
        totals.iter_mut().zip(cell).for_each(|(t, p)| *t += p);
    }
    totals
}

fn relative(left: &[f64], first: &[f64]) -> f64 {
    left.iter().zip(first).map(|(l, f)| if *f > 0.0 { l / f } else { 0.0 }).fold(0.0, f64::max)
}
