//! Clear objects inside one another: at each boundary light bends by the two media that meet there.

use glam::{DAffine3, DVec3, Vec2};
use solidtrace::geometry::{Csg, CsgOp, Operand, Shape, Solid};
use solidtrace::material::{Fresnel, MaterialId};
use solidtrace::math::{Ray, Transform};
use solidtrace::scene::Scene;
use solidtrace::world::{Media, World};

use crate::support::{Build, dielectric, empty_scene};

fn clear(scene: &mut Scene, ior: f32) -> MaterialId {
    scene.material(dielectric(ior, Fresnel::None), 0.0)
}

/// A point of a path: where, and the direction in which it goes on.
struct Step {
    p: DVec3,
    n: DVec3,
    wi: DVec3,
}

/// The path of a ray that is never reflected.
fn path(world: &World, mut ray: Ray, mut media: Media) -> Vec<Step> {
    let mut steps = Vec::new();
    while let Some(hit) = world.intersect(&ray) {
        let point = world.surface(&ray, &hit);
        let bsdf = world.bsdf(&point, &media);
        let wo = -ray.direction.as_vec3();
        let sample = bsdf.sample(wo, 0.5, Vec2::splat(0.5)).unwrap();
        media.follow(&point, world.material(&point), sample.wi);
        ray = point.spawn(sample.wi);
        steps.push(Step {
            p: point.p,
            n: point.ng.as_dvec3(),
            wi: ray.direction,
        });
        assert!(steps.len() < 20, "the path does not end");
    }
    steps
}

/// Checks that at step `i` the sines relate as the indices do, and the ray stays in the plane of incidence.
fn assert_bends(before: DVec3, step: &Step, from: f64, to: f64) {
    let (a, b) = (from * before.cross(step.n), to * step.wi.cross(step.n));
    assert!(
        a.distance(b) < 2e-6 && before.dot(step.n) * step.wi.dot(step.n) > 0.0,
        "from {from} to {to}: {a} and {b}"
    );
}

fn assert_path(steps: &[Step], start: DVec3, indices: &[f64]) {
    assert_eq!(steps.len(), indices.len() - 1);
    let mut before = start;
    for (step, pair) in steps.iter().zip(indices.windows(2)) {
        assert_bends(before, step, pair[0], pair[1]);
        before = step.wi;
    }
}

/// Glass in water in air, in either order of the scene's list.
fn nested(glass_first: bool) -> World {
    let mut scene = empty_scene();
    let (water, glass) = (clear(&mut scene, 1.33), clear(&mut scene, 1.5));
    let mut objects = [(2.0, water), (1.0, glass)];
    if glass_first {
        objects.reverse();
    }
    for (radius, material) in objects {
        scene.solid(Solid::Sphere { radius }, material, DVec3::ZERO);
    }
    scene.world()
}

#[test]
fn nested_glass_bends_light_by_the_media_on_both_sides() {
    let direction = DVec3::new(0.1, 0.02, -1.0).normalize();
    for glass_first in [false, true] {
        let world = nested(glass_first);
        let ray = Ray::new(DVec3::new(0.3, 0.2, 5.0), direction);
        let steps = path(&world, ray, Media::default());
        assert_path(&steps, direction, &[1.0, 1.33, 1.5, 1.33, 1.0]);
    }
}

#[test]
fn a_path_that_starts_inside_knows_its_media() {
    for glass_first in [false, true] {
        let world = nested(glass_first);
        let direction = DVec3::new(0.6, 0.3, -0.5).normalize();
        let inside = Ray::new(DVec3::new(0.4, 0.3, 0.1), direction);
        let steps = path(&world, inside, world.media_at(inside.origin));
        assert_path(&steps, direction, &[1.5, 1.33, 1.0]);
        let between = Ray::new(DVec3::new(1.4, 0.3, 0.1), DVec3::X);
        let steps = path(&world, between, world.media_at(between.origin));
        assert_path(&steps, DVec3::X, &[1.33, 1.0]);
    }
}

#[test]
fn where_objects_overlap_the_one_entered_last_rules() {
    let mut scene = empty_scene();
    let (water, glass) = (clear(&mut scene, 1.33), clear(&mut scene, 1.5));
    scene.solid(Solid::Sphere { radius: 1.0 }, water, DVec3::ZERO);
    scene.solid(Solid::Sphere { radius: 1.0 }, glass, DVec3::X);
    let world = scene.world();
    let direction = DVec3::new(1.0, 0.08, 0.0).normalize();
    let ray = Ray::new(DVec3::new(-3.0, 0.1, 0.2), direction);
    // Into the water, into the glass, out of the water while in the glass, out of the glass.
    let steps = path(&world, ray, Media::default());
    assert_path(&steps, direction, &[1.0, 1.33, 1.5, 1.5, 1.0]);
}

#[test]
fn a_union_of_glass_has_no_inner_faces() {
    let mut scene = empty_scene();
    let glass = clear(&mut scene, 1.5);
    let mut csg = Csg::default();
    let half = DVec3::ONE;
    for x in [-1.0, 1.0] {
        let at = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        let place = Transform::new(at).unwrap();
        csg.push(Operand::Solid(Solid::Box { half }), &place, 0..1);
    }
    csg.push(
        Operand::Solid(Solid::Sphere { radius: 0.9 }),
        &Transform::IDENTITY,
        0..1,
    );
    csg.combine(CsgOp::Union, 3);
    scene.csg(csg, &[glass], DAffine3::IDENTITY);
    let world = scene.world();
    for (y, z) in [(0.1, 0.2), (-0.7, 0.3), (0.95, -0.9), (0.0, 0.0)] {
        let ray = Ray::new(DVec3::new(-5.0, y, z), DVec3::X);
        let steps = path(&world, ray, Media::default());
        assert_path(&steps, DVec3::X, &[1.0, 1.5, 1.0]);
        assert_eq!(steps[0].p.x, -2.0);
        assert_eq!(steps[1].p.x, 2.0);
    }
}

#[test]
fn a_bubble_cut_out_of_glass_is_air() {
    let mut scene = empty_scene();
    let (glass, water) = (clear(&mut scene, 1.5), clear(&mut scene, 1.33));
    let mut csg = Csg::default();
    for (slot, radius) in [(0, 2.0), (1, 1.0)] {
        csg.push(
            Operand::Solid(Solid::Sphere { radius }),
            &Transform::IDENTITY,
            slot..slot + 1,
        );
    }
    csg.combine(CsgOp::Difference, 2);
    // The cut has a material of its own; the medium that a path leaves by it is still the glass.
    scene.csg(csg, &[glass, water], DAffine3::IDENTITY);
    let world = scene.world();
    let direction = DVec3::new(0.05, 0.02, -1.0).normalize();
    let ray = Ray::new(DVec3::new(0.3, 0.2, 5.0), direction);
    let steps = path(&world, ray, Media::default());
    assert_path(&steps[..2], direction, &[1.0, 1.5, 1.0]);
    let shape = world.scene().instances[0].shape;
    assert!(matches!(shape, Shape::Csg(_)));
}
