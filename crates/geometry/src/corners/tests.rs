use proptest::prelude::*;

use super::*;

fn patches_of(polygons: &[[DVec3; 4]]) -> Patches {
    let n = polygons.len();
    Patches::new(polygons.to_vec(), vec![0; n], (0..n as u32).collect(), vec![false; n])
}

fn sheet(nu: usize, nv: usize) -> Vec<[DVec3; 4]> {
    let p = |i: usize, j: usize| DVec3::new(i as f64 / nu as f64, j as f64 / nv as f64, 0.0);
    let cell = |i, j| [p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)];
    (0..nv).flat_map(|j| (0..nu).map(move |i| cell(i, j))).collect()
}

fn assert_close(values: &[f64], expected: &[f64]) {
    assert_eq!(values.len(), expected.len());
    let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(values.iter().zip(expected).all(is_close), "{values:?}, not {expected:?}");
}

#[test]
fn linear_fields_are_found_up_to_the_border() {
    let linear = |p: DVec3| 2.0 + 3.0 * p.x - p.y;
    // Squares, a grid stretched unevenly, and triangles.
    let mut stretched = sheet(4, 3);
    stretched.iter_mut().flatten().for_each(|p| p.x *= p.x);
    let triangles = sheet(3, 3).into_iter().flat_map(|[a, b, c, d]| [[a, b, c, c], [a, c, d, d]]).collect();
    for polygons in [sheet(4, 4), stretched, triangles] {
        let patches = patches_of(&polygons);
        let values: Vec<f64> = patches.centre.iter().map(|&c| linear(c)).collect();
        let corners = Corners::new(&patches, CREASE_ANGLE).field(&values, 1);
        let expected: Vec<f64> = polygons.iter().flatten().map(|&p| linear(p)).collect();
        assert_close(&corners, &expected);
    }
}

#[test]
fn the_error_of_smooth_fields_falls_with_the_square_of_the_patches() {
    let integral = |a: f64, b: f64| (b.sin() - a.sin()) / (b - a);
    let worst = |n: usize| {
        let patches = patches_of(&sheet(n, 2));
        let values: Vec<f64> = patches.polygons.iter().map(|p| integral(p[0].x, p[1].x)).collect();
        let corners = Corners::new(&patches, CREASE_ANGLE).field(&values, 1);
        let all = patches.polygons.iter().flatten().zip(&corners);
        all.map(|(p, c)| (c - p.x.cos()).abs()).fold(0.0, f64::max)
    };
    // Borders included: there the slope is one-sided, and still of second order at the corner.
    let ratio = worst(8) / worst(16);
    assert!(ratio > 3.5, "{} {}", worst(8), worst(16));
}

#[test]
fn creases_keep_sides_apart() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let patches = patches_of(&[[DVec3::ZERO, x, x + y, y], [x, x + z, x + y + z, x + y]]);
    let corners = Corners::new(&patches, CREASE_ANGLE).field(&[1.0, 5.0], 1);
    assert_close(&corners, &[1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]);
    let smooth = Corners::new(&patches, PI).field(&[1.0, 5.0], 1);
    assert_ne!(smooth, corners);
}

#[test]
fn a_wall_on_an_edge_is_a_crease() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let floor = [[DVec3::ZERO, x, x + y, y], [x, 2.0 * x, 2.0 * x + y, x + y]];
    let wall = [x, x + y, x + y + z, x + z];
    let open = Corners::new(&patches_of(&floor), CREASE_ANGLE).field(&[1.0, 3.0], 1);
    assert_close(&open, &[0.0, 2.0, 2.0, 0.0, 2.0, 4.0, 4.0, 2.0]);
    let patches = patches_of(&[floor[0], floor[1], wall]);
    let split = Corners::new(&patches, CREASE_ANGLE).field(&[1.0, 3.0, 7.0], 1);
    assert_close(&split, &[1.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 7.0]);
}

#[test]
fn the_backs_of_double_walls_do_not_shine_through() {
    let (x, y) = (DVec3::X, DVec3::Y);
    let patches = patches_of(&[[DVec3::ZERO, x, x + y, y], [y, x + y, x, DVec3::ZERO]]);
    let corners = Corners::new(&patches, CREASE_ANGLE).field(&[1.0, 5.0], 1);
    assert_close(&corners, &[1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]);
}

#[test]
fn degenerate_patches_keep_their_values() {
    let patches = patches_of(&[[DVec3::ZERO, DVec3::X, DVec3::X, DVec3::X], [DVec3::ZERO; 4]]);
    assert_eq!(Corners::new(&patches, 0.5).field(&[1.0, 2.0], 1)[..], [1., 1., 1., 1., 2., 2., 2., 2.]);
    assert!(Corners::new(&Patches::default(), 0.5).field(&[], 3).is_empty());
}

#[test]
fn weights_interpolate_linear_fields_on_parallelograms_and_triangles() {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
    for polygon in [[p(0., 0.), p(2., 0.), p(3., 1.), p(1., 1.)], [p(0., 0.), p(2., 0.), p(3., 1.), p(3., 1.)]] {
        let chart = Chart::new(&polygon);
        for (s, t) in [(0.1, 0.8), (0.7, 0.3), (0.5, 0.5)] {
            let weights = corner_weights(&chart, s, t);
            let point: DVec3 = (0..4).map(|k| weights[k] * polygon[k]).sum();
            assert!((point - chart.point(s, t)).length() < 1e-12);
        }
    }
}

proptest! {
    #[test]
    fn weights_sum_to_one_on_any_quad(s in 0.0..1.0f64, t in 0.0..1.0f64, x in 1.0..3.0f64, y in 0.2..3.0f64) {
        let polygon = [DVec3::ZERO, DVec3::X, DVec3::new(x, y, 0.0), DVec3::Y];
        let weights = corner_weights(&Chart::new(&polygon), s, t);
        prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        prop_assert!(weights.iter().all(|&w| w >= -1e-12));
    }
}

#[test]
fn slivers_do_not_throw_the_field_out_of_bounds() {
    // A square, slivers of many widths beside it with values of their own, and a square behind them.
    for width in [1e-2, 1e-4, 1e-6, 1e-9, 1e-13] {
        let column = |from: f64, to: f64, low: f64, high: f64| {
            [
                DVec3::new(from, low, 0.0),
                DVec3::new(to, low, 0.0),
                DVec3::new(to, high, 0.0),
                DVec3::new(from, high, 0.0),
            ]
        };
        let (a, b) = (1.0 + width, 1.0 + 2.0 * width);
        let slanted = [DVec3::new(b, 0.0, 0.0), DVec3::new(b + width, 1.0, 0.0), DVec3::new(b, 1.0, 0.0)];
        let patches = patches_of(&[
            column(0.0, 1.0, 0.0, 1.0),
            column(1.0, a, 0.0, 1.0),
            column(a, b, 0.0, 1.0),
            [slanted[0], slanted[1], slanted[2], slanted[2]],
            column(0.0, 1.0, 1.0, 2.0),
        ]);
        let corners = Corners::new(&patches, CREASE_ANGLE).field(&[1.0, 3.0, -2.0, 4.0, 2.0], 1);
        assert!(corners.iter().all(|c| c.abs() < 30.0), "{width}: {corners:?}");
    }
}
