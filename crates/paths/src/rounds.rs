//! How many rounds: as many as said, or until the mean is as good as wanted.

use radiosity_operator::{Cancelled, Control};

/// What may be spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Samples of each quantity in a round, which together fill the space of paths evenly; best a power of two.
    pub per_round: u32,
    /// Rounds at least; two tell an error, few of them badly.
    pub least: u32,
    /// Rounds at most.
    pub most: u32,
    /// The relative standard error to end at, if any.
    pub accuracy: Option<f64>,
}

impl Effort {
    /// So many samples in one round: no error is known, and it is smaller than that of many.
    pub fn at_once(samples: u32) -> Self {
        Self { per_round: samples, least: 1, most: 1, accuracy: None }
    }

    /// About so many samples, at least as many, in eight rounds or more, of a power of two up to 64 each.
    pub fn of_samples(samples: u32) -> Self {
        let per_round = (samples / 8).clamp(1, 64);
        let per_round = 1 << per_round.ilog2();
        let rounds = samples.div_ceil(per_round).max(2);
        Self { per_round, least: rounds, most: rounds, accuracy: None }
    }

    /// As many samples as it takes, at most so many.
    pub fn of_accuracy(accuracy: f64, most: u32) -> Self {
        let per_round = Self::of_samples(most).per_round.min(16);
        let most = most.div_ceil(per_round).max(2);
        Self { per_round, least: most.min(8), most, accuracy: Some(accuracy) }
    }
}

/// How it went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounds {
    /// Rounds done.
    pub rounds: u32,
    /// Samples of each quantity.
    pub samples: u32,
    /// The relative standard error; NaN after one round.
    pub error: f64,
}

/// Does round after round, each of `steps` steps of `control`, until the error that `round` returns is as wanted or the
/// most are done.
///
/// # Errors
/// What `round` returns.
pub fn rounds(
    effort: &Effort,
    steps: u64,
    control: &Control,
    mut round: impl FnMut(u32) -> Result<f64, Cancelled>,
) -> Result<Rounds, Cancelled> {
    let (mut done, mut expected, mut error) = (0, effort.least.max(1), f64::NAN);
    control.expect(steps * u64::from(expected));
    while done < expected {
        error = round(done)?;
        done += 1;
        if let Some(wanted) = effort.accuracy.filter(|_| done >= effort.least) {
            if error <= wanted {
                break;
            }
            // The error falls with the root of the rounds.
            let needed = f64::from(done) * (error / wanted).powi(2);
            let next = if needed.is_finite() { needed.ceil().min(f64::from(effort.most)) as u32 } else { effort.most };
            let next = next.clamp(done, effort.most).max((done + 1).min(effort.most));
            if next > expected {
                control.expect(steps * u64::from(next - expected));
                expected = next;
            } else if done == expected && done < effort.most {
                control.expect(steps);
                expected += 1;
            }
        }
    }
    Ok(Rounds { rounds: done, samples: done * effort.per_round, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spend(effort: Effort, error_after: impl Fn(u32) -> f64) -> (Rounds, (u64, u64)) {
        let control = Control::default();
        let spent = rounds(&effort, 3, &control, |round| {
            control.advance(3);
            Ok(error_after(round + 1))
        });
        (spent.unwrap(), control.progress())
    }

    #[test]
    fn rounds_end_when_the_error_is_as_wanted() {
        let root = |n: u32| 0.3 / f64::from(n).sqrt();
        let (rounds, (done, total)) = spend(Effort::of_accuracy(0.05, 1 << 20), root);
        assert_eq!((rounds.rounds, rounds.samples, done), (36, 36 * 16, 36 * 3));
        assert!(total >= done);
        let (rounds, progress) = spend(Effort::of_accuracy(0.05, 160), root);
        assert_eq!((rounds.rounds, progress), (10, (30, 30)));
        assert!(rounds.error > 0.05);
        assert_eq!(spend(Effort::of_accuracy(0.05, 160), |_| f64::NAN).0.rounds, 10);
    }

    #[test]
    fn samples_come_in_eight_rounds_or_more() {
        for samples in [1, 2, 8, 16, 100, 512, 1000, 5000] {
            let effort = Effort::of_samples(samples);
            assert!(effort.per_round * effort.most >= samples && effort.per_round * effort.most < samples + 64);
            assert_eq!(effort.most >= 8, samples >= 8, "{samples}");
            assert_eq!(spend(effort, |_| 1.0).0.rounds, effort.most);
        }
    }
}
