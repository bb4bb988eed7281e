//! Embree through the driver that `run.sh` compiles from `embree.cpp`.

use crate::scenes::Triangle;
use crate::{BATCH, Batch, Engine};
use radiosity_geometry::bvh::Ray;
use std::ffi::{c_int, c_uint, c_void};

#[link(name = "embree_driver")]
unsafe extern "C" {
    fn embree_build(triangles: *const f32, count: usize, robust: c_int, threads: c_uint) -> *mut c_void;
    fn embree_release(scene: *mut c_void);
    fn embree_closest(scene: *const c_void, rays: *const PeerRay, count: usize, t: *mut f32);
    fn embree_occluded(scene: *const c_void, rays: *const PeerRay, count: usize, occluded: *mut bool);
}

/// A ray in the order of fields that the driver reads.
#[repr(C)]
pub struct PeerRay([f32; 8]);

impl PeerRay {
    /// Copies the fields.
    pub fn new(ray: &Ray) -> Self {
        let ([x, y, z], [u, v, w]) = (ray.origin.to_array(), ray.direction.to_array());
        Self([x, y, z, u, v, w, ray.t_min, ray.t_max])
    }
}

/// A scene committed to Embree.
pub struct Embree(*mut c_void);

// SAFETY: a committed scene may be queried by many threads at once.
unsafe impl Sync for Embree {}

impl Embree {
    /// Builds with medium quality; `robust` sets RTC_SCENE_FLAG_ROBUST.
    pub fn build(triangles: &[Triangle], robust: bool, threads: usize) -> Self {
        // SAFETY: a Vec3 is three floats without padding; the driver copies them.
        Self(unsafe { embree_build(triangles.as_ptr().cast(), triangles.len(), robust.into(), threads as c_uint) })
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: made by `embree_build`, released once.
        unsafe { embree_release(self.0) }
    }
}

impl Engine for Embree {
    fn closest(&self, rays: &Batch, t: &mut [f32; BATCH]) {
        assert!(rays.peers.len() <= BATCH);
        // SAFETY: the driver reads and writes as many as it is told.
        unsafe { embree_closest(self.0, rays.peers.as_ptr(), rays.peers.len(), t.as_mut_ptr()) }
    }
    fn occluded(&self, rays: &Batch, occluded: &mut [bool; BATCH]) {
        assert!(rays.peers.len() <= BATCH);
        // SAFETY: the driver reads and writes as many as it is told.
        unsafe { embree_occluded(self.0, rays.peers.as_ptr(), rays.peers.len(), occluded.as_mut_ptr()) }
    }
}
