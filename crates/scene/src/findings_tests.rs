use radiosity_geometry::texture::Raster;

use super::*;
use crate::model::{Face, Material};

const WHITE: [f64; 3] = [0.7, 0.7, 0.7];
const BRIGHT: [f64; 3] = [1.0, 2.0, 3.0];

fn square() -> Surface {
    surface(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]], &[[0, 1, 2, 3]])
}

fn surface(vertices: &[[f64; 3]], faces: &[Face]) -> Surface {
    Surface {
        name: "square".into(),
        vertices: vertices.iter().map(|&v| DVec3::from_array(v)).collect(),
        faces: faces.to_vec(),
        material: Material::new("paint", &WHITE, &BRIGHT),
        texture: None,
    }
}

fn scene(surfaces: Vec<Surface>) -> Scene {
    Scene { name: "test".into(), bands: ["R", "G", "B"].map(String::from).to_vec(), surfaces, ..Scene::default() }
}

/// The only finding of a scene.
fn only(scene: &Scene) -> Finding {
    let mut found = scene.findings();
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

fn with_vertices(vertices: &[[f64; 3]]) -> Finding {
    only(&scene(vec![surface(vertices, &[[0, 1, 2, 3]])]))
}

#[test]
fn sound_scene_has_no_findings() {
    let scene = scene(vec![square()]);
    assert_eq!(scene.findings(), vec![]);
    assert!(scene.validate().is_ok());
}

#[test]
fn non_finite_vertices_are_named() {
    let found = with_vertices(&[[0., 0., 0.], [1., f64::NAN, 0.], [1., 1., 0.], [0., 1., 0.]]);
    assert_eq!((found.severity, found.code), (Severity::Error, "non-finite-vertex"));
    assert_eq!((found.place.surface, &found.place.faces[..]), (Some(0), &[0][..]));
    assert_eq!(found.element, "surface 'square', vertex 1");
}

#[test]
fn index_out_of_range_names_the_face() {
    let mut bad = square();
    bad.faces.push([0, 1, 4, 4]);
    let found = only(&scene(vec![bad]));
    assert_eq!((found.code, found.element.as_str()), ("index-out-of-range", "surface 'square', face 1"));
}

#[test]
fn scene_without_faces_is_an_error() {
    let error = scene(vec![]).validate_geometry().unwrap_err();
    assert!(error.to_string().starts_with("test: the scene has no faces"), "{error}");
}

#[test]
fn surface_without_faces_is_a_warning() {
    let mut empty = square();
    empty.faces.clear();
    empty.name = "empty".into();
    let found = only(&scene(vec![square(), empty]));
    assert_eq!((found.severity, found.code), (Severity::Warning, "empty-surface"));
}

#[test]
fn zero_area_faces_are_counted() {
    let mut thin = square();
    thin.faces.extend([[0, 0, 1, 1], [2, 2, 2, 2]]);
    let found = only(&scene(vec![thin]));
    assert_eq!((found.severity, found.code), (Severity::Warning, "zero-area-faces"));
    assert!(found.message.starts_with("2 of 3 faces"), "{}", found.message);
}

#[test]
fn bent_quad_says_by_how_much() {
    let found = with_vertices(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.4], [0., 1., 0.]]);
    assert_eq!((found.severity, found.code), (Severity::Error, "non-planar-face"));
    assert!(found.message.contains("e-2 m") || found.message.contains("e-1 m"), "{}", found.message);
}

#[test]
fn folded_quads_are_errors() {
    let found = with_vertices(&[[0., 0., 0.], [1., 1., 0.], [1., 0., 0.], [0., 1., 0.]]);
    assert_eq!((found.severity, found.code), (Severity::Error, "non-convex-face"));
}

#[test]
fn reflectance_must_stay_below_one() {
    for bad in [1.0, -0.1, f64::NAN, 1.5] {
        let mut shiny = square();
        shiny.material.reflectance[1] = bad;
        let found = only(&scene(vec![shiny]));
        assert_eq!((found.severity, found.code), (Severity::Error, "reflectance-range"), "{bad}");
        assert!(found.message.contains("band G"), "{}", found.message);
    }
}

#[test]
fn high_reflectance_is_a_note() {
    let mut bright = square();
    bright.material.reflectance[0] = 0.97;
    assert_eq!(only(&scene(vec![bright])).severity, Severity::Note);
}

#[test]
fn emission_must_be_finite_and_positive() {
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let mut lamp = square();
        lamp.material.emission[2] = bad;
        assert_eq!(only(&scene(vec![lamp])).code, "emission-range", "{bad}");
    }
}

#[test]
fn spectra_have_one_value_per_band() {
    let mut short = square();
    short.material.reflectance.pop();
    let found = only(&scene(vec![short]));
    assert_eq!((found.severity, found.code), (Severity::Error, "spectrum-length"));
}

#[test]
fn missing_light_spoils_the_light_and_not_the_geometry() {
    let mut dark = square();
    dark.material.emission = vec![0.0; 3];
    let mut scene = scene(vec![dark]);
    assert_eq!(only(&scene).code, "no-light");
    assert!(scene.validate().is_err() && scene.validate_geometry().is_ok());

    let (name, position) = ("bulb".to_string(), DVec3::Z);
    scene.lights.push(Light::Point { name, position, intensity: vec![1.0; 3] });
    assert!(scene.validate().is_ok());
}

#[test]
fn dark_light_is_a_warning() {
    let mut scene = scene(vec![square()]);
    let (name, position) = ("bulb".to_string(), DVec3::Z);
    scene.lights.push(Light::Point { name, position, intensity: vec![0.0; 3] });
    assert_eq!(only(&scene).code, "dark-light");
}

#[test]
fn spot_cone_and_direction_are_checked() {
    let spot = |direction, inner_angle, outer_angle| Light::Spot {
        name: "spot".into(),
        position: DVec3::ZERO,
        direction,
        intensity: vec![1.0; 3],
        inner_angle,
        outer_angle,
    };
    assert_eq!(misplaced(&spot(DVec3::Z, 0.2, 0.4)), None);
    assert!(misplaced(&spot(DVec3::Z, 0.5, 0.4)).is_some());
    assert!(misplaced(&spot(DVec3::Z, 0.0, 2.0)).is_some());
    assert!(misplaced(&spot(2.0 * DVec3::Z, 0.2, 0.4)).is_some());
    assert!(misplaced(&spot(DVec3::NAN, 0.2, 0.4)).is_some());
}

#[test]
fn coincident_faces_are_found_in_any_orientation() {
    for (face, code) in [([2, 3, 0, 1], "duplicate-faces"), ([1, 0, 3, 2], "coincident-opposite")] {
        let mut twin = square();
        (twin.name, twin.faces) = ("twin".into(), vec![face]);
        let found = only(&scene(vec![square(), twin]));
        assert_eq!((found.severity, found.code), (Severity::Warning, code));
        assert!(found.element.contains("'twin'") && found.message.contains("'square'"));
    }
}

#[test]
fn coincident_triangles_may_repeat_different_corners() {
    let positions = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let twice = surface(&positions, &[[0, 1, 2, 2], [1, 2, 0, 0], [0, 2, 3, 3]]);
    assert_eq!(only(&scene(vec![twice])).code, "duplicate-faces");
}

#[test]
fn implausible_sizes_suggest_the_unit() {
    for scale in [1e-5, 1e4] {
        let mut odd = square();
        odd.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
        let found = only(&scene(vec![odd]));
        assert_eq!((found.severity, found.code), (Severity::Warning, "implausible-size"));
        assert!(found.message.contains("--unit"), "{}", found.message);
    }
}

#[test]
fn unused_vertices_and_repeated_names_are_noticed() {
    let mut loose = square();
    loose.vertices.push(DVec3::Z);
    assert_eq!(only(&scene(vec![loose])).code, "unused-vertices");

    let mut shifted = square();
    shifted.vertices.iter_mut().for_each(|vertex| vertex.z += 1.0);
    assert_eq!(only(&scene(vec![square(), shifted])).code, "repeated-name");
}

#[test]
fn findings_print_as_one_line() {
    let found = Finding::warning("dark-light", "light 'a'", "its intensity is zero");
    assert_eq!(found.to_string(), "warning [dark-light]: light 'a': its intensity is zero");
}

#[test]
fn obstructions_are_checked_by_their_shapes_and_nothing_else() {
    let mut sheet = square();
    (sheet.name, sheet.material) = ("screen".into(), Material::default());
    sheet.vertices.iter_mut().for_each(|vertex| vertex.z += 1.0);
    let mut scene = scene(vec![square()]);
    scene.obstructions.push(sheet);
    assert_eq!(scene.findings(), vec![]);

    scene.obstructions[0].vertices[2].z += 0.4;
    let found = only(&scene);
    assert_eq!((found.code, found.element.as_str()), ("non-planar-face", "obstruction 'screen', face 0"));
    scene.obstructions[0].faces[0][1] = 9;
    assert_eq!(only(&scene).code, "index-out-of-range");
    scene.obstructions[0].vertices[0].x = f64::NAN;
    assert!(scene.validate_geometry().unwrap_err().to_string().contains("obstruction 'screen', vertex 0"));
}

#[test]
fn combined_surfaces_exist_and_do_not_chain() {
    let mut above = square();
    above.name = "above".into();
    above.vertices.iter_mut().for_each(|vertex| vertex.z += 1.0);
    let mut scene = scene(vec![square(), above]);
    for (pairs, sound) in [(vec![(1, 0)], true), (vec![(1, 1)], false), (vec![(2, 0)], false), (vec![(0, 2)], false)] {
        scene.combined = pairs.into_iter().collect();
        assert_eq!(scene.findings().is_empty(), sound, "{:?}", scene.combined);
    }
    scene.combined = [(0, 1), (1, 0)].into_iter().collect();
    assert!(scene.findings().iter().all(|found| found.code == "combined-surfaces"));
}

/// The faces of a unit cube, looking outward.
fn cube() -> Surface {
    let corner = |i: u32| [0, 1, 2].map(|axis| f64::from(i >> axis & 1));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    surface(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), &faces)
}

/// The same, looking inward.
fn room() -> Surface {
    let mut room = cube();
    room.faces.iter_mut().for_each(|face| face.reverse());
    room
}

#[test]
fn enclosures_look_inward() {
    let found = scene(vec![cube()]).enclosure_findings();
    assert_eq!((found.len(), found[0].severity, found[0].code), (1, Severity::Warning, "looking-outward"));

    // One wall that is a surface by itself and turned.
    let (mut walls, mut lid) = (room(), room());
    lid.name = "lid".into();
    lid.faces = walls.faces.split_off(5);
    lid.faces[0].reverse();
    let mut scene = scene(vec![walls, lid]);
    assert!(scene.findings().iter().all(|found| found.code == "unused-vertices"), "{:?}", scene.findings());
    let found = scene.enclosure_findings();
    assert_eq!((found.len(), found[0].code, found[0].element.as_str()), (1, "mixed-winding", "surface 'lid'"));
    scene.surfaces[1].material.two_sided = true;
    assert_eq!(scene.enclosure_findings(), vec![]);
}

#[test]
fn neighbours_wind_alike() {
    assert_eq!(scene(vec![cube()]).findings(), vec![]);
    let mut mixed = cube();
    mixed.faces[1].reverse();
    let found = only(&scene(vec![mixed.clone()]));
    assert_eq!((found.severity, found.code), (Severity::Warning, "mixed-winding"));
    assert_eq!(found.element, "surface 'square', face 1");
    assert_eq!((found.place.surface, &found.place.faces[..], found.place.edges.len()), (Some(0), &[1][..], 4));

    // Whoever sees both sides of a face need not care.
    mixed.material.two_sided = true;
    assert_eq!(scene(vec![mixed]).findings(), vec![]);
}

#[test]
fn closed_spaces_have_no_open_edges() {
    assert_eq!(scene(vec![room()]).enclosure_findings(), vec![]);

    let mut open = room();
    open.faces.remove(1);
    let mut scene = scene(vec![open]);
    assert_eq!(scene.findings(), vec![]);
    let found = scene.enclosure_findings();
    assert_eq!((found.len(), found[0].severity, found[0].code), (1, Severity::Note, "open-edges"));
    assert!(found[0].message.starts_with("4 edges belong to one face only, first the one at ("), "{}", found[0]);
    assert!(found[0].message.contains("1.0000);"), "the lid is at z = 1: {}", found[0]);
    assert_eq!((found[0].element.as_str(), found[0].place.edges.len()), ("surface 'square', face 1", 4));
    assert!(found[0].place.edges.iter().flatten().all(|end| end.z == 1.0));
    scene.hints.enclosure = true;
    assert_eq!(only(&scene).code, "open-edges");
}

#[test]
fn holes_are_told_apart() {
    let mut open = room();
    open.faces.truncate(4);
    let found = scene(vec![open]).enclosure_findings();
    let rims: Vec<_> = found.iter().map(|found| (found.code, found.place.edges.len())).collect();
    assert_eq!(rims, [("open-edges", 4), ("open-edges", 4)]);
}

#[test]
fn the_larger_part_of_a_shell_says_which_way_it_winds() {
    let mut mixed = cube();
    [0, 1, 2, 3].into_iter().for_each(|f: usize| mixed.faces[f].reverse());
    let found = only(&scene(vec![mixed]));
    assert_eq!(
        (found.element.as_str(), &found.place.faces[..]),
        ("surface 'square', face 4 (and 1 more)", &[4, 5][..])
    );
}

#[test]
fn slivers_are_noted() {
    let needle = |width: f64| with_vertices(&[[0., 0., 0.], [2., 0., 0.], [2., width, 0.], [0., width, 0.]]);
    let found = needle(5e-4);
    assert_eq!((found.severity, found.code), (Severity::Note, "sliver-faces"));
    assert_eq!((found.place.surface, &found.place.faces[..]), (Some(0), &[0][..]));
    assert!(found.message.starts_with("it is 5.0e-4 m wide"), "{found}");
    let strip = surface(&[[0., 0., 0.], [2., 0., 0.], [2., 3e-3, 0.], [0., 3e-3, 0.]], &[[0, 1, 2, 3], [0, 1, 2, 2]]);
    assert!(scene(vec![strip]).findings().iter().all(|found| found.code != "sliver-faces"));
}

#[test]
fn a_wall_that_floats_leaves_a_gap() {
    let wall = |height: f64, x: f64| {
        let corners = [[x, 0., height], [x, 1., height], [x, 1., 1.], [x, 0., 1.]];
        let mut wall = surface(&corners, &[[0, 1, 2, 3]]);
        wall.name = "wall".into();
        scene(vec![square(), wall])
    };
    for x in [0.0, 0.4, 1.001] {
        let found = only(&wall(1e-3, x));
        assert_eq!((found.severity, found.code), (Severity::Warning, "narrow-gap"), "{x}");
        assert!(found.element.starts_with("surface '") && found.message.contains("light leaks in between"), "{found}");
        assert_eq!(found.place.points.len(), 2);
        assert!(found.place.points[0].distance(found.place.points[1]) < 2e-3);
    }
    // Those that touch, and those that are well apart.
    for (height, x) in [(0.0, 0.0), (0.0, 0.4), (0.1, 0.0)] {
        assert_eq!(wall(height, x).findings(), vec![], "{height} {x}");
    }
}

#[test]
fn a_slit_between_two_halves_is_a_gap_and_a_panel_on_a_wall_is_none() {
    let beside = |x: f64, z: f64, scale: f64| {
        let mut other = square();
        other.name = "other".into();
        other.vertices.iter_mut().for_each(|vertex| *vertex = scale * *vertex + DVec3::new(x, 0.25 * (1.0 - scale), z));
        scene(vec![square(), other])
    };
    let found = only(&beside(1.001, 0.0, 1.0));
    assert_eq!((found.code, found.place.edges.len()), ("narrow-gap", 2));
    assert_eq!(beside(0.25, 0.001, 0.5).findings(), vec![]);
}

#[test]
fn a_body_that_was_set_down_a_little_above_the_floor_is_no_gap() {
    let mut body = cube();
    body.name = "body".into();
    body.faces.remove(0);
    body.vertices.iter_mut().for_each(|vertex| *vertex = 0.2 * *vertex + DVec3::new(0.4, 0.4, 1e-3));
    assert_eq!(scene(vec![square(), body]).findings(), vec![]);

    // Walls and a floor that end at one another are another matter.
    let (mut walls, mut floor) = (cube(), square());
    walls.faces.remove(0);
    walls.vertices.iter_mut().for_each(|vertex| vertex.z += 1e-3);
    floor.name = "floor".into();
    assert_eq!(only(&scene(vec![walls, floor])).code, "narrow-gap");
}

#[test]
fn lamps_have_an_area() {
    let mut thread = square();
    thread.faces = vec![[0, 1, 1, 0]];
    let codes: Vec<_> = scene(vec![square(), thread]).findings().into_iter().map(|found| found.code).collect();
    assert!(codes.contains(&"lamp-without-area"), "{codes:?}");
}

#[test]
fn sizes_of_rooms_in_other_units_are_recognised() {
    let sized = |metres: f64| {
        let mut odd = square();
        odd.vertices.iter_mut().for_each(|vertex| *vertex *= metres);
        only(&scene(vec![odd])).message
    };
    // A square of 4 km is 5.657 km across, one of 4 mm 5.657 mm.
    assert!(sized(4000.0).contains("--unit mm would make it 5.657 m across"), "{}", sized(4000.0));
    assert!(sized(0.004).contains("--unit km would make it 5.657 m across"), "{}", sized(0.004));
}

#[test]
fn edges_may_meet_the_middle_of_others() {
    let mut parts = room();
    parts.faces.remove(1);
    // The lid in two halves, whose corners are in the middle of edges of the walls.
    let lid = [[0., 0., 1.], [0.5, 0., 1.], [1., 0., 1.], [1., 1., 1.], [0.5, 1., 1.], [0., 1., 1.]];
    parts.vertices.extend(lid.map(DVec3::from_array));
    parts.faces.extend([[13, 12, 9, 8], [12, 11, 10, 9]]);
    assert_eq!(scene(vec![parts.clone()]).enclosure_findings(), vec![]);
    parts.faces.pop();
    assert!(scene(vec![parts]).enclosure_findings()[0].message.starts_with("4 edges"));
}

#[test]
fn crowded_edges_are_noted() {
    let mut walled = room();
    walled.faces.push([0, 1, 7, 6]);
    let found = scene(vec![walled]).enclosure_findings();
    // The other two edges of the wall end in the middle of two sides.
    let codes: Vec<_> = found.iter().map(|found| found.code).collect();
    assert_eq!(codes, ["open-edges", "open-edges", "non-manifold-edges"]);
    assert!(found[2].message.starts_with("more than two faces meet at 2 edges"), "{}", found[2]);
    assert_eq!(found[2].place.edges.len(), 2);
}

#[test]
fn overlaps_in_one_plane_are_found() {
    let placed = |x: f64, y: f64, z: f64, faces: &[Face]| {
        let mut other = square();
        other.name = "other".into();
        other.vertices.iter_mut().for_each(|vertex| *vertex += DVec3::new(x, y, z));
        other.faces = faces.to_vec();
        scene(vec![square(), other])
    };
    let found = only(&placed(0.5, 0.25, 0.0, &[[0, 1, 2, 3]]));
    assert_eq!((found.severity, found.code), (Severity::Warning, "overlapping-faces"));
    assert_eq!(found.element, "surface 'other', face 0");
    assert!(found.message.contains("face 0 of 'square'"));
    assert_eq!((found.place.surface, &found.place.faces[..]), (Some(1), &[0][..]));
    let outline = found.place.edges.iter().map(|[a, b]| a.distance(*b)).sum::<f64>();
    assert!((outline - 2.0 * (0.5 + 0.75)).abs() < 1e-9, "the outline of what is covered twice: {outline}");
    // Neighbours, faces above one another, and what stands on a floor.
    for (x, z, face) in [(1.0, 0.0, [0, 1, 2, 3]), (0.5, 1e-3, [0, 1, 2, 3]), (0.5, 0.0, [3, 2, 1, 0])] {
        assert_eq!(placed(x, 0.0, z, &[face]).findings(), vec![]);
    }
    let codes = placed(0.0, 0.0, 0.0, &[[0, 1, 2, 2]]).findings().into_iter().map(|found| found.code);
    assert_eq!(codes.collect::<Vec<_>>(), ["unused-vertices", "overlapping-faces"]);
}

#[test]
fn rules_about_neighbours_wait_for_sound_indices() {
    let mut bad = cube();
    bad.faces[3][2] = 99;
    let scene = scene(vec![bad]);
    assert_eq!(only(&scene).code, "index-out-of-range");
    assert_eq!(scene.enclosure_findings(), vec![]);
}

proptest::proptest! {
    /// Any faces over the corners of a grid, flat, folded and on top of one another.
    #[test]
    fn no_faces_panic(
        faces in proptest::collection::vec(proptest::array::uniform4(0_u32..18), 0..40),
        two_sided: bool,
    ) {
        let corner = |i: u32| [f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)];
        let vertices: Vec<_> = (0..18).map(corner).collect();
        let mut soup = surface(&vertices, &faces);
        soup.material.two_sided = two_sided;
        let mut scene = scene(vec![soup.clone(), soup]);
        scene.hints.enclosure = true;
        scene.findings();
    }
}

/// The only finding of a square with such a mirror reflectance, transmittance and paint.
fn of_parts(specular: f64, transmittance: f64, reflectance: f64, emission: f64) -> Vec<Finding> {
    let material =
        Material::new("paint", &[0.0, reflectance, 0.0], &[emission; 3]).with_specular(specular, transmittance);
    let mut found = scene(vec![Surface { material, ..square() }]).findings();
    found.retain(|finding| finding.code != "no-light");
    found
}

#[test]
fn mirrors_glass_and_paint_share_what_meets_them() {
    assert_eq!(of_parts(0.3, 0.3, 0.39, 1.0), vec![]);
    assert_eq!(of_parts(0.7, 0.3, 0.0, 0.0), vec![], "an ideal mirror and pane");
    let found = of_parts(0.5, 0.2, 0.3, 1.0).remove(0);
    assert_eq!((found.code, found.severity), ("specular-sum", Severity::Error));
    assert!(
        found.element == "surface 'square'" && found.message.contains("below 1") && found.message.contains("band G")
    );
    assert_eq!(of_parts(0.8, 0.3, 0.0, 0.0).remove(0).code, "specular-sum");
    assert_eq!(of_parts(1.0, 0.0, 0.0, 1.0).remove(0).code, "specular-lamp");
    for (specular, transmittance) in [(1.1, 0.0), (-0.1, 0.0), (0.0, f64::NAN), (0.0, 2.0)] {
        assert_eq!(of_parts(specular, transmittance, 0.0, 1.0).remove(0).code, "specular-range");
    }
}

#[test]
fn what_passes_diffusely_is_a_part_that_needs_a_back() {
    let found = |material: Material| {
        let mut found = scene(vec![Surface { material, ..square() }]).findings();
        found.retain(|finding| finding.code != "no-light");
        found
    };
    let paper =
        |rho: f64, tau: f64| Material::new("paper", &[rho; 3], &[0.0; 3]).with_diffuse_transmittance(&[0.1, tau, 0.1]);
    assert_eq!(found(paper(0.4, 0.5)), vec![]);
    let sum = found(paper(0.5, 0.5)).remove(0);
    assert_eq!((sum.code, sum.severity), ("translucent-sum", Severity::Error));
    assert!(sum.message.contains("diffuse transmittance 0.5 in band G make 1;"), "{sum}");
    let codes = |material| found(material).into_iter().map(|finding| finding.code).collect::<Vec<_>>();
    assert_eq!(codes(paper(0.5, -0.1)), ["translucent-range"]);
    assert_eq!(codes(paper(0.3, 0.4).with_specular(0.2, 0.2)), ["specular-sum"]);
    assert_eq!(codes(Material { two_sided: false, ..paper(0.5, 0.2) }), ["translucent-one-sided"]);
    assert_eq!(codes(Material { diffuse_transmittance: vec![0.1], ..paper(0.5, 0.2) }), ["spectrum-length"]);
}

#[test]
fn textures_must_fit_their_surface_and_the_bands() {
    let image = |channels: usize| std::sync::Arc::new(Raster::of_values([1, 1], channels, vec![0.5; channels]));
    let found = |image, coordinates: Vec<[f64; 2]>| {
        let texture = Some(Texture { image, coordinates });
        let scene = scene(vec![Surface { texture, ..square() }]);
        assert_eq!(scene.textured_faces().is_err(), scene.validate().is_err());
        scene.findings().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert!(found(image(3), vec![[0.0; 2]; 4]).is_empty() && found(image(1), vec![[0.0; 2]; 4]).is_empty());
    let three = found(image(3), vec![[0.0; 2]; 3]);
    assert!(three[0].contains("surface 'square': it has 3 texture coordinates for 4 vertices"), "{three:?}");
    assert!(found(image(3), vec![[f64::NAN; 2]; 4])[0].contains("texture coordinate 0 is not finite"));
    let mut grey = scene(vec![Surface {
        texture: Some(Texture { image: image(3), coordinates: vec![[0.0; 2]; 4] }),
        material: Material::new("paint", &[0.5], &[1.0]),
        ..square()
    }]);
    grey.bands = vec!["grey".into()];
    assert!(grey.validate().unwrap_err().to_string().contains("3 channels for 1 bands"));
    assert!(grey.textured_faces().is_err());
}
