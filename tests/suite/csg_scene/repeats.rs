//! Instances and repeats, as operands and in the world.

use glam::{DMat3, DVec3};
use solidtrace::geometry::{Csg, CsgOp};
use solidtrace::math::Transform;
use solidtrace::scene::{Instance, Repeat, Scene};

use super::{csg_of, only, origin, radius, repeat, scene, sphere};

fn at(position: [f64; 3]) -> Transform {
    Transform::rigid(DMat3::IDENTITY, DVec3::from(position))
}

#[test]
fn instances_of_a_definition_share_one_object() {
    let scene = scene(
        "Instance(of: \"bolt\"), Instance(of: \"two\", material: \"red\", name: \"second\"),
         Union(of: [Instance(of: \"inlined\")])",
        "\"unused\": Union(of: [Sphere(radius: 1)]), \"inlined\": Union(of: [Sphere(radius: 2)]),
         \"bolt\": Union(of: [Sphere(radius: 3, material: \"green\")], transform: [Scale(2)], name: \"bolt\"),
         \"two\": Instance(of: \"bolt\", transform: [Translate((1, 0, 0))])",
    );
    assert_eq!((scene.instances.len(), scene.csgs.len()), (3, 2));
    let [first, second, third] = &scene.instances[..] else {
        panic!();
    };
    assert_eq!(first.shape, second.shape);
    assert_eq!(radius(csg_of(&scene, first), 0), 3.0);
    assert_eq!(radius(csg_of(&scene, third), 0), 2.0);
    let name = |instance: &Instance| &scene.materials[instance.material(0).0 as usize].name;
    assert_eq!((&**name(first), &**name(second)), ("green", "red"));
    assert_eq!(second.name.as_deref(), Some("second/bolt"));
    let moved = second.world_from_object.point(DVec3::X);
    assert_eq!(moved.to_array(), [3.0, 0.0, 0.0]);
}

#[test]
fn a_csg_object_is_inlined_where_its_instance_is_an_operand() {
    let scene = scene(
        "Difference(from: Sphere(radius: 9), subtract: [Instance(of: \"pair\", transform: [Scale(3), Translate((0, 0, 1))])])",
        "\"pair\": Intersection(of: [Sphere(radius: 1, center: (1, 0, 0)), Instance(of: \"ball\")], transform: [Translate((0, 1, 0))]),
         \"ball\": Sphere(radius: 2, center: (0, 0, 4))",
    );
    let csg = only(&scene);
    assert_eq!((csg.len(), csg.results()), (3, 1));
    assert_eq!([1, 2].map(|i| radius(csg, i)), [1.0, 2.0]);
    assert_eq!(origin(csg, 1), [3.0, 3.0, 1.0]);
    assert_eq!(origin(csg, 2), [0.0, 3.0, 13.0]);
    let thrice = DMat3::from_diagonal(DVec3::splat(3.0));
    assert_eq!(csg.operand(2).1.matrix().matrix3, thrice);
}

#[test]
fn a_repeat_as_an_operand_is_the_union_of_its_copies() {
    let ball = "Sphere(center: (1, 0, 0), radius: 0.5)";
    let turn = ", transform: [Rotate(axis: (0, 0, 1), degrees: 90), Translate((0, 0, 5))]";
    let scene = scene(
        &format!(
            "Difference(from: Sphere(radius: 9), subtract: [{}, Sphere(radius: 8)])",
            repeat(ball, turn)
        ),
        "",
    );
    let csg = only(&scene);
    let places: Vec<Transform> = (1..5).map(|i| csg.operand(i).1).collect();
    let mut expected = Csg::default();
    expected.push(sphere(9.0), &Transform::IDENTITY, 0..1);
    let mut one = Csg::default();
    one.push(sphere(0.5), &at([1.0, 0.0, 0.0]), 0..1);
    let back = at([-1.0, 0.0, 0.0]);
    expected.append(&one, places.iter().map(|place| place.after(&back)), 0..1);
    expected.combine(CsgOp::Union, 4);
    expected.push(sphere(8.0), &Transform::IDENTITY, 0..1);
    expected.combine(CsgOp::Difference, 3);
    assert_eq!((csg.len(), csg.results()), (6, 1));
    // (x, y, z) turns to (-y, x, z); the copies stand at (1, 0), (11, 0), (1, 20), (11, 20).
    let positions = [[0.0, 1.0], [0.0, 11.0], [-20.0, 1.0], [-20.0, 11.0]];
    for (place, [x, y]) in places.iter().zip(positions) {
        let origin = place.matrix().translation;
        assert!(
            (origin - DVec3::new(x, y, 5.0)).length() < 1e-13,
            "{origin}"
        );
        let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        assert!(place.matrix().matrix3.abs_diff_eq(quarter, 1e-15));
    }
    for i in 0..6 {
        assert_eq!(csg.operand(i).0, expected.operand(i).0);
    }
}

#[test]
fn a_repeat_of_a_repeat_and_of_operators_copies_all_of_it() {
    let pair =
        "Difference(from: Sphere(radius: 1), subtract: [Sphere(radius: 2, center: (1, 0, 0))])";
    let inner = repeat(pair, "");
    let outer = format!(
        "Repeat(count: (1, 1, 3), step: ((0, 0, 0), (0, 0, 0), (0, 0, 100)), of: {inner}, transform: [Scale(2)])"
    );
    for text in [
        format!("Union(of: [Sphere(radius: 7), {outer}])"),
        "Union(of: [Sphere(radius: 7), Instance(of: \"grid\")])".into(),
    ] {
        let scene = scene(&text, &format!("\"grid\": {outer}"));
        let csg = only(&scene);
        assert_eq!((csg.len(), csg.results()), (25, 1));
        for copy in 0..12_u32 {
            let [i, j, k] = [copy % 2, copy / 2 % 2, copy / 4].map(f64::from);
            let [x, y, z] = [20.0 * i, 40.0 * j, 200.0 * k];
            assert_eq!(origin(csg, 1 + 2 * copy), [x, y, z]);
            assert_eq!(origin(csg, 2 + 2 * copy), [x + 2.0, y, z]);
            assert_eq!(radius(csg, 2 + 2 * copy), 2.0);
        }
    }
}

#[test]
fn a_repeat_in_the_world_is_so_many_instances() {
    let ball = "Sphere(radius: 1, center: (1, 0, 0), name: \"ball\", material: \"red\")";
    let named = scene(&repeat(ball, ", name: \"grid\", transform: [Scale(2)]"), "");
    let names: Vec<_> = named
        .instances
        .iter()
        .map(|i| i.name.as_deref().unwrap())
        .collect();
    let expected = [
        "grid[0,0,0]/ball",
        "grid[1,0,0]/ball",
        "grid[0,1,0]/ball",
        "grid[1,1,0]/ball",
    ];
    assert_eq!(names, expected);
    let origins = |scene: &Scene| -> Vec<[f64; 3]> {
        let origin = |i: &Instance| i.world_from_object.point(DVec3::ZERO).to_array();
        scene.instances.iter().map(origin).collect()
    };
    let expected = [[2.0, 0.0], [22.0, 0.0], [2.0, 40.0], [22.0, 40.0]];
    assert_eq!(origins(&named), expected.map(|[x, y]| [x, y, 0.0]));

    let twice = scene(
        "Instance(of: \"grid\"), Instance(of: \"grid\", material: \"blue\", name: \"b\")",
        &format!("\"grid\": {}", repeat("Union(of: [Sphere(radius: 1)])", "")),
    );
    assert_eq!((twice.instances.len(), twice.csgs.len()), (8, 1));
    assert_eq!(twice.instances[7].name.as_deref(), Some("b"));
    let expected = [[0.0, 0.0], [10.0, 0.0], [0.0, 20.0], [10.0, 20.0]].repeat(2);
    let expected: Vec<[f64; 3]> = expected.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    assert_eq!(origins(&twice), expected);
}

/// The definition of PCG-XSH-RR 64/32 (O'Neill 2014).
struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    fn new(seed: u64, stream: u64) -> Self {
        let increment = stream << 1 | 1;
        let mut pcg = Self {
            state: 0,
            increment,
        };
        pcg.next();
        pcg.state = pcg.state.wrapping_add(seed);
        pcg.next();
        pcg
    }

    fn next(&mut self) -> u32 {
        let old = self.state;
        self.state = old
            .wrapping_mul(6364136223846793005)
            .wrapping_add(self.increment);
        let shifted = ((old >> 18 ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }
}

#[test]
fn jitter_is_what_the_generators_definition_gives() {
    // The first numbers of the demonstration that comes with the generator.
    let mut demo = Pcg::new(42, 54);
    assert_eq!(
        [0; 3].map(|_: u32| demo.next()),
        [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330]
    );

    let repeat = Repeat {
        count: [2, 1, 2],
        step: [DVec3::X, DVec3::Y, DVec3::Z],
        jitter: DVec3::new(0.25, 0.0, 2.0),
        seed: 7,
    };
    let mut pcg = Pcg::new(7, 0x0a02_bdbf_7bb3_c0a7);
    let mut uniform = || (f64::from(pcg.next()) + 0.5) / 2_147_483_648.0 - 1.0;
    let grid = [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]];
    let expected = grid.map(|index: [u32; 3]| {
        let [x, _, z] = [uniform(), uniform(), uniform()];
        let [i, j, k] = index.map(f64::from);
        (index, DVec3::new(i + 0.25 * x, j, k + 2.0 * z))
    });
    let positions: Vec<([u32; 3], DVec3)> = repeat.positions().collect();
    assert_eq!(positions, expected);
    // By another implementation still: r = 0x4be788d7 and 0x68ef91ea.
    assert!((positions[0].1.x - 0.25 * -0.406_996_626_639_738_7).abs() < 1e-16);
    assert!((positions[0].1.z - 2.0 * -0.180_188_904_283_568_26).abs() < 1e-15);
}

#[test]
fn a_file_of_copies_has_the_jitter_of_its_seed() {
    let scene = scene(
        "Union(of: [Repeat(count: (3, 1, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), jitter: (0.5, 0.5, 0.5), seed: 7,
            of: Sphere(radius: 1))])",
        "",
    );
    let mut pcg = Pcg::new(7, 0x0a02_bdbf_7bb3_c0a7);
    for copy in 0..3 {
        let shift = [0; 3].map(|_| (f64::from(pcg.next()) + 0.5) / 4_294_967_296.0 - 0.5);
        let expected = DVec3::from(shift) + f64::from(copy) * DVec3::X;
        let origin = DVec3::from(origin(only(&scene), copy));
        assert!(
            (origin - expected).length() < 1e-15,
            "{origin} is not {expected}"
        );
    }
}

#[test]
fn a_million_copies_share_what_they_can() {
    let scene = scene(
        "Difference(from: Box(size: (1, 1, 1)), subtract: [Repeat(count: (100, 100, 100),
            step: ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01)), jitter: (0.001, 0.001, 0.001), of: Sphere(radius: 0.002))])",
        "",
    );
    let csg = only(&scene);
    assert_eq!((csg.len(), csg.results()), (1_000_001, 1));
    assert_eq!(scene.instances[0].materials.len(), 1);
    let last = DVec3::from(origin(csg, 1_000_000));
    assert!((last - DVec3::splat(0.99)).abs().max_element() < 0.001);
}
