//! Means of independent rounds and their standard errors.

/// Running means and sums of squared deviations of many quantities (Welford 1962).
///
/// A round is one estimate of each, independent of other rounds; what is evenly spread within a round makes it better
/// than its number of samples tells, so only rounds tell how good the mean is.
#[derive(Clone, Debug, Default)]
pub struct Means {
    mean: Vec<f64>,
    squares: Vec<f64>,
    rounds: u32,
}

impl Means {
    /// Of so many quantities.
    pub fn new(count: usize) -> Self {
        Self { mean: vec![0.0; count], squares: vec![0.0; count], rounds: 0 }
    }

    /// Adds a round.
    ///
    /// # Panics
    /// If it is not as long as the others.
    pub fn add(&mut self, round: &[f64]) {
        assert_eq!(round.len(), self.mean.len(), "one estimate of each quantity");
        self.rounds += 1;
        let n = f64::from(self.rounds);
        for ((mean, squares), value) in self.mean.iter_mut().zip(&mut self.squares).zip(round) {
            let deviation = value - *mean;
            *mean += deviation / n;
            *squares += deviation * (value - *mean);
        }
    }

    /// The means.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Squares of the standard errors of the means; NaN of less than two rounds.
    pub fn variance(&self) -> impl Iterator<Item = f64> + '_ {
        let n = f64::from(self.rounds);
        let scale = if self.rounds < 2 { f64::NAN } else { 1.0 / (n * (n - 1.0)) };
        self.squares.iter().map(move |s| s * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_their_errors() {
        let mut means = Means::new(2);
        for (a, b) in [(1.0, 5.0), (2.0, 5.0), (6.0, 5.0)] {
            means.add(&[a, b]);
        }
        assert_eq!(means.mean(), [3.0, 5.0]);
        // The squared deviations 4 + 1 + 9 over 3 * 2.
        let variance: Vec<f64> = means.variance().collect();
        assert!((variance[0] - 14.0 / 6.0).abs() < 1e-15 && variance[1] == 0.0, "{variance:?}");
        assert!(Means::new(1).variance().all(f64::is_nan));
    }
}
