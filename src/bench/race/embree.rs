use std::sync::Arc;

use crate::embree::{EmbreeOptions, EmbreePacket, EmbreeRay, EmbreeScene};
use crate::error::Result;
use crate::math::{Ray, Transform};

use super::engine::{Answers, Engine};
use crate::bench::Subject;

/// Instances of meshes that are used more than once are instances to Embree too.
pub(super) fn scene(subject: &Subject, options: EmbreeOptions) -> Result<EmbreeScene> {
    if subject.is_instanced() {
        return EmbreeScene::of_instances(&subject.meshes, &subject.instances, options);
    }
    let meshes: Vec<_> = (subject.meshes.iter())
        .map(|mesh| (mesh, &Transform::IDENTITY))
        .collect();
    EmbreeScene::new(&meshes, options)
}

/// Answers that fit into the nearest cache.
const SOME: usize = 512;

/// Embree, asked ray by ray.
pub(super) struct Embree(pub Arc<EmbreeScene>);

impl Engine for Embree {
    type Ray = EmbreeRay;

    fn load(&self, rays: &[Ray]) -> Vec<EmbreeRay> {
        rays.iter().map(EmbreeRay::new).collect()
    }

    fn closest(&self, rays: &[EmbreeRay]) -> Answers {
        let mut distances = [0.0; SOME];
        rays.chunks(SOME).fold(Answers::default(), |sum, rays| {
            let distances = &mut distances[..rays.len()];
            self.0.intersect_all(rays, distances);
            sum.plus(Answers::of_distances(distances))
        })
    }

    fn any(&self, rays: &[EmbreeRay]) -> Answers {
        let mut blocked = [false; SOME];
        rays.chunks(SOME).fold(Answers::default(), |sum, rays| {
            let blocked = &mut blocked[..rays.len()];
            self.0.occluded_all(rays, blocked);
            sum.plus(Answers::of_blocked(blocked.iter().copied()))
        })
    }
}

/// Embree, asked for sixteen rays at once that run alike.
pub(super) struct EmbreePackets(pub Arc<EmbreeScene>);

impl Engine for EmbreePackets {
    type Ray = EmbreePacket;

    fn load(&self, rays: &[Ray]) -> Vec<EmbreePacket> {
        rays.as_chunks().0.iter().map(EmbreePacket::new).collect()
    }

    fn closest(&self, packets: &[EmbreePacket]) -> Answers {
        let mut distances = [0.0; SOME];
        (packets.chunks(SOME / EmbreePacket::RAYS)).fold(Answers::default(), |sum, packets| {
            let distances = &mut distances[..packets.len() * EmbreePacket::RAYS];
            self.0.intersect_packets(packets, distances);
            sum.plus(Answers::of_distances(distances))
        })
    }

    fn any(&self, packets: &[EmbreePacket]) -> Answers {
        let mut blocked = [false; SOME];
        (packets.chunks(SOME / EmbreePacket::RAYS)).fold(Answers::default(), |sum, packets| {
            let blocked = &mut blocked[..packets.len() * EmbreePacket::RAYS];
            self.0.occluded_packets(packets, blocked);
            sum.plus(Answers::of_blocked(blocked.iter().copied()))
        })
    }
}
