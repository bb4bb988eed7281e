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
    let mut back = square();
    back.name = "back".into();
    back.faces = vec![[1, 0, 3, 2]];
    let found = only(&scene(vec![square(), back]));
    assert_eq!((found.severity, found.code), (Severity::Warning, "duplicate-faces"));
    assert!(found.element.contains("'back'") && found.message.contains("'square'"));
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
