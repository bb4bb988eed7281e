use std::f64::consts::PI;

use radiosity_geometry::texture::Wrap;

use super::*;
use crate::formats::tests::Scratch;
use crate::formats::texture::tests::two_colour_png;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn try_parse(text: &str) -> Result<Scene, SceneError> {
    parse(Path::new("nowhere/test.obj"), text.as_bytes(), &LoadOptions::default())
}

fn refusal(text: &str) -> String {
    try_parse(text).unwrap_err().to_string()
}

fn codes(scene: &Scene) -> Vec<&str> {
    scene.findings.iter().map(|finding| finding.code).collect()
}

#[test]
fn quads_stay_quads_and_are_two_sided() {
    let scene = try_parse(&format!("{SQUARE}o sheet\nf 1/1/1 2//1 3/2 4\n")).unwrap();
    let sheet = &scene.surfaces[0];
    assert_eq!((sheet.name.as_str(), &sheet.faces[..]), ("sheet", &[[0, 1, 2, 3]][..]));
    assert!(sheet.material.two_sided);
    assert_eq!(sheet.material.reflectance, [0.5; 3]);
    assert_eq!(codes(&scene), ["no-material"]);

    let options = LoadOptions { two_sided: Some(false), ..LoadOptions::default() };
    let text = format!("{SQUARE}f 1 2 3 4");
    let scene = parse(Path::new("a.obj"), text.as_bytes(), &options).unwrap();
    assert!(!scene.surfaces[0].material.two_sided);
}

#[test]
fn relative_indices_count_backwards() {
    let scene = try_parse(&format!("{SQUARE}f -4 -3 -2 -1\nv 5 5 5\nf -1 -2 -3")).unwrap();
    let surface = &scene.surfaces[0];
    assert_eq!(surface.corners(surface.faces[0])[0], DVec3::ZERO);
    assert_eq!(surface.corners(surface.faces[1])[0], DVec3::splat(5.0));
}

#[test]
fn bad_statements_name_their_line() {
    let cases = [
        ("f 1 2 5", "line 5: the face refers to vertex 5 of 4"),
        ("f 1 2 0", "line 5: the face refers to vertex 0; OBJ counts from 1"),
        ("f 1 2 -5", "line 5: the face refers to vertex -5 of 4"),
        ("f 1 2 -9223372036854775808", "line 5: the face refers to vertex -9223372036854775808 of 4"),
        ("f 1 2 9223372036854775807", "line 5: the face refers to vertex 9223372036854775807 of 4"),
        ("f 1 2 99999999999999999999", "line 5: '99999999999999999999' is not a vertex index"),
        ("f 1 2 x", "line 5: 'x' is not a vertex index"),
        ("v 1 2", "line 5: the vertex '1 2' has fewer than three"),
        ("v 1 nan 2", "line 5: '1 nan 2' are not three finite"),
        ("v 1 inf 2", "line 5: '1 inf 2' are not three finite"),
        ("v 1 1e999 2", "line 5: '1 1e999 2' are not three finite"),
        ("v 1 1e300 2", "line 5: '1 1e300 2' are not three finite"),
        ("v a b c", "line 5: 'a b c' are not three finite"),
    ];
    for (statement, expected) in cases {
        let message = refusal(&format!("{SQUARE}{statement}\nf 1 2 3\n"));
        assert!(message.starts_with(&format!("nowhere/test.obj: {expected}")), "{message}");
    }
}

#[test]
fn continued_lines_are_joined() {
    let scene = try_parse(&format!("{SQUARE}f 1 2 \\\n  3 4 # and a comment\n")).unwrap();
    assert_eq!(scene.surfaces[0].faces, [[0, 1, 2, 3]]);
    assert!(refusal(&format!("{SQUARE}f 1 2 \\\n  3 4\nf 1 2 9")).contains("line 7"));
}

#[test]
fn byte_order_marks_and_signs_within_names_are_kept_apart() {
    let scene = try_parse(&format!("\u{feff}{SQUARE}o wall#1#a # the first\nf 1 2 3 4 #end\n")).unwrap();
    assert_eq!(scene.surfaces[0].name, "wall#1#a");
    assert_eq!(scene.surfaces[0].vertices.len(), 4);
}

#[test]
fn groups_and_materials_make_surfaces() {
    let faces = "g wall\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\ng\nf 1 2 4\ng wall\nusemtl a\nf 2 3 4\n";
    let scene = try_parse(&format!("{SQUARE}{faces}")).unwrap();
    let surfaces: Vec<_> = scene.surfaces.iter().map(|s| (s.name.as_str(), s.faces.len())).collect();
    assert_eq!(surfaces, [("wall.a", 2), ("wall.b", 1), ("b", 1)]);
    assert_eq!(codes(&scene), ["unknown-material"]);
    assert_eq!(scene.findings[0].element, "materials 'a', 'b'");
}

#[test]
fn polygons_are_triangulated_and_bent_quads_noticed() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 2 1\nf 1 2 3 4 5 6\nf 1 2 3 7\n";
    let scene = try_parse(text).unwrap();
    assert_eq!(scene.face_count(), 6);
    assert!(codes(&scene).contains(&"non-planar-polygons"));
    assert!(scene.validate_geometry().is_ok());
}

#[test]
fn lines_and_flat_polygons_are_left_out() {
    let scene = try_parse(&format!("{SQUARE}l 1 2\np 1\nf 1 2 1\nf 1 2 3\n")).unwrap();
    assert_eq!(scene.face_count(), 1);
    assert_eq!(codes(&scene), ["no-material", "zero-area-polygons", "no-area-primitives"]);
}

#[test]
fn faces_of_fewer_than_three_corners_are_left_out() {
    let scene = try_parse(&format!("{SQUARE}f 1 2\nf 1 2 3\nf 4\nf\nf 1 3 4\n")).unwrap();
    assert_eq!(scene.surfaces[0].faces, [[0, 1, 2, 2], [0, 2, 3, 3]]);
    assert_eq!(codes(&scene), ["no-material", "slender-faces"]);
    assert_eq!(scene.findings[1].element, "line 5");
    assert!(scene.findings[1].message.starts_with("3 faces"));
    assert!(refusal(&format!("{SQUARE}f 1 2\n")).contains("holds no faces"));
}

#[test]
fn libraries_give_colours_light_and_textures() {
    let scratch = Scratch::new("library");
    scratch.write("tex/check.png", two_colour_png([255; 3], [0; 3]));
    let mtl = "newmtl wall\nKd 0.8 0.6 1\nmap_Kd tex\\check.png\nnewmtl lamp\nKd 1 1 1\nKe 1 2 3\n";
    scratch.write("my room.mtl", mtl);
    let faces = "usemtl wall\nf 1 2 3\nusemtl lamp\nf 1 3 4\n";
    let path = scratch.write("room.obj", format!("mtllib my room.mtl\n{SQUARE}{faces}"));
    let scene = load(&path, &LoadOptions::default()).unwrap();
    let [wall, lamp] = &scene.surfaces[..] else { panic!("{:?}", scene.surfaces) };
    assert_eq!(wall.material.reflectance, [0.4, 0.3, 0.5]);
    assert_eq!(lamp.material.emission, [PI, 2.0 * PI, 3.0 * PI]);
    assert_eq!(lamp.material.reflectance, [0.95; 3]);
    // The wall has no texture coordinates, and takes the mean.
    assert_eq!(codes(&scene), ["no-texture-coordinates", "reflectance-limited"]);
    assert!(scene.validate().is_ok());
}

#[test]
fn textures_are_laid_by_coordinates_of_corners() {
    let scratch = Scratch::new("texture");
    scratch.write("check.png", two_colour_png([255; 3], [0; 3]));
    scratch.write("a.mtl", "newmtl wall\nKd 0.8 0.6 0.4\nmap_Kd -clamp on check.png\n");
    // The second triangle has the first one's corner with other coordinates.
    let coordinates = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.25 0\n";
    let faces = "usemtl wall\nf 1/1 2/2 3/3\nf 1/4 3/3 4/-4\n";
    let path = scratch.write("room.obj", format!("mtllib a.mtl\n{SQUARE}{coordinates}{faces}"));
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(scene.findings, []);
    let [wall] = &scene.surfaces[..] else { panic!("{:?}", scene.surfaces) };
    assert_eq!(wall.faces, [[0, 1, 2, 2], [3, 2, 4, 4]]);
    let texture = wall.texture.as_ref().unwrap();
    // v points down here.
    assert_eq!(texture.coordinates, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.5, 0.75], [0.0, 1.0]]);
    assert_eq!((wall.material.reflectance[1], texture.image.wrap()), (0.6, [Wrap::Clamp; 2]));
    let faces = scene.textured_faces().unwrap()[0].clone().unwrap();
    let found = faces.at(0, DVec3::new(0.2, 0.1, 0.0));
    assert_eq!([0, 1, 2].map(|band| found.band(band)), [0.8, 0.6, 0.4]);
}

#[test]
fn unsound_coordinates_leave_the_mean() {
    let scratch = Scratch::new("unsound");
    scratch.write("check.png", two_colour_png([255; 3], [0; 3]));
    scratch.write("a.mtl", "newmtl wall\nKd 0.8 0.6 0.4\nmap_Kd check.png\n");
    for coordinates in ["f 1/1 2/2 3/9", "vt 0 0\nvt 1 0\nvt nan 1\nf 1/1 2/2 3/3", "vt 0 0\nf 1/1 2/ 3/1"] {
        let path = scratch.write("room.obj", format!("mtllib a.mtl\n{SQUARE}usemtl wall\n{coordinates}\n"));
        let scene = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(codes(&scene), ["no-texture-coordinates"], "{coordinates}");
        assert!(scene.surfaces[0].texture.is_none() && scene.surfaces[0].material.reflectance == [0.4, 0.3, 0.2]);
    }
}

#[test]
fn missing_libraries_and_textures_are_warnings() {
    let scratch = Scratch::new("missing");
    scratch.write("a.mtl", "newmtl wall\nmap_Kd ../secret.png\n");
    let path = scratch.write("room.obj", format!("mtllib a.mtl\nmtllib b.mtl\n{SQUARE}usemtl wall\nf 1 2 3\n"));
    let scene = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(codes(&scene), ["missing-library", "unreadable-texture"]);
    assert_eq!(scene.surfaces[0].material.reflectance, [0.5; 3]);
}

#[test]
fn no_damage_panics() {
    let whole =
        format!("mtllib x.mtl\no a\n{SQUARE}vt 0 1\nusemtl m\nf 1/1/1 2/2/2 -2 \\\n 4\ng b c\nf 1 2 3\nl 1 2\n");
    for position in 0..whole.len() {
        let _ = try_parse(&whole[..position]);
        for byte in [0, b' ', b'\n', b'-', b'/', b'9', b'\\', b'#', 0xff] {
            let mut damaged = whole.clone().into_bytes();
            damaged[position] = byte;
            let _ = parse(Path::new("test.obj"), &damaged, &LoadOptions::default()).map(|scene| scene.findings());
        }
    }
}
