//! Is it true: closed forms, the furnace, rates, and that nothing depends on threads.

use std::sync::Arc;

use glam::DVec3;
use radiosity_exchange::kernels::point_to_polygon::point_to_polygon;
use radiosity_exchange::{Enclosure, Luminaire};
use radiosity_geometry::Patches;
use radiosity_geometry::texture::{Raster, TexturedFaces, TexturedPatches};
use radiosity_operator::{Cancelled, Control};

use crate::{Effort, Exitance, Light, Measured, Tracer, at_points, of_sides};

/// A rectangle from a corner along two edges, its normal along `u x v`.
fn rectangle(o: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [DVec3; 4] {
    let [o, u, v] = [o, u, v].map(DVec3::from_array);
    [o, o + u, o + u + v, o + v]
}

/// The unit cube seen from inside, `n` by `n` patches a face.
fn room(n: usize) -> Vec<[DVec3; 4]> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut polygons = Vec::new();
    for k in 0..6 {
        let (u, v, w) = (axes[k % 3], axes[(k + 1) % 3], axes[(k + 2) % 3]);
        let (u, v, o) = if k < 3 { (u, v, DVec3::ZERO) } else { (v, u, w) };
        let at = |i: usize, j: usize| o + (u * i as f64 + v * j as f64) / n as f64;
        let cells = (0..n * n).map(|c| (c % n, c / n));
        polygons.extend(cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
    }
    polygons
}

fn enclosure(polygons: &[[DVec3; 4]], two_sided: bool) -> Enclosure {
    let n = polygons.len();
    Enclosure::new(Patches::new(polygons.to_vec(), (0..n as u32).collect(), vec![0; n], vec![two_sided; n]))
}

fn paths(enclosure: &Enclosure, emission: Vec<f32>, reflectance: f32, lights: Vec<Light>) -> Tracer<'_> {
    let rho = vec![reflectance; emission.len()];
    Tracer::paths(enclosure, 1, Exitance::Uniform(emission), rho, lights, 7)
}

fn at(tracer: &Tracer, point: DVec3, normal: DVec3, samples: u32) -> (f64, f64) {
    let measured = at_points(tracer, &[point], &[normal], &Effort::of_samples(samples), &Control::default()).unwrap();
    (measured.irradiance[0], measured.standard_error[0])
}

fn assert_within((value, error): (f64, f64), truth: f64) {
    assert!((value - truth).abs() < 4.0 * error && error < 0.02 * truth, "{value} +- {error}, not {truth}");
}

#[test]
fn a_furnace_has_its_closed_form() {
    // Everything emits 1 and reflects rho: H = 1 / (1 - rho).
    for rho in [0.0, 0.5, 0.95] {
        let enclosure = enclosure(&room(2), false);
        let tracer = paths(&enclosure, vec![1.0; 24], rho, vec![]);
        // Sixty-four rounds, so that what is far off is improbable.
        let measured = of_sides(&tracer, &Effort::of_samples(4096), &Control::default()).unwrap();
        let truth = 1.0 / (1.0 - f64::from(rho));
        let mean = measured.irradiance.iter().sum::<f64>() / 24.0;
        assert!((mean / truth - 1.0).abs() < 0.01, "{mean} {truth}");
        let scores = z_scores(&measured, |_| truth, 1e-6);
        assert!(scores.iter().all(|z| z.abs() < 4.5), "{scores:?}");
    }
}

#[test]
fn textures_stand_for_the_reflectance_of_their_sides_at_every_bounce() {
    // All is said to be black, and an image on every face reflects a half: H = 1 / (1 - 1/2).
    let enclosure = enclosure(&room(1), false);
    let patches = enclosure.patches();
    let image = Arc::new(Raster::of_values([2, 2], 1, vec![0.5; 4]));
    let faces = patches.polygons.iter().map(|&polygon| {
        let face = [(polygon, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])];
        Some(Arc::new(TexturedFaces::new(Arc::clone(&image), face, &[1.0])))
    });
    let textures = TexturedPatches::new(patches, &faces.collect::<Vec<_>>());
    let tracer = paths(&enclosure, vec![1.0; 6], 0.0, vec![]).with_textures(Some(textures));
    let at = at(&tracer, DVec3::new(0.5, 0.5, 1e-3), DVec3::Z, 1024);
    assert_within(at, 2.0);
}

fn z_scores(measured: &Measured, truth: impl Fn(usize) -> f64, rounding: f64) -> Vec<f64> {
    let of = |(i, (value, error)): (usize, (&f64, &f64))| (value - truth(i)) / error.hypot(rounding * truth(i));
    measured.irradiance.iter().zip(&measured.standard_error).enumerate().map(of).collect()
}

#[test]
fn a_lamp_counts_once_however_near_or_far_it_is() {
    // A strip of a ceiling, and points under it, beside it, far from it and almost in its plane.
    let lamp = rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    // The lamp is one among dark walls far away, so that it is taken for one.
    let wall = rectangle([-50.0, -50.0, -9.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]);
    let enclosure = enclosure(&[lamp, wall], false);
    let tracer = paths(&enclosure, vec![10.0, 0.0], 0.0, vec![]);
    for point in [[0.5, 0.5, 0.0], [0.3, 0.4, 0.99], [3.0, -2.0, -8.0], [-0.01, 0.5, 0.95]] {
        let point = DVec3::from_array(point);
        for normal in [DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8)] {
            let truth = 10.0 * point_to_polygon(point, normal, &lamp);
            let (value, error) = at(&tracer, point, normal, 4096);
            assert!((value - truth).abs() <= 4.0 * error + 1e-6 * truth, "{value} +- {error}, not {truth}");
            assert!(error <= 0.03 * truth, "{error} of {truth}");
        }
    }
}

#[test]
fn many_lamps_are_chosen_from_as_they_matter() {
    // Sixty lamps of different strength on sixty surfaces: more than there may be groups.
    let lamps: Vec<_> =
        (0..60).map(|i| rectangle([f64::from(i), 0.0, 1.0], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0])).collect();
    let wall = rectangle([-500.0, -500.0, -9.0], [1000.0, 0.0, 0.0], [0.0, 1000.0, 0.0]);
    let emission: Vec<f32> = (0..60).map(|i| 1.0 + (i % 7) as f32).chain([0.0]).collect();
    let enclosure = enclosure(&[lamps.clone(), vec![wall]].concat(), false);
    let tracer = paths(&enclosure, emission.clone(), 0.0, vec![]);
    let point = DVec3::new(20.3, 0.4, 0.5);
    let truth: f64 =
        lamps.iter().zip(&emission).map(|(l, &e)| f64::from(e) * point_to_polygon(point, DVec3::Z, l)).sum();
    assert_within(at(&tracer, point, DVec3::Z, 1 << 14), truth);
}

#[test]
fn lights_without_area_have_their_closed_forms() {
    let floor = rectangle([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
    let screen = rectangle([4.0, 4.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let enclosure = enclosure(&[floor, screen], false);
    let position = DVec3::new(0.0, 0.0, 2.0);
    let light = |luminaire, strength| Light { luminaire, strength: vec![strength] };
    let down = -DVec3::Z;
    let lights = vec![
        light(Luminaire::Point { position }, 3.0),
        light(Luminaire::Spot { position, direction: down, cos_inner: 0.95, cos_outer: 0.9 }, 8.0),
        light(Luminaire::Directional { direction: DVec3::new(0.6, 0.0, -0.8) }, 5.0),
    ];
    let tracer = paths(&enclosure, vec![0.0; 2], 0.0, lights);
    // Straight below: 3 / 4 + 8 / 4 + 5 * 0.8, without noise, as each is looked at.
    let (value, error) = at(&tracer, DVec3::ZERO, DVec3::Z, 64);
    assert!((value - 6.75).abs() < 1e-5 && error < 1e-6, "{value} +- {error}");
    // Outside the cone: (0, 2, 0) is sqrt(8) away at 45 degrees.
    let (value, _) = at(&tracer, DVec3::new(0.0, 2.0, 0.0), DVec3::Z, 64);
    assert!((value - (4.0 + 3.0 * 0.5f64.sqrt() / 8.0)).abs() < 1e-5, "{value}");
    // In the shadow of the screen, which the sun casts along x.
    let shadow = DVec3::new(4.5 + 0.75, 4.5, 0.0);
    let (value, _) = at(&tracer, shadow, DVec3::Z, 64);
    assert!((value - 3.0 * 2.0 / (shadow.length_squared() + 4.0).powf(1.5)).abs() < 1e-5, "{value}");
}

#[test]
fn of_many_lights_those_are_chosen_that_bring_most() {
    let floor = rectangle([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
    let enclosure = enclosure(&[floor], false);
    let position = |i: u32| DVec3::new(f64::from(i), 1.0, 1.0 + f64::from(i % 3));
    let lights: Vec<Light> = (0..20)
        .map(|i| Light { luminaire: Luminaire::Point { position: position(i) }, strength: vec![1.0 + i as f32] })
        .collect();
    let truth: f64 = (0..20).map(|i| (1.0 + f64::from(i)) * position(i).z / position(i).length().powi(3)).sum();
    let tracer = paths(&enclosure, vec![0.0], 0.0, lights);
    let (value, error) = at(&tracer, DVec3::ZERO, DVec3::Z, 64);
    assert!((value / truth - 1.0).abs() < 1e-6 && error < 1e-6 * truth, "{value} +- {error}, not {truth}");
}

#[test]
fn backs_are_black_and_both_sides_of_two_sided_patches_shine() {
    let lamp = rectangle([-1.0, -1.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    for two_sided in [false, true] {
        let enclosure = enclosure(&[lamp], two_sided);
        let tracer = paths(&enclosure, vec![1.0; enclosure.sides()], 0.0, vec![]);
        let truth = point_to_polygon(DVec3::ZERO, DVec3::Z, &lamp);
        let below = at(&tracer, DVec3::ZERO, DVec3::Z, 2048);
        let above = at(&tracer, 2.0 * DVec3::Z, -DVec3::Z, 2048);
        assert_within(above, truth);
        if two_sided { assert_within(below, truth) } else { assert_eq!(below.0, 0.0) }
    }
}

#[test]
fn a_gather_takes_what_is_on_the_first_side_and_nothing_else() {
    // The floor shines as x does, from 0 to 4; nothing else does. A point one above its middle sees 2 on average, weighed
    // evenly to both sides.
    let floor = rectangle([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    let enclosure = enclosure(&[floor], false);
    let corners = Exitance::Corners(vec![0.0, 4.0, 4.0, 0.0]);
    let tracer = Tracer::gather(&enclosure, 1, corners, vec![], 3);
    let truth = 2.0 * point_to_polygon(DVec3::Z, -DVec3::Z, &floor);
    assert_within(at(&tracer, DVec3::Z, -DVec3::Z, 4096), truth);
}

#[test]
fn errors_fall_with_the_root_of_the_rounds_and_are_what_they_say() {
    let mut polygons = room(2);
    polygons.push(rectangle([0.3, 0.3, 0.9], [0.0, 0.3, 0.0], [0.3, 0.0, 0.0]));
    let enclosure = enclosure(&polygons, true);
    let emission: Vec<f32> = (0..enclosure.sides()).map(|s| if s == 24 { 20.0 } else { 0.0 }).collect();
    let tracer = paths(&enclosure, emission, 0.6, vec![]);
    let measure = |rounds| {
        let effort = Effort { per_round: 16, least: rounds, most: rounds, accuracy: None };
        of_sides(&tracer, &effort, &Control::default()).unwrap()
    };
    let (few, many) = (measure(16), measure(1024));
    let rate = (many.rounds.error / few.rounds.error).log2() / 6.0;
    assert!((rate + 0.5).abs() < 0.05, "{rate}");
    // The few rounds are the first of the many, which takes 1/64 off their variance. 49 scores of t with 15 degrees of
    // freedom: their mean square is 15 / 13.
    let scores = z_scores(&few, |i| many.irradiance[i], 0.0);
    let lit: Vec<f64> = scores.into_iter().filter(|z| z.is_finite()).collect();
    let mean_square = lit.iter().map(|z| z * z).sum::<f64>() / lit.len() as f64;
    assert!((0.6..1.9).contains(&mean_square), "{mean_square}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_nothing_if_cancelled() {
    let enclosure = enclosure(&room(3), false);
    let emission: Vec<f32> = (0..54).map(|s| if s == 30 { 9.0 } else { 0.0 }).collect();
    let tracer = paths(&enclosure, emission, 0.5, vec![]);
    let measure = || of_sides(&tracer, &Effort::of_samples(1024), &Control::default()).unwrap();
    let many = measure();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(measure);
    assert_eq!((&many.irradiance, &many.standard_error, many.rays), (&one.irradiance, &one.standard_error, one.rays));
    let control = Control::default();
    control.cancel();
    assert_eq!(of_sides(&tracer, &Effort::of_samples(8), &control).unwrap_err(), Cancelled);
}

/// The unit cube from inside, of whose faces mirrors reflect these parts; and the part per patch.
fn mirrored_room(parts: [f64; 6], n: usize) -> (Enclosure, Vec<f64>) {
    let polygons = room(n);
    let specular: Vec<f64> = (0..polygons.len()).map(|i| parts[i / (n * n)]).collect();
    let enclosure = enclosure(&polygons, false).with_specular(specular.clone(), vec![0.0; polygons.len()]);
    (enclosure, specular)
}

#[test]
fn furnaces_stay_even_with_mirrors() {
    for parts in [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.9, 1.0, 0.0, 0.3]] {
        let (enclosure, specular) = mirrored_room(parts, 2);
        // Every side sends 2 (1 - s) of its own where 2 arrives: H = 2.
        let own: Vec<f32> = specular.iter().map(|s| (2.0 * (1.0 - s)) as f32).collect();
        let corners = own.iter().flat_map(|&b| [b; 4]).collect();
        let gather = Tracer::gather(&enclosure, 1, Exitance::Corners(corners), vec![], 3);
        let measured = of_sides(&gather, &Effort::of_samples(64), &Control::default()).unwrap();
        // Exactly, without noise: a gather lands once, and counts the same wherever that is.
        assert!(measured.irradiance.iter().all(|h| (h / 2.0 - 1.0).abs() < 1e-5), "{:?}", measured.irradiance);
        // Of that, half is emitted and half reflected.
        let emission = Exitance::Uniform(own.iter().map(|b| b / 2.0).collect());
        let reflectance = own.iter().map(|b| b / 4.0).collect();
        let tracer = Tracer::paths(&enclosure, 1, emission, reflectance, vec![], 3);
        let measured = of_sides(&tracer, &Effort::of_samples(1024), &Control::default()).unwrap();
        let scores = z_scores(&measured, |_| 2.0, 1e-6);
        assert!(scores.iter().all(|z| z.abs() < 4.5), "{scores:?}");
    }
}

#[test]
fn lamps_count_once_through_glass_and_in_mirrors() {
    // A lamp over a point, a pane of 0.7 between; and its image in a mirror beside, which only rays find.
    let lamp = rectangle([-0.5, -0.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let wall = rectangle([-50.0, -50.0, -9.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]);
    let pane = rectangle([-9.0, -9.0, 0.5], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let glazed = enclosure(&[lamp, wall, pane], false).with_specular(vec![0.0; 3], vec![0.0, 0.0, 0.7]);
    let tracer = paths(&glazed, vec![10.0, 0.0, 0.0], 0.0, vec![]);
    let straight = 10.0 * point_to_polygon(DVec3::ZERO, DVec3::Z, &lamp);
    assert_within(at(&tracer, DVec3::ZERO, DVec3::Z, 4096), 0.7 * straight);
    let mirror = rectangle([1.0, -9.0, -9.0], [0.0, 0.0, 18.0], [0.0, 18.0, 0.0]);
    let mirrored = enclosure(&[lamp, wall, mirror], false).with_specular(vec![0.0, 0.0, 0.8], vec![0.0; 3]);
    let tracer = paths(&mirrored, vec![10.0, 0.0, 0.0], 0.0, vec![]);
    let image = lamp.map(|p| DVec3::new(2.0 - p.x, p.y, p.z));
    let image = [image[3], image[2], image[1], image[0]];
    let seen = 0.8 * 10.0 * point_to_polygon(DVec3::ZERO, DVec3::Z, &image);
    assert_within(at(&tracer, DVec3::ZERO, DVec3::Z, 1 << 14), straight + seen);
}

#[test]
fn lights_without_area_are_seen_in_mirrors_and_through_panes() {
    let floor = rectangle([-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
    let mirror = rectangle([1.0, -9.0, -9.0], [0.0, 0.0, 18.0], [0.0, 18.0, 0.0]);
    let pane = rectangle([-9.0, -9.0, 0.5], [9.5, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let enclosure = enclosure(&[floor, mirror, pane], false).with_specular(vec![0.0, 0.75, 0.0], vec![0.0, 0.0, 0.5]);
    let light = |luminaire| Light { luminaire, strength: vec![4.0] };
    let position = DVec3::new(0.0, 0.0, 1.0);
    let point = Luminaire::Point { position };
    let tracer = paths(&enclosure, vec![0.0; 3], 0.0, vec![light(point)]);
    // Straight through the pane, and from (2, 0, 1), whose light reaches the mirror beside the pane.
    let truth = 4.0 * (0.5 + 0.75 / 5.0_f64.powf(1.5));
    let (value, error) = at(&tracer, DVec3::ZERO, DVec3::Z, 64);
    assert!((value - truth).abs() < 1e-4 && error < 1e-6, "{value} +- {error}, not {truth}");
    let sun = Luminaire::Directional { direction: DVec3::new(0.6, 0.0, -0.8) };
    let tracer = paths(&enclosure, vec![0.0; 3], 0.0, vec![light(sun)]);
    let (value, _) = at(&tracer, DVec3::new(0.9, 0.0, 0.0), DVec3::Z, 64);
    assert!((value - 4.0 * 0.8 * 1.75).abs() < 1e-5, "{value}");
}

/// The room with a sheet in it at `z`, of two sides.
fn with_sheet(z: f64) -> Enclosure {
    let sheet = rectangle([0.0, 0.0, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let polygons = [room(1), vec![sheet]].concat();
    let n = polygons.len();
    Enclosure::new(Patches::new(polygons, vec![0; n], vec![0; n], (0..n).map(|i| i == n - 1).collect()))
}

#[test]
fn furnaces_stay_even_with_sheets_that_light_passes_through() {
    let enclosure = with_sheet(0.4);
    for (rho, tau) in [(0.5, 0.3), (0.1, 0.7), (0.0, 0.8)] {
        let reflectance = [vec![0.8; 6], vec![rho; 2]].concat();
        let through = [vec![0.0; 6], vec![tau; 2]].concat();
        let tracer = Tracer::paths(&enclosure, 1, Exitance::Uniform(vec![1.0; 8]), reflectance, vec![], 4);
        let tracer = tracer.with_diffuse_transmittance(through);
        let measured = of_sides(&tracer, &Effort::of_samples(4096), &Control::default()).unwrap();
        // Everything sends back 0.8 of what meets it, by one way or the other: H = 1 / (1 - 0.8).
        let scores = z_scores(&measured, |_| 5.0, 1e-6);
        assert!(scores.iter().all(|z| z.abs() < 4.5), "{scores:?} {:?}", measured.irradiance);
    }
}

#[test]
fn a_sheet_over_a_lamp_sends_on_its_part() {
    // The lamp fills the floor of a black room; bands pass differently, and none is reflected.
    let enclosure = with_sheet(0.5);
    let facing = |z: f64| (0..6).find(|&side| enclosure.normal(side).z == z).expect("a face that looks that way");
    let (floor, ceiling) = (facing(1.0), facing(-1.0));
    let emission: Vec<f32> = (0..8).flat_map(|side| [if side == floor { 3.0 } else { 0.0 }; 2]).collect();
    let through: Vec<f32> = (0..8).flat_map(|side| if side >= 6 { [0.8, 0.2] } else { [0.0; 2] }).collect();
    let tracer = Tracer::paths(&enclosure, 2, Exitance::Uniform(emission), vec![0.0; 16], vec![], 4);
    let tracer = tracer.with_diffuse_transmittance(through);
    let measured = of_sides(&tracer, &Effort::of_samples(1 << 14), &Control::default()).unwrap();
    // Half way up, factors to floor and ceiling are the same, so that the mean over the ceiling is that of their square.
    let lamp = enclosure.patches().polygons[floor];
    let at = |i: usize| (i as f64 + 0.5) / 32.0;
    let factor = |i: usize, j: usize| point_to_polygon(DVec3::new(at(i), at(j), 0.5), -DVec3::Z, &lamp);
    let square =
        (0..32).flat_map(|i| (0..32).map(move |j| (i, j))).map(|(i, j)| factor(i, j).powi(2)).sum::<f64>() / 1024.0;
    for (band, tau) in [(0, 0.8), (1, 0.2)] {
        let (passed, error) = (measured.irradiance[2 * ceiling + band], measured.standard_error[2 * ceiling + band]);
        assert_within((passed, error), 3.0 * tau * square);
    }
}
