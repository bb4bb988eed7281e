use super::*;
use crate::model::Surface;

#[test]
fn rooms_are_sound_at_every_detail() {
    for detail in [0, 1, 3, 8] {
        let room = furnished_room(detail);
        assert_eq!(room.findings(), vec![], "detail {detail}");
    }
}

#[test]
fn detail_multiplies_faces() {
    let counts = [0, 1, 3].map(|detail| furnished_room(detail).face_count());
    assert!(counts[0] < 1500 && counts[0] < counts[1] && counts[1] < counts[2], "{counts:?}");
}

/// Distance along a ray to a triangle and whether it meets the front (Möller and Trumbore 1997).
fn meet(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, bool)> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let s = origin - a;
    let q = s.cross(ab);
    let (u, v, t) = (s.dot(p) / determinant, direction.dot(q) / determinant, ac.dot(q) / determinant);
    (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && t > 1e-9).then_some((t, determinant > 0.0))
}

fn nearest(room: &Scene, origin: DVec3, direction: DVec3) -> Option<(f64, bool, &Surface)> {
    let mut nearest: Option<(f64, bool, &Surface)> = None;
    for surface in &room.surfaces {
        for &face in &surface.faces {
            let [a, b, c, d] = surface.corners(face);
            for triangle in [[a, b, c], [a, c, d]] {
                if let Some((t, front)) = meet(origin, direction, triangle)
                    && nearest.is_none_or(|(best, ..)| t < best)
                {
                    nearest = Some((t, front, surface));
                }
            }
        }
    }
    nearest
}

/// Rays from the cameras hit something, and its front: the shell is closed and nothing is inside out.
#[test]
fn cameras_see_only_fronts() {
    let room = furnished_room(0);
    for camera in &room.cameras {
        for i in 0..800 {
            // Golden-angle points on the sphere.
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 800.0;
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let direction = DVec3::new(r * cos, r * sin, z);
            let (_, front, surface) = nearest(&room, camera.position, direction).expect("the shell is closed");
            assert!(front || surface.material.two_sided, "{} from {}", surface.name, camera.name);
        }
    }
}

#[test]
fn cameras_have_room_in_front_of_them() {
    let room = furnished_room(1);
    for camera in &room.cameras {
        let (distance, ..) = nearest(&room, camera.position, camera.forward).unwrap();
        assert!(distance > 1.0, "{} looks at something {distance} m away", camera.name);
    }
}
