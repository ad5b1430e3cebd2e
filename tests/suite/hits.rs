//! Hits of meshes and solids against Embree's. The long run of the mesh part, on any scene:
//! `tests/with-embree.sh cargo run --release --features embree -- check INPUT --rays 10000000`

use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::{Accel, Placed};
use solidtrace::check::{CheckSettings, Checker, Tally};
use solidtrace::embree::{EmbreeOptions, EmbreeScene, UserShape};
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::io::read_model;
use solidtrace::math::{Bounds, Ray, Transform};
use solidtrace::sampling::uniform_sphere;

use crate::csg::oracle::{lathe, outside};
use crate::support::Build;
use crate::support::comparison::{comparison_cases, framed};
use crate::support::meshes::moved;

const ROBUST: EmbreeOptions = EmbreeOptions {
    robust: true,
    high_quality: false,
    threads: 1,
    avx2: false,
};

/// The model's only mesh.
fn model(path: &Path) -> Mesh {
    read_model(path).unwrap().meshes.remove(0)
}

#[test]
fn meshes_are_hit_where_embree_hits_them_or_the_arbiter_sides_with_us() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut cases = comparison_cases();
    let girl = model(&root.join("assets/girl.obj"));
    cases.push((
        "girl moved by 1e6".into(),
        moved(girl.clone(), 1.0, Vec3::splat(1e6)),
    ));
    cases.push(("girl".into(), girl));
    let shared = root.join("../shared/data/girl.obj");
    if shared.exists() {
        cases.push(("the report's girl".into(), model(&shared)));
    } else {
        println!("left out: the report's girl, which is not part of the project");
    }
    let mut sum = Tally::default();
    for (name, mesh) in cases {
        let world = framed(vec![mesh], &[(0, DAffine3::IDENTITY)]).world();
        let settings = CheckSettings {
            rays: 21_000,
            seed: 11,
            heat_map: false,
        };
        let report = Checker::new(&world).unwrap().run(&settings, &());
        for (class, tally) in &report.classes {
            assert_eq!(tally.ours_wrong, 0, "{name} {class:?}: {tally:?}");
        }
        sum += report.sum();
    }
    println!("{sum:?}");
    assert!(sum.hits > sum.rays / 3, "{sum:?}");
}

/// A solid in its place, intersected by code of its own: dense steps along the ray and bisection on the
/// sign of a distance-like function.
struct Marched {
    solid: Solid,
    place: Transform,
    /// In world space.
    bounds: Bounds,
}

impl Marched {
    /// Negative inside; distance-like.
    fn value(&self, p: DVec3) -> f64 {
        outside(&self.solid, self.place.inverse_point(p))
    }
}

/// Steps of the march over the ray's way through the bounds.
const STEPS: u32 = 400;

impl UserShape for Marched {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn intersect(&self, ray: &Ray) -> Option<f64> {
        let (a, b) = (
            (self.bounds.min - ray.origin) / ray.direction,
            (self.bounds.max - ray.origin) / ray.direction,
        );
        let start = a.min(b).max_element().max(ray.tmin);
        let end = a.max(b).min_element().min(ray.tmax);
        let at = |i: u32| start + (end - start) * f64::from(i) / f64::from(STEPS);
        let inside = |t: f64| self.value(ray.at(t)) < 0.0;
        let first = inside(start);
        let step = (1..=STEPS).find(|&i| inside(at(i)) != first)?;
        let (mut low, mut high) = (at(step - 1), at(step));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if inside(middle) == first {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }
}

fn solids() -> [Solid; 5] {
    [
        Solid::Sphere { radius: 0.7 },
        Solid::Box {
            half: DVec3::new(0.5, 0.3, 0.6),
        },
        Solid::Cylinder {
            radius: 0.4,
            height: 1.1,
        },
        Solid::Cone {
            from_radius: 0.6,
            to_radius: 0.0,
            height: 1.2,
        },
        Solid::Torus {
            major: 0.6,
            minor: 0.2,
        },
    ]
}

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3()
}

/// A ray through a ball of the given radius around the origin, exact in f32.
fn through(radius: f64, rng: &mut Pcg64Mcg) -> Ray {
    let origin = (3.0 * radius * direction(rng)).as_vec3().as_dvec3();
    let target = radius * rng.random::<f64>().cbrt() * direction(rng);
    Ray::new(origin, (target - origin).as_vec3().as_dvec3())
}

#[test]
fn a_crowd_of_solids_is_hit_where_embree_finds_user_geometry() {
    let mut rng = Pcg64Mcg::seed_from_u64(77);
    let placed: Vec<Placed> = (0..60)
        .map(|i| {
            let turn = DQuat::from_axis_angle(direction(&mut rng), rng.random_range(0.0..TAU));
            let at = 4.0 * rng.random::<f64>().cbrt() * direction(&mut rng);
            let place = DAffine3::from_mat3_translation(DMat3::from_quat(turn), at);
            Placed {
                shape: Shape::Solid(solids()[i % 5]),
                world_from_object: Transform::new(place).unwrap(),
            }
        })
        .collect();
    let marched = placed.iter().map(|p| {
        let Shape::Solid(solid) = p.shape else {
            unreachable!("all are solids");
        };
        Box::new(Marched {
            solid,
            place: p.world_from_object,
            bounds: p.world_from_object.bounds(&solid.bounds()),
        }) as Box<dyn UserShape>
    });
    let embree = EmbreeScene::of_shapes(marched.collect(), ROBUST).unwrap();
    let accel = Accel::build(&[], &[], placed).unwrap();
    let (mut hits, mut missed, count) = (0, 0, 30_000);
    for _ in 0..count {
        let ray = through(4.5, &mut rng);
        let (ours, theirs) = (accel.intersect(&ray), embree.intersect(&ray));
        assert_eq!(accel.occluded(&ray), ours.is_some());
        match (ours, theirs) {
            (Some(a), Some(b)) if (a.t - f64::from(b.t)).abs() < 1e-5 => {
                hits += 1;
                assert_eq!(a.instance, b.primitive);
            }
            // A march steps over pieces shorter than a step; it never finds what is not there.
            (Some(a), b) => {
                assert!(
                    b.is_none_or(|b| f64::from(b.t) > a.t),
                    "{ray:?}: {a:?} {b:?}"
                );
                missed += 1;
            }
            (None, Some(b)) => panic!("{ray:?}: only Embree hits, {b:?}"),
            (None, None) => {}
        }
    }
    println!("{hits} of {count} rays agree on a hit, {missed} graze");
    assert!(hits > count / 3 && missed < count / 200, "{hits} {missed}");
}

#[test]
fn solids_are_hit_where_embree_hits_their_fine_tessellation() {
    const N: u32 = 720;
    let half_turn = |radius: f64| -> Vec<(f64, f64)> {
        (0..=N)
            .map(|i| (PI * f64::from(i) / f64::from(N)).sin_cos())
            .map(|(sin, cos)| (radius * sin, radius * cos))
            .collect()
    };
    let ring = |major: f64, minor: f64| -> Vec<(f64, f64)> {
        (0..N)
            .map(|i| (TAU * f64::from(i) / f64::from(N)).sin_cos())
            .map(|(sin, cos)| (major + minor * cos, minor * sin))
            .collect()
    };
    for solid in solids() {
        let mesh = match solid {
            Solid::Sphere { radius } => lathe(&half_turn(radius), N, false),
            Solid::Box { half } => {
                let half = half.as_vec3();
                crate::support::meshes::box_mesh(-half, half)
            }
            Solid::Cylinder { radius, height } => lathe(
                &[(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)],
                N,
                false,
            ),
            Solid::Cone {
                from_radius,
                to_radius,
                height,
            } => lathe(
                &[
                    (0.0, 0.0),
                    (from_radius, 0.0),
                    (to_radius, height),
                    (0.0, height),
                ],
                N,
                false,
            ),
            Solid::Torus { major, minor } => lathe(&ring(major, minor), N, true),
            Solid::Plane | Solid::Rectangle { .. } | Solid::Disk { .. } => {
                unreachable!("closed solids only")
            }
        };
        let embree = EmbreeScene::new(&[(&mesh, &Transform::IDENTITY)], ROBUST).unwrap();
        // The chords of the tessellation stay this near to the surface; f32 adds a little.
        let sagitta = 0.8 * (1.0 - (PI / f64::from(N)).cos()) * 2.0 + 1e-6;
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let (mut steep, mut grazing) = (0, 0);
        for _ in 0..20_000 {
            let ray = through(1.2, &mut rng);
            let ours = solid.closest(&ray).map(|(crossing, _)| crossing);
            let theirs = embree.intersect(&ray);
            let facing = ours.map_or(0.0, |c| {
                let n = solid.normal(solid.project(ray.at(c.t), c.face), c.face);
                n.dot(ray.direction.normalize()).abs()
            });
            if facing < 0.1 {
                // Seen edge-on, or missed: the tessellation may be on the other side of the silhouette.
                grazing += u32::from(ours.is_some() != theirs.is_some());
                continue;
            }
            let (Some(ours), Some(theirs)) = (ours, theirs) else {
                // Only rims and edges can be missed at a steep angle.
                grazing += 1;
                continue;
            };
            let distance = (ours.t - f64::from(theirs.t)).abs() * ray.direction.length();
            if distance <= 3.0 * sagitta / facing {
                steep += 1;
            } else {
                grazing += 1;
            }
        }
        println!("{solid:?}: {steep} agree, {grazing} at silhouettes and rims");
        assert!(steep > 3000 && grazing < 20, "{solid:?}: {steep} {grazing}");
    }
}
