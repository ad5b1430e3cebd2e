/// Picks an index with probability in proportion to its weight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Discrete {
    /// Sums of the weights up to and including each index.
    cumulative: Vec<f64>,
    probabilities: Vec<f32>,
}

impl Discrete {
    /// A distribution over `weights`, finite and at least 0; where all are 0 each index is as likely.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = (weights.into_iter())
            .map(|w| {
                sum += w;
                sum
            })
            .collect();
        if sum == 0.0 {
            for (i, c) in cumulative.iter_mut().enumerate() {
                *c = (i + 1) as f64;
            }
        }
        let total = cumulative.last().copied().unwrap_or(0.0);
        let probabilities = (0..cumulative.len()).map(|i| {
            let below = if i == 0 { 0.0 } else { cumulative[i - 1] };
            ((cumulative[i] - below) / total) as f32
        });
        Self {
            probabilities: probabilities.collect(),
            cumulative,
        }
    }

    /// An index and its probability, or `None` where there are no weights. `u` in [0, 1).
    pub fn sample(&self, u: f32) -> Option<(usize, f32)> {
        let target = f64::from(u) * self.cumulative.last()?;
        let index = self.cumulative.partition_point(|&c| c <= target);
        Some((index, *self.probabilities.get(index)?))
    }

    /// The probability of an index.
    pub fn probability(&self, index: usize) -> f32 {
        self.probabilities[index]
    }
}

/// Picks an index with probability in proportion to its weight, at least 0, by `u` in [0, 1), and makes of `u` a number
/// that is as uniform within the choice. `None` where all weights are 0.
pub fn choose<const N: usize>(u: f64, weights: [f64; N]) -> Option<(usize, f64)> {
    let mut left = u * weights.iter().sum::<f64>();
    let mut chosen = None;
    for (i, weight) in weights.into_iter().enumerate().filter(|(_, w)| *w > 0.0) {
        // Rounding may leave a little beyond the last one.
        chosen = Some((i, (left / weight).min(1.0)));
        if left < weight {
            break;
        }
        left -= weight;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_come_in_proportion_to_their_weights() {
        let d = Discrete::new([1.0, 0.0, 3.0, 4.0]);
        let mut counts = [0; 4];
        for i in 0..8000 {
            counts[d.sample((i as f32 + 0.5) / 8000.0).unwrap().0] += 1;
        }
        assert_eq!(counts, [1000, 0, 3000, 4000]);
        assert_eq!(d.probability(2), 0.375);
        assert_eq!(Discrete::new([]).sample(0.5), None);
        assert_eq!(Discrete::new([0.0, 0.0]).sample(0.75), Some((1, 0.5)));
    }

    #[test]
    fn a_choice_leaves_a_number_that_is_uniform_within_it() {
        let weights = [0.0, 1.0, 0.0, 3.0, 0.0];
        for (u, index, rest) in [
            (0.0, 1, 0.0),
            (0.125, 1, 0.5),
            (0.25, 3, 0.0),
            (0.625, 3, 0.5),
        ] {
            assert_eq!(choose(u, weights), Some((index, rest)));
        }
        assert_eq!(choose(0.5, [0.0; 2]), None);
    }
}
