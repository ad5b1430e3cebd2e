use glam::{Vec2, Vec3};
use solidtrace::io::read_model;

use super::{Files, area, mutate, volume};
use crate::random::SplitMix;

/// A cube of edge 2 around the origin, its faces quads in the order -z +z -y +y -x +x.
const CUBE: &str = "\
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 4 8 7 3
f 1 5 8 4
f 2 3 7 6
";

#[test]
fn a_cube_has_its_volume_and_its_triangles_in_file_order() {
    let model = Files::new().read("cube.obj", CUBE).unwrap();
    let mesh = &model.meshes[0];
    assert_eq!(mesh.triangles.len(), 12);
    assert_eq!(mesh.positions.len(), 8);
    assert_eq!((volume(mesh), area(mesh)), (8.0, 24.0));
    let outward = [
        Vec3::NEG_Z,
        Vec3::Z,
        Vec3::NEG_Y,
        Vec3::Y,
        Vec3::NEG_X,
        Vec3::X,
    ];
    for i in 0..12_u32 {
        let [a, b, c] = mesh.corners(i);
        assert_eq!((b - a).cross(c - a).normalize(), outward[i as usize / 2]);
    }
    // The fan's order within the face.
    assert_eq!(mesh.corners(0)[2], Vec3::new(1.0, 1.0, -1.0));
    assert_eq!(mesh.corners(1)[2], Vec3::new(1.0, -1.0, -1.0));
    assert!(mesh.normals.is_empty() && mesh.uvs.is_empty() && mesh.slots.is_empty());
    assert_eq!(model.parts.len(), 1);
    assert!(model.parts[0].model_from_mesh.is_identity());
    assert_eq!(model.parts[0].materials, [None]);
    assert!(model.warnings.is_empty());
}

#[test]
fn byte_order_marks_line_ends_continuations_and_comments_change_nothing() {
    let files = Files::new();
    let plain = files.read("a.obj", CUBE).unwrap().meshes;
    let variants = [
        format!("\u{FEFF}{CUBE}"),
        CUBE.replace('\n', "\r\n"),
        CUBE.replace("f 1 4 3 2", "f 1 4 \\\n 3 \\\n\t2"),
        CUBE.replace("f 1 4 3 2", "f 1 4 \\\r\n 3 2"),
        CUBE.replace(' ', "\t  "),
        CUBE.replace("f 1 4 3 2", "# from C:\\models\\\nf 1 4 3 2 # the back"),
        CUBE.replace("f 5", "\n\n  f 5").trim_end().to_owned(),
        CUBE.replace("v 1 -1 -1", "v +1.0e0 -1. -10E-1 1.0"),
        CUBE.replace("v 1 -1 -1", "v 1 -1 -1 0.5 0.5 0.5"),
        format!("o cube\ng a b\ns 1\n{CUBE}s off\ng\n"),
    ];
    for text in variants {
        let model = files.read("a.obj", &text).unwrap();
        assert_eq!(model.meshes, plain, "{text:?}");
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    }
}

#[test]
fn negative_indices_and_vertices_that_come_later_mean_the_same_faces() {
    let files = Files::new();
    let mesh = files.read("a.obj", CUBE).unwrap().meshes.remove(0);
    let (vertices, faces) = CUBE.split_at(CUBE.find('f').unwrap());
    let later = format!("{faces}{vertices}");
    assert_eq!(files.read("a.obj", later).unwrap().meshes[0], mesh);
    let negative = CUBE
        .replace("f 1 4 3 2", "f -8 -5 -6 -7")
        .replace("f 2 3 7 6", "v 9 9 9\nf -8 -7 -3 -4");
    assert_eq!(files.read("a.obj", negative).unwrap().meshes[0], mesh);
}

#[test]
fn corners_without_coordinate_or_normal_get_zeros_and_the_others_keep_theirs() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                vt 0.25 0.5\nvt 0.75\nvn 0 0 2\nvn 0 3 4\n\
                f 1/1/1 2//2 3\nf 1 2/2 4/1/2\nf 3/ 2// 4/2/\n";
    let model = Files::new().read("mixed.obj", text).unwrap();
    let mesh = &model.meshes[0];
    let corner = |triangle: usize, corner: usize| {
        let v = mesh.triangles[triangle][corner] as usize;
        (mesh.positions[v], mesh.uvs[v], mesh.normals[v])
    };
    let (o, x, y, z) = (Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z);
    let (none, first, second) = (Vec2::ZERO, Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.0));
    let slanted = Vec3::new(0.0, 0.6, 0.8);
    let expected = [
        [(o, first, z), (x, none, slanted), (y, none, o)],
        [(o, none, o), (x, second, o), (z, first, slanted)],
        [(y, none, o), (x, none, o), (z, second, o)],
    ];
    for (i, triangle) in expected.iter().enumerate() {
        for (j, expected) in triangle.iter().enumerate() {
            assert_eq!(corner(i, j), *expected, "triangle {i} corner {j}");
        }
    }
}

#[test]
fn attributes_that_no_corner_uses_are_left_out() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1 2 3\n";
    let model = Files::new().read("a.obj", text).unwrap();
    assert!(model.meshes[0].uvs.is_empty() && model.meshes[0].normals.is_empty());
}

#[test]
fn concave_polygons_cover_their_area_once_in_any_plane() {
    // An L of three unit squares, a C of seven, and an arrow of area 4, each in three planes.
    let letter_l = vec![(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let letter_c = vec![
        (0, 0),
        (3, 0),
        (3, 1),
        (1, 1),
        (1, 2),
        (3, 2),
        (3, 3),
        (0, 3),
    ];
    let arrow = vec![(1, 2), (0, 0), (4, 2), (0, 4)];
    let files = Files::new();
    for (outline, expected) in [(letter_l, 3.0), (letter_c, 7.0), (arrow, 6.0)] {
        for start in 0..outline.len() {
            let mut turned = outline.clone();
            turned.rotate_left(start);
            for plane in 0..3 {
                let vertex = |&(a, b): &(i32, i32)| match plane {
                    0 => format!("v {a} {b} 7\n"),
                    1 => format!("v 7 {a} {b}\n"),
                    _ => format!("v {b} 7 {a}\n"),
                };
                let mut text: String = turned.iter().map(vertex).collect();
                text.push('f');
                text.extend((1..=turned.len()).map(|i| format!(" {i}")));
                let model = files.read("a.obj", &text).unwrap();
                let mesh = &model.meshes[0];
                assert_eq!(mesh.triangles.len(), turned.len() - 2);
                assert!((area(mesh) - expected).abs() < 1e-6, "{text}");
                let normal = [Vec3::Z, Vec3::X, Vec3::Y][plane];
                for i in 0..mesh.triangles.len() as u32 {
                    let [a, b, c] = mesh.corners(i);
                    assert!((b - a).cross(c - a).dot(normal) > 0.0, "{text}");
                }
            }
        }
    }
}

#[test]
fn material_names_are_slots_in_order_of_first_use() {
    let files = Files::new();
    files.write(
        "lib.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl unused\nnewmtl dark blue\nKd 0 0 1\n",
    );
    let text = "mtllib lib.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\
                f 1 2 3\nusemtl unused\nusemtl dark blue\nf 1 2 3\nusemtl rde\nf 1 2 3\n\
                usemtl red\ng other\nf 1 2 3\nusemtl dark blue\nf 1 2 3\n";
    let model = files.read("a.obj", text).unwrap();
    assert_eq!(model.meshes[0].slots, [0, 1, 2, 3, 1]);
    assert_eq!(model.parts[0].materials, [None, Some(0), None, Some(1)]);
    let names: Vec<&str> = model.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["dark blue", "red"]);
    assert_eq!(model.warnings.len(), 1);
    let warning = &model.warnings[0];
    assert!(warning.contains(":9:") && warning.contains("`rde`") && warning.contains("`red`"));
}

#[test]
fn what_is_left_out_is_counted_in_the_warnings() {
    let text = format!("{CUBE}l 1 2\np 3\nl 2 3\nfrobnicate 1\nx\n");
    let warnings = Files::new().read("a.obj", text).unwrap().warnings;
    assert_eq!(warnings.len(), 2);
    assert!(
        warnings[0].contains(":15:") && warnings[0].contains("3 lines"),
        "{warnings:?}"
    );
    assert!(warnings[1].contains("2 lines") && warnings[1].contains("`frobnicate`"));
}

#[test]
fn every_error_names_line_column_and_value() {
    let cases = [
        ("f 1 2 9", 15, 7, "`9` uses v 9, but the file has 8"),
        ("f 1 2 -9", 15, 7, "only 8 come before"),
        ("f 1 0 2", 15, 5, "index 0"),
        ("f 1/1 2 3", 15, 3, "uses vt 1, but the file has 0"),
        ("f 1//-1 2 3", 15, 3, "uses vn -1"),
        ("f 1 2", 15, 1, "2 corners"),
        ("f", 15, 1, "0 corners"),
        ("f 1 x 3", 15, 5, "`x` is not a corner"),
        ("f 1 2.0 3", 15, 5, "`2.0` is not a corner"),
        ("f 1 /1 3", 15, 5, "`/1` is not a corner"),
        ("f 1///1 2 3", 15, 3, "`1///1` is not a corner"),
        ("f 1 2 99999999999999999999", 15, 7, "is not a corner"),
        ("f 1 2 -999999999999999999", 15, 7, "only 8 come before"),
        ("f 1 \\\n 2 \\\n 9", 15, 11, "uses v 9"),
        ("v 1 2", 15, 1, "`v` has 2 numbers"),
        ("v 1 2 nan", 15, 7, "`nan` is not a finite number"),
        ("v -inf 2 3", 15, 3, "`-inf` is not a finite number"),
        ("v 1e39 2 3", 15, 3, "`1e39` is not a finite number"),
        ("v 1,5 2 3", 15, 3, "`1,5` is not a number"),
        ("v é 2 3", 15, 3, "is not a number"),
        (
            "vn 0 0 infinity",
            15,
            8,
            "`infinity` is not a finite number",
        ),
        ("vn 0 1", 15, 1, "`vn` has 2 numbers"),
        ("vt NaN", 15, 4, "`NaN` is not a finite number"),
        ("vt", 15, 1, "`vt` has 0 numbers"),
    ];
    let files = Files::new();
    for (line, number, column, message) in cases {
        let error = files.error("a.obj", format!("{CUBE}{line}\n"));
        let place = error.place().unwrap().clone();
        assert!(error.message().contains(message), "{line}: {error}");
        assert_eq!(
            (place.line, place.column),
            (Some(number), Some(column)),
            "{error}"
        );
        assert_eq!(place.file, files.path("a.obj"));
        assert!(error.to_string().contains("help:"), "{error}");
    }
}

#[test]
fn a_file_without_faces_is_an_error() {
    for text in ["", "\u{FEFF}", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "l 1 2"] {
        let files = Files::new();
        let error = files.error("empty.obj", text.replace("l 1 2", "v 0 0 0\nl 1 1"));
        assert!(error.message().contains("no triangles"), "{error}");
        assert_eq!(error.place().unwrap().file, files.path("empty.obj"));
    }
}

#[test]
fn flat_and_repeated_corners_still_give_a_triangle_for_each_index() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3 4\nf 1 1 1 1 1\nf 1 2 1\n";
    let model = Files::new().read("a.obj", text).unwrap();
    assert_eq!(model.meshes[0].triangles.len(), 2 + 3 + 1);
}

#[test]
fn two_thousand_damaged_files_never_panic() {
    let text = format!(
        "\u{FEFF}mtllib a.mtl\r\n{CUBE}vt 0 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2//1 3 \\\n 4/1 -1\nl 1 2\n"
    );
    let files = Files::new();
    files.write("a.mtl", "newmtl a\nKd 0.5\n");
    let mut random = SplitMix(1);
    let mut good = 0;
    for _ in 0..2000 {
        let path = files.write("a.obj", mutate(&mut random, text.as_bytes()));
        match read_model(&path) {
            Ok(model) => {
                model.meshes[0].validate().unwrap();
                good += 1;
            }
            Err(error) => assert!(error.place().is_some(), "{error}"),
        }
    }
    assert!((200..1800).contains(&good), "{good} of 2000 were read");
}
