//! Irradiance against closed forms. Howell's catalogue of configuration factors (B-12 to B-15: a small plane to a disk; B-30:
//! to a cylinder), Lambert's formula for polygons, and the silhouettes of convex bodies, which are all that counts where
//! the radiance is the same everywhere.

use std::f64::consts::PI;

use glam::{DAffine3, DVec2, DVec3, Vec2};
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::math::Transform;
use solidtrace::texture::{Pattern, Ramp, Texture};
use solidtrace::world::World;

use super::{SOLIDS, alone, alone_mesh, askew, irradiance, mesh, sheared};
use crate::support::{Build, diffuse, empty_scene};

/// `factor` is of the hemisphere; radiance is 1.
#[track_caller]
fn assert_factor(world: &World, p: DVec3, n: DVec3, factor: f64, tolerance: f64) {
    let ratio = irradiance(world, p, n) / (PI * factor);
    assert!(
        (ratio - 1.0).abs() < tolerance,
        "{ratio} of the closed form {factor} at {p}"
    );
}

/// From a plane at a distance `a` from the axis of a disk of radius `r`, parallel to it, `h` below.
fn disk_parallel(h: f64, a: f64, r: f64) -> f64 {
    let (h, r) = (h / a, r / a);
    let z = 1.0 + h * h + r * r;
    0.5 * (1.0 - (z - 2.0 * r * r) / (z * z - 4.0 * r * r).sqrt())
}

/// The same for a plane that is perpendicular to the disk and faces its axis.
fn disk_perpendicular(h: f64, a: f64, r: f64) -> f64 {
    let (h, r) = (h / a, r / a);
    let z = 1.0 + h * h + r * r;
    0.5 * h * (z / (z * z - 4.0 * r * r).sqrt() - 1.0)
}

#[test]
fn a_disk_sheds_the_light_of_its_closed_form() {
    let radius = 1.5;
    let disk = alone(Solid::Disk { radius }, DAffine3::IDENTITY);
    for side in [-1.0, 1.0] {
        for (h, a) in [(1.0, 2.0), (0.2, 0.7), (4.0, 0.3), (0.5, 3.0)] {
            let p = DVec3::new(a, 0.0, side * h);
            let factor = disk_parallel(h, a, radius);
            assert_factor(&disk, p, -side * DVec3::Z, factor, 0.003);
        }
        for (h, a) in [(1.0, 2.0), (0.3, 1.8), (4.0, 1.6)] {
            let p = DVec3::new(a, 0.0, side * h);
            let factor = disk_perpendicular(h, a, radius);
            assert_factor(&disk, p, DVec3::NEG_X, factor, 0.003);
        }
    }
}

/// From a plane that faces the axis of a cylinder of radius `r`, over one end, to its side of height `l`, from a
/// distance `h` of the axis.
fn cylinder(l: f64, h: f64, r: f64) -> f64 {
    let (l, h) = (l / r, h / r);
    let (x, y) = ((1.0 + h).powi(2) + l * l, (1.0 - h).powi(2) + l * l);
    let end = (l / (h * h - 1.0).sqrt()).atan() / (PI * h);
    let far = (x * (h - 1.0) / (y * (h + 1.0))).sqrt().atan();
    let near = ((h - 1.0) / (h + 1.0)).sqrt().atan();
    end + l / PI * ((x - 2.0 * h) / (h * (x * y).sqrt()) * far - near / h)
}

#[test]
fn a_cylinder_sheds_the_light_of_its_closed_form() {
    for (radius, height, distance) in [(1.0, 2.0, 3.0), (0.4, 2.0, 0.6), (0.5, 0.35, 1.1)] {
        let world = alone(Solid::Cylinder { radius, height }, DAffine3::IDENTITY);
        let factor = cylinder(height, distance, radius);
        for turn in [0.0, 2.5, 4.0] {
            let out = DVec2::from_angle(turn).extend(0.0);
            // At either end, whose cap is not seen.
            for z in [0.0, height] {
                let p = (distance * out).with_z(z);
                assert_factor(&world, p, -out, factor, 0.003);
            }
        }
    }
}

#[test]
fn a_cone_seen_from_beyond_its_apex_sheds_the_light_of_its_base() {
    let cone = Solid::Cone {
        from_radius: 0.8,
        to_radius: 0.3,
        height: 0.5,
    };
    let world = alone(cone, DAffine3::IDENTITY);
    // Over z = 0.8 the whole side is in view, below 0 the base alone.
    for h in [1.0, 1.7, -0.4] {
        let p = h * DVec3::Z;
        let factor = 0.64 / (0.64 + h * h);
        assert_factor(&world, p, -p.normalize(), factor, 0.003);
    }
}

#[test]
fn a_torus_sheds_the_light_of_the_ring_that_it_is_seen_as() {
    let (major, minor) = (0.8, 0.25);
    let world = alone(Solid::Torus { major, minor }, DAffine3::IDENTITY);
    for h in [0.5, 1.0, 3.0_f64] {
        // In the plane of the axis the tube is a circle.
        let (middle, half) = (major.atan2(h), (minor / major.hypot(h)).asin());
        let factor = (middle + half).sin().powi(2) - (middle - half).sin().powi(2);
        assert_factor(&world, h * DVec3::Z, DVec3::NEG_Z, factor, 0.005);
    }
}

#[test]
fn an_ellipsoid_sheds_the_light_of_its_cone_of_tangents() {
    let (a, c) = (0.6, 0.9);
    let stretch = DAffine3::from_scale(DVec3::new(a, a, c) / 0.5);
    let world = alone(Solid::Sphere { radius: 0.5 }, stretch);
    for h in [1.0, 1.5, 6.0] {
        let factor = a * a / (a * a + h * h - c * c);
        assert_factor(&world, h * DVec3::Z, DVec3::NEG_Z, factor, 0.003);
    }
}

/// Lambert's formula: half the sum over edges of the angle times the cosine to the normal of its plane. The polygon is
/// above the horizon.
fn polygon(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    let seen = |i: usize| (corners[i % corners.len()] - p).normalize();
    let edges = (0..corners.len()).map(|i| {
        let (a, b) = (seen(i), seen(i + 1));
        assert!(a.dot(n) >= 0.0, "below the horizon");
        a.angle_between(b) * a.cross(b).normalize_or_zero().dot(n)
    });
    (edges.sum::<f64>() / (2.0 * PI)).abs()
}

const PLACES: [(DVec3, DVec3); 5] = [
    (DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z),
    (DVec3::new(0.4, -0.2, 1.6), DVec3::NEG_Z),
    (DVec3::new(-2.0, 0.5, 1.7), DVec3::X),
    (DVec3::new(2.2, 1.9, -1.4), DVec3::new(-0.6, -0.64, 0.48)),
    (DVec3::new(-9.0, 20.0, 14.0), DVec3::new(0.36, -0.8, -0.48)),
];

#[test]
fn polygons_shed_the_light_of_lamberts_formula() {
    let half = DVec2::new(1.0, 0.4);
    let corners = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
    for at in [DAffine3::IDENTITY, askew(), sheared()] {
        let world = alone(Solid::Rectangle { half }, at);
        let corners = corners.map(|p| at.transform_point3(p));
        for (p, n) in PLACES {
            assert_factor(&world, p, n, polygon(p, n, &corners), 0.003);
        }
    }
    let triangle = [[-0.6, -0.5, 0.3], [0.9, -0.2, -0.1], [0.1, 0.8, 0.2]];
    let world = alone_mesh(mesh(&triangle, &[[0, 1, 2]]));
    let corners = triangle.map(|p| glam::Vec3::from(p).as_dvec3());
    for (p, n) in PLACES {
        assert_factor(&world, p, n, polygon(p, n, &corners), 0.003);
    }
}

#[test]
fn a_textured_rectangle_sheds_the_light_of_its_parts() {
    let half = DVec2::new(1.0, 0.4);
    for at in [DAffine3::IDENTITY, askew(), sheared()] {
        let corners = [(-1.0, -0.4), (1.0, -0.4), (1.0, 0.4), (-1.0, 0.4)];
        let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
        let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let mesh = Mesh {
            uvs: uvs.to_vec(),
            ..mesh(
                &corners.map(|p| p.as_vec3().to_array()),
                &[[0, 1, 2], [2, 3, 0]],
            )
        };
        for of_triangles in [false, true] {
            let mut scene = empty_scene();
            let lamp = scene.material(diffuse(0.0), 2.0);
            scene.materials[lamp.0 as usize].emission_texture = Some(Texture::Pattern {
                pattern: Pattern::UvChecker { step: 0.5 },
                colors: Ramp::between(Rgb::splat(0.25), Rgb::splat(1.5)),
            });
            if of_triangles {
                scene.mesh(mesh.clone(), lamp);
                scene.instances[0].world_from_object = Transform::new(at).unwrap();
            } else {
                scene.place(Shape::Solid(Solid::Rectangle { half }), lamp, at);
            }
            let world = scene.world();
            for (p, n) in PLACES {
                let mut factor = 0.0;
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    // From the middle to one corner.
                    let (x, y) = (x * half.x * DVec3::X, y * half.y * DVec3::Y);
                    let part = [DVec3::ZERO, x, x + y, y].map(|p| at.transform_point3(p));
                    let even = x.x * y.y > 0.0;
                    factor += polygon(p, n, &part) * if even { 0.5 } else { 3.0 };
                }
                assert_factor(&world, p, n, factor, 0.01);
            }
        }
    }
}

/// A panel a thousandth of its size under a ceiling sheds on that what a whole half-space would, but for the rim.
#[test]
fn a_rectangle_sheds_its_radiance_on_what_all_but_touches_it() {
    let world = alone(SOLIDS[1].1, DAffine3::IDENTITY);
    for gap in [1e-3, 1e-5, 1e-7] {
        let ratio = irradiance(&world, DVec3::new(0.2, -0.1, gap), DVec3::NEG_Z) / PI;
        assert!((ratio - 1.0).abs() < 1e-3 + 2.0 * gap, "{gap}: {ratio}");
    }
    // In the plane itself it is seen on edge.
    assert_eq!(
        irradiance(&world, DVec3::new(0.2, -0.1, 0.0), DVec3::Z),
        0.0
    );
}

#[test]
fn a_box_sheds_the_light_of_the_faces_that_are_seen() {
    let Solid::Box { half } = SOLIDS[3].1 else {
        panic!("the fourth is the box");
    };
    for at in [DAffine3::IDENTITY, askew(), sheared()] {
        let world = alone(SOLIDS[3].1, at);
        for (p, n) in PLACES {
            let mut factor = 0.0;
            for axis in 0..3 {
                let [x, y, z] = [0, 1, 2].map(|i| half * DVec3::AXES[(axis + i) % 3]);
                for out in [-x, x] {
                    let corners = [-y - z, y - z, y + z, z - y].map(|c| out + c);
                    let seen = at.inverse().transform_point3(p).dot(out) > out.length_squared();
                    if seen {
                        let corners = corners.map(|c| at.transform_point3(c));
                        factor += polygon(p, n, &corners);
                    }
                }
            }
            assert_factor(&world, p, n, factor, 0.003);
        }
    }
}
