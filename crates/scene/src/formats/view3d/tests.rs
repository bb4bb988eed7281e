use proptest::prelude::*;

use super::*;
use crate::formats::Unit;

/// The L-shaped room of Pinney and Bean's test 4, as the user manual of View3D gives it in the form F 3.
const ROOM: &str = "T  Pinney & Bean test 4: L shaped room (page A2.14; Table A2.11) BRE
! encl list  epsu  epso  maxu maxo mino emit
C  encl=1 list=2 eps=1.e-4 maxu=8 maxo=8 mino=0 emit=1
F  3
!  #   x    y    z      coordinates of vertices
V  1   0.   3.   3.
V  2   1.   3.   3.
V  3   0.   3.   0.
V  4   1.   3.   0.
V  5   0.   1.   0.
V  6   1.   1.   0.
V  7   3.   1.   0.
V  8   0.   0.   0.
V  9   1.   0.   0.
V 10   3.   0.   0.
V 11   0.   0.   3.
V 12   1.   0.   3.
V 13   3.   0.   3.
V 14   0.   1.   3.
V 15   1.   1.   3.
V 16   3.   1.   3.
!  #   v1  v2  v3  v4 base cmb  emit  name      surface data
S  1   11  13  10   8   0   0   0.90  srf-1
S  2   10  13  16   7   0   0   0.90  srf-2
S  3    6   7  16  15   0   0   0.90  srf-3
S  4    4   6  15   2   0   0   0.90  srf-4
S  5    3   4   2   1   0   0   0.90  srf-5
S  6    8   3   1  11   0   0   0.90  srf-6
S  7   11  14  15  12   0   0   0.90  srf-7
S  8    8   9   6   5   0   0   0.90  srf-8
S  9    1   2  15  14   0   7   0.90  srf-7b    ! surfaces that combine
S 10   15  16  13  12   0   7   0.90  srf-7c
S 11    5   6   4   3   0   8   0.90  srf-8b
S 12    9  10   7   6   0   8   0.90  srf-8c
End of data
what follows is not read
";

/// The same room as the manual gives it in the form F 3a.
const ROOM_OF_PLANES: &str = "T Pinney & Bean test 4: L shaped room (page A2.14; Table A2.11) BRE
C  encl=1 list=2 eps=1.e-5
F  3a
!  #  s base cmb emit  name
S  1  R   0   0  0.90  srf-1
  3. 0. 0.    0  90    3. 3.
S  2  R   0   0  0.90  srf-2
  3. 1. 0.  270  90    1. 3.
S  3  r   0   0  0.90  srf-3
  1. 1. 0.  180  90    2. 3.
S  4  R   0   0  0.90  srf-4
  1. 3. 0.  270  90    2. 3.
S  5  R   0   0  0.90  srf-5
  0. 3. 0.  180  90    1. 3.
S  6  R   0   0  0.90  srf-6
  0. 0. 0.   90  90    3. 3.
S  7  Q   0   0  0.90  srf-7
  3. 0. 3.    0  180
  2. 0.   3. 0.   3. 1.   2. 1.
S  8  Q   0   0  0.90  srf-8
  0. 0. 0.  180   0
  0. 0.   1. 0.   1. 1.   0. 1.
S  9  Q   0   7  0.90  srf-7b
  3. 0. 3.    0  180
  2. 1.   3. 1.   3. 3.   2. 3.
S 10  Q   0   7  0.90  srf-7c
  3. 0. 3.    0  180
  0. 0.   2. 0.   2. 1.   0. 1.
S 11  Q   0   8  0.90  srf-8b
  0. 0. 0.  180.  0.
  0. 1.   1. 1.   1. 3.   0. 3.
S 12  q   0   8  0.90  srf-8c
  0. 0. 0.  180.  0.
  1. 0.   3. 0.   3. 1.   1. 1.
End of data
";

/// A unit square and a smaller one in it.
const PLATE: &str = "F 3
V 1 0 0 0
V 2 1 0 0
V 3 1 1 0
V 4 0 1 0
V 5 .25 .25 0
V 6 .75 .25 0
V 7 .75 .75 0
V 8 .25 .75 0
S 1 1 2 3 4 0 0 0.9 plate
";

fn try_parse(text: &str) -> Result<Scene, SceneError> {
    parse(Path::new("nowhere/room.vs3"), text.as_bytes(), &LoadOptions::default())
}

fn refusal(text: &str) -> String {
    try_parse(text).unwrap_err().to_string()
}

fn area(surface: &Surface) -> DVec3 {
    let corners = surface.faces.iter().map(|&face| surface.corners(face));
    corners.map(|[a, b, c, d]| 0.5 * (c - a).cross(d - b)).sum()
}

/// By the divergence theorem, positive where normals point outward.
fn volume(scene: &Scene) -> f64 {
    let faces = scene.surfaces.iter().flat_map(|surface| surface.faces.iter().map(|&face| surface.corners(face)));
    faces.map(|[a, b, c, d]| a.dot(b.cross(c)) + a.dot(c.cross(d))).sum::<f64>() / 6.0
}

fn codes(scene: &Scene) -> Vec<&str> {
    scene.findings.iter().map(|finding| finding.code).collect()
}

#[test]
fn room_of_the_manual_looks_inward() {
    let scene = try_parse(ROOM).unwrap();
    let names: Vec<_> = scene.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!((names[0], names[8], names.len()), ("srf-1", "srf-7b", 12));
    assert!(scene.surfaces.iter().all(|surface| surface.faces.len() == 1 && !surface.material.two_sided));
    assert!((scene.surfaces[0].material.reflectance[0] - 0.1).abs() < 1e-15);
    // An L of 5 m2, 3 m high: fronts face inward, so that the volume comes out negative.
    assert!((volume(&scene) + 15.0).abs() < 1e-12, "{}", volume(&scene));
    assert!(scene.surfaces.iter().map(area).sum::<DVec3>().length() < 1e-12);
    assert_eq!(scene.combined, [(8, 6), (9, 6), (10, 7), (11, 7)].into_iter().collect());
    let expected = Hints { tolerance: Some(1e-4), enclosure: true, emissivity: true, row: None, column: None };
    assert_eq!(scene.hints, expected);
    assert_eq!(codes(&scene), ["ignored-controls"]);
    assert!(scene.findings[0].message.ends_with(": list=2, maxu=8, maxo=8, mino=0"));
    assert!(scene.validate_geometry().is_ok());
}

#[test]
fn both_forms_of_the_manual_describe_one_room() {
    let (vertices, planes) = (try_parse(ROOM).unwrap(), try_parse(ROOM_OF_PLANES).unwrap());
    assert!((volume(&planes) + 15.0).abs() < 1e-12);
    assert_eq!(planes.combined, vertices.combined);
    for (a, b) in vertices.surfaces.iter().zip(&planes.surfaces) {
        assert!((area(a) - area(b)).length() < 1e-12, "{}", a.name);
        let [one, other] = [a, b].map(|s| s.vertices.iter().sum::<DVec3>());
        assert!((one - other).length() < 1e-12, "{}", a.name);
    }
}

#[test]
fn subsurfaces_are_cut_from_their_base() {
    let scene = try_parse(&format!("{PLATE}S 2 5 6 7 8 1 0 0.5 hatch\nS 3 5 6 8 0 2 0 0.5 pane\n")).unwrap();
    let areas: Vec<_> = scene.surfaces.iter().map(area).collect();
    for (found, expected) in areas.iter().zip([0.75, 0.125, 0.125]) {
        assert!((*found - expected * DVec3::Z).length() < 1e-12, "{areas:?}");
    }
    assert!(scene.obstructions.is_empty() && scene.findings.is_empty());
    assert!(scene.validate_geometry().is_ok());
}

#[test]
fn null_surfaces_take_area_away_and_still_block() {
    let scene = try_parse(&format!("{PLATE}N 2 8 7 6 5 1 0 0.9 hole\nS 3 5 6 7 8 0 0 0.9 other\n")).unwrap();
    assert_eq!(scene.surfaces.len(), 2);
    assert!((area(&scene.surfaces[0]).z - 0.75).abs() < 1e-12);
    let [hole] = &scene.obstructions[..] else { panic!("{:?}", scene.obstructions) };
    assert_eq!(hole.name, "hole");
    assert!((area(hole).z + 0.25).abs() < 1e-12);
}

#[test]
fn obstructions_may_be_the_base_of_surfaces() {
    let text = PLATE.replace("S 1 1 2 3 4 0 0 0.9 plate", "S 1 5 6 7 8 2 0 0.9 pane\nO 2 1 2 3 4");
    let scene = try_parse(&text).unwrap();
    assert!((area(&scene.surfaces[0]).z - 0.25).abs() < 1e-12);
    let [screen] = &scene.obstructions[..] else { panic!("{:?}", scene.obstructions) };
    assert_eq!((screen.name.as_str(), screen.faces.len()), ("obstruction 2", 4));
    assert!((area(screen).z - 0.75).abs() < 1e-12);
}

#[test]
fn triangles_names_units_and_sides() {
    let text = format!("{PLATE}s 2,1\t3 2 0 0 0 1 plate!\nS 3 5 6 7 8 0 0 0 / no name\n");
    let options = LoadOptions { unit: Unit::Millimetre, two_sided: Some(true), ..LoadOptions::default() };
    let scene = parse(Path::new("a.vs3"), text.as_bytes(), &options).unwrap();
    let names: Vec<_> = scene.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!(names, ["plate", "plate!", "surface 3"]);
    assert_eq!(scene.surfaces[1].faces, [[0, 1, 2, 2]]);
    assert!((area(&scene.surfaces[1]).z + 0.5e-6).abs() < 1e-18);
    assert!(scene.surfaces[0].material.two_sided);
    assert_eq!(scene.surfaces[1].material.reflectance, [0.0]);
    // View3D's own limit, which keeps reflectances below one.
    assert_eq!(scene.surfaces[2].material.reflectance, [0.999]);
    assert_eq!(codes(&scene), ["emissivity-limited"]);
}

#[test]
fn rows_and_columns_are_surfaces_with_factors() {
    let scene = try_parse(&format!("C row = 3, col=1\n{PLATE}N 2 8 7 6 5 1 0 0.9 hole\nS 3 5 6 7 8 0 0 .9 x")).unwrap();
    assert_eq!((scene.hints.row, scene.hints.column), (Some(1), Some(0)));
    let scene = try_parse(&format!("C row=2\n{PLATE}N 2 8 7 6 5 1 0 0.9 hole\nEnd\nQ\n")).unwrap();
    assert_eq!(codes(&scene), ["ignored-controls"]);
    let scene = try_parse(&format!("{PLATE}Q\nW\n")).unwrap();
    assert_eq!((codes(&scene), scene.findings[0].element.as_str()), (vec!["unknown-statement"], "line 11"));
}

#[test]
fn bad_statements_name_their_line() {
    let cases = [
        ("S 3 5 6 7 8 0 0 0.9 x", "line 11: surface '3' is out of sequence; it must be number 2"),
        ("V 10 0 0 0", "line 11: vertex '10' is out of sequence; it must be number 9"),
        ("V 9 0 nan 0", "line 11: 'nan' is not a finite number"),
        ("V 9 0 1e300 0", "line 11: '1e300' is not a finite number"),
        ("V 9 0 0", "line 11: vertex 9 has 2 coordinates"),
        ("V", "line 11: a vertex needs a number"),
        ("S", "line 11: a surface needs a number"),
        ("S 2 5 6 7", "line 11: the surface has too few numbers"),
        ("S 2 5 6 7 9 0 0 0.9 x", "line 11: it refers to vertex '9' of 8"),
        ("S 2 0 6 7 8 0 0 0.9 x", "line 11: it refers to vertex '0' of 8"),
        ("S 2 5 6 7 8 0 0 1.1 x", "line 11: '1.1' is not an emissivity"),
        ("S 2 5 6 7 8 0 0 -1 x", "line 11: '-1' is not an emissivity"),
        ("S 2 5 6 7 8 0 0 nan x", "line 11: 'nan' is not an emissivity"),
        ("S 2 5 6 7 8 3 0 0.9 x", "line 11: its base is surface 3 of 2"),
        ("S 2 5 6 7 8 2 0 0.9 x", "line 11: the base of a surface must come before it"),
        ("S 2 5 6 7 8 -1 0 0.9 x", "line 11: '-1' is not the number of a surface"),
        ("S 2 5 6 7 8 0 2 0.9 x", "line 11: it is combined with 2, which is no earlier surface"),
        ("S 2 5 6 7 8 0 1 .9 x\nS 3 5 6 7 8 0 2 .9", "line 12: it is combined with surface 2, which is combined"),
        ("S 2 8 7 6 5 1 0 0.9 x", "line 11: it must face the same way as its base"),
        ("N 2 5 6 7 8 1 0 0.9 x", "line 11: a null surface must face its base"),
        ("N 2 8 7 6 5 0 0 0.9 x", "line 11: a null surface needs a base"),
        ("N 2 8 7 6 5 1 1 0.9 x", "line 11: a null surface cannot be combined"),
        ("N 2 8 7 6 5 1 0 .9 x\nS 3 5 6 7 0 2 0 .9", "line 12: its base 2 is a null surface"),
        ("M 2 8 7 6 5 1 0 0.9 x", "line 11: masking surfaces are not modelled"),
        ("S 2 5 6 7 8 1 0 .9\nS 3 5 6 8 0 1 0 .9", "line 12: it overlaps another surface of the same base"),
        ("V 9 0 0 1\nS 2 5 6 9 0 1 0 .9", "line 12: it does not lie in the plane"),
        ("V 9 0 2 0\nS 2 5 6 9 0 1 0 .9", "line 12: it reaches beyond its base"),
        ("S 2 5 7 6 8 1 0 .9", "line 11: it has an inward corner or crosses itself"),
        ("S 2 5 5 6 6 1 0 .9", "line 11: the surface has no area"),
        ("F 2", "line 11: the line F must come before"),
        ("C eps=tiny", "line 11: 'tiny' is not a positive number"),
        ("C encl", "line 11: 'encl' has no value"),
    ];
    for (statement, expected) in cases {
        let message = refusal(&format!("{PLATE}{statement}\n"));
        assert!(message.starts_with(&format!("nowhere/room.vs3: {expected}")), "{message}");
    }
    assert!(refusal(&PLATE.replace("F 3", "F 2")).contains("line 1: the file describes a 2-D geometry"));
    assert!(refusal(&PLATE.replace("F 3", "F 1")).contains("there is no form '1'"));
    assert!(refusal(&ROOM_OF_PLANES.replace("S  1  R", "S  1  P")).contains("line 5: there is no shape 'P'"));
    assert!(refusal("F 3a\nS 1 R 0 0 .9 x\n 0 0 0 0 0 1\n").contains("ends within a surface"));
}

#[test]
fn many_subsurfaces_are_refused_before_they_take_long() {
    let text = (2..=MOST_IN_ONE + 3).fold(PLATE.to_string(), |text, i| format!("{text}S {i} 5 6 7 8 1 0 .9 x\n"));
    assert!(refusal(&text).contains("lie in one; divide the base"));
}

proptest! {
    #[test]
    fn no_damage_panics(cut in 0_usize..1700, place in 0_usize..1700, with in "[ 0-9.SOMNVFCE!*=a\n-]", form in 0_usize..3) {
        let plate = format!("{PLATE}N 2 8 7 6 5 1 0 0.9 hole\nS 3 5 6 7 8 0 1 0.9 other\nO 4 1 2 3 4\n");
        let mut text = [ROOM, ROOM_OF_PLANES, plate.as_str()][form].to_string();
        text.truncate(cut.max(1));
        if place < text.len() {
            text.replace_range(place..=place, &with);
        }
        let _ = try_parse(&text).map(|scene| scene.findings());
    }

    #[test]
    fn noise_does_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = parse(Path::new("a.vs3"), &bytes, &LoadOptions::default()).map(|scene| scene.findings());
    }
}
