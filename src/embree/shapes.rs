//! What Embree calls for user shapes.

use std::ffi::c_void;

use embree4_sys as sys;
use glam::Vec3;

use crate::math::Ray;

use super::UserShape;

/// The shape that a callback is about.
///
/// # Safety
/// `list` and `index` come from Embree, for a geometry made by `add_shapes` whose scene is alive.
unsafe fn shape_of<'a>(list: *mut c_void, index: u32) -> &'a dyn UserShape {
    // SAFETY: `list` is the start of the scene's shapes, and Embree counts no further than their number.
    unsafe { (*list.cast::<Box<dyn UserShape>>().add(index as usize)).as_ref() }
}

pub(super) unsafe extern "C" fn shape_bounds(args: *const sys::RTCBoundsFunctionArguments) {
    // SAFETY: Embree passes valid arguments.
    let args = unsafe { &*args };
    // SAFETY: they are for one of our shapes.
    let shape = unsafe { shape_of(args.geometryUserPtr, args.primID) };
    let (min, max) = shape.bounds().outward_f32();
    // SAFETY: `bounds_o` is where Embree wants the answer.
    let out = unsafe { &mut *args.bounds_o };
    (out.lower_x, out.lower_y, out.lower_z) = min.into();
    (out.upper_x, out.upper_y, out.upper_z) = max.into();
}

pub(super) unsafe extern "C" fn intersect_shape(args: *const sys::RTCIntersectFunctionNArguments) {
    // SAFETY: Embree passes valid arguments.
    let args = unsafe { &*args };
    // SAFETY: they are for one of our shapes.
    let shape = unsafe { shape_of(args.geometryUserPtr, args.primID) };
    // SAFETY: all queries are of a single ray, N is 1, and then the packet is laid out as an `RTCRayHit`.
    let sys::RTCRayHit { ray, hit } = unsafe { &mut *args.rayhit.cast::<sys::RTCRayHit>() };
    if let Some(t) = shape.intersect(&from_embree(ray)) {
        ray.tfar = t as f32;
        *hit = sys::RTCHit {
            primID: args.primID,
            geomID: args.geomID,
            ..sys::RTCHit::default()
        };
    }
}

pub(super) unsafe extern "C" fn occluded_by_shape(args: *const sys::RTCOccludedFunctionNArguments) {
    // SAFETY: Embree passes valid arguments.
    let args = unsafe { &*args };
    // SAFETY: they are for one of our shapes.
    let shape = unsafe { shape_of(args.geometryUserPtr, args.primID) };
    // SAFETY: all queries are of a single ray, N is 1, and then the packet is laid out as an `RTCRay`.
    let ray = unsafe { &mut *args.ray.cast::<sys::RTCRay>() };
    if shape.intersect(&from_embree(ray)).is_some() {
        ray.tfar = f32::NEG_INFINITY;
    }
}

fn from_embree(ray: &sys::RTCRay) -> Ray {
    Ray {
        origin: Vec3::new(ray.org_x, ray.org_y, ray.org_z).as_dvec3(),
        direction: Vec3::new(ray.dir_x, ray.dir_y, ray.dir_z).as_dvec3(),
        tmin: f64::from(ray.tnear),
        tmax: f64::from(ray.tfar),
    }
}
