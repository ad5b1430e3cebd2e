//! Bumps give the normals of the surface that they pretend to be.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Csg, CsgOp, Mesh, Operand, Shape, Solid};
use solidtrace::material::{MaterialId, Relief};
use solidtrace::math::{Ray, Transform};
use solidtrace::scene::Scene;
use solidtrace::texture::{Bitmap, Pattern, PixelFilter, Ramp, Sampling, Texture, Wrap};
use solidtrace::world::{SurfacePoint, World};

use crate::support::meshes::sphere_mesh;
use crate::support::{Build, diffuse, empty_scene};

const HEIGHT: f64 = 0.1;

/// `(1 + sin(x + y + z)) / 2`.
fn waves() -> Texture {
    Texture::Pattern {
        pattern: Pattern::Marble {
            grain: 0.0,
            octaves: 1,
            alpha: 0.0,
        },
        colors: Ramp::new(vec![(-1.0, Rgb::ZERO), (1.0, Rgb::ONE)]).unwrap(),
    }
}

/// Its gradient.
fn waves_gradient(p: DVec3) -> DVec3 {
    DVec3::splat(0.5 * p.element_sum().cos())
}

/// The normal of a surface with outward normal `n` that is raised by `HEIGHT` times something with that gradient.
fn raised(n: DVec3, gradient: DVec3) -> DVec3 {
    (n - HEIGHT * gradient.reject_from_normalized(n)).normalize()
}

pub fn with_relief(scene: &mut Scene, relief: Relief) -> MaterialId {
    let id = scene.material(diffuse(0.5), 0.0);
    scene.materials[id.0 as usize].relief = Some(relief);
    id
}

fn bump(scene: &mut Scene, texture: Texture, height: f64) -> MaterialId {
    with_relief(scene, Relief::Bump { texture, height })
}

/// Surfaces that rays from all around towards the middle meet.
pub fn surfaces(world: &World, place: DAffine3) -> Vec<SurfacePoint> {
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    let mut point = |extent: f64| {
        let p: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        extent * DVec3::from_array(p)
    };
    let points: Vec<SurfacePoint> = (0..500)
        .filter_map(|_| {
            let from = place.transform_point3(10.0 * point(1.0).normalize());
            let ray = Ray::new(from, place.transform_point3(point(0.5)) - from);
            let hit = world.intersect(&ray)?;
            Some(world.surface(&ray, &hit))
        })
        .collect();
    assert!(points.len() > 100);
    points
}

fn assert_near(found: Vec3, expected: DVec3, tolerance: f64) {
    let found = found.as_dvec3();
    assert!(
        (found - expected).length() < tolerance,
        "{found} for {expected}"
    );
}

#[test]
fn a_bump_has_the_normals_of_the_raised_surface_on_solids_under_any_transform() {
    for place in [
        DAffine3::IDENTITY,
        DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 2.0, -0.5),
            DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
            DVec3::new(3.0, -1.0, 2.0),
        ),
    ] {
        let solids = [
            Solid::Sphere { radius: 1.5 },
            Solid::Plane,
            Solid::Cylinder {
                radius: 1.0,
                height: 2.0,
            },
            Solid::Torus {
                major: 1.0,
                minor: 0.4,
            },
        ];
        for solid in solids {
            let mut scene = empty_scene();
            let bumpy = bump(&mut scene, waves(), HEIGHT);
            scene.place(Shape::Solid(solid), bumpy, place);
            let normals = Transform::new(place).unwrap();
            let mut bent = 0.0_f32;
            for point in surfaces(&scene.world(), place) {
                let texture = point.texture;
                let expected = raised(texture.n, waves_gradient(texture.p));
                assert_near(point.ns, normals.normal(expected), 1e-4);
                bent = bent.max((point.ns - point.ng).length());
            }
            assert!(bent > 0.02, "{solid:?}");
        }
    }
}

#[test]
fn a_bump_in_a_pit_rises_towards_the_open() {
    let mut csg = Csg::default();
    let half = DVec3::splat(1.0);
    csg.push(
        Operand::Solid(Solid::Box { half }),
        &Transform::IDENTITY,
        0..1,
    );
    let pit = DVec3::new(0.0, 0.0, 1.0);
    let place = Transform::new(DAffine3::from_translation(pit)).unwrap();
    csg.push(Operand::Solid(Solid::Sphere { radius: 0.8 }), &place, 0..1);
    csg.combine(CsgOp::Difference, 2);
    let mut scene = empty_scene();
    let bumpy = bump(&mut scene, waves(), HEIGHT);
    scene.csg(csg, &[bumpy], DAffine3::IDENTITY);
    let mut inside = 0;
    for point in surfaces(&scene.world(), DAffine3::IDENTITY) {
        let in_pit = ((point.p - pit).length() - 0.8).abs() < 1e-9;
        inside += usize::from(in_pit);
        let n = if in_pit {
            (pit - point.p).normalize()
        } else {
            point.ng.as_dvec3()
        };
        assert_near(point.ns, raised(n, waves_gradient(point.p)), 1e-4);
    }
    assert!(inside > 20, "{inside}");
}

#[test]
fn a_bump_rises_from_the_smooth_surface_of_a_mesh() {
    let mut mesh = sphere_mesh(90, |_| 1.0);
    mesh.normals = mesh.positions.clone();
    let mut scene = empty_scene();
    let bumpy = bump(&mut scene, waves(), HEIGHT);
    scene.mesh(mesh, bumpy);
    for point in surfaces(&scene.world(), DAffine3::IDENTITY) {
        let expected = raised(point.p.normalize(), waves_gradient(point.p));
        assert_near(point.ns, expected, 1e-3);
    }
}

/// A picture whose value is u, from 0 at the left edge to 1 at the right one.
fn slope() -> Texture {
    let width = 64;
    let value = |i: usize| Rgb::splat((i as f32 + 0.5) / width as f32);
    Texture::Image {
        image: Arc::new(Bitmap {
            width,
            height: 1,
            pixels: (0..width).map(value).collect(),
        }),
        scale: Rgb::ONE,
        sampling: Sampling {
            wrap: [Wrap::Clamp; 2],
            filter: PixelFilter::Bilinear,
        },
    }
}

#[test]
fn a_picture_as_a_bump_slopes_as_its_surface_coordinates_stretch_it() {
    // u grows by 1 around a cylinder: by 1 / (2 pi r) to the left of the axis.
    let mut scene = empty_scene();
    let bumpy = bump(&mut scene, slope(), 1.0);
    let radius = 0.7;
    let shape = Solid::Cylinder {
        radius,
        height: 2.0,
    };
    scene.place(Shape::Solid(shape), bumpy, DAffine3::IDENTITY);
    let mut seen = 0;
    for point in surfaces(&scene.world(), DAffine3::IDENTITY) {
        let flat = point.p.with_z(0.0);
        let u = point.texture.uv.x;
        // The side, away from where one turn ends and the next begins.
        if (flat.length() - radius).abs() > 1e-9 || !(0.02..0.98).contains(&u) {
            continue;
        }
        seen += 1;
        let n = flat / radius;
        let east = DVec3::Z.cross(n);
        assert_near(point.ns, (n - east / (TAU * radius)).normalize(), 1e-4);
    }
    assert!(seen > 50);

    // On a sheared triangle u = x + y / 2.
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh {
        positions: corners.to_vec(),
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::new(0.5, 1.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let mut scene = empty_scene();
    let bumpy = bump(&mut scene, slope(), 0.3);
    scene.mesh(mesh, bumpy);
    let world = scene.world();
    let ray = Ray::new(DVec3::new(0.3, 0.3, 1.0), DVec3::NEG_Z);
    let point = world.surface(&ray, &world.intersect(&ray).unwrap());
    let gradient = DVec3::new(1.0, 0.5, 0.0);
    assert_near(point.ns, (DVec3::Z - 0.3 * gradient).normalize(), 1e-4);
}

#[test]
fn no_relief_turns_a_normal_below_its_surface_and_a_level_one_leaves_it() {
    let solid = Shape::Solid(Solid::Sphere { radius: 1.0 });
    let normals = |relief: Option<Relief>| {
        let mut scene = empty_scene();
        let material = scene.material(diffuse(0.5), 0.0);
        scene.materials[0].relief = relief;
        let mut mesh = sphere_mesh(6, |_| 1.0);
        mesh.normals = mesh.positions.clone();
        mesh.uvs = mesh.positions.iter().map(|p| p.truncate()).collect();
        scene.place(solid, material, DAffine3::from_translation(DVec3::X));
        scene.mesh(mesh, material);
        surfaces(&scene.world(), DAffine3::IDENTITY)
    };
    let plain = normals(None);
    let flat = Texture::Constant(Rgb::splat(0.5));
    let blue = Texture::Constant(Rgb::new(0.5, 0.5, 1.0));
    for level in [
        Relief::Bump {
            texture: flat,
            height: 1e6,
        },
        Relief::NormalMap {
            texture: blue,
            scale: 1.0,
        },
    ] {
        for (a, b) in plain.iter().zip(normals(Some(level))) {
            assert!(
                a.ns.normalize().abs_diff_eq(b.ns, 1e-5),
                "{} {}",
                a.ns,
                b.ns
            );
        }
    }
    let noise = Texture::Pattern {
        pattern: Pattern::Noise {
            scale: 0.1,
            octaves: 3,
        },
        colors: Ramp::between(Rgb::ZERO, Rgb::ONE),
    };
    for wild in [
        Relief::Bump {
            texture: noise,
            height: 1e3,
        },
        Relief::NormalMap {
            texture: Texture::Constant(Rgb::new(1.0, 0.0, 0.0)),
            scale: 100.0,
        },
    ] {
        for point in normals(Some(wild)) {
            assert!(point.ns.is_normalized());
            assert!(point.ns.dot(point.ng) > -1e-6);
        }
    }
}
