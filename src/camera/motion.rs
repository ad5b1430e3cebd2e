use glam::DVec3;

/// Where a camera is at some frames; it goes from one to the next, and stands still before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// In ascending order of their frames, no two at one.
    pub keys: Vec<Key>,
    /// How it goes from one to the next.
    pub interpolation: Interpolation,
}

/// Where a camera is at one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Number of the frame.
    pub frame: f64,
    /// As [`super::Camera::eye`].
    pub eye: DVec3,
    /// As [`super::Camera::look_at`].
    pub look_at: DVec3,
    /// As [`super::Camera::up`].
    pub up: DVec3,
    /// As [`super::Projection::field`]; of no effect where that cannot be chosen.
    pub field: f64,
}

/// How a camera goes from key to key. All keys are met exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight on, at a constant speed.
    Linear,
    /// Without a jerk at a key. Points follow Catmull and Rom's spline with the frames as knots (Barry and Goldman 1988),
    /// which is exact on parabolas; the field of view Fritsch and Butland's monotone one (1984), so that it never leaves
    /// the range of its keys.
    Smooth,
}

impl Motion {
    /// What a key at `frame` would say; nothing if there are no keys.
    pub fn at(&self, frame: f64) -> Option<Key> {
        let (first, last) = (self.keys.first()?, self.keys.last()?);
        if frame <= first.frame {
            return Some(*first);
        }
        if frame >= last.frame {
            return Some(*last);
        }
        Some(Key {
            frame,
            eye: self.point(frame, |key| key.eye),
            look_at: self.point(frame, |key| key.look_at),
            up: self.point(frame, |key| key.up),
            field: self.number(frame, |key| key.field, monotone),
        })
    }

    fn point(&self, frame: f64, value: impl Fn(&Key) -> DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|i| self.number(frame, |key| value(key)[i], catmull_rom)))
    }

    /// Hermite's cubic between the keys around `frame`, which is not beyond all of them.
    fn number(&self, frame: f64, value: impl Fn(&Key) -> f64, slope: Slope) -> f64 {
        let keys = &self.keys;
        let length = |i: usize| keys[i + 1].frame - keys[i].frame;
        let secant = |i: usize| (value(&keys[i + 1]) - value(&keys[i])) / length(i);
        let at = keys.partition_point(|key| key.frame <= frame) - 1;
        let straight = secant(at);
        let slope = |i: usize| match self.interpolation {
            Interpolation::Linear => straight,
            Interpolation::Smooth if i == 0 => secant(0),
            Interpolation::Smooth if i == keys.len() - 1 => secant(i - 1),
            Interpolation::Smooth => slope([secant(i - 1), secant(i)], [length(i - 1), length(i)]),
        };
        let (start, end) = (slope(at), slope(at + 1));
        let u = (frame - keys[at].frame) / length(at);
        let bend = 3.0 * straight - 2.0 * start - end + u * (start + end - 2.0 * straight);
        value(&keys[at]) + length(at) * u * (start + u * bend)
    }
}

/// The slope at a key, given those of the straight lines to its neighbours and how far these are.
type Slope = fn([f64; 2], [f64; 2]) -> f64;

fn catmull_rom([before, after]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
    (before * to + after * from) / (from + to)
}

fn monotone([before, after]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
    if before * after <= 0.0 {
        return 0.0;
    }
    let (before_share, after_share) = (from + 2.0 * to, 2.0 * from + to);
    (before_share + after_share) / (before_share / before + after_share / after)
}
