use crate::image::{Channel, Image};

use super::tally::Outcome;

/// The camera's view as counts a pixel.
#[derive(Clone, Debug)]
pub struct HeatMap {
    size: (u32, u32),
    counts: [Vec<f32>; 6],
}

/// The channels: rays, those on which an engine's answer differs from the others', those that it answers wrong.
const CHANNELS: [&str; 6] = [
    "rays",
    "fast.differs",
    "fast.wrong",
    "robust.differs",
    "robust.wrong",
    "ours.wrong",
];

impl HeatMap {
    pub(super) fn new(size: (u32, u32)) -> Self {
        let pixels = size.0 as usize * size.1 as usize;
        Self {
            size,
            counts: [(); 6].map(|()| vec![0.0; pixels]),
        }
    }

    pub(super) fn add(&mut self, (x, y): (u32, u32), outcome: &Outcome) {
        let [fast_differs, robust_differs] = outcome.differs;
        let [fast_wrong, robust_wrong] = outcome.embree_wrong;
        let marks = [
            true,
            fast_differs,
            fast_wrong,
            robust_differs,
            robust_wrong,
            outcome.ours_wrong,
        ];
        let pixel = y as usize * self.size.0 as usize + x as usize;
        for (counts, mark) in self.counts.iter_mut().zip(marks) {
            counts[pixel] += f32::from(u8::from(mark));
        }
    }

    /// As a picture with the channels `rays`, `fast.differs`, `fast.wrong`, `robust.differs`, `robust.wrong` and
    /// `ours.wrong`.
    pub fn to_image(&self) -> Image {
        let channels = CHANNELS.iter().zip(&self.counts);
        Image {
            width: self.size.0 as usize,
            height: self.size.1 as usize,
            channels: channels
                .map(|(name, values)| Channel {
                    name: (*name).to_owned(),
                    values: values.clone(),
                })
                .collect(),
            metadata: Vec::new(),
        }
    }
}
