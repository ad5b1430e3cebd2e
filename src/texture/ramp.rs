use crate::color::Rgb;

/// Colours along a line, straight in linear light between its stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp(Vec<(f32, Rgb)>);

impl Ramp {
    /// From `a` at 0 to `b` at 1.
    pub fn between(a: Rgb, b: Rgb) -> Self {
        Self(vec![(0.0, a), (1.0, b)])
    }

    /// Through `stops`, positions with their colours; two at one position make an edge. `None` where there is none,
    /// or positions go down or are not finite.
    pub fn new(stops: Vec<(f32, Rgb)>) -> Option<Self> {
        let finite = stops.iter().all(|(t, _)| t.is_finite());
        let sorted = stops.is_sorted_by(|a, b| a.0 <= b.0);
        (finite && sorted && !stops.is_empty()).then_some(Self(stops))
    }

    /// The colour at `t`; beyond the first and last stop theirs.
    pub fn at(&self, t: f32) -> Rgb {
        let next = self.0.partition_point(|stop| stop.0 <= t);
        match (next.checked_sub(1).map(|i| self.0[i]), self.0.get(next)) {
            (Some((t0, a)), Some(&(t1, b))) => a.lerp(b, (t - t0) / (t1 - t0)),
            (Some((_, end)), None) | (None, Some(&(_, end))) => end,
            (None, None) => unreachable!("a ramp has a stop"),
        }
    }
}
