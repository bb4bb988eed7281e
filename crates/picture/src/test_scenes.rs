//! Shapes for the tests of this crate.

use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_scene::{Camera, Scene, Surface};

/// One surface of these polygons.
pub fn patches_of(polygons: &[[DVec3; 4]]) -> Patches {
    let n = polygons.len();
    Patches::new(polygons.to_vec(), vec![0; n], (0..n as u32).collect(), vec![false; n])
}

/// The unit square, facing up, in `nu` by `nv` patches.
pub fn sheet(nu: usize, nv: usize) -> Patches {
    let mut polygons = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let p = |i: usize, j: usize| DVec3::new(i as f64 / nu as f64, j as f64 / nv as f64, 0.0);
            polygons.push([p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)]);
        }
    }
    patches_of(&polygons)
}

/// A unit cube around the origin, facing outwards, of `n` by `n` patches per face.
pub fn cube(n: usize) -> Patches {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut surface = Surface { name: "cube".into(), ..Surface::default() };
    for k in 0..6 {
        let (u, v, w) = (axes[k % 3], axes[(k + 1) % 3], axes[(k + 2) % 3]);
        let (u, v, w) = if k < 3 { (u, v, w) } else { (v, u, -w) };
        let first = surface.vertices.len() as u32;
        surface.vertices.extend([-u - v, u - v, u + v, v - u].map(|corner| 0.5 * (corner + w)));
        surface.faces.push([first, first + 1, first + 2, first + 3]);
    }
    let scene = Scene { surfaces: vec![surface], ..Scene::default() };
    radiosity_scene::meshing::grid(&scene, &[(n, n); 6]).unwrap()
}

/// A camera at `position` that looks at the origin.
pub fn camera(position: DVec3, vertical_fov: f64) -> Camera {
    let forward = -position.normalize();
    let up = forward.any_orthonormal_vector();
    Camera { name: "eye".into(), position, forward, up, vertical_fov, aspect: None }
}
