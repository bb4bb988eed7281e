//! Input that nobody should give.

use super::*;

const UNIT: Triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];

#[test]
fn nothing_is_hit_in_an_empty_scene() {
    for bvh in with_all_kernels(&Bvh::build(&[], &BvhParams::default())) {
        bvh.validate().unwrap();
        assert!(bvh.closest_hit(&ray(Vec3::ZERO, Vec3::X)).is_miss());
        assert!(!bvh.occluded(&ray(Vec3::ZERO, Vec3::X)));
        bvh.closest_hits(&[], &mut []);
        let mut occluded = [true];
        bvh.occlusions(&[ray(Vec3::ZERO, Vec3::X)], &mut occluded);
        assert_eq!((bvh.sah_cost(), bvh.memory_bytes(), occluded), (0.0, 0, [false]));
    }
}

#[test]
fn triangles_without_area_or_sense_keep_their_index() {
    let nan = Vec3::new(f32::NAN, 0.0, 0.0);
    let triangles = [
        [Vec3::ZERO; 3],
        [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        [Vec3::ZERO, Vec3::X, nan],
        [Vec3::ZERO, Vec3::X, Vec3::splat(f32::INFINITY)],
        [Vec3::ZERO, Vec3::X, Vec3::splat(1e30)],
        UNIT,
    ];
    let bvh = Bvh::build(&triangles, &BvhParams::default());
    bvh.validate().unwrap();
    assert_eq!(bvh.triangle_count(), 6);
    assert_eq!(bvh.bounds(), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
    for bvh in with_all_kernels(&bvh) {
        assert_eq!(bvh.closest_hit(&ray(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z)).triangle, 5);
    }
    let none = Bvh::build(&triangles[..5], &BvhParams::default());
    none.validate().unwrap();
    assert!(none.closest_hit(&ray(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z)).is_miss());
}

#[test]
fn senseless_rays_hit_nothing() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let good = ray(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z);
    let mut rays = vec![
        Ray { direction: Vec3::ZERO, ..good },
        Ray { t_min: f32::NAN, ..good },
        Ray { t_max: f32::NAN, ..good },
        Ray { t_min: 2.0, t_max: 1.5, ..good },
        Ray { t_max: -1.0, ..good },
    ];
    for value in bad {
        for axis in 0..3 {
            let (mut by_origin, mut by_direction) = (good, good);
            by_origin.origin[axis] = value;
            by_direction.direction[axis] = value;
            rays.extend([by_origin, by_direction]);
        }
    }
    rays.push(good);
    for bvh in with_all_kernels(&Bvh::build(&[UNIT], &BvhParams::default())) {
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.closest_hits(&rays, &mut hits);
        assert!(!hits.pop().unwrap().is_miss());
        assert!(hits.iter().all(Hit::is_miss), "{hits:?}");
        assert!(rays[..hits.len()].iter().all(|ray| !bvh.occluded(ray)));
    }
}

proptest! {
    /// Whatever the bits say, a walk ends.
    #[test]
    fn any_bits_make_a_ray(bits in prop::collection::vec(prop::array::uniform8(any::<u32>()), 2..50)) {
        let rays: Vec<Ray> = bits
            .iter()
            .map(|bits| {
                let [a, b, c, d, e, f, t_min, t_max] = bits.map(f32::from_bits);
                Ray { origin: Vec3::new(a, b, c), direction: Vec3::new(d, e, f), t_min, t_max }
            })
            .collect();
        let triangles: Vec<Triangle> = (0..100).map(|i| UNIT.map(|corner| corner + Vec3::splat(i as f32))).collect();
        let bvh = Bvh::build(&triangles, &BvhParams::default());
        for bvh in with_all_kernels(&bvh) {
            let mut hits = vec![Hit::MISS; rays.len()];
            bvh.closest_hits(&rays, &mut hits);
            for (ray, hit) in rays.iter().zip(&hits) {
                prop_assert_eq!(bvh.occluded(ray), !hit.is_miss());
            }
        }
    }
}

#[test]
fn extreme_rays_come_to_an_end() {
    let triangles: Vec<Triangle> = (0..100).map(|i| UNIT.map(|corner| corner + Vec3::splat(i as f32))).collect();
    let values = [0.0, -0.0, 1e-45, 1e-38, 1e-20, 1e-12, 1.0, 1e12, 1e20, 3e38, -1e-20, -1.0, -1e12, -3e38];
    let mut random = Random(3);
    let mut value = || values[random.below(values.len())];
    let rays: Vec<Ray> =
        (0..20_000).map(|_| ray(Vec3::new(value(), value(), value()), Vec3::new(value(), value(), value()))).collect();
    for bvh in with_all_kernels(&Bvh::build(&triangles, &BvhParams::default())) {
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.closest_hits(&rays, &mut hits);
        assert!(rays.iter().zip(&hits).all(|(ray, hit)| bvh.occluded(ray) != hit.is_miss()));
    }
}

#[test]
fn both_ends_of_a_ray_count() {
    for bvh in with_all_kernels(&Bvh::build(&[UNIT], &BvhParams::default())) {
        let at = |t_min, t_max| Ray { origin: Vec3::new(0.2, 0.2, 1.0), direction: -Vec3::Z, t_min, t_max };
        assert!(bvh.occluded(&at(1.0, 1.0)));
        assert!(bvh.occluded(&at(0.0, 1.0)));
        assert!(bvh.occluded(&at(1.0, f32::INFINITY)));
        assert!(!bvh.occluded(&at(0.0, 1.0_f32.next_down())));
        assert!(!bvh.occluded(&at(1.0_f32.next_up(), 9.0)));
        // Negative distances never count.
        let behind = Ray { direction: Vec3::Z, ..at(-5.0, 5.0) };
        assert!(!bvh.occluded(&behind));
        let on_it = Ray { origin: Vec3::new(0.2, 0.2, 0.0), ..at(-0.0, 1.0) };
        assert_eq!(bvh.closest_hit(&on_it).t, 0.0);
    }
}

#[test]
fn size_does_not_matter() {
    let mut random = Random(11);
    for exponent in [-11, -6, 0, 6, 11] {
        let scale = 10_f32.powi(exponent);
        let bvh = Bvh::build(&[UNIT.map(|corner| corner * scale)], &BvhParams::default());
        for speed in [1e-11, 1.0, 1e11] {
            for _ in 0..100 {
                let target = Vec3::new(0.05 + 0.4 * random.float(), 0.05 + 0.4 * random.float(), 0.0);
                let origin = 3.0 * random.vector();
                let direction = (target - origin) * speed;
                if direction.z.abs() < 0.05 * speed {
                    continue;
                }
                for bvh in with_all_kernels(&bvh) {
                    let hit = bvh.closest_hit(&ray(origin * scale, direction));
                    assert!((hit.t * speed / scale - 1.0).abs() < 1e-4, "{hit:?} at scale {scale}, speed {speed}");
                }
            }
        }
    }
}

/// Each centre lies twice as far out as the last, so that every split parts one triangle from the rest.
#[test]
fn trees_stay_within_the_stack() {
    let mut triangles = Vec::new();
    for i in 0..110 {
        let size = 1.3_f32.powi(i - 60);
        triangles.extend([UNIT.map(|corner| corner * size + size); 9]);
    }
    for params in all_params() {
        let bvh = Bvh::build(&triangles, &params);
        bvh.validate().unwrap();
        assert!(!bvh.closest_hit(&ray(Vec3::new(1.2, 1.2, 0.0), Vec3::Z)).is_miss());
    }
}

#[test]
fn equal_centres_are_halved() {
    let triangles: Vec<Triangle> = (0..5000).map(|_| UNIT).collect();
    for params in all_params() {
        let bvh = Bvh::build(&triangles, &params);
        bvh.validate().unwrap();
        assert_eq!(bvh.closest_hit(&ray(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z)).triangle, 0);
    }
}
