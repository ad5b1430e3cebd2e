//! The peer itself, against closed forms: what it says must be right before it may judge.

#[cfg(not(feature = "embree"))]
#[test]
fn without_the_feature_the_suite_says_that_embree_is_left_out() {
    use std::io::Write;
    // Past the test harness, which shows what a passing test prints to nobody.
    let _ = writeln!(
        std::io::stderr(),
        "\nleft out: comparisons with Embree (`tests/run.sh` brings Embree and runs them)"
    );
}

#[cfg(feature = "embree")]
mod peer {
    use std::f64::consts::TAU;

    use glam::{DAffine3, DVec3, Vec3};
    use rayon::prelude::*;
    use solidtrace::embree::{
        EmbreeHit, EmbreeOptions, EmbreePacket, EmbreeRay, EmbreeScene, UserShape,
    };
    use solidtrace::geometry::Mesh;
    use solidtrace::math::{Bounds, Ray, Transform};

    const ROBUST: EmbreeOptions = EmbreeOptions {
        robust: true,
        high_quality: false,
        threads: 1,
        avx2: false,
    };

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            positions: positions.iter().map(|&p| p.into()).collect(),
            triangles: triangles.to_vec(),
            ..Mesh::default()
        }
    }

    fn triangle() -> Mesh {
        mesh(&[[0., 0., 0.], [4., 0., 0.], [0., 2., 0.]], &[[0, 1, 2]])
    }

    /// Straight down on (x, y) from a height of 6, two units a step.
    fn down(x: f64, y: f64) -> Ray {
        Ray::new(DVec3::new(x, y, 6.0), DVec3::new(0.0, 0.0, -2.0))
    }

    fn scene(meshes: &[(&Mesh, &Transform)]) -> EmbreeScene {
        EmbreeScene::new(meshes, ROBUST).unwrap()
    }

    #[test]
    fn a_triangle_is_hit_at_its_closed_form() {
        for robust in [false, true] {
            let options = EmbreeOptions {
                robust,
                threads: 1,
                ..EmbreeOptions::default()
            };
            let scene = EmbreeScene::new(&[(&triangle(), &Transform::IDENTITY)], options).unwrap();
            // (1, 1, 0) = p0 + 1/4 (p1 - p0) + 1/2 (p2 - p0)
            let expected = EmbreeHit {
                t: 3.0,
                u: 0.25,
                v: 0.5,
                geometry: 0,
                primitive: 0,
                ng: Vec3::new(0.0, 0.0, 8.0),
            };
            assert_eq!(scene.intersect(&down(1.0, 1.0)), Some(expected));
            assert!(scene.occluded(&down(1.0, 1.0)));
            for (x, y) in [(-0.1, 1.0), (1.0, -0.1), (3.0, 1.0)] {
                assert_eq!(scene.intersect(&down(x, y)), None, "beside at {x} {y}");
                assert!(!scene.occluded(&down(x, y)), "beside at {x} {y}");
            }
        }
    }

    #[test]
    fn hits_outside_the_rays_range_do_not_count() {
        let scene = scene(&[(&triangle(), &Transform::IDENTITY)]);
        for (tmin, tmax, hit) in [
            (0.0, 2.9, false),
            (0.0, 3.1, true),
            (2.9, 3.1, true),
            (3.1, f64::INFINITY, false),
        ] {
            let ray = Ray {
                tmin,
                tmax,
                ..down(1.0, 1.0)
            };
            assert_eq!(scene.intersect(&ray).is_some(), hit, "{tmin} to {tmax}");
            assert_eq!(scene.occluded(&ray), hit, "{tmin} to {tmax}");
        }
    }

    #[test]
    fn a_quad_has_no_gap_and_names_its_triangles() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let quad = mesh(&corners, &[[0, 1, 2], [0, 2, 3]]);
        let scene = scene(&[(&quad, &Transform::IDENTITY)]);
        for i in 1..100 {
            for j in 1..100 {
                let (x, y) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
                let hit = scene.intersect(&down(x, y)).expect("a hit");
                assert_eq!(hit.t, 3.0);
                if i != j {
                    assert_eq!(hit.primitive, u32::from(y > x), "at {x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_nearest_mesh_wins_in_its_place() {
        let raised = Transform::new(DAffine3::from_translation(DVec3::Z)).unwrap();
        let wide = Transform::new(DAffine3::from_scale(DVec3::new(10.0, 10.0, 1.0))).unwrap();
        let triangle = triangle();
        let scene = scene(&[(&triangle, &wide), (&triangle, &raised)]);
        let near = scene.intersect(&down(1.0, 1.0)).unwrap();
        assert_eq!((near.geometry, near.t), (1, 2.5));
        let wide = scene.intersect(&down(10.0, 10.0)).unwrap();
        assert_eq!((wide.geometry, wide.t, wide.u, wide.v), (0, 3.0, 0.25, 0.5));
    }

    #[test]
    fn the_identity_keeps_every_vertex_to_the_bit() {
        // Planes z = c for awkward c, with edges that are powers of two, so that no step of finding t rounds.
        for c in [0.1_f32, 1.0 / 3.0, 1e-7, 12345.678, 1e10_f32.next_up()] {
            let far = c.log2().ceil().exp2();
            let plane = mesh(
                &[[-far, -far, c], [3.0 * far, -far, c], [-far, 3.0 * far, c]],
                &[[0, 1, 2]],
            );
            let up = Ray::new(DVec3::ZERO, DVec3::Z);
            let hit = scene(&[(&plane, &Transform::IDENTITY)]).intersect(&up);
            assert_eq!(hit.expect("a hit").t, c);
        }
    }

    #[test]
    fn what_embree_would_leave_out_in_silence_is_an_error() {
        let new = |mesh: &Mesh| EmbreeScene::new(&[(mesh, &Transform::IDENTITY)], ROBUST);
        let message = |mesh: &Mesh| new(mesh).err().expect("an error").message().to_owned();
        let huge = mesh(&[[0., 0., 0.], [2e18, 0., 0.], [0., 2., 0.]], &[[0, 1, 2]]);
        assert!(message(&huge).starts_with("mesh 0"), "{}", message(&huge));
        let stray = mesh(&[[0., 0., 0.]], &[[0, 0, 7]]);
        assert!(message(&stray).contains('7'), "{}", message(&stray));
        let endless = EmbreeScene::of_shapes(
            vec![Box::new(Ball {
                center: DVec3::ZERO,
                radius: f64::INFINITY,
            })],
            ROBUST,
        );
        assert!(endless.is_err());
    }

    struct Ball {
        center: DVec3,
        radius: f64,
    }

    impl UserShape for Ball {
        fn bounds(&self) -> Bounds {
            Bounds {
                min: self.center - self.radius,
                max: self.center + self.radius,
            }
        }

        fn intersect(&self, ray: &Ray) -> Option<f64> {
            let (d, to) = (ray.direction, self.center - ray.origin);
            let middle = to.dot(d) / d.length_squared();
            let beside = (to - middle * d).length_squared();
            let half = ((self.radius.powi(2) - beside) / d.length_squared()).sqrt();
            // NaN where the line misses, and then no comparison holds.
            [middle - half, middle + half]
                .into_iter()
                .find(|&t| t > ray.tmin && t < ray.tmax)
        }
    }

    fn balls(shapes: impl IntoIterator<Item = (DVec3, f64)>) -> EmbreeScene {
        let shapes = shapes
            .into_iter()
            .map(|(center, radius)| Box::new(Ball { center, radius }) as Box<dyn UserShape>)
            .collect();
        EmbreeScene::of_shapes(shapes, ROBUST).unwrap()
    }

    #[test]
    fn a_ball_of_the_callers_own_is_hit_at_its_closed_form() {
        let scene = balls([(DVec3::ZERO, 1.0)]);
        let outside = scene.intersect(&down(0.6, 0.0)).unwrap();
        assert_eq!(
            (outside.t, outside.geometry, outside.primitive),
            (2.6, 0, 0)
        );
        let inside = Ray::new(DVec3::ZERO, DVec3::new(0.0, 0.0, -2.0));
        assert_eq!(scene.intersect(&inside).unwrap().t, 0.5);
        assert!(scene.occluded(&inside));
        let short = Ray {
            tmax: 0.4,
            ..inside
        };
        assert_eq!(scene.intersect(&short), None);
        assert!(!scene.occluded(&short));
        assert_eq!(scene.intersect(&down(1.01, 0.0)), None);
    }

    #[test]
    fn many_threads_find_the_nearest_of_many_balls() {
        // A ring of balls around the axis; a ray outward at angle i meets ball i alone, at distance 99.5.
        let count = 500_u32;
        let outward = |i: u32| {
            let (y, x) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
            DVec3::new(x, y, 0.0)
        };
        let scene = balls((0..count).map(|i| (100.0 * outward(i), 0.5)));
        (0..count).into_par_iter().for_each(|i| {
            let ray = Ray::new(DVec3::ZERO, outward(i));
            let hit = scene.intersect(&ray).expect("a hit");
            assert_eq!(hit.primitive, i);
            assert!((hit.t - 99.5).abs() < 1e-4, "{hit:?}");
            assert!(scene.occluded(&ray));
        });
    }

    /// The square from (-1, -1) to (1, 1) at height 0.
    fn square() -> Mesh {
        mesh(
            &[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]],
            &[[0, 1, 2], [0, 2, 3]],
        )
    }

    /// Downward rays on a 16 by 16 grid from (-1.875, -1.875) to (1.875, 1.875), with how high they start.
    fn grid() -> (Vec<Ray>, Vec<f64>) {
        let at = |i: u32| 0.25 * f64::from(i) - 1.875;
        let points = (0..16).flat_map(|y| (0..16).map(move |x| DVec3::new(at(x), at(y), 0.0)));
        let heights: Vec<f64> = (0..256).map(|i| 1.0 + f64::from(i)).collect();
        let start = |(p, h): (DVec3, &f64)| Ray::new(p + *h * DVec3::Z, DVec3::NEG_Z);
        (points.zip(&heights).map(start).collect(), heights)
    }

    fn meets_square(ray: &Ray) -> bool {
        ray.origin.x.abs().max(ray.origin.y.abs()) < 1.0
    }

    #[test]
    fn many_rays_at_once_are_answered_each_for_itself() {
        let mesh = square();
        let scene = EmbreeScene::new(&[(&mesh, &Transform::IDENTITY)], ROBUST).unwrap();
        assert!(scene.report().bytes > 0);
        let (rays, heights) = grid();
        let short = rays
            .iter()
            .zip(&heights)
            .enumerate()
            .map(|(i, (ray, height))| Ray {
                tmax: if i % 3 == 0 {
                    0.5 * height
                } else {
                    f64::INFINITY
                },
                ..*ray
            });
        let rays: Vec<Ray> = short.collect();
        let singles: Vec<EmbreeRay> = rays.iter().map(EmbreeRay::new).collect();
        let packets: Vec<EmbreePacket> = rays.as_chunks().0.iter().map(EmbreePacket::new).collect();
        let (mut distances, mut blocked) = ([[0.0; 256]; 2], [[false; 256]; 2]);
        scene.intersect_all(&singles, &mut distances[0]);
        scene.intersect_packets(&packets, &mut distances[1]);
        scene.occluded_all(&singles, &mut blocked[0]);
        scene.occluded_packets(&packets, &mut blocked[1]);
        for (i, (ray, height)) in rays.iter().zip(&heights).enumerate() {
            let hits = meets_square(ray) && ray.tmax > *height;
            let distance = if hits { *height as f32 } else { f32::INFINITY };
            assert_eq!(distances.map(|d| d[i]), [distance; 2], "{ray:?}");
            assert_eq!(blocked.map(|b| b[i]), [hits; 2], "{ray:?}");
        }
    }

    #[test]
    fn small_numbers_are_themselves_again_after_many_rays() {
        let mesh = square();
        let scene = EmbreeScene::new(&[(&mesh, &Transform::IDENTITY)], ROBUST).unwrap();
        let (rays, _) = grid();
        let rays: Vec<EmbreeRay> = rays.iter().map(EmbreeRay::new).collect();
        scene.intersect_all(&rays, &mut [0.0; 256]);
        scene.occluded_all(&rays, &mut [false; 256]);
        assert!(std::hint::black_box(f32::MIN_POSITIVE) * std::hint::black_box(0.5) > 0.0);
    }

    #[test]
    fn instances_stand_where_their_transforms_say() {
        let meshes = [
            square(),
            mesh(&[[9., 9., 9.], [9.5, 9., 9.], [9., 9.5, 9.]], &[[0, 1, 2]]),
        ];
        let at = |scale: f64, x: f64, z: f64| {
            let map = DAffine3::from_scale(DVec3::splat(scale));
            Transform::new(DAffine3::from_translation(DVec3::new(x, 0.0, z)) * map).unwrap()
        };
        let places = [
            (0, at(0.5, 0.0, 3.0)),
            (0, at(2.0, 0.0, 1.0)),
            (1, at(1.0, 0.0, 0.0)),
            (0, at(1.0, 9.0, -1.0)),
        ];
        for options in [
            ROBUST,
            EmbreeOptions {
                high_quality: true,
                ..ROBUST
            },
        ] {
            let scene = EmbreeScene::of_instances(&meshes, &places, options).unwrap();
            let hit = |x, y| {
                scene
                    .intersect(&Ray::new(DVec3::new(x, y, 10.0), DVec3::NEG_Z))
                    .map(|hit| (hit.t, hit.geometry))
            };
            assert_eq!(hit(0.25, 0.3), Some((7.0, 0)));
            assert_eq!(hit(0.75, 0.3), Some((9.0, 1)));
            assert_eq!(hit(9.1, 9.1), Some((1.0, 2)));
            assert_eq!(hit(9.1, 0.3), Some((11.0, 3)));
            assert_eq!(hit(4.0, 0.3), None);
        }
    }
}
