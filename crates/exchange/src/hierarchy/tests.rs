use super::*;
use glam::DVec3;
use radiosity_geometry::Patches;
use radiosity_operator::{Operator, conformance};

/// A face by a corner and two edges, cut into `n x n`; several of them.
fn patches(faces: &[(DVec3, DVec3, DVec3)], n: usize) -> Patches {
    let (mut polygons, mut face) = (Vec::new(), Vec::new());
    for (k, &(o, u, v)) in faces.iter().enumerate() {
        let (u, v) = (u / n as f64, v / n as f64);
        for c in 0..n * n {
            let a = o + (c % n) as f64 * u + (c / n) as f64 * v;
            polygons.push([a, a + u, a + u + v, a + v]);
            face.push(k as u32);
        }
    }
    let count = polygons.len();
    Patches::new(polygons, vec![0; count], face, vec![false; count])
}

fn faces_of_box(low: DVec3, high: DVec3, inward: bool) -> Vec<(DVec3, DVec3, DVec3)> {
    let d = high - low;
    let (x, y, z) = (DVec3::X * d.x, DVec3::Y * d.y, DVec3::Z * d.z);
    let faces = [(low, x, y), (low, y, z), (low, z, x), (low + z, y, x), (low + x, z, y), (low + y, x, z)];
    faces.map(|(o, u, v)| if inward { (o, u, v) } else { (o, v, u) }).to_vec()
}

/// A closed cube with two closed boxes in it that do not touch.
fn room(n: usize) -> Enclosure {
    let p = DVec3::new;
    let mut faces = faces_of_box(DVec3::ZERO, DVec3::ONE, true);
    faces.extend(faces_of_box(p(0.2, 0.25, 0.1), p(0.5, 0.55, 0.6), false));
    faces.extend(faces_of_box(p(0.6, 0.5, 0.3), p(0.9, 0.7, 0.45), false));
    Enclosure::new(patches(&faces, n))
}

/// A bumpy height field.
fn terrain(n: usize) -> Enclosure {
    let height = |i: usize, j: usize| {
        let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
        0.15 * (7.0 * x).sin() * (5.0 * y).cos() + 0.6 / n as f64 * (12.9898 * (i * (n + 1) + j) as f64).sin()
    };
    let at = |i: usize, j: usize| DVec3::new(i as f64 / n as f64, j as f64 / n as f64, height(i, j));
    let cells = (0..n * n).flat_map(|c| {
        let (i, j) = (c % n, c / n);
        let (a, b, d, e) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, d, d], [a, d, e, e]]
    });
    let polygons: Vec<_> = cells.collect();
    let count = polygons.len();
    Enclosure::new(Patches::new(polygons, vec![0; count], (0..count as u32).collect(), vec![false; count]))
}

fn exchange(enclosure: &Enclosure, tolerance: f64) -> (Hierarchical, Tally) {
    let (operator, tally, _) = measure(enclosure, &Settings::new(tolerance, 0), &[], &Control::default()).unwrap();
    (operator, tally)
}

/// `F x` of an operator.
fn product(enclosure: &Enclosure, operator: &dyn Operator, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    operator.apply(x, &mut y, 1);
    y.iter().enumerate().map(|(i, v)| v / enclosure.area(i)).collect()
}

/// Root mean square over area of what two products differ by.
fn distance(enclosure: &Enclosure, a: &[f64], b: &[f64]) -> f64 {
    let area: f64 = (0..a.len()).map(|i| enclosure.area(i)).sum();
    (a.iter().zip(b).enumerate().map(|(i, (a, b))| enclosure.area(i) * (a - b).powi(2)).sum::<f64>() / area).sqrt()
}

fn fields(enclosure: &Enclosure) -> Vec<Vec<f64>> {
    let of = |f: &dyn Fn(usize) -> f64| (0..enclosure.sides()).map(f).collect::<Vec<f64>>();
    let noise = |i: usize| ((i as f64 * 78.233).sin() * 43758.5453).rem_euclid(1.0);
    vec![of(&|_| 1.0), of(&noise), of(&|i| enclosure.patches().centre[i].x.clamp(0.0, 1.0))]
}

#[test]
fn conforms() {
    for enclosure in [room(6), terrain(16)] {
        conformance::check(&exchange(&enclosure, 1e-2).0);
    }
}

#[test]
fn products_are_within_the_tolerance_of_all_pairs() {
    for enclosure in [room(9), terrain(26)] {
        let exact = pairs::Settings { kernel: Kernel::Auto, tolerance: 1e-3, seed: 5 };
        let (all, _) = pairs::measure(&enclosure, &exact, &Control::default()).unwrap();
        let mut before = f64::INFINITY;
        for tolerance in [2e-2, 5e-3, 2e-3] {
            let (operator, tally) = exchange(&enclosure, tolerance);
            assert!(tally.sampled > 0 && operator.links() > 0, "{tally:?}");
            let worst = fields(&enclosure)
                .iter()
                .map(|x| distance(&enclosure, &product(&enclosure, &operator, x), &product(&enclosure, &all, x)))
                .fold(0.0, f64::max);
            assert!(worst < tolerance, "{worst} at {tolerance}");
            assert!(worst < before, "less tolerance, less error");
            before = worst;
        }
    }
}

#[test]
fn what_sees_all_of_a_convex_room_needs_no_ray() {
    let enclosure = Enclosure::new(patches(&faces_of_box(DVec3::ZERO, DVec3::ONE, true), 14));
    let (operator, tally, pairs) = measure(&enclosure, &Settings::new(5e-3, 0), &[], &Control::default()).unwrap();
    assert!(tally.clear > 0 && tally.sampled == 0 && pairs.partial == 0, "{tally:?} {pairs:?}");
    let ones = vec![1.0; enclosure.sides()];
    assert!(distance(&enclosure, &product(&enclosure, &operator, &ones), &ones) < 2e-3);
}

#[test]
fn a_wall_hides_the_two_halves_of_a_room_from_each_other() {
    let p = DVec3::new;
    let mut faces = faces_of_box(DVec3::ZERO, p(2.0, 1.0, 1.0), true);
    // A thick wall from side to side, so that both halves are closed.
    faces.extend([(p(0.9, 0., 0.), p(0., 0., 1.), p(0., 1., 0.)), (p(1.1, 0., 0.), p(0., 1., 0.), p(0., 0., 1.))]);
    let enclosure = Enclosure::new(patches(&faces, 20));
    let (operator, _) = exchange(&enclosure, 1e-2);
    let left = |i: usize| enclosure.patches().centre[i].x < 0.9 + 1e-9;
    let x: Vec<f64> = (0..enclosure.sides()).map(|i| f64::from(u8::from(left(i)))).collect();
    let y = product(&enclosure, &operator, &x);
    for (i, &y) in y.iter().enumerate() {
        assert!(left(i) || y == 0.0, "light {y} came through the wall to patch {i}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let enclosure = room(8);
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (operator, _) = exchange(&enclosure, 1e-2);
            product(&enclosure, &operator, &fields(&enclosure)[1])
        })
    };
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(of(1)), bits(of(3)));
}

#[test]
fn checks_see_the_error() {
    let enclosure = room(9);
    let (operator, _) = exchange(&enclosure, 5e-3);
    let ones = vec![1.0; enclosure.sides()];
    let arriving = product(&enclosure, &operator, &ones);
    let check = Check::new(&enclosure, 5e-3, 0, &Control::default()).unwrap();
    let small = check.deviations(&ones, &arriving, 1)[0];
    assert!(small.error < 6e-3, "{small:?}");
    let off: Vec<f64> = arriving.iter().map(|h| 1.05 * h).collect();
    let large = check.deviations(&ones, &off, 1)[0];
    assert!((large.error - 0.05 * large.mean).abs() < 0.015, "{large:?}");
}

#[test]
fn a_lamp_that_matters_gets_more_rays() {
    let enclosure = room(8);
    let lamp = |i: usize| enclosure.patches().centre[i].distance(DVec3::new(0.5, 0.5, 1.0)) < 0.15;
    let importance: Vec<f64> = (0..enclosure.sides()).map(|i| if lamp(i) { 50.0 } else { 1.0 }).collect();
    let x: Vec<f64> = importance.iter().map(|&w| if w > 1.0 { 1.0 } else { 0.0 }).collect();
    let exact = pairs::Settings { kernel: Kernel::Auto, tolerance: 1e-4, seed: 5 };
    let truth = product(&enclosure, &pairs::measure(&enclosure, &exact, &Control::default()).unwrap().0, &x);
    // So few rays that their noise is nearly all there is.
    let settings = Settings { separation: 0.4, ray_share: 0.3, ..Settings::new(2e-2, 0) };
    let error = |importance: &[f64]| {
        let (operator, tally, pairs) = measure(&enclosure, &settings, importance, &Control::default()).unwrap();
        (distance(&enclosure, &product(&enclosure, &operator, &x), &truth), tally.rays + pairs.rays)
    };
    let ((even, few), (weighed, many)) = (error(&[]), error(&importance));
    assert!(many > few);
    assert!(weighed < 0.8 * even, "{weighed} {even}");
}

#[test]
fn nothing_exchanges_nothing() {
    let one = patches(&[(DVec3::ZERO, DVec3::X, DVec3::Y)], 1);
    for (patches, count) in [(one, 1), (Patches::new(vec![], vec![], vec![], vec![]), 0)] {
        let (operator, _) = exchange(&Enclosure::new(patches), 1e-2);
        assert_eq!((operator.len(), operator.links(), operator.pairs()), (count, 0, 0));
    }
}
