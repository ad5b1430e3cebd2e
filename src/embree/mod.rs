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

mod batch;
mod device;
mod shapes;

use std::ptr;
use std::time::{Duration, Instant};

use embree4_sys::{self as sys, RTCBufferType, RTCFormat};
use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::math::{Bounds, Ray, Transform};

pub use batch::{EmbreePacket, EmbreeRay};
use device::{Device, Geometry, SceneHandle, failure};
use shapes::{intersect_shape, occluded_by_shape, shape_bounds};

/// Embree leaves out primitives with a coordinate of this magnitude or more (its `FLT_LARGE`).
const LARGEST: f64 = 1.844e18;

/// How Embree builds and walks its tree.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmbreeOptions {
    /// Whether to avoid the optimisations that can miss at edges (`RTC_SCENE_FLAG_ROBUST`).
    pub robust: bool,
    /// Whether the build takes its time, and splits triangles (`RTC_BUILD_QUALITY_HIGH`).
    pub high_quality: bool,
    /// Threads that build; 0 takes one a core. A query runs on the thread that asks.
    pub threads: usize,
    /// Whether to use nothing beyond AVX2; else Embree takes what it finds best on the processor.
    pub avx2: bool,
}

/// What building a scene's trees took, apart from the vertices and indices that they were built from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmbreeReport {
    /// Time spent in `rtcCommitScene`.
    pub time: Duration,
    /// Bytes that stay in use.
    pub bytes: usize,
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
    /// Index in the list of meshes or instances; 0 on a user shape.
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
    // Fields are dropped in order: what belongs to the device goes before it.
    scene: SceneHandle,
    device: Device,
    report: EmbreeReport,
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

impl RayHit {
    fn new(ray: sys::RTCRay) -> Self {
        Self {
            record: sys::RTCRayHit {
                ray,
                hit: sys::RTCHit::default(),
            },
            room: [0; 4],
        }
    }
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
            scene.scene.attach(&scene.mesh(mesh, transform)?);
        }
        scene.commit()
    }

    /// Triangle meshes with a tree each, and a tree over instances: index of a mesh and `world_from_object`, which
    /// Embree keeps in f32.
    ///
    /// # Errors
    /// As [`EmbreeScene::new`].
    pub fn of_instances(
        meshes: &[Mesh],
        instances: &[(usize, Transform)],
        options: EmbreeOptions,
    ) -> Result<Self> {
        let mut scene = Self::empty(options, Vec::new())?;
        let mut below = Vec::with_capacity(meshes.len());
        for (index, mesh) in meshes.iter().enumerate() {
            mesh.validate()?;
            check_bounds("mesh", index, &mesh.bounds())?;
            let own = SceneHandle::new(&scene.device, options)?;
            own.attach(&scene.mesh(mesh, &Transform::IDENTITY)?);
            scene.report.add(&own, &scene.device);
            below.push(own);
        }
        for (index, (mesh, transform)) in instances.iter().enumerate() {
            let bounds = transform.bounds(&meshes[*mesh].bounds());
            check_bounds("instance", index, &bounds)?;
            scene.add_instance(&below[*mesh], transform)?;
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

    /// What building it took.
    pub fn report(&self) -> EmbreeReport {
        self.report
    }

    /// The closest hit between `tmin` and `tmax`, all of the ray rounded to f32. Whether a hit exactly at
    /// either end counts is left open by Embree.
    pub fn intersect(&self, ray: &Ray) -> Option<EmbreeHit> {
        let mut query = RayHit::new(to_embree(ray));
        // SAFETY: the scene is committed and alive; the record is aligned, with room for all that Embree writes.
        // The pointer is to the whole of `query`, and Embree takes the address alone.
        unsafe { sys::rtcIntersect1(self.scene.0, (&raw mut query).cast(), ptr::null_mut()) };
        let sys::RTCRayHit { ray, hit } = query.record;
        let instance = hit.instID[0];
        (hit.geomID != sys::RTC_INVALID_GEOMETRY_ID).then_some(EmbreeHit {
            t: ray.tfar,
            u: hit.u,
            v: hit.v,
            geometry: if instance == sys::RTC_INVALID_GEOMETRY_ID {
                hit.geomID
            } else {
                instance
            },
            primitive: hit.primID,
            ng: Vec3::new(hit.Ng_x, hit.Ng_y, hit.Ng_z),
        })
    }

    /// Whether there is any hit between `tmin` and `tmax`; rounding and ends as in [`EmbreeScene::intersect`].
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut ray = to_embree(ray);
        // SAFETY: the scene is committed and alive; `RTCRay` has the alignment that Embree asks for.
        unsafe { sys::rtcOccluded1(self.scene.0, &raw mut ray, ptr::null_mut()) };
        ray.tfar == f32::NEG_INFINITY
    }

    fn empty(options: EmbreeOptions, shapes: Vec<Box<dyn UserShape>>) -> Result<Self> {
        let device = Device::new(options)?;
        Ok(Self {
            scene: SceneHandle::new(&device, options)?,
            device,
            report: EmbreeReport::default(),
            shapes,
        })
    }

    fn mesh(&self, mesh: &Mesh, transform: &Transform) -> Result<Geometry> {
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
        Ok(geometry)
    }

    fn add_instance(&self, scene: &SceneHandle, transform: &Transform) -> Result<()> {
        let geometry = Geometry::new(&self.device, sys::RTCGeometryType::INSTANCE)?;
        let columns = transform.matrix().to_cols_array().map(|x| x as f32);
        // SAFETY: both are alive and of one device; Embree copies twelve numbers, three a column.
        unsafe {
            sys::rtcSetGeometryInstancedScene(geometry.0, scene.0);
            let format = RTCFormat::FLOAT3X4_COLUMN_MAJOR;
            sys::rtcSetGeometryTransform(geometry.0, 0, format, columns.as_ptr().cast());
        }
        self.scene.attach(&geometry);
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
        self.scene.attach(&geometry);
        Ok(())
    }

    fn commit(mut self) -> Result<Self> {
        self.report.add(&self.scene, &self.device);
        match self.device.last() {
            sys::RTCError::NONE => Ok(self),
            error => Err(failure(error)),
        }
    }
}

impl EmbreeReport {
    /// Builds the tree of `scene` and adds what it took.
    fn add(&mut self, scene: &SceneHandle, device: &Device) {
        let (start, before) = (Instant::now(), device.bytes());
        scene.commit();
        self.time += start.elapsed();
        self.bytes += device.bytes().saturating_sub(before);
    }
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
