//! What rays and light samples by mirrors and clear glass add up to.

use glam::DVec3;
use radiosity_exchange::images::{Images, left_out};
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::operator::{ElementExchange, Measured};
use radiosity_exchange::{Elements, Enclosure, LightSample, Luminaire, Samples, Shot, factors, shots};
use radiosity_geometry::Patches;
use radiosity_operator::{Control, Operator, conformance};
use std::sync::Arc;

/// A parallelogram that looks along u x v.
fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [DVec3; 4] {
    let [c, u, v] = [corner, u, v].map(DVec3::from_array);
    [c, c + u, c + u + v, c + v]
}

/// The inside of a unit cube: x0, x1, y0, y1, z0, z1.
fn cube() -> Vec<[DVec3; 4]> {
    let (x, y, z, o) = ([1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0.; 3]);
    vec![quad(o, y, z), quad(x, z, y), quad(o, z, x), quad(y, x, z), quad(o, x, y), quad(z, y, x)]
}

fn enclosure(polygons: Vec<[DVec3; 4]>, specular: &[f64], transmittance: &[f64]) -> Enclosure {
    let n = polygons.len();
    Enclosure::new(Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![false; n]))
        .with_specular(specular.to_vec(), transmittance.to_vec())
}

fn measured(
    enclosure: &Enclosure,
    luminaires: &Luminaires,
    each: u32,
    balance: Option<(f64, usize)>,
) -> ElementExchange {
    let sides = enclosure.sides();
    let (mut rays, mut lights) = (Samples::<Shot>::new(sides, 4), Samples::<LightSample>::new(sides, 4));
    let (wanted, control) = (vec![each; sides], Control::default());
    let imaged = Images::new(enclosure, luminaires).turns_of_sides;
    shots::shoot_beyond(enclosure, &mut rays, &wanted, 7, imaged, &control).unwrap();
    if !luminaires.list.is_empty() {
        luminaires.sample(enclosure, &mut lights, &wanted, 7, &control).unwrap();
    }
    let all = |_| usize::MAX;
    let list = &luminaires.list;
    Measured { enclosure, shots: &rays, luminaires: list, lights: &lights, most_shots: &all, most_lights: &all }
        .on(&Elements::whole(enclosure), balance)
}

/// G between the first two patches.
fn entry(exchange: &ElementExchange) -> f64 {
    let n = exchange.operator.len();
    let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
    x[1] = 1.0;
    exchange.operator.apply(&x, &mut y, 1);
    y[0]
}

fn lamp(side: u32) -> Luminaires {
    Luminaires { list: vec![Luminaire::Side(side)], strength: vec![1.0] }
}

/// A receiver, a lamp that looks away from it, and a mirror above both; the exchange with the image of the lamp.
fn under_a_mirror() -> (Vec<[DVec3; 4]>, f64) {
    let receiver = quad([-1., 0., 0.], [0.5, 0., 0.], [0., 0.5, 0.]);
    let lamp = quad([1., 0., 1.], [0.5, 0., 0.], [0., 0.5, 0.]);
    let mirror = quad([-2., -2., 2.], [0., 5., 0.], [5., 0., 0.]);
    let image = quad([1., 0., 3.], [0., 0.5, 0.], [0.5, 0., 0.]);
    let patches = Patches::new(vec![receiver, image], vec![0; 2], vec![0, 1], vec![false; 2]);
    let settings =
        factors::Settings { method: factors::Method::Contour, tolerance: 1e-9, seed: 0, memory_limit: u64::MAX };
    let exact = factors::measure(Arc::new(Enclosure::new(patches)), &settings, &Control::default()).unwrap();
    (vec![receiver, lamp, mirror], exact.operator.row(0)[0].1)
}

#[test]
fn a_form_factor_by_a_mirror_is_that_of_the_image() {
    let (polygons, exact) = under_a_mirror();
    let room = enclosure(polygons, &[0.0, 0.0, 0.8], &[0.0; 3]);
    let by_rays = entry(&measured(&room, &Luminaires::default(), 1 << 16, None));
    // Of half a million rays from both ends, 1,700 arrive.
    assert!((by_rays / (0.8 * exact) - 1.0).abs() < 0.06, "{by_rays} {exact}");
    let by_area = entry(&measured(&room, &lamp(1), 1 << 10, None));
    assert!((by_area / (0.8 * exact) - 1.0).abs() < 2e-3, "{by_area} {exact}");
}

#[test]
fn a_pane_on_the_way_takes_its_share_by_rays_and_by_area() {
    let (mut polygons, exact) = under_a_mirror();
    polygons.push(quad([-2., -2., 0.5], [5., 0., 0.], [0., 5., 0.]));
    let room = enclosure(polygons, &[0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 0.0, 0.5]);
    let by_rays = entry(&measured(&room, &Luminaires::default(), 1 << 16, None));
    assert!((by_rays / (0.5 * exact) - 1.0).abs() < 0.08, "{by_rays} {exact}");
    let by_area = entry(&measured(&room, &lamp(1), 1 << 10, None));
    assert!((by_area / (0.5 * exact) - 1.0).abs() < 2e-3, "{by_area} {exact}");
}

#[test]
fn operators_with_mirrors_conform_and_rows_sum_to_diffuse_areas() {
    // A perfect mirror, one that is half diffuse, and a lamp that is a little of a mirror.
    let room = enclosure(cube(), &[1.0, 0.5, 0.0, 0.0, 0.0, 0.2], &[0.0; 6]);
    let exchange = measured(&room, &lamp(5), 512, Some((1e-9, 500)));
    conformance::check(&exchange.operator);
    let wanted = [0.0, 0.5, 1.0, 1.0, 1.0, 0.8];
    for (side, sum) in exchange.operator.row_sums().into_iter().enumerate() {
        assert!((sum - wanted[side]).abs() < 1e-6, "{side}: {sum}");
        assert!((exchange.exposed_area[side] - wanted[side]).abs() < 1e-12);
    }
}

#[test]
fn images_end_where_mirrors_see_none() {
    let light = Luminaire::Point { position: DVec3::new(0.4, 0.5, 0.6) };
    let luminaires = Luminaires { list: vec![light], strength: vec![1.0] };
    let images = |specular: [f64; 6]| Images::new(&enclosure(cube(), &specular, &[0.0; 6]), &luminaires);
    let one = images([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!((one.list.len(), one.turns_of_lights), (1, u32::MAX));
    // Two at right angles: in each, and in both in either order.
    let corner = images([1.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!((corner.list.len(), corner.turns_of_lights), (4, u32::MAX));
    // Between two that face each other there is no end, and two more at every turn.
    let facing = images([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(facing.list.len(), 2 * facing.turns_of_lights as usize);
    assert!(facing.turns_of_lights >= 32);
}

#[test]
fn what_images_leave_out_of_a_light_is_told() {
    // Of light between floor and ceiling of reflectance s, s^n comes by more than n of them, if walls are as far away.
    let facing = enclosure(
        vec![
            quad([-900., -900., 0.], [1800., 0., 0.], [0., 1800., 0.]),
            quad([-900., -900., 1.], [0., 1800., 0.], [1800., 0., 0.]),
        ],
        &[0.5; 2],
        &[0.0; 2],
    );
    let light = Luminaire::Point { position: DVec3::new(0.0, 0.0, 0.5) };
    let whole = left_out(&facing, &light, 0, 3);
    assert!((whole / (4.0 * std::f64::consts::PI) - 0.5).abs() < 0.05, "{whole}");
    let more = left_out(&facing, &light, 2, 3);
    assert!((more / whole - 0.25).abs() < 0.04, "{more} {whole}");
    assert_eq!(left_out(&facing, &light, u32::MAX, 3), 0.0);
}

#[test]
fn what_cannot_follow_mirrors_refuses_them() {
    let room = Arc::new(enclosure(cube(), &[0.0, 0.0, 0.3, 0.0, 0.0, 0.0], &[0.0; 6]));
    let settings =
        factors::Settings { method: factors::Method::Auto, tolerance: 1e-3, seed: 0, memory_limit: u64::MAX };
    let failure = factors::measure(room, &settings, &Control::default()).err().unwrap().to_string();
    assert!(failure.contains("patch 2, of surface 0") && failure.contains("\"sampled\""), "{failure}");
}

#[test]
fn an_enclosure_without_any_is_the_plain_one() {
    let plain = enclosure(cube(), &[0.0; 6], &[0.0; 6]);
    assert!(plain.specular().is_none());
    assert_eq!((plain.diffuse_share(0), plain.diffuse_area(0)), (1.0, plain.area(0)));
}
