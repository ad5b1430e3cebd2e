//! Embree 4 as a peer: the same triangles, and solids as user geometry, behind the same two queries, so that
//! tests and benches can lay its answers beside ours. Embree computes in f32 and is a peer, not the truth.
//!
//! ```
//! use glam::{DVec3, Vec3};
//! use solidtrace::embree::{EmbreeOptions, EmbreeScene};
//! use solidtrace::geometry::Mesh;
//! use solidtrace::math::{Ray, Transform};
//!
//! let triangle = Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! };
//! let scene = EmbreeScene::new(&[(&triangle, &Transform::IDENTITY)], EmbreeOptions::default())?;
//! let hit = scene.intersect(&Ray::new(DVec3::new(0.25, 0.25, 2.0), DVec3::NEG_Z));
//! assert_eq!(hit.map(|hit| hit.t), Some(2.0));
//! # Ok::<(), solidtrace::Error>(())
//! ```

#![allow(unsafe_code)]

use std::ffi::{CString, c_void};
use std::ptr;

use embree4_sys::{self as sys, RTCBufferType, RTCFormat};
use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::math::{Bounds, Ray, Transform};

/// Embree leaves out primitives with a coordinate of this magnitude or more (its `FLT_LARGE`).
const LARGEST: f64 = 1.844e18;

/// How Embree builds and walks its tree.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmbreeOptions {
    /// Whether to avoid the optimisations that can miss at edges (`RTC_SCENE_FLAG_ROBUST`).
    pub robust: bool,
    /// Threads that build; 0 takes one a core. A query runs on the thread that asks.
    pub threads: usize,
}

/// A closest hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbreeHit {
    /// Ray parameter, in units of the direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner; 0 on a user shape.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner; 0 on a user shape.
    pub v: f32,
    /// Index in the list of meshes; 0 on a user shape.
    pub geometry: u32,
    /// Index of the triangle in its mesh, or of the user shape.
    pub primitive: u32,
    /// The triangle's normal, (p1 - p0) x (p2 - p0), not of unit length; 0 on a user shape.
    pub ng: Vec3,
}

/// A shape that Embree's tree holds by its bounds and asks for its hits.
pub trait UserShape: Send + Sync {
    /// A finite box around the shape.
    fn bounds(&self) -> Bounds;

    /// The least parameter of a hit between the ray's `tmin` and `tmax`.
    fn intersect(&self, ray: &Ray) -> Option<f64>;
}

/// A committed scene. Its queries may run on many threads at once.
pub struct EmbreeScene {
    scene: sys::RTCScene,
    device: Device,
    // Embree's callbacks hold the address of the elements: the list stays as it is as long as the scene.
    shapes: Vec<Box<dyn UserShape>>,
}

// SAFETY: Embree objects are not bound to a thread, the shapes are `Send`, and nothing else has the pointers.
unsafe impl Send for EmbreeScene {}
// SAFETY: a committed scene is never changed, Embree allows any number of queries on one at once, and the
// shapes that they reach are `Sync`.
unsafe impl Sync for EmbreeScene {}

/// The hit record of Embree 4.3 has a last field (`instPrimID`) that the bindings, of 4.2, lack: room for it.
#[repr(C, align(16))]
struct RayHit {
    record: sys::RTCRayHit,
    room: [u32; 4],
}

impl EmbreeScene {
    /// Triangle meshes, each with its `world_from_object`. Vertices are f32: under the identity the mesh's own to
    /// the bit, else transformed in f64 and rounded once.
    ///
    /// # Errors
    /// Names a mesh that is not valid or too large for Embree; says what Embree reports.
    pub fn new(meshes: &[(&Mesh, &Transform)], options: EmbreeOptions) -> Result<Self> {
        let scene = Self::empty(options, Vec::new())?;
        for (index, (mesh, transform)) in meshes.iter().enumerate() {
            mesh.validate()?;
            check_bounds("mesh", index, &transform.bounds(&mesh.bounds()))?;
            scene.add_mesh(mesh, transform)?;
        }
        scene.commit()
    }

    /// User shapes, all in geometry 0.
    ///
    /// # Errors
    /// Names a shape whose bounds Embree cannot hold; says what Embree reports.
    pub fn of_shapes(shapes: Vec<Box<dyn UserShape>>, options: EmbreeOptions) -> Result<Self> {
        for (index, shape) in shapes.iter().enumerate() {
            check_bounds("shape", index, &shape.bounds())?;
        }
        let scene = Self::empty(options, shapes)?;
        scene.add_shapes()?;
        scene.commit()
    }

    /// The closest hit between `tmin` and `tmax`, all of the ray rounded to f32. Whether a hit exactly at
    /// either end counts is left open by Embree.
    pub fn intersect(&self, ray: &Ray) -> Option<EmbreeHit> {
        let mut query = RayHit {
            record: sys::RTCRayHit {
                ray: to_embree(ray),
                hit: sys::RTCHit::default(),
            },
            room: [0; 4],
        };
        // SAFETY: the scene is committed and alive; the record is aligned, with room for all that Embree writes.
        // The pointer is to the whole of `query`, and Embree takes the address alone.
        unsafe { sys::rtcIntersect1(self.scene, (&raw mut query).cast(), ptr::null_mut()) };
        let sys::RTCRayHit { ray, hit } = query.record;
        (hit.geomID != sys::RTC_INVALID_GEOMETRY_ID).then_some(EmbreeHit {
            t: ray.tfar,
            u: hit.u,
            v: hit.v,
            geometry: hit.geomID,
            primitive: hit.primID,
            ng: Vec3::new(hit.Ng_x, hit.Ng_y, hit.Ng_z),
        })
    }

    /// Whether there is any hit between `tmin` and `tmax`; rounding and ends as in [`EmbreeScene::intersect`].
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut ray = to_embree(ray);
        // SAFETY: the scene is committed and alive; `RTCRay` has the alignment that Embree asks for.
        unsafe { sys::rtcOccluded1(self.scene, &raw mut ray, ptr::null_mut()) };
        ray.tfar == f32::NEG_INFINITY
    }

    fn empty(options: EmbreeOptions, shapes: Vec<Box<dyn UserShape>>) -> Result<Self> {
        let device = Device::new(options)?;
        // SAFETY: the device is alive.
        let scene = unsafe { sys::rtcNewScene(device.0) };
        if scene.is_null() {
            return Err(device.error());
        }
        if options.robust {
            // SAFETY: the scene is alive, and not committed.
            unsafe { sys::rtcSetSceneFlags(scene, sys::RTCSceneFlags::ROBUST) };
        }
        Ok(Self {
            scene,
            device,
            shapes,
        })
    }

    fn add_mesh(&self, mesh: &Mesh, transform: &Transform) -> Result<()> {
        let place = |p: &Vec3| {
            if transform.is_identity() {
                p.to_array()
            } else {
                transform.point(p.as_dvec3()).as_vec3().to_array()
            }
        };
        let vertices = mesh.positions.iter().map(place);
        let triangles = mesh.triangles.iter().copied();
        let geometry = Geometry::new(&self.device, sys::RTCGeometryType::TRIANGLE)?;
        self.fill(
            &geometry,
            RTCBufferType::VERTEX,
            RTCFormat::FLOAT3,
            vertices,
        )?;
        self.fill(&geometry, RTCBufferType::INDEX, RTCFormat::UINT3, triangles)?;
        self.attach(&geometry);
        Ok(())
    }

    /// Makes a buffer of three numbers an item and fills it.
    fn fill<T>(
        &self,
        geometry: &Geometry,
        buffer: RTCBufferType,
        format: RTCFormat,
        items: impl ExactSizeIterator<Item = [T; 3]>,
    ) -> Result<()> {
        let (stride, count) = (size_of::<[T; 3]>(), items.len());
        // SAFETY: the geometry is alive; both formats have this stride.
        let start: *mut [T; 3] =
            unsafe { sys::rtcSetNewGeometryBuffer(geometry.0, buffer, 0, format, stride, count) }
                .cast();
        if start.is_null() {
            return Err(self.device.error());
        }
        for (i, item) in items.take(count).enumerate() {
            // SAFETY: the buffer holds `count` items, aligned to 16 bytes, and nothing else has its address.
            unsafe { start.add(i).write(item) };
        }
        Ok(())
    }

    fn add_shapes(&self) -> Result<()> {
        let count = self.shapes.len();
        let count = u32::try_from(count)
            .map_err(|_| Error::input(format!("{count} shapes are too many for Embree")))?;
        let geometry = Geometry::new(&self.device, sys::RTCGeometryType::USER)?;
        let list = self.shapes.as_ptr();
        // SAFETY: the geometry is alive. The callbacks only read the list, which outlives the scene unchanged.
        unsafe {
            sys::rtcSetGeometryUserPrimitiveCount(geometry.0, count);
            sys::rtcSetGeometryUserData(geometry.0, list.cast_mut().cast());
            sys::rtcSetGeometryBoundsFunction(geometry.0, Some(shape_bounds), ptr::null_mut());
            sys::rtcSetGeometryIntersectFunction(geometry.0, Some(intersect_shape));
            sys::rtcSetGeometryOccludedFunction(geometry.0, Some(occluded_by_shape));
        }
        self.attach(&geometry);
        Ok(())
    }

    /// Hands the geometry to the scene, which gives it the next index.
    fn attach(&self, geometry: &Geometry) {
        // SAFETY: both are alive and of one device.
        unsafe {
            sys::rtcCommitGeometry(geometry.0);
            sys::rtcAttachGeometry(self.scene, geometry.0);
        }
    }

    fn commit(self) -> Result<Self> {
        // SAFETY: the scene and the device are alive, and no other thread has them yet.
        let error = unsafe {
            sys::rtcCommitScene(self.scene);
            sys::rtcGetDeviceError(self.device.0)
        };
        match error {
            sys::RTCError::NONE => Ok(self),
            error => Err(failure(error)),
        }
    }
}

impl Drop for EmbreeScene {
    fn drop(&mut self) {
        // SAFETY: the scene is alive until here, and its last query is over.
        unsafe { sys::rtcReleaseScene(self.scene) };
    }
}

/// One reference to a device.
struct Device(sys::RTCDevice);

impl Device {
    fn new(options: EmbreeOptions) -> Result<Self> {
        let config = CString::new(format!("threads={}", options.threads))
            .expect("a number holds no zero byte");
        // SAFETY: `config` is a C string that outlives the call.
        let device = Self(unsafe { sys::rtcNewDevice(config.as_ptr()) });
        if device.0.is_null() {
            return Err(device.error());
        }
        Ok(device)
    }

    /// The last failure; of device creation where there is no device.
    fn error(&self) -> Error {
        // SAFETY: the device is alive or null, and both are allowed. A CPU device gives the codes of 4.2 only.
        failure(unsafe { sys::rtcGetDeviceError(self.0) })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: it is alive, and what else belongs to it holds its own references.
            unsafe { sys::rtcReleaseDevice(self.0) };
        }
    }
}

/// One reference to a geometry; a scene that it is attached to holds another.
struct Geometry(sys::RTCGeometry);

impl Geometry {
    fn new(device: &Device, kind: sys::RTCGeometryType) -> Result<Self> {
        // SAFETY: the device is alive.
        let geometry = unsafe { sys::rtcNewGeometry(device.0, kind) };
        if geometry.is_null() {
            return Err(device.error());
        }
        Ok(Self(geometry))
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: it is alive.
        unsafe { sys::rtcReleaseGeometry(self.0) };
    }
}

fn failure(code: sys::RTCError) -> Error {
    Error::input(format!("Embree failed with the code {code:?}"))
}

fn check_bounds(what: &str, index: usize, bounds: &Bounds) -> Result<()> {
    let fits = |corner: DVec3| corner.abs().cmplt(DVec3::splat(LARGEST)).all();
    if fits(bounds.min) && fits(bounds.max) {
        return Ok(());
    }
    Err(Error::input(format!(
        "{what} {index} lies in {} to {}, and Embree takes coordinates below {LARGEST:e} only",
        bounds.min, bounds.max
    )))
}

fn to_embree(ray: &Ray) -> sys::RTCRay {
    let (origin, direction) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    sys::RTCRay {
        org_x: origin.x,
        org_y: origin.y,
        org_z: origin.z,
        dir_x: direction.x,
        dir_y: direction.y,
        dir_z: direction.z,
        tnear: ray.tmin as f32,
        tfar: ray.tmax as f32,
        ..sys::RTCRay::default()
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

/// The shape that a callback is about.
///
/// # Safety
/// `list` and `index` come from Embree, for a geometry made by `add_shapes` whose scene is alive.
unsafe fn shape_of<'a>(list: *mut c_void, index: u32) -> &'a dyn UserShape {
    // SAFETY: `list` is the start of the scene's shapes, and Embree counts no further than their number.
    unsafe { (*list.cast::<Box<dyn UserShape>>().add(index as usize)).as_ref() }
}

unsafe extern "C" fn shape_bounds(args: *const sys::RTCBoundsFunctionArguments) {
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

unsafe extern "C" fn intersect_shape(args: *const sys::RTCIntersectFunctionNArguments) {
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

unsafe extern "C" fn occluded_by_shape(args: *const sys::RTCOccludedFunctionNArguments) {
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
