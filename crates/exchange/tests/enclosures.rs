//! What rays and light samples of small enclosures add up to.

use glam::DVec3;
use radiosity_exchange::kernels::point_to_polygon::point_to_polygon;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::operator::{ElementExchange, Measured};
use radiosity_exchange::{Elements, Enclosure, LightSample, Luminaire, Samples, Shot, shots};
use radiosity_geometry::Patches;
use radiosity_operator::{Control, Operator, conformance};

const CORNERS: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

/// A box seen from inside or, with its faces turned, from outside.
fn faces(low: DVec3, high: DVec3, inward: bool) -> Vec<[DVec3; 4]> {
    let corner = |k: usize| {
        let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
        DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    CORNERS
        .iter()
        .map(|face| {
            let p = face.map(corner);
            if inward { p } else { [p[3], p[2], p[1], p[0]] }
        })
        .collect()
}

/// Cuts a parallelogram into `n x n`.
fn cut(p: [DVec3; 4], n: usize) -> Vec<[DVec3; 4]> {
    let at = |i: usize, j: usize| p[0] + (p[1] - p[0]) * (i as f64 / n as f64) + (p[3] - p[0]) * (j as f64 / n as f64);
    (0..n * n).map(|k| (k % n, k / n)).map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect()
}

fn enclosure(polygons: Vec<[DVec3; 4]>, two_sided: Vec<bool>) -> Enclosure {
    let n = polygons.len();
    Enclosure::new(Patches::new(polygons, vec![0; n], (0..n as u32).collect(), two_sided))
}

/// A unit cube with a block standing on its floor.
fn room(n: usize) -> Enclosure {
    let mut polygons: Vec<_> = faces(DVec3::ZERO, DVec3::ONE, true).into_iter().flat_map(|f| cut(f, n)).collect();
    polygons.extend(faces(DVec3::new(0.3, 0.3, 0.0), DVec3::new(0.6, 0.6, 0.5), false));
    let count = polygons.len();
    enclosure(polygons, vec![false; count])
}

fn shoot(enclosure: &Enclosure, per_replicate: u32) -> Samples<Shot> {
    let mut samples = Samples::new(enclosure.sides(), 4);
    shots::shoot(enclosure, &mut samples, &vec![per_replicate; enclosure.sides()], 7, &Control::default()).unwrap();
    samples
}

fn operator(
    enclosure: &Enclosure,
    shots: &Samples<Shot>,
    luminaires: &[Luminaire],
    lights: &Samples<LightSample>,
    elements: &Elements,
    balance: Option<(f64, usize)>,
) -> ElementExchange {
    let all = |_| usize::MAX;
    Measured { enclosure, shots, luminaires, lights, most_shots: &all, most_lights: &all }.on(elements, balance)
}

fn no_lights(enclosure: &Enclosure) -> Samples<LightSample> {
    Samples::new(enclosure.sides(), 4)
}

#[test]
fn operators_conform_raw_balanced_and_on_elements() {
    let room = room(3);
    let shots = shoot(&room, 64);
    let whole = Elements::whole(&room);
    let cut = Elements::new((0..room.sides()).map(|i| (i % 3) as u8).collect());
    for elements in [&whole, &cut] {
        for balance in [None, Some((1e-6, 50))] {
            let exchange = operator(&room, &shots, &[], &no_lights(&room), elements, balance);
            conformance::check(&exchange.operator);
        }
    }
}

#[test]
fn nothing_escapes_a_closed_room_and_balanced_rows_are_its_exposed_area() {
    // Boxes inside that touch nothing: a face that lies on another's plane looks out between the two.
    let mut polygons: Vec<_> = faces(DVec3::ZERO, DVec3::ONE, true).into_iter().flat_map(|f| cut(f, 4)).collect();
    polygons.extend(faces(DVec3::new(0.3, 0.3, 0.1), DVec3::new(0.6, 0.6, 0.5), false));
    polygons.extend(faces(DVec3::new(0.7, 0.1, 0.3), DVec3::new(0.9, 0.9, 0.4), false));
    let count = polygons.len();
    let room = enclosure(polygons, vec![false; count]);
    let shots = shoot(&room, 128);
    for side in 0..room.sides() {
        assert!(shots.of(side).flatten().all(|s| s.target() != Shot::ESCAPED && s.target() != Shot::BACK));
    }
    let exchange = operator(&room, &shots, &[], &no_lights(&room), &Elements::whole(&room), Some((1e-9, 500)));
    assert!(exchange.imbalance < 1e-8, "{}", exchange.imbalance);
    for (sum, area) in exchange.operator.row_sums().iter().zip(&exchange.exposed_area) {
        assert!((sum - area).abs() < 1e-7, "{sum} {area}");
    }
}

#[test]
fn what_stands_on_a_patch_buries_its_share_of_it() {
    let room = room(1);
    let shots = shoot(&room, 1024);
    let exchange = operator(&room, &shots, &[], &no_lights(&room), &Elements::whole(&room), None);
    // The block's foot is 0.3 x 0.3 of the unit floor; its own bottom lies on the floor, face down.
    assert!((exchange.exposed_area[0] - 0.91).abs() < 0.004, "{}", exchange.exposed_area[0]);
    assert_eq!(exchange.exposed_area[1], 1.0);
}

#[test]
fn facing_squares_see_each_other_as_the_closed_form_says() {
    let below = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let above = [DVec3::ZERO, DVec3::Y, DVec3::X + DVec3::Y, DVec3::X].map(|p| p + DVec3::Z);
    let pair = enclosure(vec![below, above], vec![false; 2]);
    let exchange = operator(&pair, &shoot(&pair, 4096), &[], &no_lights(&pair), &Elements::whole(&pair), None);
    let factor = exchange.operator.row_sums()[0];
    // 32,768 rays from both ends: plain Monte Carlo would have a standard error of 0.0022.
    assert!((factor - 0.199_824_895_698).abs() < 0.001, "{factor}");
    assert_eq!(exchange.operator.row(0).len(), exchange.operator.row(1).len());
}

#[test]
fn backs_of_two_sided_patches_are_sides_of_their_own() {
    // A two-sided sheet halves the unit cube: its front sees the upper half, its back the lower.
    let mut polygons = faces(DVec3::ZERO, DVec3::ONE, true);
    polygons.push([DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p + 0.5 * DVec3::Z));
    let halves = enclosure(polygons, [vec![false; 6], vec![true]].concat());
    assert_eq!((halves.sides(), halves.back_of(6), halves.back_of(0)), (8, Some(7), None));
    assert_eq!(halves.normal(7), -halves.normal(6));
    let shots = shoot(&halves, 256);
    assert!(shots.of(6).flatten().all(|s| s.target() != 0 && s.landed()), "the front sees no floor");
    assert!(shots.of(7).flatten().all(|s| s.target() != 1 && s.landed()), "the back sees no ceiling");
    assert!(shots.of(0).flatten().all(|s| s.target() != 6 && s.landed()), "the floor sees the back, not the front");
    assert!(shots.of(0).flatten().any(|s| s.target() == 7));
}

/// The mean light-sample weight of a side.
fn mean_weight(samples: &Samples<LightSample>, side: usize) -> f64 {
    let weights: Vec<f64> = samples.of(side).flatten().map(|s| f64::from(s.weight)).collect();
    weights.iter().sum::<f64>() / weights.len() as f64
}

#[test]
fn light_samples_of_a_lamp_measure_its_form_factor() {
    // Near and far lamps, one that touches the receiver, one that straddles its horizon.
    let receiver = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let lamps = [
        [DVec3::ZERO, DVec3::Y, DVec3::X + DVec3::Y, DVec3::X].map(|p| p + 0.3 * DVec3::Z),
        [DVec3::ZERO, DVec3::Y, DVec3::X + DVec3::Y, DVec3::X].map(|p| p + 20.0 * DVec3::Z),
        [DVec3::ZERO, DVec3::Y, DVec3::Y + DVec3::Z, DVec3::Z],
        [DVec3::ZERO, DVec3::Y, DVec3::Y + DVec3::Z, DVec3::Z].map(|p| p - 0.5 * DVec3::Z - 0.2 * DVec3::X),
    ];
    for (k, lamp) in lamps.into_iter().enumerate() {
        let pair = enclosure(vec![receiver, lamp], vec![false; 2]);
        let luminaires = Luminaires { list: vec![Luminaire::Side(1)], strength: vec![1.0] };
        let mut samples = Samples::new(2, 4);
        luminaires.sample(&pair, &mut samples, &[1024; 2], 3, &Control::default()).unwrap();
        let n = 400;
        let point = |i: usize| {
            DVec3::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5, 0.0) / DVec3::new(n as f64, n as f64, 1.0)
        };
        let exact = (0..n * n).map(|i| point_to_polygon(point(i), DVec3::Z, &lamp)).sum::<f64>() / (n * n) as f64;
        let measured = mean_weight(&samples, 0);
        assert!((measured / exact - 1.0).abs() < 0.01, "lamp {k}: {measured} {exact}");
        assert!(samples.of(1).flatten().all(|s| s.weight == 0.0), "a lamp does not light itself");
    }
}

#[test]
fn a_hidden_lamp_sends_nothing_and_a_half_hidden_one_half() {
    let receiver = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let lamp = [DVec3::ZERO, DVec3::Y, DVec3::X + DVec3::Y, DVec3::X].map(|p| p + DVec3::Z);
    let luminaires = Luminaires { list: vec![Luminaire::Side(1)], strength: vec![1.0] };
    let factor = |screen: [DVec3; 4]| {
        let scene = enclosure(vec![receiver, lamp, screen], vec![false; 3]);
        let mut samples = Samples::new(3, 4);
        luminaires.sample(&scene, &mut samples, &[2048; 3], 3, &Control::default()).unwrap();
        mean_weight(&samples, 0)
    };
    let wide = [-9.0, 9.0].map(|x| DVec3::new(x, x, 0.5));
    let plane = [wide[0], DVec3::new(9., -9., 0.5), wide[1], DVec3::new(-9., 9., 0.5)];
    assert_eq!(factor(plane), 0.0);
    // The centred plate of half the size, midway: 0.09950629459898.
    let plate = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 0.5 * p + DVec3::new(0.25, 0.25, 0.5));
    let measured = factor(plate);
    assert!((measured / 0.099_506_294_598_98 - 1.0).abs() < 0.02, "{measured}");
}

#[test]
fn samples_extend_what_was_drawn_and_do_not_depend_on_threads() {
    let room = room(2);
    let on = |threads: usize, steps: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut samples = Samples::new(room.sides(), 4);
            for &n in steps {
                shots::shoot(&room, &mut samples, &vec![n; room.sides()], 5, &Control::default()).unwrap();
            }
            let mut all: Vec<Vec<Shot>> =
                (0..room.sides()).map(|s| samples.of(s).flatten().copied().collect()).collect();
            all.iter_mut().for_each(|side| side.sort_by_key(|s| (s.target(), format!("{s:?}"))));
            all
        })
    };
    assert_eq!(on(1, &[64]), on(2, &[64]));
    assert_eq!(on(2, &[64]), on(1, &[16, 64]), "two rounds draw what one does");
}

#[test]
fn work_stops_on_request() {
    let room = room(2);
    let control = Control::default();
    control.cancel();
    let mut samples = Samples::new(room.sides(), 4);
    assert!(shots::shoot(&room, &mut samples, &vec![1 << 16; room.sides()], 5, &control).is_err());
}

#[test]
fn patches_without_area_send_and_receive_nothing() {
    let mut polygons = faces(DVec3::ZERO, DVec3::ONE, true);
    polygons.push([DVec3::splat(0.5); 4]);
    let room = enclosure(polygons, vec![false; 7]);
    let shots = shoot(&room, 64);
    let exchange = operator(&room, &shots, &[], &no_lights(&room), &Elements::whole(&room), Some((1e-3, 50)));
    assert!(exchange.operator.row(6).is_empty());
    conformance::check(&exchange.operator);
}
