//! Where the power went: the balance of an answer.

use crate::answer::{Answer, Task, ratio};
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
    /// Of that, by mirrors and clear glass; empty where there are none.
    pub absorbed_by_mirrors: Vec<f64>,
    /// Left the scene.
    pub escaped: Vec<f64>,
    /// Absorbed by black backs of one-sided patches, and emitted where a solid stands on a patch.
    pub lost_on_backs: Vec<f64>,
    /// Not followed to its end between mirrors; empty where there are none.
    pub unfollowed: Vec<f64>,
    /// Power in less power out, relative to power in: the worst band.
    pub imbalance: f64,
    /// The share of rays that left the scene.
    pub escape_share: f64,
}

impl Energy {
    pub(crate) fn of(task: &Task, answer: &Answer) -> Self {
        let (bands, transport) = (task.lighting.bands, &task.measurement.transport);
        let enclosure = transport.enclosure();
        let none = || vec![0.0; bands];
        let of_mirrors = |value: &dyn Fn() -> Vec<f64>| enclosure.specular().map_or(Vec::new(), |_| value());
        let mut energy = Self {
            emitted: none(),
            from_lights: task.incident_power(),
            absorbed: none(),
            escaped: none(),
            lost_on_backs: none(),
            absorbed_by_mirrors: of_mirrors(&none),
            unfollowed: of_mirrors(&|| task.unfollowed_of_lights()),
            imbalance: 0.0,
            escape_share: escape_share(transport),
        };
        // What images of lights leave out arrives too, but is not followed.
        energy.from_lights.iter_mut().zip(&energy.unfollowed).for_each(|(arrived, left_out)| *arrived += left_out);
        for side in 0..enclosure.sides() {
            let (patch, area) = (enclosure.patch_of(side), enclosure.diffuse_area(side));
            // What passes is lost where a solid stands.
            let buried = 1.0 - ratio(task.measurement.exchange.exposed_area[side], area);
            let through = task.through(side);
            let is_mirror = enclosure.diffuse_share(side) < 1.0;
            for b in 0..bands {
                let k = side * bands + b;
                let absorbed = area * task.lighting.absorptance(patch, b) * answer.irradiance[k];
                energy.emitted[b] += area * task.lighting.emission_of(patch)[b];
                energy.absorbed[b] += absorbed;
                if is_mirror {
                    energy.absorbed_by_mirrors[b] += absorbed;
                }
                energy.escaped[b] += area * answer.escaped[k];
                energy.lost_on_backs[b] += area * answer.lost[k];
                if let Some((other, transmittance)) = through {
                    energy.lost_on_backs[b] += area * buried * transmittance[b] * answer.irradiance[other * bands + b];
                }
                if let Some(unfollowed) = energy.unfollowed.get_mut(b) {
                    *unfollowed += area * answer.unfollowed[k];
                }
            }
        }
        energy.balance();
        energy
    }

    /// Works out the imbalance.
    pub(crate) fn balance(&mut self) {
        let worst = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        self.imbalance = (0..self.emitted.len()).map(|b| self.unexplained(b)).fold(0.0, worst);
    }

    fn unexplained(&self, band: usize) -> f64 {
        let input = self.emitted[band] + self.from_lights[band];
        let output = [&self.absorbed, &self.escaped, &self.lost_on_backs, &self.unfollowed];
        ratio(output.into_iter().fold(input, |left, part| left - part.get(band).unwrap_or(&0.0)), input)
    }

    /// What is not followed to its end relative to what is absorbed: the worst band.
    pub(crate) fn unfollowed_share(&self) -> f64 {
        self.unfollowed.iter().zip(&self.absorbed).map(|(lost, absorbed)| ratio(*lost, *absorbed)).fold(0.0, f64::max)
    }
}

fn escape_share(transport: &Transport) -> f64 {
    let (mut escaped, mut total) = (0u64, 0u64);
    for side in 0..transport.enclosure().sides() {
        for shots in transport.shots().of(side) {
            total += shots.len() as u64;
            escaped += shots.iter().filter(|s| s.target() == Shot::ESCAPED).count() as u64;
        }
    }
    ratio(escaped as f64, total as f64)
}
