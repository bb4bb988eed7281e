//! A state as plain arrays, for files.

use super::state::StateError;
use super::{REPLICATES, Replicate, Shares, Shooting};

/// Changes when the meaning of the arrays does.
const VERSION: u64 = 1;

/// All numbers of a state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Version, then what is whole.
    pub counts: Vec<u64>,
    /// Power left, then escaped, on backs and weight of both kinds of power, replicate by replicate.
    pub shares: Vec<f64>,
    /// Exposed shares and what coarser cells would change, by each half of the replicates, then the sums of each
    /// replicate, cells x bands each.
    pub sums: Vec<f32>,
    /// Rays that landed, per cell.
    pub landed: Vec<u32>,
}

impl Shooting {
    /// The state as arrays.
    pub fn to_parts(&self) -> Parts {
        let emitters = self.replicates.iter().any(|r| !r.from_emitters.is_empty());
        let counts = vec![
            VERSION,
            self.seed,
            self.fingerprint,
            self.bands as u64,
            u64::from(emitters),
            u64::from(self.rounds),
            u64::from(self.rays),
            u64::from(self.light_samples),
            self.rays_shot,
            self.rays_gathered,
            self.rays_escaped,
            u64::from(self.bounces),
        ];
        let (mut shares, mut sums) =
            (vec![self.left], [&self.exposure[..], &self.changed[0], &self.changed[1]].concat());
        for replicate in &self.replicates {
            for s in [&replicate.emitters, &replicate.others] {
                shares.extend(s.escaped.iter().chain(&s.on_backs).chain([&s.weight]));
            }
            let Replicate { from_lights, from_emitters, gathered, bounced, .. } = replicate;
            [from_lights, from_emitters, gathered, bounced].iter().for_each(|values| sums.extend_from_slice(values));
        }
        Parts { counts, shares, sums, landed: self.landed.clone() }
    }

    /// The state that arrays tell of.
    pub fn from_parts(parts: Parts) -> Result<Self, StateError> {
        let error = |what: &str| Err(StateError(format!("this is no state of shooting: {what}")));
        let [
            version,
            seed,
            fingerprint,
            bands,
            emitters,
            rounds,
            rays,
            light_samples,
            shot,
            gathered,
            escaped,
            bounces,
        ] = parts.counts[..]
        else {
            return error("it has another number of counts");
        };
        if version != VERSION {
            return Err(StateError(format!("the state has version {version}; this program reads version {VERSION}")));
        }
        let (cells, bands) = (parts.landed.len(), bands as usize);
        let blocks = if emitters == 0 { 3 } else { 4 };
        let size = bands.checked_mul(cells).filter(|size| {
            let sums = size.checked_mul(REPLICATES * blocks).and_then(|s| s.checked_add(3 * cells));
            sums == Some(parts.sums.len()) && parts.shares.len() == 1 + REPLICATES * 2 * (2 * bands + 1)
        });
        let Some(size) = size else { return error("its arrays do not fit together") };
        if rounds == 0 || !parts.sums.iter().all(|v| v.is_finite()) || !parts.shares.iter().all(|v| v.is_finite()) {
            return error("its numbers make no sense");
        }
        let whole = |v: u64| u32::try_from(v).map_err(|_| StateError("a count of the state is too large".into()));
        let mut take = Taker { shares: &parts.shares[1..], sums: &parts.sums[3 * cells..] };
        let replicates = (0..REPLICATES).map(|_| take.replicate(bands, size, emitters != 0)).collect();
        Ok(Self {
            seed,
            bands,
            fingerprint,
            rounds: whole(rounds)?,
            rays: whole(rays)?,
            light_samples: whole(light_samples)?,
            next: (whole(rays)?, whole(light_samples)?),
            rays_shot: shot,
            rays_gathered: gathered,
            rays_escaped: escaped,
            bounces: whole(bounces)?,
            left: parts.shares[0],
            exposure: parts.sums[..cells].to_vec(),
            changed: [1, 2].map(|k| parts.sums[k * cells..(k + 1) * cells].to_vec()),
            landed: parts.landed,
            replicates,
        })
    }
}

/// What is not read yet.
struct Taker<'a> {
    shares: &'a [f64],
    sums: &'a [f32],
}

impl Taker<'_> {
    fn replicate(&mut self, bands: usize, size: usize, emitters: bool) -> Replicate {
        let (from_emitters, others) = (self.shares(bands), self.shares(bands));
        Replicate {
            from_lights: self.sums(size),
            from_emitters: self.sums(if emitters { size } else { 0 }),
            gathered: self.sums(size),
            bounced: self.sums(size),
            emitters: from_emitters,
            others,
        }
    }

    fn shares(&mut self, bands: usize) -> Shares {
        let (taken, rest) = self.shares.split_at(2 * bands + 1);
        self.shares = rest;
        Shares {
            escaped: taken[..bands].to_vec(),
            on_backs: taken[bands..2 * bands].to_vec(),
            weight: taken[2 * bands],
        }
    }

    fn sums(&mut self, count: usize) -> Vec<f32> {
        let (taken, rest) = self.sums.split_at(count);
        self.sums = rest;
        taken.to_vec()
    }
}
