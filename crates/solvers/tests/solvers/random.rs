//! Random exchanges with light on them, and their direct solution.

use radiosity_operator::Dense;
use radiosity_solvers::Problem;

/// A number in [0, 1).
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Elements that exchange at random.
pub struct Room {
    pub exchange: Dense,
    pub area: Vec<f64>,
    pub reflectance: Vec<f64>,
    pub emission: Vec<f64>,
    pub incident: Vec<f64>,
    pub bands: usize,
}

impl Room {
    /// Rows sum to `closure` of the area; reflectances are below `highest`.
    pub fn new(n: usize, bands: usize, closure: f64, highest: f64, state: &mut u64) -> Self {
        let mut g = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..i {
                let v = random(state);
                g[i * n + j] = v;
                g[j * n + i] = v;
            }
        }
        let area = (0..n).map(|i| g[i * n..(i + 1) * n].iter().sum::<f64>() / closure).collect();
        let mut block = |scale: f64| (0..n * bands).map(|_| scale * random(state)).collect::<Vec<_>>();
        let (reflectance, emission, incident) = (block(highest), block(10.0), block(1.0));
        Self { exchange: Dense::new(n, g), area, reflectance, emission, incident, bands }
    }

    pub fn problem(&self) -> Problem<'_> {
        Problem {
            exchange: &self.exchange,
            area: &self.area,
            reflectance: &self.reflectance,
            emission: &self.emission,
            incident: &self.incident,
            bands: self.bands,
        }
    }

    /// The radiosity by Gaussian elimination of `A B - rho G B = A (E + rho H0)`.
    pub fn eliminated(&self) -> Vec<f64> {
        let mut radiosity = vec![0.0; self.emission.len()];
        for band in 0..self.bands {
            for (i, b) in self.eliminated_band(band).into_iter().enumerate() {
                radiosity[i * self.bands + band] = b;
            }
        }
        radiosity
    }

    fn eliminated_band(&self, band: usize) -> Vec<f64> {
        let n = self.area.len();
        let at = |x: &[f64], i: usize| x[i * self.bands + band];
        let row = |i: usize| -> Vec<f64> {
            let (area, rho, g) = (self.area[i], at(&self.reflectance, i), self.exchange.row(i));
            let known = area * (at(&self.emission, i) + rho * at(&self.incident, i));
            (0..n).map(|j| if i == j { area } else { 0.0 } - rho * g[j]).chain([known]).collect()
        };
        let mut m: Vec<Vec<f64>> = (0..n).map(row).collect();
        for p in 0..n {
            let pivot = m[p].clone();
            for (_, row) in m.iter_mut().enumerate().filter(|(i, _)| *i != p) {
                let f = row[p] / pivot[p];
                row.iter_mut().zip(&pivot).for_each(|(x, v)| *x -= f * v);
            }
        }
        (0..n).map(|i| m[i][n] / m[i][i]).collect()
    }
}
