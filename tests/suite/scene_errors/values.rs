//! Numbers, tuples, transforms, solids, cameras and settings out of range.

use super::{camera_fails, material_fails, object_fails, setting_fails};

#[test]
fn lengths_must_be_above_zero_and_finite() {
    object_fails(
        "Sphere(radius: «-3)",
        &["`-3`", "`radius` of `Sphere`", "above 0"],
    );
    object_fails("Sphere(radius: «0)", &["`0`", "above 0"]);
    object_fails("Sphere(radius: «inf)", &["`inf`", "finite"]);
    object_fails("Sphere(radius: «-inf)", &["`-inf`", "finite"]);
    object_fails(
        "Sphere(center: (0, «NaN, 0), radius: 1)",
        &["`NaN`", "`center`"],
    );
    object_fails("Sphere(center: (0, 0, «1e300), radius: 1)", &["`1e300`"]);
    object_fails("Sphere(radius: «1e-200)", &["`1e-200`"]);
    object_fails("Box(size: (1, «0, 1))", &["`0`", "`size` of `Box`"]);
    object_fails(
        "Cylinder(from: (0, 0, 0), to: (0, 1, 0), radius: «-1)",
        &["`-1`"],
    );
    object_fails(
        "Cone(from: (0, 0, 0), to: (0, 1, 0), from_radius: «-1)",
        &["`-1`", "`from_radius` of `Cone`", "at least 0"],
    );
}

#[test]
fn solids_must_not_be_degenerate() {
    object_fails(
        "Cylinder(from: (1, 2, 3), to: «(1, 2, 3), radius: 1)",
        &["`(1, 2, 3)`", "same point as `from`"],
    );
    object_fails(
        "«Cone(from: (0, 0, 0), to: (0, 1, 0), from_radius: 0)",
        &["both radii"],
    );
    object_fails(
        "Torus(major_radius: 2, minor_radius: «2)",
        &["`2`", "less than the `major_radius`, 2"],
    );
    object_fails(
        "Torus(axis: «(0, 0, 0), major_radius: 2, minor_radius: 1)",
        &["`(0, 0, 0)`"],
    );
    object_fails("Plane(normal: «(0, 0, 0))", &["`(0, 0, 0)`", "direction"]);
    object_fails(
        "Box(size: (1, 1, 1), axes: ((1, 0, 0), «(2, 0, 0)))",
        &["`(2, 0, 0)`", "0.0 degrees", "perpendicular"],
    );
    object_fails(
        "Box(size: (1, 1, 1), axes: («(0, 0, 0), (2, 0, 0)))",
        &["`(0, 0, 0)`"],
    );
}

#[test]
fn rectangles_and_disks_have_a_size_and_a_direction() {
    object_fails(
        "Rectangle(size: (1, «0))",
        &["`0`", "`size` of `Rectangle`", "above 0"],
    );
    object_fails("Rectangle(size: «(1, 1, 1))", &["3 values", "2"]);
    object_fails("Rectangle(size: «3)", &["`(width, height)`"]);
    object_fails(
        "Rectangle(size: (1, 1), axes: ((1, 0, 0), «(1, 1, 0)))",
        &["45.0 degrees", "perpendicular"],
    );
    object_fails("«Disk(radius: 1)", &["needs the field `normal`"]);
    object_fails(
        "Disk(normal: (0, 1, 0), radius: «-2)",
        &["`-2`", "`radius` of `Disk`"],
    );
}

#[test]
fn a_spot_shines_one_way_within_its_angles() {
    let spot = |rest: &str| format!("lights: [Spot(position: (1, 2, 3), {rest})]");
    let fine = "intensity: (1, 1, 1)";
    setting_fails(
        &format!("lights: [«Spot(position: (1, 2, 3), {fine})]"),
        &["where", "a `target` or a `direction`"],
    );
    setting_fails(
        &format!(
            "lights: [«Spot(position: (1, 2, 3), target: (0, 0, 0), direction: (0, 0, 1), {fine})]"
        ),
        &["both", "leave one"],
    );
    setting_fails(
        &spot(&format!("target: «(1, 2, 3), {fine}")),
        &["same point as `position`"],
    );
    setting_fails(
        &spot(&format!("direction: (0, 0, 1), angle: «0, {fine}")),
        &["`0`", "`angle` of `Spot`", "180"],
    );
    setting_fails(
        &spot(&format!(
            "direction: (0, 0, 1), angle: 20, inner_angle: «30, {fine}"
        )),
        &["`30`", "0..=20"],
    );
    setting_fails(
        "lights: [«Spot(position: (1, 2, 3), target: (0, 0, 0))]",
        &["needs the field `intensity`"],
    );
}

#[test]
fn transforms_must_be_invertible() {
    let sphere =
        |step: &str| format!("Sphere(radius: 1, transform: [Translate((1, 0, 0)), {step}])");
    object_fails(&sphere("Scale((1, «0, 1))"), &["`0`", "flatten"]);
    object_fails(&sphere("Scale(«0)"), &["`0`", "flatten"]);
    object_fails(
        &sphere("Rotate(axis: «(0, 0, 0), degrees: 3)"),
        &["`(0, 0, 0)`", "`axis` of `Rotate`"],
    );
    object_fails(
        &sphere("Rotate(«axes: (0, 0, 1), degrees: 3)"),
        &["`axes`", "did you mean `axis`?"],
    );
    object_fails(
        &sphere("«Rotat(axis: (0, 0, 1), degrees: 3)"),
        &["`Rotat`", "did you mean `Rotate`?"],
    );
    object_fails(
        &sphere("«Matrix(((1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 0)))"),
        &["flattens"],
    );
    object_fails(
        &sphere("Matrix(«((1, 0, 0), (0, 1, 0), (1, 1, 0)))"),
        &["3 values"],
    );
    object_fails("Sphere(radius: 1, transform: «Scale(2))", &["a list"]);
    let many = "Scale(1e12), ".repeat(25);
    let step = format!("{many}«Scale(1e12), {}", "Scale(1e12)");
    object_fails(&sphere(&step), &["beyond"]);
}

#[test]
fn tuples_must_have_the_right_count() {
    object_fails(
        "Sphere(center: «(0, 0), radius: 1)",
        &["`(0, 0)`", "2 values", "`(x, y, z)`"],
    );
    object_fails("Sphere(center: «(0, 0, 0, 1), radius: 1)", &["4 values"]);
    object_fails("Sphere(center: «7, radius: 1)", &["`7`", "`(x, y, z)`"]);
    setting_fails(
        "film: (size: «(1, 2, 3))",
        &["`(1, 2, 3)`", "`(width, height)`"],
    );
}

#[test]
fn values_must_be_of_the_right_type() {
    object_fails("Sphere(radius: «\"3\")", &["`\"3\"`", "a number"]);
    object_fails("Sphere(radius: «None)", &["`None`", "a number"]);
    object_fails(
        "Sphere(radius: 1, material: «red)",
        &["`red`", "double quotes"],
    );
    object_fails("Sphere(radius: 1, name: «3)", &["`3`"]);
    object_fails("Sphere(radius: 1, name: «\"\")", &["empty"]);
    object_fails(
        "Mesh(file: \"a.obj\", smooth: «1)",
        &["`1`", "`true` or `false`"],
    );
    object_fails("Sphere(«3)", &["need their names"]);
    object_fails("«7", &["`7`", "an object"]);
}

#[test]
fn colours_must_be_in_range() {
    material_fails(
        "Diffuse(color: (0.5, «1.5, 0))",
        &["`1.5`", "0..=1", "`Emissive`"],
    );
    material_fails("Diffuse(color: (0.5, «-0.5, 0))", &["`-0.5`"]);
    material_fails("Diffuse(color: «(1, 1))", &["2 values", "`(r, g, b)`"]);
    material_fails(
        "Mirror(color: Checker(a: (1, 1, «2)))",
        &["`2`", "`a` of `Checker`"],
    );
    material_fails(
        "Diffuse(color: Checker(step: «0))",
        &["`0`", "`step` of `Checker`"],
    );
    material_fails(
        "Diffuse(color: Checker(«stp: 1))",
        &["did you mean `step`?"],
    );
    material_fails("Emissive(radiance: (15, «-1, 15))", &["`-1`"]);
    material_fails("«Emissive()", &["needs the field `radiance`"]);
    material_fails("Dielectric(ior: «0)", &["`0`", "`ior` of `Dielectric`"]);
    setting_fails("environment: Constant(color: (0, 0, «-1))", &["`-1`"]);
    setting_fails(
        "lights: [Point(position: (0, 0, 0), intensity: (1, 1, «-1))]",
        &["`-1`", "`intensity` of `Point`"],
    );
}

#[test]
fn settings_must_be_in_range() {
    setting_fails("film: (size: («0, 10))", &["`0`", "1..=65536"]);
    setting_fails("film: (size: (10, «65537))", &["`65537`"]);
    setting_fails("film: (size: (10, «1.5))", &["`1.5`", "whole"]);
    setting_fails("film: (spp: «0)", &["`0`"]);
    setting_fails("film: (filter: Box(radius: «0))", &["`0`"]);
    setting_fails("integrator: Path(max_depth: «-1)", &["`-1`"]);
    setting_fails("integrator: Whitted(shadow_factor: «2)", &["`2`", "0..=1"]);
    setting_fails("integrator: Direct(max_depth: «1.5)", &["`1.5`"]);
    setting_fails("integrator: Ao(radius: «0)", &["`0`"]);
    setting_fails(
        "integrator: Normals(«radius: 1)",
        &["`Normals` has no field `radius`"],
    );
}

#[test]
fn motions_must_be_possible() {
    let keys = |keys: &str| {
        format!(
            "Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45, motion: Smooth(keys: [{keys}]))"
        )
    };
    camera_fails(&keys("(frame: 3), (frame: «3)"), &["`3`", "key before, 3"]);
    camera_fails(&keys("(frame: «-1)"), &["`frame` of `key`", "`-1`"]);
    camera_fails(&keys("(frame: «1.5)"), &["`1.5`", "whole number"]);
    camera_fails(&keys("«(eye: (0, 0, 1))"), &["field `frame`"]);
    camera_fails(&keys("(frame: 0, «vfof: 3)"), &["did you mean `vfov`?"]);
    camera_fails(&keys("(frame: 0, vfov: «180)"), &["`180`"]);
    camera_fails(&keys("(frame: 0, look_at: «(0, 0, 9))"), &["looks nowhere"]);
    camera_fails(
        &keys("(frame: 0), «(frame: 1, eye: (0, 4, 0))"),
        &["along its `up`", "give the key another"],
    );
    camera_fails(
        "Panorama(eye: (0, 0, 9), look_at: (0, 0, 0), motion: Linear(keys: [(frame: 0, «vfov: 3)]))",
        &["no field `vfov`"],
    );
    let camera = |rest: &str| format!("Orthographic(eye: (0, 0, 9), look_at: (0, 0, 0), {rest})");
    camera_fails(
        &camera("height: «0"),
        &["`height` of `Orthographic`", "`0`"],
    );
    camera_fails(&camera("height: 1, «vfov: 9"), &["no field `vfov`"]);
    camera_fails(
        &camera("height: 1, motion: «Bezier(keys: [])"),
        &["`Bezier`", "Linear"],
    );
    camera_fails(
        &camera("height: 1, motion: Linear(keys: «[])"),
        &["has no keys"],
    );
}

#[test]
fn cameras_must_look_somewhere() {
    let camera = |rest: &str| format!("Perspective(eye: (0, 0, 9), {rest})");
    camera_fails(&camera("look_at: «(0, 0, 9), vfov: 45"), &["`(0, 0, 9)`"]);
    camera_fails(
        &camera("look_at: (0, 0, 0), up: «(0, 0, 2), vfov: 45"),
        &["`(0, 0, 2)`", "along the view"],
    );
    camera_fails(
        "«Perspective(eye: (0, 5, 0), look_at: (0, 0, 0), vfov: 45)",
        &["y axis", "`up`"],
    );
    camera_fails(
        &camera("look_at: (0, 0, 0), vfov: «180"),
        &["`180`", "between 0 and 180"],
    );
    camera_fails(&camera("look_at: (0, 0, 0), vfov: «0"), &["`0`"]);
    camera_fails(
        &camera("look_at: (0, 0, 0), vfov: 9, aperture: «-1"),
        &["`-1`"],
    );
    camera_fails(&camera("look_at: (0, 0, 0), vfov: 9, focus: «0"), &["`0`"]);
    camera_fails(
        "«Perspective(look_at: (0, 0, 0), vfov: 9)",
        &["needs the field `eye`"],
    );
}
