//! One salvo: rays that carry given power from cells to wherever they land.
//!
//! Every ray carries about the same power, so cells shoot in proportion to what they have (Neumann 1995; Bekaert 1999,
//! *Hierarchical and Stochastic Algorithms for Radiosity*, section 6.3). A ray carries all bands at once. How many rays
//! a cell gets is rounded along the running sum of powers with one random offset, so that no run of cells shoots more
//! than one ray too many or too few, and each as many as it should on average.
//!
//! Power is counted in whole units of about 2^-60 of the salvo's. Sums of whole numbers do not depend on their order,
//! so any number of threads may add to one count at once, and nothing is lost between them.

use super::Context;
use super::rays::{BATCH, Batch};
use radiosity_exchange::enclosure::Landing;
use radiosity_exchange::shots::is_buried;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::{Sequence, cosine_hemisphere};
use radiosity_operator::Cancelled;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The power of a salvo in units.
const UNITS: f64 = (1u64 << 60) as f64;

/// The share of rays by each band's own total, whatever its power: no band starves.
const EVEN: f64 = 0.25;

/// How often a ray that would start inside a solid is started elsewhere on its cell.
const TRIES: u32 = 16;

/// Counts of arrived power, cells x bands.
pub(super) struct Counts(Vec<AtomicU64>);

impl Counts {
    pub fn new(size: usize) -> Self {
        Self((0..size).map(|_| AtomicU64::new(0)).collect())
    }

    #[inline]
    fn add(&self, k: usize, units: u64) {
        self.0[k].fetch_add(units, Ordering::Relaxed);
    }

    /// Takes the count, which is zero again.
    #[inline]
    pub fn take(&self, k: usize) -> u64 {
        // No salvo is under way: nobody else writes.
        let units = self.0[k].load(Ordering::Relaxed);
        self.0[k].store(0, Ordering::Relaxed);
        units
    }
}

/// Power per band that did not land, W.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Losses {
    pub escaped: Vec<f64>,
    pub on_backs: Vec<f64>,
}

/// How the first bounce is shared with what gathers the same light from the other end.
pub(super) struct Sharing<'a> {
    /// Rays that a cell gathers by, per m2.
    pub gathered: &'a [f32],
    /// The part of arrivals that counts here.
    pub counts: &'a Counts,
}

/// Rays of each cell, and what each carries.
pub(super) struct Salvo<'a> {
    power: &'a [f64],
    bands: usize,
    /// Total power per band, W.
    total: Vec<f64>,
    /// Rays of all cells before each; one more than cells.
    offsets: Vec<u64>,
    /// Expected rays per weight.
    per_weight: f64,
    /// What makes the rays carry the power of each band exactly.
    scale: Vec<f64>,
}

impl<'a> Salvo<'a> {
    /// Shares `rays` among cells by power (cells x bands, W); `offset` in [0, 1) decides how shares are rounded.
    pub fn new(power: &'a [f64], bands: usize, rays: u64, offset: f64) -> Self {
        let mut total = vec![0.0; bands];
        for cell in power.chunks_exact(bands) {
            total.iter_mut().zip(cell).for_each(|(t, p)| *t += p);
        }
        let mut salvo = Self { power, bands, total, offsets: Vec::new(), per_weight: 0.0, scale: vec![1.0; bands] };
        let cells = power.len() / bands;
        let sum: f64 = (0..cells).map(|cell| salvo.weight(cell)).sum();
        salvo.offsets = vec![0; cells + 1];
        if sum > 0.0 {
            salvo.per_weight = rays as f64 / sum;
            salvo.share(offset);
        }
        salvo
    }

    fn share(&mut self, offset: f64) {
        let (mut running, mut carried) = (0.0, vec![0.0; self.bands]);
        for cell in 0..self.offsets.len() - 1 {
            let expected = self.expected(cell);
            running += expected;
            self.offsets[cell + 1] = (running + offset) as u64;
            let rays = (self.offsets[cell + 1] - self.offsets[cell]) as f64;
            if rays > 0.0 {
                let power = &self.power[cell * self.bands..][..self.bands];
                carried.iter_mut().zip(power).for_each(|(c, p)| *c += rays * p / expected);
            }
        }
        for (b, carried) in carried.into_iter().enumerate() {
            self.scale[b] = if carried > 0.0 { self.total[b] / carried } else { 0.0 };
        }
    }

    /// The share of a cell in the rays, not normalised: by the squares of its bands, which is what an error is, and
    /// a part by each band's share of its own total.
    fn weight(&self, cell: usize) -> f64 {
        let power = &self.power[cell * self.bands..][..self.bands];
        let (mut squares, mut even, mut whole) = (0.0, 0.0, 0.0);
        for (p, t) in power.iter().zip(&self.total).filter(|(_, t)| **t > 0.0) {
            squares += p * p;
            even += p / t;
            whole += t;
        }
        if whole > 0.0 { (1.0 - EVEN) * squares.sqrt() / whole + EVEN * even } else { 0.0 }
    }

    /// Expected rays of a cell.
    pub fn expected(&self, cell: usize) -> f64 {
        self.weight(cell) * self.per_weight
    }

    pub fn rays(&self) -> u64 {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// The power of one unit of a band, W.
    pub fn unit(&self, band: usize) -> f64 {
        self.total[band] / UNITS
    }

    /// Shoots; what lands is added to `arrived`.
    pub fn shoot(
        &self,
        context: &Context,
        replicate: u32,
        stream: u32,
        arrived: &Counts,
        sharing: Option<&Sharing>,
    ) -> Result<Losses, Cancelled> {
        let tasks = self.rays().div_ceil(BATCH as u64);
        let none = || vec![0u64; 2 * self.bands];
        let lost = (0..tasks)
            .into_par_iter()
            .map_init(Gun::default, |gun, task| {
                context.control.check()?;
                let mut lost = none();
                let rays = task * BATCH as u64..((task + 1) * BATCH as u64).min(self.rays());
                context.control.advance(rays.end - rays.start);
                gun.load(self, context, replicate, stream, rays);
                gun.fire(self, context, arrived, sharing, &mut lost);
                Ok(lost)
            })
            .try_reduce(none, |mut a, b| {
                a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                Ok(a)
            })?;
        let watts = |k: usize| (0..self.bands).map(|b| lost[k * self.bands + b] as f64 * self.unit(b)).collect();
        Ok(Losses { escaped: watts(0), on_backs: watts(1) })
    }
}

/// A cell within a batch.
struct Shooter {
    cell: usize,
    sequence: Sequence,
    rays: u32,
    /// Rays per m2 of the exposed part.
    density: f32,
}

/// Buffers of one worker.
#[derive(Default)]
struct Gun {
    batch: Batch,
    shooters: Vec<Shooter>,
    /// Units that each ray of a shooter carries, shooters x bands.
    units: Vec<u64>,
    /// Shooter and origin of rays that ended on a back and may have started in a solid.
    doubtful: Vec<(u32, Ray)>,
}

impl Gun {
    /// Makes a range of the salvo's rays.
    fn load(&mut self, salvo: &Salvo, context: &Context, replicate: u32, stream: u32, range: std::ops::Range<u64>) {
        self.shooters.clear();
        self.units.clear();
        let mut cell = salvo.offsets.partition_point(|&o| o <= range.start) - 1;
        let mut ray = range.start;
        while ray < range.end {
            let (start, end) = (salvo.offsets[cell], salvo.offsets[cell + 1]);
            if start < end {
                let tag = self.shooters.len() as u32;
                self.enlist(salvo, context, replicate, stream, cell);
                let frame = context.cells.frame(cell);
                for index in ray - start..end.min(range.end) - start {
                    let [u, v, s, t] = self.shooters[tag as usize].sequence.point(index as u32);
                    let origin = context.cells.point_off(cell, s, t);
                    self.batch.push(context.cells.enclosure.ray(origin, cosine_hemisphere(&frame, u, v)), tag);
                }
                ray = end.min(range.end);
            }
            cell += 1;
        }
    }

    fn enlist(&mut self, salvo: &Salvo, context: &Context, replicate: u32, stream: u32, cell: usize) {
        let expected = salvo.expected(cell);
        let area = context.cells.area(cell) * f64::from(context.exposure[cell]);
        self.shooters.push(Shooter {
            cell,
            sequence: Sequence::new(context.seed, cell as u32, replicate, stream),
            rays: (salvo.offsets[cell + 1] - salvo.offsets[cell]) as u32,
            density: if area > 0.0 { (expected / area) as f32 } else { 0.0 },
        });
        for b in 0..salvo.bands {
            let power = salvo.power[cell * salvo.bands + b] / expected * salvo.scale[b];
            self.units.push(if power > 0.0 { (power / salvo.unit(b)).round() as u64 } else { 0 });
        }
    }

    /// Traces the rays and adds what they carry to where they land.
    fn fire(
        &mut self,
        salvo: &Salvo,
        context: &Context,
        arrived: &Counts,
        sharing: Option<&Sharing>,
        lost: &mut [u64],
    ) {
        let Self { batch, shooters, units, doubtful } = self;
        let bands = salvo.bands;
        let mut end = |tag: u32, landing: Landing| {
            let carried = &units[tag as usize * bands..][..bands];
            match landing {
                Landing::Escaped => lost[..bands].iter_mut().zip(carried).for_each(|(l, c)| *l += c),
                Landing::Back => lost[bands..].iter_mut().zip(carried).for_each(|(l, c)| *l += c),
                Landing::Side(cell) => {
                    let first = cell as usize * bands;
                    carried.iter().enumerate().for_each(|(b, &c)| arrived.add(first + b, c));
                    if let Some(sharing) = sharing {
                        let share = sharing.share(shooters[tag as usize].density, cell as usize);
                        let part = |c: u64| (c as f64 * share) as u64;
                        carried.iter().enumerate().for_each(|(b, &c)| sharing.counts.add(first + b, part(c)));
                    }
                }
            }
        };
        batch.trace(context.cells, |tag, ray, landing| {
            let exposed = context.exposure[shooters[tag as usize].cell] == 1.0;
            if landing == Landing::Back && !exposed {
                doubtful.push((tag, *ray));
            } else {
                end(tag, landing);
            }
        });
        for (number, (tag, ray)) in doubtful.drain(..).enumerate() {
            end(tag, from_outside(context, &shooters[tag as usize], &ray, number as u32));
        }
    }
}

impl Sharing<'_> {
    /// The part of a ray's power that counts here: the balance heuristic (Veach and Guibas 1995) between shooting and
    /// gathering along the same line.
    fn share(&self, shot: f32, receiver: usize) -> f64 {
        let gathered = self.gathered[receiver];
        f64::from(shot) / f64::from(shot + gathered)
    }
}

/// Where a ray lands that ended on a back: as it did, unless it started in a solid; then where another one of the cell
/// does.
fn from_outside(context: &Context, shooter: &Shooter, ray: &Ray, number: u32) -> Landing {
    let (cells, enclosure) = (context.cells, context.cells.enclosure);
    let buried = |ray: &Ray| is_buried(enclosure, cells.side_of(shooter.cell), ray);
    if !buried(ray) {
        return Landing::Back;
    }
    let frame = cells.frame(shooter.cell);
    for attempt in 0..TRIES {
        let index = shooter.rays.wrapping_add(number * TRIES + attempt);
        let [u, v, s, t] = shooter.sequence.point(index);
        let ray = enclosure.ray(cells.point_off(shooter.cell, s, t), cosine_hemisphere(&frame, u, v));
        let landing = cells.landing(&ray, &enclosure.bvh().closest_hit(&ray));
        if landing != Landing::Back || !buried(&ray) {
            return landing;
        }
    }
    Landing::Back
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_shoot_in_proportion_and_all_is_shot() {
        let power: Vec<f64> = (0..1000).map(|k| f64::from(k % 7)).collect();
        let salvo = Salvo::new(&power, 1, 500, 0.3);
        assert!((salvo.rays() as i64 - 500).abs() <= 1);
        let mut shot = 0.0;
        for (cell, power) in power.iter().enumerate() {
            let rays = salvo.offsets[cell + 1] - salvo.offsets[cell];
            assert!((rays as f64 - salvo.expected(cell)).abs() <= 1.0);
            if rays > 0 {
                shot += rays as f64 * power / salvo.expected(cell) * salvo.scale[0];
            }
        }
        assert!((shot - power.iter().sum::<f64>()).abs() < 1e-9 * shot);
    }

    #[test]
    fn a_faint_band_has_rays_too() {
        // One cell has all of a band of a millionth of the power.
        let power = [1.0, 0.0, 0.0, 1e-6];
        let salvo = Salvo::new(&power, 2, 1000, 0.5);
        assert!(salvo.expected(1) > 100.0, "{}", salvo.expected(1));
    }
}
