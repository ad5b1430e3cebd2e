use std::ffi::{CString, c_void};
use std::ptr;
use std::sync::atomic::{AtomicIsize, Ordering};

use embree4_sys as sys;

use crate::error::{Error, Result};

use super::EmbreeOptions;

/// One reference to a device, which counts the memory that Embree takes for it.
pub(super) struct Device {
    pub handle: sys::RTCDevice,
    // Embree holds its address.
    bytes: Box<AtomicIsize>,
}

impl Device {
    pub(super) fn new(options: EmbreeOptions) -> Result<Self> {
        let isa = if options.avx2 { ",isa=avx2" } else { "" };
        let config = CString::new(format!("threads={}{isa}", options.threads))
            .expect("neither a number nor a name holds a zero byte");
        let device = Self {
            // SAFETY: `config` is a C string that outlives the call.
            handle: unsafe { sys::rtcNewDevice(config.as_ptr()) },
            bytes: Box::default(),
        };
        if device.handle.is_null() {
            return Err(device.error());
        }
        let counter = ptr::from_ref(&*device.bytes).cast_mut().cast();
        // SAFETY: the device is alive, and released before the counter is.
        unsafe { sys::rtcSetDeviceMemoryMonitorFunction(device.handle, Some(count), counter) };
        Ok(device)
    }

    /// Bytes in use.
    pub(super) fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed).max(0) as usize
    }

    /// The last failure; of device creation where there is no device.
    pub(super) fn error(&self) -> Error {
        failure(self.last())
    }

    /// The code of the last failure, which this forgets.
    pub(super) fn last(&self) -> sys::RTCError {
        // SAFETY: the device is alive or null, and both are allowed. A CPU device gives the codes of 4.2 only.
        unsafe { sys::rtcGetDeviceError(self.handle) }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: it is alive, and what else belongs to it has been released.
            unsafe { sys::rtcReleaseDevice(self.handle) };
        }
    }
}

/// One reference to a scene; a geometry that places it holds another.
pub(super) struct SceneHandle(pub sys::RTCScene);

impl SceneHandle {
    pub(super) fn new(device: &Device, options: EmbreeOptions) -> Result<Self> {
        // SAFETY: the device is alive.
        let scene = Self(unsafe { sys::rtcNewScene(device.handle) });
        if scene.0.is_null() {
            return Err(device.error());
        }
        if options.robust {
            // SAFETY: the scene is alive, and not committed.
            unsafe { sys::rtcSetSceneFlags(scene.0, sys::RTCSceneFlags::ROBUST) };
        }
        if options.high_quality {
            // SAFETY: as above.
            unsafe { sys::rtcSetSceneBuildQuality(scene.0, sys::RTCBuildQuality::HIGH) };
        }
        Ok(scene)
    }

    /// Hands the geometry to the scene, which gives it the next index.
    pub(super) fn attach(&self, geometry: &Geometry) {
        // SAFETY: both are alive and of one device.
        unsafe {
            sys::rtcCommitGeometry(geometry.0);
            sys::rtcAttachGeometry(self.0, geometry.0);
        }
    }

    /// Builds the tree.
    pub(super) fn commit(&self) {
        // SAFETY: the scene is alive, and no other thread has it yet.
        unsafe { sys::rtcCommitScene(self.0) };
    }
}

impl Drop for SceneHandle {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: the scene is alive until here, and its last query is over.
            unsafe { sys::rtcReleaseScene(self.0) };
        }
    }
}

/// One reference to a geometry; a scene that it is attached to holds another.
pub(super) struct Geometry(pub sys::RTCGeometry);

impl Geometry {
    pub(super) fn new(device: &Device, kind: sys::RTCGeometryType) -> Result<Self> {
        // SAFETY: the device is alive.
        let geometry = unsafe { sys::rtcNewGeometry(device.handle, kind) };
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

pub(super) fn failure(code: sys::RTCError) -> Error {
    Error::input(format!("Embree failed with the code {code:?}"))
}

/// Embree calls this before it allocates and after it frees; false would forbid it.
unsafe extern "C" fn count(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `counter` is the device's own, which outlives it.
    let counter = unsafe { &*counter.cast::<AtomicIsize>() };
    counter.fetch_add(bytes, Ordering::Relaxed);
    true
}
