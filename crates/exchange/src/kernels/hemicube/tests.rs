//! What hemicubes of known scenes see.

use super::*;
use crate::kernels::point_to_polygon::point_to_polygon;
use proptest::prelude::*;
use radiosity_geometry::Patches;

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

/// Cuts a parallelogram into `n x n`, every other one into triangles.
fn cut(p: [DVec3; 4], n: usize) -> Vec<[DVec3; 4]> {
    let at = |i: usize, j: usize| {
        // Weights of all four corners, so that two faces compute the points of a common edge alike.
        let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
        p[0] * ((1. - s) * (1. - t)) + p[1] * (s * (1. - t)) + p[2] * (s * t) + p[3] * ((1. - s) * t)
    };
    let quad = |k: usize| {
        let (i, j) = (k % n, k / n);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    };
    let halves = |[a, b, c, d]: [DVec3; 4]| [[a, b, c, c], [a, c, d, d]];
    (0..n * n).flat_map(|k| if k % 2 == 0 { vec![quad(k)] } else { halves(quad(k)).to_vec() }).collect()
}

fn patches(polygons: Vec<[DVec3; 4]>, two_sided: bool) -> Patches {
    let n = polygons.len();
    Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![two_sided; n])
}

fn enclosure(polygons: Vec<[DVec3; 4]>) -> Enclosure {
    Enclosure::new(patches(polygons, false))
}

/// A unit cube with blocks that hang in it, nothing parallel to the walls about them.
fn room(n: usize) -> Enclosure {
    let mut polygons: Vec<_> = faces(DVec3::ZERO, DVec3::ONE, true).into_iter().flat_map(|f| cut(f, n)).collect();
    for (k, low) in [DVec3::new(0.3, 0.3, 0.2), DVec3::new(0.6, 0.1, 0.55)].into_iter().enumerate() {
        let turn = glam::DQuat::from_rotation_y(0.3 + k as f64) * glam::DQuat::from_rotation_x(0.2);
        let block = faces(DVec3::ZERO, DVec3::new(0.3, 0.3, 0.2), false);
        let place = |polygon: [DVec3; 4]| polygon.map(|p| low + turn * p);
        polygons.extend(block.into_iter().flat_map(|f| cut(place(f), 2)));
    }
    enclosure(polygons)
}

fn all_rows(enclosure: &Enclosure, settings: &Settings) -> Rows {
    rows(enclosure, settings, &Control::default()).unwrap()
}

fn sum(row: &[(u32, f64)]) -> f64 {
    row.iter().map(|(_, f)| f).sum()
}

fn factor(row: &[(u32, f64)], side: usize) -> f64 {
    row.iter().find(|(to, _)| *to as usize == side).map_or(0.0, |(_, f)| *f)
}

#[test]
fn every_row_of_a_closed_room_sums_to_one() {
    for enclosure in [enclosure(faces(DVec3::ZERO, DVec3::ONE, true)), room(1), room(5)] {
        for (resolution, positions) in [(8, 1), (10, 3), (128, 1), (130, 2)] {
            let rows = all_rows(&enclosure, &Settings { resolution, positions, seed: 5 });
            assert_eq!(rows.len(), enclosure.sides());
            for side in 0..rows.len() {
                let sum = sum(rows.row(side));
                assert!((sum - 1.0).abs() < 1e-12, "{resolution} {positions} {side}: {sum}");
                assert!(rows.row(side).windows(2).all(|w| w[0].0 < w[1].0));
                assert_eq!(factor(rows.row(side), side), 0.0);
            }
        }
    }
}

/// A square of half edge 1/2 about the origin that faces up.
fn floor() -> [DVec3; 4] {
    [DVec3::new(-0.5, -0.5, 0.), DVec3::new(0.5, -0.5, 0.), DVec3::new(0.5, 0.5, 0.), DVec3::new(-0.5, 0.5, 0.)]
}

fn row_of(enclosure: &Enclosure, side: usize, settings: &Settings) -> Vec<(u32, f64)> {
    rows_of(enclosure, &[side], settings, &Control::default()).unwrap().entries
}

#[test]
fn rows_converge_to_the_closed_form_at_the_rate_of_pixels() {
    let mut polygons: Vec<_> = faces(DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 1.0), true)
        .into_iter()
        .flat_map(|f| cut(f, 3))
        .collect();
    polygons.retain(|p| p.iter().any(|p| p.z > 0.0));
    polygons.insert(0, floor());
    let enclosure = enclosure(polygons);
    let truth: Vec<f64> = (0..enclosure.sides())
        .map(|side| point_to_polygon(DVec3::ZERO, DVec3::Z, enclosure.patches().corners(side)))
        .collect();
    let error = |resolution: usize| {
        let squares = (0..24).map(|seed| {
            let row = row_of(&enclosure, 0, &Settings { resolution, positions: 1, seed });
            (1..truth.len()).map(|side| (factor(&row, side) - truth[side]).powi(2)).sum::<f64>()
        });
        (squares.sum::<f64>() / (24 * truth.len()) as f64).sqrt()
    };
    let points: Vec<_> = (5..=10).map(|k| ((1 << k) as f64, error(1 << k))).map(|(r, e)| (r.ln(), e.ln())).collect();
    let slope = slope(&points);
    // Counting pixels in a shape errs by its perimeter at most (1/R) and as chance along it at best (1/R^1.5).
    assert!((-1.7..-0.7).contains(&slope), "{slope} {points:?}");
    assert!(points[5].1.exp() < 1e-4, "{points:?}");
}

/// The slope of the line through points by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p.0 - x) * (p.1 - y), b + (p.0 - x).powi(2)));
    xy / xx
}

#[test]
fn several_positions_converge_to_the_factor_between_areas() {
    let enclosure = enclosure(faces(DVec3::ZERO, DVec3::ONE, true));
    // Hottel's closed form for opposite squares at the distance of their edge.
    let opposite = 0.199_824_9;
    let settings = Settings { resolution: 64, positions: 256, seed: 3 };
    let row = row_of(&enclosure, 0, &settings);
    assert!((factor(&row, 1) - opposite).abs() < 1e-3, "{}", factor(&row, 1));
    // From the middle of the square alone it is a fifth too large.
    let row = row_of(&enclosure, 0, &Settings { positions: 1, ..settings });
    let centre = point_to_polygon(DVec3::new(0.5, 0.5, 0.), DVec3::Z, enclosure.patches().corners(1));
    assert!((factor(&row, 1) - centre).abs() < 5e-3, "{} {centre}", factor(&row, 1));
    assert!(centre > 1.15 * opposite);
}

#[test]
fn pixels_see_what_rays_through_them_hit() {
    let enclosure = room(4);
    for side in (0..enclosure.sides()).step_by(7) {
        let buffer = item_buffer(&enclosure, side, &Settings { resolution: 64, positions: 1, seed: 2 });
        let (mut wrong, mut deep, mut count) = (0, 0, 0);
        for (face, owners) in buffer.owner.iter().enumerate() {
            for (pixel, &owner) in owners.iter().enumerate() {
                let direction = buffer.direction(face, pixel / 64, pixel % 64).as_vec3();
                let ray = enclosure.ray(buffer.position + 1e-6 * buffer.axes[2], direction);
                let hit = enclosure.bvh().closest_hit(&ray);
                let expected = match enclosure.sight(direction, &hit) {
                    crate::enclosure::Sight::Side(side, ..) => side,
                    crate::enclosure::Sight::Back => ItemBuffer::BACK,
                    crate::enclosure::Sight::Escaped => ItemBuffer::NOTHING,
                };
                count += 1;
                wrong += usize::from(owner != expected);
                deep += usize::from(owner == expected && (buffer.depth[face][pixel] / hit.t - 1.0).abs() > 1e-3);
            }
        }
        // Rays start a little higher and are in single precision: a few in a thousand pass an edge on the other side.
        assert_eq!(count, 3 * 64 * 64);
        assert!(wrong * 500 < count && deep * 500 < count, "{side}: {wrong} and {deep} of {count}");
    }
}

#[test]
fn polygons_that_share_edges_cover_every_pixel_once() {
    let mut polygons: Vec<_> = faces(DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 1.0), true)
        .into_iter()
        .flat_map(|f| cut(f, 5))
        .collect();
    polygons.retain(|p| p.iter().any(|p| p.z > 0.0));
    for seed in 0..3 {
        let settings = Settings { resolution: 64, positions: 1, seed };
        let mut covered = [(); 5].map(|_| vec![0; 64 * 64]);
        for &polygon in &polygons {
            let buffer = item_buffer(&enclosure(vec![floor(), polygon]), 0, &settings);
            for (covered, owners) in covered.iter_mut().zip(&buffer.owner) {
                for (covered, &owner) in covered.iter_mut().zip(owners) {
                    *covered += usize::from(owner == 1);
                }
            }
        }
        assert!(covered[0].iter().all(|&times| times == 1));
        assert!(covered[1..].iter().all(|face| face[..64 * 32].iter().all(|&times| times == 1)));
    }
}

/// A unit square parallel to the floor at a height, facing down.
fn ceiling(z: f64) -> [DVec3; 4] {
    let [a, b, c, d] = floor().map(|p| p + z * DVec3::Z);
    [d, c, b, a]
}

#[test]
fn obstructions_and_backs_absorb() {
    let settings = Settings { resolution: 256, ..Settings::default() };
    let between = floor().map(|p| p + 0.5 * DVec3::Z);
    for between in [between, {
        let [a, b, c, d] = between;
        [d, c, b, a]
    }] {
        // Seen as an obstruction from both sides, it hides what is behind.
        let patches = patches(vec![floor(), ceiling(1.0)], false).with_obstructions(vec![between]);
        let enclosure = Enclosure::new(patches);
        assert!(row_of(&enclosure, 0, &settings).is_empty());
        let buffer = item_buffer(&enclosure, 0, &settings);
        let seen = |code: u32| buffer.owner.iter().flatten().filter(|&&owner| owner == code).count();
        assert_eq!(seen(ItemBuffer::BACK) + seen(ItemBuffer::NOTHING), 3 * 256 * 256);
        assert!(seen(ItemBuffer::BACK) > 256 * 256 / 2);
    }
    // A ceiling that turns its back on the floor is as black.
    let [a, b, c, d] = ceiling(1.0);
    assert!(row_of(&enclosure(vec![floor(), [d, c, b, a]]), 0, &settings).is_empty());
}

#[test]
fn where_a_back_and_a_front_lie_together_the_front_is_seen() {
    // A sheet of two one-sided squares, slanted so that depths round; the one that turns its back is drawn first.
    let slanted = ceiling(1.0).map(|p| p + (0.3 * p.x + 0.2 * p.y) * DVec3::Z);
    let [a, b, c, d] = slanted;
    let settings = Settings { resolution: 128, ..Settings::default() };
    let alone = row_of(&enclosure(vec![floor(), slanted]), 0, &settings);
    let sheet = row_of(&enclosure(vec![floor(), [c, b, a, d], [a, b, c, c], [a, c, d, d]]), 0, &settings);
    assert_eq!(sheet.len(), 2);
    assert!((sum(&sheet) - sum(&alone)).abs() < 1e-12, "{sheet:?} {alone:?}");
}

#[test]
fn an_obstruction_hides_its_part() {
    // A wall as high as the ceiling, off the middle of the floor: it hides the strip beyond the line of sight.
    let wall = [DVec3::new(0.1, -9., 0.), DVec3::new(0.1, 9., 0.), DVec3::new(0.1, 9., 0.5), DVec3::new(0.1, -9., 0.5)];
    let patches = patches(vec![floor(), ceiling(1.0)], false).with_obstructions(vec![wall]);
    let row = row_of(&Enclosure::new(patches), 0, &Settings { resolution: 1024, ..Settings::default() });
    let visible = ceiling(1.0).map(|p| DVec3::new(p.x.min(0.2), p.y, p.z));
    let expected = point_to_polygon(DVec3::ZERO, DVec3::Z, &visible);
    // An edge of n pixels' length is off by a pixel's width at most: 2/R along two edges of length 1 at 1/pi.
    assert!((row[0].1 - expected).abs() < 4.0 / 1024.0 / std::f64::consts::PI, "{row:?} {expected}");
}

#[test]
fn both_sides_of_a_two_sided_patch_see_and_are_seen() {
    let polygons = vec![floor(), floor().map(|p| p + DVec3::Z), ceiling(2.0)];
    let enclosure = Enclosure::new(Patches::new(polygons, vec![0; 3], vec![0, 1, 2], vec![false, true, false]));
    let back = enclosure.back_of(1).unwrap();
    let rows = all_rows(&enclosure, &Settings { resolution: 256, ..Settings::default() });
    let expected = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling(1.0));
    for (from, to) in [(0, back), (back, 0), (1, 2), (2, 1)] {
        let row = rows.row(from);
        assert_eq!(row.len(), 1, "{from}: {row:?}");
        assert_eq!(row[0].0 as usize, to);
        assert!((row[0].1 - expected).abs() < 2e-3, "{from}: {row:?} {expected}");
    }
}

#[test]
fn coplanar_patches_are_not_seen() {
    let twin = floor();
    let beside = floor().map(|p| p + DVec3::X);
    let lifted = floor().map(|p| p + DVec3::new(0., 1., 1e-8));
    let patches = patches(vec![floor(), twin, beside, lifted], true).with_obstructions(vec![twin]);
    let rows = all_rows(&Enclosure::new(patches), &Settings { resolution: 64, ..Settings::default() });
    assert!(rows.entries.is_empty(), "{:?}", rows.entries);
}

#[test]
fn rows_are_the_same_on_any_number_of_threads_and_in_any_company() {
    let enclosure = room(3);
    let settings = Settings { resolution: 64, positions: 2, seed: 11 };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| all_rows(&enclosure, &settings))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    let some = [5, 0, 17, 5];
    let rows = rows_of(&enclosure, &some, &settings, &Control::default()).unwrap();
    for (k, &side) in some.iter().enumerate() {
        assert_eq!(rows.row(k), one.row(side));
    }
    assert_ne!(one, all_rows(&enclosure, &Settings { seed: 12, ..settings }));
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let enclosure = room(3);
    let settings = Settings { resolution: 130, positions: 1, seed: 1 };
    let rows = |kernel: Kernel| -> Vec<_> {
        let scene = Scene::new(&enclosure, &settings, kernel);
        let mut hemicube = Hemicube::new(&scene);
        (0..enclosure.sides()).map(|side| hemicube.row(&scene, side)).collect()
    };
    let plain = rows(Kernel::Plain);
    for &kernel in Kernel::available() {
        assert_eq!(rows(kernel), plain, "{kernel:?}");
    }
}

#[test]
fn work_stops_on_request_and_counts_sides() {
    let enclosure = room(1);
    let settings = Settings { resolution: 8, ..Settings::default() };
    let control = Control::default();
    rows(&enclosure, &settings, &control).unwrap();
    assert_eq!(control.progress(), (enclosure.sides() as u64, enclosure.sides() as u64));
    control.cancel();
    assert_eq!(rows(&enclosure, &settings, &control), Err(Cancelled));
}

#[test]
fn degenerate_patches_see_nothing_and_are_not_seen() {
    let p = DVec3::new(0.1, 0.2, 0.4);
    let line = [p, p + DVec3::X, p + 2.0 * DVec3::X, p + 3.0 * DVec3::X];
    let mut polygons = faces(DVec3::ZERO, DVec3::ONE, true);
    polygons.extend([[p; 4], line]);
    let rows = all_rows(&enclosure(polygons), &Settings { resolution: 32, ..Settings::default() });
    assert!((0..6).all(|side| (sum(rows.row(side)) - 1.0).abs() < 1e-12 && rows.row(side).iter().all(|e| e.0 < 6)));
    assert!(rows.row(6).is_empty() && rows.row(7).is_empty());
    assert!(all_rows(&enclosure(Vec::new()), &Settings::default()).is_empty());
}

#[test]
fn polygons_through_the_position_and_the_horizon_leave_no_gap() {
    // Two squares that stand on the floor's middle, one of them reaching below: the position lies on both.
    let upright = |x: f64, y: f64, low: f64| {
        let d = DVec3::new(x, y, 0.0);
        [-d + low * DVec3::Z, d + low * DVec3::Z, d + 0.3 * DVec3::Z, -d + 0.3 * DVec3::Z]
    };
    let mut polygons = faces(DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 1.0), true);
    // Slanted and far larger than the room, but below the horizon of the floor in part: planes through its middle.
    polygons.extend([upright(0.3, 0.1, 0.0), upright(-0.1, 0.3, -0.2)]);
    let slanted = [
        DVec3::new(-0.4, 0.1, -0.3),
        DVec3::new(0.4, 0.1, -0.3),
        DVec3::new(0.4, 0.3, 0.5),
        DVec3::new(-0.4, 0.3, 0.5),
    ];
    polygons.push(slanted);
    let enclosure = Enclosure::new(patches(polygons, true));
    for resolution in [8, 64, 256] {
        let rows = all_rows(&enclosure, &Settings { resolution, ..Settings::default() });
        for side in 0..6 {
            let sum = sum(rows.row(side));
            assert!((sum - 1.0).abs() < 1e-12, "{resolution} {side}: {sum}");
        }
    }
}

#[test]
fn rooms_of_any_size_and_place_are_closed() {
    for (scale, place) in [(1e-6, 0.0), (1e6, 1e6), (1.0, 1e6), (1e60, 1e60)] {
        let polygons: Vec<_> = faces(DVec3::splat(place), DVec3::splat(place + scale), true);
        let rows = all_rows(&enclosure(polygons), &Settings { resolution: 64, ..Settings::default() });
        for side in 0..6 {
            let sum = sum(rows.row(side));
            assert!((sum - 1.0).abs() < 1e-12, "{scale} {place} {side}: {sum}");
        }
    }
    // Beyond what doubles can square there is no area, and nothing to see; but no panic.
    let polygons = faces(DVec3::splat(-1e100), DVec3::splat(1e200), true);
    assert!(all_rows(&enclosure(polygons), &Settings { resolution: 8, ..Settings::default() }).entries.is_empty());
}

#[test]
fn the_unfolded_hemicube_is_continuous_at_the_edges_of_its_top() {
    let resolution = 16;
    let mut buffer = item_buffer(&enclosure(vec![floor()]), 0, &Settings { resolution, ..Settings::default() });
    assert!(buffer.owner.iter().flatten().all(|&owner| owner == ItemBuffer::NOTHING));
    assert!(buffer.depth.iter().flatten().all(|depth| depth.is_infinite()));
    for (face, owners) in buffer.owner.iter_mut().enumerate() {
        *owners = (0..owners.len()).map(|pixel| (face * 1000 + pixel) as u32).collect();
    }
    let picture = buffer.unfolded();
    let size = 2 * resolution;
    let direction = |x: usize, y: usize| {
        let code = picture[y * size + x] as usize;
        (code < 5000)
            .then(|| buffer.direction(code / 1000, code % 1000 / resolution, code % 1000 % resolution).normalize())
    };
    let mut pixels = 0;
    for (x, y) in (0..size - 1).flat_map(|x| (0..size - 1).map(move |y| (x, y))) {
        let Some(here) = direction(x, y) else { continue };
        pixels += 1;
        for there in [direction(x + 1, y), direction(x, y + 1)].into_iter().flatten() {
            // Not more than the diagonal of a pixel apart.
            assert!(
                here.angle_between(there) < 2.0 * std::f64::consts::SQRT_2 / resolution as f64,
                "{x} {y} {here} {there}"
            );
        }
    }
    assert!(pixels > 3 * resolution * resolution - 4 * resolution);
}

#[test]
#[should_panic(expected = "even and in 8..=4096, not 9")]
fn odd_resolutions_are_refused() {
    all_rows(&room(1), &Settings { resolution: 9, ..Settings::default() });
}

/// Whether the ray from the origin meets a triangle; nothing where that is a matter of rounding.
fn meets(direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<bool> {
    let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|n| direction.dot(n));
    let total = a.dot(b.cross(c));
    if volumes.iter().chain([&total]).any(|v| v.abs() < 1e-9) {
        return None;
    }
    Some(volumes.iter().all(|v| (*v > 0.0) == (total > 0.0)))
}

fn anywhere() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

proptest! {
    #[test]
    fn a_triangle_anywhere_covers_the_pixels_whose_rays_meet_it(a in anywhere(), b in anywhere(), c in anywhere(), seed: u64) {
        let settings = Settings { resolution: 32, positions: 1, seed };
        let buffer = item_buffer(&enclosure(vec![floor(), [a, b, c, c]]), 0, &settings);
        let facing = a.dot((b - a).cross(c - a)) < 0.0;
        let owner = if facing { 1 } else { ItemBuffer::BACK };
        let highest = a.z.max(b.z).max(c.z);
        for (face, owners) in buffer.owner.iter().enumerate() {
            for (pixel, &seen) in owners.iter().enumerate() {
                let direction = buffer.direction(face, pixel / 32, pixel % 32);
                let Some(meets) = meets(direction, [a, b, c]).map(|meets| meets && highest > 1e-6) else { continue };
                prop_assert_eq!(seen, if meets { owner } else { ItemBuffer::NOTHING }, "{} {}", face, pixel);
            }
        }
    }

    #[test]
    fn a_room_full_of_anything_is_closed(corners in prop::collection::vec(anywhere(), 4..60), seed: u64) {
        let mut polygons = faces(DVec3::splat(-1.0), DVec3::ONE, true);
        // Quadrangles of random corners are neither planar nor convex.
        polygons.extend(corners.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]));
        let enclosure = Enclosure::new(patches(polygons, true));
        let rows = all_rows(&enclosure, &Settings { resolution: 16, positions: 1, seed });
        for side in 0..6 {
            let sum = sum(rows.row(side));
            prop_assert!((sum - 1.0).abs() < 1e-12, "{}: {}", side, sum);
        }
    }
}
