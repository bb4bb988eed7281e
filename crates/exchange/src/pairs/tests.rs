use super::*;
use radiosity_geometry::Patches;

const OPPOSITE: f64 = 0.199_824_895_698_387_46;
const ADJACENT: f64 = 0.200_043_776_075_403_16;

fn p(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A face by a corner and two edges, cut into `n x m`.
#[derive(Clone, Copy)]
struct Grid(DVec3, DVec3, DVec3, usize, usize);

fn patches(faces: &[Grid]) -> Patches {
    let (mut polygons, mut face) = (Vec::new(), Vec::new());
    for (k, Grid(o, u, v, n, m)) in faces.iter().enumerate() {
        let (u, v) = (*u / *n as f64, *v / *m as f64);
        for (i, j) in (0..n * m).map(|c| (c % n, c / n)) {
            let a = *o + i as f64 * u + j as f64 * v;
            polygons.push([a, a + u, a + u + v, a + v]);
            face.push(k as u32);
        }
    }
    let count = polygons.len();
    Patches::new(polygons, vec![0; count], face, vec![false; count])
}

/// The six faces of a box, seen from inside or outside.
fn faces_of_box(low: DVec3, high: DVec3, inward: bool, n: usize) -> Vec<Grid> {
    let d = high - low;
    let (x, y, z) = (p(d.x, 0., 0.), p(0., d.y, 0.), p(0., 0., d.z));
    let faces = [(low, x, y), (low, y, z), (low, z, x), (low + z, y, x), (low + x, z, y), (low + y, x, z)];
    faces.map(|(o, u, v)| if inward { Grid(o, u, v, n, n) } else { Grid(o, v, u, n, n) }).to_vec()
}

fn exchange(patches: &Patches, kernel: Kernel, tolerance: f64) -> (Symmetric, Tally) {
    let enclosure = Enclosure::new(patches.clone());
    measure(&enclosure, &Settings { kernel, tolerance, seed: 0 }, &Control::default()).unwrap()
}

fn closure(patches: &Patches, g: &Symmetric) -> f64 {
    use radiosity_operator::Operator;
    g.row_sums().iter().zip(&patches.area).map(|(s, a)| (s / a - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn the_faces_of_a_cube_by_every_kernel() {
    let patches = patches(&faces_of_box(DVec3::ZERO, DVec3::ONE, true, 1));
    for (kernel, error) in [
        (Kernel::Auto, 1e-6),
        (Kernel::Contour, 1e-12),
        (Kernel::Analytic, 1e-12),
        (Kernel::Nusselt(PlaneRule::new(8)), 3e-3),
    ] {
        let (g, _) = exchange(&patches, kernel.clone(), 1e-6);
        for i in 0..6 {
            for (j, f) in g.row(i) {
                let exact = if (i as u32 + 3) % 6 == j { OPPOSITE } else { ADJACENT };
                assert!((f - exact).abs() < error, "{kernel:?}: {i} {j} {f}");
            }
        }
    }
}

#[test]
fn a_fine_cube_adds_up() {
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-9] {
        let patches = patches(&faces_of_box(DVec3::ZERO, DVec3::ONE, true, 7));
        let (g, tally) = exchange(&patches, Kernel::Auto, tolerance);
        let worst = closure(&patches, &g);
        println!("{tolerance} {worst} {tally:?}");
        assert!(worst < tolerance);
        assert_eq!(tally.partial + tally.hidden, 0);
    }
}

#[test]
fn a_plate_between_squares() {
    // Howell has no such case; the smooth four-dimensional integral by Gauss-Legendre is 0.09950629459898.
    let mut patches = patches(&[
        Grid(p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), 1, 1),
        Grid(p(0., 0., 1.), p(0., 1., 0.), p(1., 0., 0.), 1, 1),
    ]);
    patches.obstructions = vec![[p(0.25, 0.25, 0.5), p(0.75, 0.25, 0.5), p(0.75, 0.75, 0.5), p(0.25, 0.75, 0.5)]];
    for (kernel, error) in [(Kernel::Auto, 1e-7), (Kernel::Contour, 1e-7)] {
        let start = std::time::Instant::now();
        let (g, tally) = exchange(&patches, kernel, 1e-7);
        let f = g.row(0)[0].1;
        println!("{f} {:e} {tally:?} {:?}", f - 0.09950629459898, start.elapsed());
        assert!((f - 0.09950629459898).abs() < error, "{f}");
    }
}

#[test]
fn a_room_with_a_box_adds_up() {
    let mut faces = faces_of_box(DVec3::ZERO, p(2., 3., 2.5), true, 3);
    faces.extend(faces_of_box(p(0.7, 1.1, 0.8), p(1.3, 1.9, 1.4), false, 2));
    let patches = patches(&faces);
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let start = std::time::Instant::now();
        let (g, tally) = exchange(&patches, Kernel::Auto, tolerance);
        let worst = closure(&patches, &g);
        println!("{tolerance} {worst} {tally:?} {:?}", start.elapsed());
        assert!(worst < tolerance);
        assert_eq!(tally.unresolved, 0);
    }
}
