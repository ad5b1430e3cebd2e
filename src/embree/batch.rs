//! Many rays at a time, each in Embree's own form: what is left to do in the loop is Embree's work.

use std::array;
use std::ptr;

use embree4_sys as sys;

use super::{EmbreeScene, RayHit, to_embree};
use crate::math::Ray;

/// A ray as Embree reads it.
pub struct EmbreeRay(sys::RTCRay);

impl EmbreeRay {
    /// `ray` rounded to f32.
    pub fn new(ray: &Ray) -> Self {
        Self(to_embree(ray))
    }
}

/// Sixteen rays as Embree reads them.
pub struct EmbreePacket(sys::RTCRay16);

impl EmbreePacket {
    /// Rays in a packet.
    pub const RAYS: usize = 16;

    /// `rays` rounded to f32.
    pub fn new(rays: &[Ray; Self::RAYS]) -> Self {
        let rays = rays.each_ref().map(to_embree);
        let all = |of: fn(&sys::RTCRay) -> f32| array::from_fn(|i| of(&rays[i]));
        Self(sys::RTCRay16 {
            org_x: all(|ray| ray.org_x),
            org_y: all(|ray| ray.org_y),
            org_z: all(|ray| ray.org_z),
            dir_x: all(|ray| ray.dir_x),
            dir_y: all(|ray| ray.dir_y),
            dir_z: all(|ray| ray.dir_z),
            tnear: all(|ray| ray.tnear),
            tfar: all(|ray| ray.tfar),
            ..sys::RTCRay16::default()
        })
    }
}

/// Embree 4.3 writes one field more than the bindings know, as in [`RayHit`].
#[repr(C, align(64))]
struct PacketHit {
    record: sys::RTCRayHit16,
    room: [u32; EmbreePacket::RAYS],
}

impl EmbreeScene {
    /// The distance to the closest hit of each ray, infinite where there is none, into `distances` of the same
    /// length. Numbers too small for f32's normal range count as 0, as Embree asks for.
    pub fn intersect_all(&self, rays: &[EmbreeRay], distances: &mut [f32]) {
        assert_eq!(rays.len(), distances.len());
        let mut query = RayHit::new(sys::RTCRay::default());
        let _small = SmallAsZero::set();
        for (ray, distance) in rays.iter().zip(distances) {
            query.record.ray = ray.0;
            query.record.hit.geomID = sys::RTC_INVALID_GEOMETRY_ID;
            // SAFETY: as in `EmbreeScene::intersect`.
            unsafe {
                sys::rtcIntersect1(self.scene.0, (&raw mut query).cast(), ptr::null_mut());
            }
            *distance = if query.record.hit.geomID == sys::RTC_INVALID_GEOMETRY_ID {
                f32::INFINITY
            } else {
                query.record.ray.tfar
            };
        }
    }

    /// Whether each ray is blocked, into `blocked` of the same length; small numbers as in
    /// [`EmbreeScene::intersect_all`].
    pub fn occluded_all(&self, rays: &[EmbreeRay], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len());
        let _small = SmallAsZero::set();
        for (ray, blocked) in rays.iter().zip(blocked) {
            let mut query = ray.0;
            // SAFETY: as in `EmbreeScene::occluded`.
            unsafe { sys::rtcOccluded1(self.scene.0, &raw mut query, ptr::null_mut()) };
            *blocked = query.tfar == f32::NEG_INFINITY;
        }
    }

    /// [`EmbreeScene::intersect_all`] for packets of rays that run alike, in a scene of meshes; sixteen distances a
    /// packet.
    pub fn intersect_packets(&self, packets: &[EmbreePacket], distances: &mut [f32]) {
        // The callbacks of user shapes take single rays alone.
        assert!(self.shapes.is_empty());
        assert_eq!(EmbreePacket::RAYS * packets.len(), distances.len());
        let mut query = PacketHit {
            record: sys::RTCRayHit16 {
                ray: sys::RTCRay16::default(),
                hit: sys::RTCHit16::default(),
            },
            room: [0; EmbreePacket::RAYS],
        };
        let mut arguments = sys::RTCIntersectArguments {
            flags: sys::RTCRayQueryFlags::COHERENT,
            feature_mask: sys::RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: ptr::null_mut(),
            filter: None,
            intersect: None,
        };
        let valid = Valid::ALL;
        let _small = SmallAsZero::set();
        for (packet, distances) in
            (packets.iter()).zip(distances.chunks_exact_mut(EmbreePacket::RAYS))
        {
            query.record.ray = packet.0;
            query.record.hit.geomID = [sys::RTC_INVALID_GEOMETRY_ID; EmbreePacket::RAYS];
            // SAFETY: as in `EmbreeScene::intersect`; the mask and the arguments outlive the call.
            unsafe {
                sys::rtcIntersect16(
                    valid.0.as_ptr(),
                    self.scene.0,
                    (&raw mut query).cast(),
                    &raw mut arguments,
                );
            }
            for (i, distance) in distances.iter_mut().enumerate() {
                *distance = if query.record.hit.geomID[i] == sys::RTC_INVALID_GEOMETRY_ID {
                    f32::INFINITY
                } else {
                    query.record.ray.tfar[i]
                };
            }
        }
    }

    /// [`EmbreeScene::occluded_all`] for packets, in a scene of meshes; sixteen answers a packet. Embree is told that
    /// the rays differ, with which it is about twice as fast on shadow rays.
    pub fn occluded_packets(&self, packets: &[EmbreePacket], blocked: &mut [bool]) {
        // The callbacks of user shapes take single rays alone.
        assert!(self.shapes.is_empty());
        assert_eq!(EmbreePacket::RAYS * packets.len(), blocked.len());
        let mut arguments = sys::RTCOccludedArguments {
            flags: sys::RTCRayQueryFlags::INCOHERENT,
            feature_mask: sys::RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
            context: ptr::null_mut(),
            filter: None,
            occluded: None,
        };
        let valid = Valid::ALL;
        let _small = SmallAsZero::set();
        for (packet, blocked) in (packets.iter()).zip(blocked.chunks_exact_mut(EmbreePacket::RAYS))
        {
            let mut query = packet.0;
            // SAFETY: `RTCRay16` has the alignment that Embree asks for; the mask and the arguments outlive the call.
            unsafe {
                sys::rtcOccluded16(
                    valid.0.as_ptr(),
                    self.scene.0,
                    &raw mut query,
                    &raw mut arguments,
                );
            }
            for (tfar, blocked) in query.tfar.iter().zip(blocked) {
                *blocked = *tfar == f32::NEG_INFINITY;
            }
        }
    }
}

/// Which rays of a packet are asked for; Embree wants it aligned as the packet is.
#[repr(align(64))]
struct Valid([i32; EmbreePacket::RAYS]);

impl Valid {
    const ALL: Self = Self([-1; EmbreePacket::RAYS]);
}

/// While this lives, the thread's SSE unit takes numbers below f32's normal range for 0, in and out (FTZ and DAZ):
/// what Embree's manual asks for. The loops above compute nothing themselves.
struct SmallAsZero {
    #[cfg(target_arch = "x86_64")]
    before: u32,
}

impl SmallAsZero {
    #[cfg(target_arch = "x86_64")]
    fn set() -> Self {
        let mut before = 0_u32;
        // SAFETY: it writes four bytes to `before`.
        unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut before, options(nostack)) };
        Self::load(before | 0x8040);
        Self { before }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn set() -> Self {
        Self {}
    }

    #[cfg(target_arch = "x86_64")]
    fn load(state: u32) {
        // SAFETY: it reads four bytes of `state`, which differs from a valid one in FTZ and DAZ at most.
        unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const state, options(nostack)) };
    }
}

#[cfg(target_arch = "x86_64")]
impl Drop for SmallAsZero {
    fn drop(&mut self) {
        Self::load(self.before);
    }
}
