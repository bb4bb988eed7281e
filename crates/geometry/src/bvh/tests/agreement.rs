//! Answers are right, and the same whoever gives them.

use super::super::node::BLOCK;
use super::super::traverse::brute_force;
use super::*;
use glam::DVec3;

/// Where a ray meets a triangle in double precision: distance, barycentric coordinates (Moeller and Trumbore 1997),
/// and the sine of the angle between ray and plane.
fn exact_hit(ray: &Ray, triangle: &Triangle) -> Option<(f64, [f64; 3], f64)> {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (p, q) = (b - a, c - a);
    let normal = p.cross(q);
    let determinant = -normal.dot(direction);
    let sine = determinant.abs() / (normal.length() * direction.length());
    if sine.is_nan() || sine == 0.0 {
        return None;
    }
    let offset: DVec3 = origin - a;
    let cross = offset.cross(direction);
    let (u, v) = (q.dot(cross) / determinant, -p.dot(cross) / determinant);
    Some((normal.dot(offset) / determinant, [1.0 - u - v, u, v], sine))
}

/// Whether double precision leaves no doubt that a ray hits a triangle between its ends.
fn surely_hits(ray: &Ray, triangle: &Triangle) -> Option<f64> {
    let (t, weights, sine) = exact_hit(ray, triangle)?;
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let thickness = (b - a).cross(c - a).length() / (b - a).length().max((c - a).length()).max((c - b).length());
    let inside = weights.iter().all(|&weight| weight > 1e-3);
    let slack = 1e-3 * (1.0 + t.abs());
    let in_range = t > f64::from(ray.t_min) + slack && t < f64::from(ray.t_max) - slack;
    (inside && in_range && sine > 1e-2 && thickness > 1e-2).then_some(t)
}

fn check_against_double_precision(triangles: &[Triangle], rays: &[Ray], hits: &[Hit]) {
    for (ray, hit) in rays.iter().zip(hits) {
        let nearest = triangles.iter().filter_map(|triangle| surely_hits(ray, triangle)).fold(f64::INFINITY, f64::min);
        let t = f64::from(hit.t);
        assert!(t <= nearest + 1e-3 * (1.0 + nearest), "{ray:?} missed a triangle at {nearest}, got {hit:?}");
        if hit.is_miss() {
            continue;
        }
        assert!(ray.t_min <= hit.t && hit.t <= ray.t_max);
        let (exact, weights, sine) = exact_hit(ray, &triangles[hit.triangle as usize]).expect("not edge-on");
        if sine > 1e-2 {
            assert!((t - exact).abs() < 1e-4 * (1.0 + exact.abs()), "{hit:?} of {ray:?} should be at {exact}");
            let [_, u, v] = weights;
            let [a, b, c] = triangles[hit.triangle as usize].map(|corner| corner.as_dvec3());
            let found = a + f64::from(hit.u) * (b - a) + f64::from(hit.v) * (c - a);
            let right = a + u * (b - a) + v * (c - a);
            assert!(found.distance(right) < 1e-3, "{hit:?} of {ray:?} should have weights {weights:?}");
        }
    }
}

fn same(p: &Hit, q: &Hit) -> bool {
    let bits = |hit: &Hit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle];
    bits(p) == bits(q)
}

/// Builds with every preset, casts with every kernel, in batches and one by one, and compares all of it.
fn check(triangles: &[Triangle], rays: &[Ray]) {
    let mut reference: Option<Vec<Hit>> = None;
    for params in all_params() {
        let bvh = Bvh::build(triangles, &params);
        bvh.validate().unwrap();
        assert_eq!(bvh.triangle_count(), triangles.len());
        for bvh in with_all_kernels(&bvh) {
            let mut hits = vec![Hit::MISS; rays.len()];
            let mut occluded = vec![false; rays.len()];
            bvh.closest_hits(rays, &mut hits);
            bvh.occlusions(rays, &mut occluded);
            for (i, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
                assert!(same(hit, &bvh.closest_hit(ray)));
                assert!(same(hit, &brute_force(&bvh, ray)), "{hit:?} {:?} {ray:?}", brute_force(&bvh, ray));
                assert_eq!(occluded[i], !hit.is_miss());
                assert_eq!(occluded[i], bvh.occluded(ray));
            }
            let first = reference.get_or_insert_with(|| hits.clone());
            assert!(first.iter().zip(&hits).all(|(p, q)| same(p, q)), "{:?} differs", bvh.kernel());
        }
    }
    check_against_double_precision(triangles, rays, &reference.expect("there are kernels"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn small_triangles_are_hit_as_in_double_precision(triangles in soup(1.0), rays in rays()) {
        check(&triangles, &rays);
    }

    #[test]
    fn large_triangles_are_hit_as_in_double_precision(triangles in soup(15.0), rays in rays()) {
        check(&triangles, &rays);
    }
}

#[test]
fn kernels_agree_in_a_tessellated_room() {
    let mut mesh = Mesh::default();
    mesh.add_box(&[lines(0.0, 5.0, 12), lines(0.0, 3.0, 9), lines(0.0, 4.0, 11)]);
    mesh.add_box(&[lines(1.0, 2.0, 5), lines(0.5, 1.5, 4), lines(1.0, 2.0, 3)]);
    let mut random = Random(5);
    let rays: Vec<Ray> =
        (0..4000).map(|_| ray(1.4 * random.vector() + Vec3::new(2.5, 1.5, 2.0), random.vector())).collect();
    check(&mesh.triangles(), &rays);
}

#[test]
fn kernels_agree_on_a_tree_too_big_for_the_cache() {
    let mut random = Random(6);
    let triangles: Vec<Triangle> = (0..40_000)
        .map(|_| {
            let centre = 5.0 * random.vector();
            [centre, centre + 0.1 * random.vector(), centre + 0.1 * random.vector()]
        })
        .collect();
    let rays: Vec<Ray> = (0..20_000).map(|_| ray(6.0 * random.vector(), random.vector())).collect();
    let bvh = Bvh::build(&triangles, &BvhParams::default());
    bvh.validate().unwrap();
    let answers: Vec<Vec<Hit>> = with_all_kernels(&bvh)
        .iter()
        .map(|bvh| {
            let mut hits = vec![Hit::MISS; rays.len()];
            bvh.closest_hits(&rays, &mut hits);
            hits
        })
        .collect();
    assert!(answers[0].iter().filter(|hit| !hit.is_miss()).count() > rays.len() / 10);
    for hits in &answers {
        assert!(hits.iter().zip(&answers[0]).all(|(p, q)| same(p, q)));
    }
    for (ray, hit) in rays.iter().zip(&answers[0]).step_by(97) {
        assert!(same(hit, &brute_force(&bvh, ray)));
    }
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let mut mesh = Mesh::default();
    mesh.add_box(&[lines(0.0, 5.0, 60), lines(0.0, 3.0, 50), lines(0.0, 4.0, 40)]);
    let triangles = mesh.triangles();
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::build(&triangles, &BvhParams::default()))
    };
    let one = build(1);
    for threads in [2, 3, 8] {
        let many = build(threads);
        assert_eq!(format!("{:?}", one.nodes), format!("{:?}", many.nodes));
        assert_eq!(format!("{:?}", one.blocks), format!("{:?}", many.blocks));
    }
}

#[test]
fn of_equal_triangles_the_first_is_hit() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let elsewhere = [Vec3::Z, Vec3::Z + Vec3::X, Vec3::Z + Vec3::Y];
    let mut triangles = vec![elsewhere; 3];
    triangles.extend([triangle; 5 * BLOCK]);
    for bvh in with_all_kernels(&Bvh::build(&triangles, &BvhParams::default())) {
        let hit = bvh.closest_hit(&ray(Vec3::new(0.2, 0.3, -1.0), Vec3::Z));
        assert_eq!((hit.t, hit.triangle), (1.0, 3));
    }
}

#[test]
fn weights_follow_the_callers_corners() {
    let corners = [Vec3::ZERO, 3.0 * Vec3::X, 2.0 * Vec3::Y];
    let point = 0.5 * corners[0] + 0.3 * corners[1] + 0.2 * corners[2];
    for shift in 0..3 {
        let triangle = [0, 1, 2].map(|i| corners[(i + shift) % 3]);
        let bvh = Bvh::build(&[triangle], &BvhParams::default());
        for side in [1.0, -1.0] {
            let hit = bvh.closest_hit(&ray(point + side * Vec3::Z, -2.0 * side * Vec3::Z));
            let found = (1.0 - hit.u - hit.v) * triangle[0] + hit.u * triangle[1] + hit.v * triangle[2];
            assert!(found.distance(point) < 1e-6 && (hit.t - 0.5).abs() < 1e-6);
        }
    }
}
