//! Where the power went: the balance of an answer.

use crate::answer::{Task, ratio};
use crate::transport::Transport;
use radiosity_exchange::Shot;

/// Powers in W per band, and what they leave unexplained.
#[derive(Clone, Debug, Default)]
pub struct Energy {
    /// Emitted by surfaces.
    pub emitted: Vec<f64>,
    /// Put on surfaces by lights without area.
    pub from_lights: Vec<f64>,
    /// Absorbed by the sides.
    pub absorbed: Vec<f64>,
    /// Left the scene.
    pub escaped: Vec<f64>,
    /// Absorbed by black backs of one-sided patches, and emitted where a solid stands on a patch.
    pub lost_on_backs: Vec<f64>,
    /// Power in less power out, relative to power in: the worst band.
    pub imbalance: f64,
    /// The share of rays that left the scene.
    pub escape_share: f64,
}

impl Energy {
    pub(crate) fn of(task: &Task, irradiance: &[f64]) -> Self {
        let (bands, transport) = (task.lighting.bands, &task.measurement.transport);
        let enclosure = transport.enclosure();
        let radiosity = task.radiosity(irradiance);
        let none = || vec![0.0; bands];
        let mut energy = Self {
            emitted: none(),
            from_lights: task.incident_power(),
            absorbed: none(),
            escaped: none(),
            lost_on_backs: none(),
            ..Self::default()
        };
        let (mut rays, mut escaped) = (0.0, 0.0);
        for side in 0..enclosure.sides() {
            let (patch, area, share) = (enclosure.patch_of(side), enclosure.area(side), Fates::of(transport, side));
            rays += share.total;
            escaped += share.total * share.escaped;
            for b in 0..bands {
                let k = side * bands + b;
                let emission = task.lighting.emission_of(patch)[b];
                // Buried parts receive nothing: only their own emission is lost there.
                let exposed = ratio(radiosity[k] - share.buried * emission, 1.0 - share.buried);
                energy.emitted[b] += area * emission;
                energy.absorbed[b] += area * (1.0 - task.lighting.reflectance_of(patch)[b]) * irradiance[k];
                energy.escaped[b] += area * exposed * share.escaped;
                energy.lost_on_backs[b] += area * (share.buried * emission + exposed * share.back);
            }
        }
        energy.imbalance =
            (0..bands).map(|b| energy.unexplained(b)).fold(0.0, |a, b| if b.abs() > f64::abs(a) { b } else { a });
        energy.escape_share = ratio(escaped, rays);
        energy
    }

    fn unexplained(&self, band: usize) -> f64 {
        let input = self.emitted[band] + self.from_lights[band];
        ratio(input - self.absorbed[band] - self.escaped[band] - self.lost_on_backs[band], input)
    }
}

/// What became of a side's rays, as shares of all.
struct Fates {
    total: f64,
    escaped: f64,
    back: f64,
    buried: f64,
}

impl Fates {
    fn of(transport: &Transport, side: usize) -> Self {
        let (mut total, mut escaped, mut back, mut buried) = (0u32, 0u32, 0u32, 0u32);
        for shot in transport.shots().of(side).flatten() {
            total += 1;
            escaped += u32::from(shot.target == Shot::ESCAPED);
            back += u32::from(shot.target == Shot::BACK);
            buried += u32::from(shot.target == Shot::BURIED);
        }
        let share = |n: u32| ratio(f64::from(n), f64::from(total));
        Self { total: f64::from(total), escaped: share(escaped), back: share(back), buried: share(buried) }
    }
}
