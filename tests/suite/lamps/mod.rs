//! Light sources with an extent, and spots: what they shed, and how their points are drawn.

mod density;
mod forms;
mod list;
mod spot;

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::light::{LightSample, Source};
use solidtrace::math::Ray;
use solidtrace::sampling::{Sampler, SamplerKind};
use solidtrace::scene::Scene;
use solidtrace::texture::{Pattern, Ramp, Texture};
use solidtrace::world::World;

use crate::support::meshes::box_mesh;
use crate::support::{Build, diffuse, empty_scene};

/// Turned and moved.
fn askew() -> DAffine3 {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    DAffine3::from_mat3_translation(turn, DVec3::new(0.1, -0.2, 0.15))
}

/// Stretched by another factor along each axis, sheared, turned and moved.
fn sheared() -> DAffine3 {
    let shear = DMat3::from_cols(
        DVec3::new(1.3, 0.2, 0.0),
        DVec3::new(0.4, 0.7, 0.1),
        DVec3::new(-0.3, 0.1, 1.1),
    );
    askew() * DAffine3::from_mat3(shear)
}

fn mesh(corners: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        positions: corners.iter().copied().map(Vec3::from).collect(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    }
}

/// One lamp of radiance 1 in an empty world.
fn alone(solid: Solid, at: DAffine3) -> World {
    let mut scene = empty_scene();
    let lamp = scene.material(diffuse(0.0), 1.0);
    scene.place(Shape::Solid(solid), lamp, at);
    scene.world()
}

fn alone_mesh(mesh: Mesh) -> World {
    let mut scene = empty_scene();
    let lamp = scene.material(diffuse(0.0), 1.0);
    scene.mesh(mesh, lamp);
    scene.world()
}

const SOLIDS: [(&str, Solid); 8] = [
    ("sphere", Solid::Sphere { radius: 0.8 }),
    (
        "rectangle",
        Solid::Rectangle {
            half: DVec2::new(1.0, 0.4),
        },
    ),
    ("disk", Solid::Disk { radius: 0.9 }),
    (
        "box",
        Solid::Box {
            half: DVec3::new(0.7, 0.4, 0.5),
        },
    ),
    (
        "cylinder",
        Solid::Cylinder {
            radius: 0.4,
            height: 1.1,
        },
    ),
    (
        "cone",
        Solid::Cone {
            from_radius: 0.7,
            to_radius: 0.2,
            height: 0.9,
        },
    ),
    (
        "pointed cone",
        Solid::Cone {
            from_radius: 0.0,
            to_radius: 0.8,
            height: 0.7,
        },
    ),
    (
        "torus",
        Solid::Torus {
            major: 0.7,
            minor: 0.3,
        },
    ),
];

/// Every kind of lamp, alone.
fn lamps() -> Vec<(String, World)> {
    let places = [("askew", askew()), ("sheared", sheared())];
    let mut lamps: Vec<(String, World)> = (SOLIDS.iter())
        .flat_map(|(name, solid)| {
            places.map(|(how, at)| (format!("{name}, {how}"), alone(*solid, at)))
        })
        .collect();
    let triangle = [[-0.6, -0.5, 0.3], [0.9, -0.2, -0.1], [0.1, 0.8, 0.2]];
    let sliver = [[-0.9, 0.0, 0.1], [0.9, 0.04, 0.0], [0.0, 0.0, 0.1]];
    lamps.push(("triangle".into(), alone_mesh(mesh(&triangle, &[[0, 1, 2]]))));
    lamps.push(("sliver".into(), alone_mesh(mesh(&sliver, &[[0, 1, 2]]))));
    // In f32 its corners are not quite in one plane.
    let square = [[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]];
    let square = square.map(|[x, y]| askew().transform_point3(DVec3::new(x, y, 0.0)));
    let square = mesh(
        &square.map(|p| p.as_vec3().to_array()),
        &[[0, 1, 2], [0, 2, 3]],
    );
    lamps.push(("rounded square".into(), alone_mesh(square)));
    let cube = box_mesh(Vec3::new(-0.5, -0.3, 0.0), Vec3::new(0.4, 0.6, 0.2));
    lamps.push(("box of triangles".into(), alone_mesh(cube)));
    lamps
}

/// From far and near, above and beside, and from inside where there is one.
const VIEWERS: [DVec3; 5] = [
    DVec3::new(25.0, -14.0, 30.0),
    DVec3::new(1.5, 1.9, -1.2),
    DVec3::new(0.3, -0.4, 1.6),
    DVec3::new(1.1, 0.15, 0.12),
    DVec3::new(0.13, -0.16, 0.31),
];

/// Canonical samples for a choice and a point.
fn canonical(kind: SamplerKind, seed: u64, index: u32) -> (f32, Vec2) {
    let [pick, u, v, _] = Sampler::new(kind, seed, (0, 0), index).set(0);
    (pick, Vec2::new(u, v))
}

/// Where a sample of a lamp is.
fn place(sample: &LightSample) -> DVec3 {
    let Source::Point(p) = sample.source else {
        panic!("{sample:?}");
    };
    p
}

/// By light sampling, on a surface at `p` that faces along `n`.
fn irradiance(world: &World, p: DVec3, n: DVec3) -> f64 {
    const COUNT: u32 = 1 << 14;
    let arriving = (0..COUNT).filter_map(|i| {
        let (pick, u2) = canonical(SamplerKind::Sobol, 5, i);
        let sample = world.sample_light(p, pick, u2)?;
        let to = place(&sample) - p;
        let segment = Ray {
            tmax: 1.0,
            ..Ray::new(p, to)
        };
        let cos = n.dot(to.normalize());
        let seen = cos > 0.0 && !world.occluded(&segment);
        seen.then(|| f64::from(sample.li.x / sample.divisor()) * cos)
    });
    arriving.sum::<f64>() / f64::from(COUNT)
}

/// A matt floor between two matt walls under lamps of all kinds, some textured.
pub fn showroom() -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (12, 12);
    let eye = DVec3::new(0.0, 1.5, 6.0);
    scene.cameras = vec![crate::support::camera(eye, DVec3::new(0.0, 0.9, 0.0))];
    let white = scene.material(diffuse(0.8), 0.0);
    let lamp = scene.material(diffuse(0.3), 3.0);
    let textured = scene.material(diffuse(0.3), 4.0);
    scene.materials[textured.0 as usize].emission_texture = Some(Texture::Pattern {
        pattern: Pattern::Checker { step: 0.35 },
        colors: Ramp::between(Vec3::new(0.1, 0.9, 1.0), Vec3::new(1.6, 0.3, 0.0)),
    });
    let level = DMat3::from_rotation_x(-FRAC_PI_2);
    let floor = DAffine3::from_mat3(level);
    scene.place(Shape::Solid(Solid::Plane), white, floor);
    let back = DAffine3::from_translation(DVec3::NEG_Z * 2.0);
    scene.place(Shape::Solid(Solid::Plane), white, back);
    for (i, (_, solid)) in SOLIDS.into_iter().enumerate() {
        let (x, y) = (f64::from(i as u32 % 4) - 1.5, f64::from(i as u32 / 4));
        let at = DAffine3::from_translation(DVec3::new(1.3 * x, 0.7 + 1.4 * y, 0.2 * x));
        let small = DAffine3::from_scale(DVec3::splat(0.55));
        let place = at * small * if i % 3 == 0 { askew() } else { sheared() };
        let material = if i % 2 == 1 { textured } else { lamp };
        scene.place(Shape::Solid(solid), material, place);
    }
    let uvs = [[0.0, 0.0], [1.0, 0.2], [0.9, 1.3], [-0.1, 1.1]].map(Vec2::from);
    let panel = Mesh {
        uvs: uvs.to_vec(),
        ..mesh(
            &[
                [-1.2, 2.6, -1.0],
                [1.2, 2.6, -1.0],
                [1.2, 2.6, 0.5],
                [-1.2, 2.6, 0.5],
            ],
            &[[0, 1, 2], [0, 2, 3]],
        )
    };
    let screen = scene.material(diffuse(0.0), 3.0);
    scene.materials[screen.0 as usize].emission_texture = Some(Texture::Pattern {
        pattern: Pattern::UvChecker { step: 0.23 },
        colors: Ramp::between(Vec3::new(0.0, 0.2, 2.0), Vec3::new(1.0, 0.5, 0.1)),
    });
    scene.mesh(panel, screen);
    scene
}
