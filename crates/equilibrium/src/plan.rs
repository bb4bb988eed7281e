//! Where to spend the next samples.

/// How fast the variance of a scrambled-net estimate falls with the number of samples: between 1 (Monte Carlo) and
/// 3 (smooth integrands, Owen 1997); edges of shadows keep it nearer to 1.
pub(crate) const RATE: f64 = 1.5;

/// Plan for somewhat less error than asked: the plan is an extrapolation, and to miss costs a round.
const AIM: f64 = 0.88;

/// Samples of one kind: what they cost nothing to know.
pub(crate) struct Kind<'a> {
    /// Samples per replicate so far, per side.
    pub drawn: Vec<u32>,
    /// Variance of the mean they leave, per side.
    pub variance: &'a [f64],
    /// Fewest and most per replicate.
    pub range: (u32, u32),
}

/// Chooses samples per side and kind so that the area-weighted mean variance meets `target` at least cost.
///
/// With variance `v (n0/n)^RATE` the cost is least where each side's marginal gain is equal: `n` proportional to
/// `(a v n0^RATE)^(1 / (1 + RATE))`. Counts are powers of two, where the sequences are most even. Sides of one `group`
/// that follow each other are neighbours.
pub(crate) fn plan(kinds: &[Kind], area_share: &[f64], group: &[u32], target: f64, growth: u32) -> Vec<Vec<u32>> {
    let target = target * AIM * AIM;
    let smoothed: Vec<Vec<f64>> = kinds.iter().map(|k| smooth(k.variance, area_share, group)).collect();
    let base: Vec<Vec<f64>> = kinds
        .iter()
        .zip(&smoothed)
        .map(|(kind, variance)| {
            let demand = |(side, v): (usize, &f64)| {
                (area_share[side] * v * f64::from(kind.drawn[side]).powf(RATE)).powf(1.0 / (1.0 + RATE))
            };
            variance.iter().enumerate().map(demand).collect()
        })
        .collect();
    let count = |kind: &Kind, side: usize, wanted: f64| {
        let drawn = kind.drawn[side];
        let most = kind.range.1.min(drawn.saturating_mul(growth));
        let n = (wanted.clamp(1.0, f64::from(1u32 << 30)) as u32).next_power_of_two();
        n.max(drawn).max(kind.range.0).min(most.max(drawn))
    };
    let left = |factor: f64| -> f64 {
        let mut sum = 0.0;
        for ((kind, base), variance) in kinds.iter().zip(&base).zip(&smoothed) {
            for side in 0..variance.len() {
                let drawn = f64::from(kind.drawn[side]);
                if drawn > 0.0 {
                    let n = f64::from(count(kind, side, factor * base[side]));
                    sum += area_share[side] * variance[side] * (drawn / n).powf(RATE);
                }
            }
        }
        sum
    };
    // `left` falls with the factor: bisect on its logarithm.
    let (mut low, mut high) = (-20.0f64, 60.0f64);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if left(middle.exp2()) > target { low = middle } else { high = middle }
    }
    let factor = high.exp2();
    kinds
        .iter()
        .zip(&base)
        .map(|(kind, base)| (0..base.len()).map(|side| count(kind, side, factor * base[side])).collect())
        .collect()
}

/// Sides on either hand whose variances are averaged, and how many sides' worth the mean of all counts.
const NEIGHBOURS: usize = 8;
const PRIOR: f64 = 2.0;

/// Averages each side's variance with its neighbours' of the same group, and a little with everybody's.
///
/// A side's own few replicates know its variance badly, and what is worse, err together with its mean: to sample more
/// where a side looks noisy by itself corrects those that came out too bright and leaves those too dark, which biases
/// the whole (Kirk and Arvo 1991, *Unbiased sampling techniques for image synthesis*). Neighbours' samples are
/// independent.
fn smooth(variance: &[f64], area_share: &[f64], group: &[u32]) -> Vec<f64> {
    let mean: f64 = variance.iter().zip(area_share).map(|(v, a)| v * a).sum();
    let mut sums = Vec::with_capacity(variance.len() + 1);
    sums.push(0.0);
    for v in variance {
        sums.push(sums[sums.len() - 1] + v);
    }
    let mut smoothed = Vec::with_capacity(variance.len());
    for run in group.chunk_by(|a, b| a == b) {
        let (first, end) = (smoothed.len(), smoothed.len() + run.len());
        for side in first..end {
            let (low, high) = (side.saturating_sub(NEIGHBOURS).max(first), (side + NEIGHBOURS + 1).min(end));
            smoothed.push((sums[high] - sums[low] + PRIOR * mean) / ((high - low) as f64 + PRIOR));
        }
    }
    smoothed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_go_where_the_variance_is() {
        let variance: Vec<f64> = (0..100).map(|i| if (40..60).contains(&i) { 100.0 } else { 1.0 }).collect();
        let kind = Kind { drawn: vec![16; 100], variance: &variance, range: (1, 1 << 16) };
        let counts = plan(&[kind], &[0.01; 100], &[0; 100], 1.0, 64).remove(0);
        assert!(counts[50] > counts[0] && counts[0] == counts[99] && counts[0] >= 16, "{counts:?}");
    }

    #[test]
    fn neighbours_are_of_one_group() {
        let variance = [1.0, 1.0, 9.0, 9.0];
        let apart = smooth(&variance, &[0.25; 4], &[0, 0, 1, 1]);
        assert!(apart[1] < apart[2] && apart[0] == apart[1] && apart[2] == apart[3], "{apart:?}");
        let together = smooth(&variance, &[0.25; 4], &[0; 4]);
        assert_eq!(together, vec![5.0; 4]);
    }

    #[test]
    fn a_met_target_asks_for_nothing_more() {
        let variance = vec![1.0; 3];
        let kind = Kind { drawn: vec![8; 3], variance: &variance, range: (1, 1 << 16) };
        assert_eq!(plan(&[kind], &[1.0 / 3.0; 3], &[0; 3], 2.0, 16), vec![vec![8; 3]]);
    }

    #[test]
    fn growth_and_range_bound_the_plan() {
        let variance = vec![1.0];
        let plan = |drawn, range, growth| {
            plan(&[Kind { drawn: vec![drawn], variance: &variance, range }], &[1.0], &[0], 1e-12, growth)[0][0]
        };
        assert_eq!(plan(16, (1, 1 << 16), 8), 128);
        assert_eq!(plan(16, (1, 64), 8), 64);
    }
}
