//! Light straight from luminaires: area samples with visibility tests, as `luminaires.rs` of the exchange takes them.

use super::{Context, Replicate};
use radiosity_exchange::LightSample;
use radiosity_exchange::luminaires::{Luminaires, Probe, Scratch};
use radiosity_operator::Cancelled;
use rayon::prelude::*;

/// Sides of one task.
const SIDES: usize = 64;

/// Adds samples `first..first + count` of every cell to a replicate's sums. Points of a side's sequence fill its cells
/// equally.
pub(super) fn sample(
    context: &Context,
    luminaires: &Luminaires,
    number: u32,
    (first, count): (u32, u32),
    replicate: &mut Replicate,
) -> Result<(), Cancelled> {
    let (bands, cells) = (context.lighting.bands, context.cells);
    let width = cells.per_side() * bands;
    let [first, count] = [first, count].map(|n| n * cells.per_side() as u32);
    let emitters = luminaires.list.len() - context.lighting.lamps.len();
    // A seed of its own for each replicate: the probe numbers replicates of one call from zero.
    let probe = Probe::new(cells.enclosure, luminaires, context.seed ^ (u64::from(number) << 56));
    let lights = replicate.from_lights.par_chunks_mut(SIDES * width);
    let from_emitters = chunks_or_none(&mut replicate.from_emitters, SIDES * width, lights.len());
    lights.zip(from_emitters).enumerate().try_for_each_init(
        || (Scratch::default(), vec![LightSample::default(); count as usize]),
        |(scratch, items), (task, (lights, from_emitters))| {
            context.control.check()?;
            for (k, lights) in lights.chunks_exact_mut(width).enumerate() {
                items.fill(LightSample::default());
                probe.draw(scratch, task * SIDES + k, first, 1, items);
                for sample in items.iter().filter(|sample| sample.weight > 0.0) {
                    let at = cells.within(sample.origin_cell) * bands;
                    let (out, strength) = match (sample.luminaire as usize).checked_sub(emitters) {
                        Some(lamp) => (&mut lights[at..at + bands], context.lighting.lamps[lamp].strength.as_slice()),
                        None => {
                            (&mut from_emitters[k * width + at..][..bands], context.emission_of(luminaires, sample))
                        }
                    };
                    out.iter_mut().zip(strength).for_each(|(o, s)| *o += sample.weight * *s as f32);
                }
            }
            context.control.advance((lights.len() / width) as u64 * u64::from(count));
            Ok(())
        },
    )
}

/// Chunks of what may be empty.
fn chunks_or_none(values: &mut [f32], size: usize, count: usize) -> Vec<&mut [f32]> {
    let mut chunks: Vec<&mut [f32]> = values.chunks_mut(size).collect();
    chunks.resize_with(count, Default::default);
    chunks
}
