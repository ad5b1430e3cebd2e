//! Cameras against closed forms: which rays they send, how they move, how scene files describe them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec2};
use solidtrace::camera::{Camera, Interpolation, Key, Lens, Motion, Projection};
use solidtrace::math::Ray;
use solidtrace::scene::SceneDescription;

use crate::support::camera;

const MIDDLE: Vec2 = Vec2::splat(0.5);

/// At (1, 2, 9), with the picture's axes x and y and the view along -z.
fn facing(projection: Projection) -> Camera {
    let eye = DVec3::new(1.0, 2.0, 9.0);
    Camera {
        projection,
        ..camera(eye, eye - 3.0 * DVec3::Z)
    }
}

fn close(a: DVec3, b: DVec3) {
    assert!(a.abs_diff_eq(b, 1e-12), "{a} is not {b}");
}

#[test]
fn a_pinhole_has_its_field_from_the_upper_to_the_lower_edge() {
    let lens = facing(Projection::pinhole(FRAC_PI_2))
        .lens((40, 20))
        .unwrap();
    let through = |x, y| {
        let ray = lens.ray(x, y, Vec2::ZERO);
        assert_eq!(ray.origin, DVec3::new(1.0, 2.0, 9.0));
        ray.direction
    };
    close(through(20.0, 10.0), DVec3::NEG_Z);
    close(through(20.0, 0.0), DVec3::new(0.0, 1.0, -1.0).normalize());
    close(through(20.0, 20.0), DVec3::new(0.0, -1.0, -1.0).normalize());
    close(through(40.0, 20.0), DVec3::new(2.0, -1.0, -1.0).normalize());
    close(through(0.0, 10.0), DVec3::new(-2.0, 0.0, -1.0).normalize());
}

/// Where a ray of [`facing`] crosses the plane at `distance` from its eye.
fn at_distance(ray: &Ray, distance: f64) -> DVec3 {
    let t = (9.0 - distance - ray.origin.z) / ray.direction.z;
    ray.origin + t * ray.direction
}

#[test]
fn the_circle_of_confusion_has_the_radius_of_similar_triangles() {
    let (aperture, focus) = (0.4, 5.0);
    let projection = Projection::Perspective {
        vfov: 1.0,
        aperture,
        focus: Some(focus),
    };
    let lens = facing(projection).lens((30, 30)).unwrap();
    let pinhole = facing(Projection::pinhole(1.0)).lens((30, 30)).unwrap();
    let n = 100;
    for (x, y) in [(15.0, 15.0), (3.0, 22.0)] {
        for distance in [0.5, 2.0, 5.0, 7.5, 40.0] {
            let center = at_distance(&pinhole.ray(x, y, MIDDLE), distance);
            let radius = aperture * (distance - focus).abs() / focus;
            let (mut farthest, mut squares, mut sum) = (0.0_f64, 0.0, DVec3::ZERO);
            for i in 0..n * n {
                let u2 = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let off = at_distance(&lens.ray(x, y, u2), distance) - center;
                farthest = farthest.max(off.length());
                squares += off.length_squared();
                sum += off;
            }
            let count = f64::from(n * n);
            assert!(
                farthest <= radius * (1.0 + 1e-6) + 1e-9,
                "{farthest} > {radius}"
            );
            assert!(farthest >= 0.98 * radius);
            // A disk that is filled evenly: the mean square is half of the radius squared.
            let expected = 0.5 * radius * radius;
            assert!((squares / count - expected).abs() <= 1e-3 * expected + 1e-12);
            assert!((sum / count).length() <= 1e-3 * radius + 1e-9);
        }
    }
}

#[test]
fn a_lens_without_a_focus_is_sharp_where_it_looks() {
    let projection = Projection::Perspective {
        vfov: 1.0,
        aperture: 0.4,
        focus: None,
    };
    let lens = facing(projection).lens((30, 30)).unwrap();
    for u2 in [Vec2::ZERO, MIDDLE, Vec2::new(0.9, 0.2)] {
        let met = at_distance(&lens.ray(15.0, 15.0, u2), 3.0);
        assert!(met.abs_diff_eq(DVec3::new(1.0, 2.0, 6.0), 1e-6));
    }
}

#[test]
fn orthographic_rays_are_parallel_and_start_on_the_plane_of_the_eye() {
    let projection = Projection::Orthographic { height: 3.0 };
    let lens = facing(projection).lens((40, 20)).unwrap();
    for (x, y, origin) in [
        (20.0, 10.0, DVec3::new(1.0, 2.0, 9.0)),
        (0.0, 0.0, DVec3::new(-2.0, 3.5, 9.0)),
        (40.0, 20.0, DVec3::new(4.0, 0.5, 9.0)),
        (40.0, 5.0, DVec3::new(4.0, 2.75, 9.0)),
    ] {
        let ray = lens.ray(x, y, MIDDLE);
        close(ray.direction, DVec3::NEG_Z);
        close(ray.origin, origin);
    }
}

fn panorama(look_at: DVec3) -> Lens {
    let panorama = Camera {
        projection: Projection::Panorama,
        ..camera(DVec3::ZERO, look_at)
    };
    panorama.lens((360, 180)).unwrap()
}

#[test]
fn a_panorama_is_level_with_its_heading_in_the_middle() {
    // However far it looks down.
    for look_at in [DVec3::NEG_Z, DVec3::new(0.0, -7.0, -1.0)] {
        let lens = panorama(look_at);
        let toward = |x, y| lens.ray(x, y, MIDDLE).direction;
        close(toward(180.0, 90.0), DVec3::NEG_Z);
        close(toward(270.0, 90.0), DVec3::X);
        close(toward(90.0, 90.0), DVec3::NEG_X);
        close(toward(0.0, 90.0), DVec3::Z);
        close(toward(360.0, 90.0), DVec3::Z);
        close(toward(77.0, 0.0), DVec3::Y);
        close(toward(77.0, 180.0), DVec3::NEG_Y);
        close(toward(180.0, 45.0), DVec3::new(0.0, 1.0, -1.0).normalize());
        // Over the top and down on the other side.
        close(toward(180.0, -30.0), toward(0.0, 30.0));
    }
}

#[test]
fn a_panorama_covers_the_sphere_once() {
    let lens = panorama(DVec3::new(0.3, 0.2, 0.8));
    let at = |x: i32, y: i32| lens.ray(f64::from(x), f64::from(y), MIDDLE).direction;
    let mut whole = 0.0;
    for y in 0..180 {
        // A rectangle of a latitude and longitude grid between heights sin(a) and sin(b) has the area
        // (sin(a) - sin(b)) * width: Archimedes.
        let edge = |y: i32| (FRAC_PI_2 - f64::from(y).to_radians()).sin();
        let expected = (edge(y) - edge(y + 1)) * 1_f64.to_radians();
        let mut row = 0.0;
        for x in 0..360 {
            let corners = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            row += triangle([corners[0], corners[1], corners[2]])
                + triangle([corners[0], corners[2], corners[3]]);
        }
        // Great circles are not circles of latitude, by a part in the square of the pixel.
        assert!((row / 360.0 / expected - 1.0).abs() < 0.02, "row {y}");
        whole += row;
    }
    assert!((whole / (4.0 * PI) - 1.0).abs() < 1e-9, "{whole}");
}

/// The solid angle of a triangle seen from the origin, positive where it turns right from there (Van Oosterom and Strackee 1983).
fn triangle([a, b, c]: [DVec3; 3]) -> f64 {
    let volume = a.dot(b.cross(c));
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

fn keys(times: &[f64], value: impl Fn(f64) -> (DVec3, f64)) -> Vec<Key> {
    let key = |&frame: &f64| Key {
        frame,
        eye: value(frame).0,
        look_at: -value(frame).0,
        up: DVec3::Y,
        field: value(frame).1,
    };
    times.iter().map(key).collect()
}

const TIMES: [f64; 5] = [2.0, 3.0, 7.0, 12.0, 13.0];

fn parabola(t: f64) -> DVec3 {
    DVec3::new(1.0 + t - 0.3 * t * t, 0.1 * t * t, 5.0 - t)
}

#[test]
fn keys_are_met_exactly_and_held_beyond_the_ends() {
    let wild = |t: f64| {
        (
            DVec3::new((t * t).sin(), t.exp(), 9.0),
            0.5 + 0.4 * (3.0 * t).sin(),
        )
    };
    for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
        let motion = Motion {
            keys: keys(&TIMES, wild),
            interpolation,
        };
        for key in &motion.keys {
            assert_eq!(motion.at(key.frame).unwrap(), *key);
        }
        assert_eq!(motion.at(0.0), Some(motion.keys[0]));
        assert_eq!(motion.at(99.0), Some(motion.keys[4]));
    }
    let none = Motion {
        keys: Vec::new(),
        interpolation: Interpolation::Smooth,
    };
    assert_eq!(none.at(0.0), None);
}

#[test]
fn linear_motion_is_straight_between_keys() {
    let motion = Motion {
        keys: keys(&TIMES, |t| (parabola(t), t * t)),
        interpolation: Interpolation::Linear,
    };
    for pair in TIMES.windows(2) {
        for share in [0.25, 0.5, 0.9] {
            let key = motion.at(pair[0] + share * (pair[1] - pair[0])).unwrap();
            close(key.eye, parabola(pair[0]).lerp(parabola(pair[1]), share));
            let field = pair[0] * pair[0] * (1.0 - share) + pair[1] * pair[1] * share;
            assert!((key.field - field).abs() < 1e-12);
        }
    }
}

#[test]
fn smooth_motion_is_exact_on_parabolas_between_inner_keys() {
    let motion = Motion {
        keys: keys(&TIMES, |t| (parabola(t), 1.0)),
        interpolation: Interpolation::Smooth,
    };
    for i in 0..=90 {
        let t = 3.0 + 0.1 * f64::from(i);
        let key = motion.at(t).unwrap();
        close(key.eye, parabola(t));
        close(key.look_at, -parabola(t));
    }
}

#[test]
fn smooth_motion_has_no_jerk_and_its_field_never_overshoots() {
    let fields = [0.3, 2.9, 2.95, 0.4, 0.4];
    let mut keys = keys(&TIMES, |t| (DVec3::new(t.sin(), (2.0 * t).cos(), 9.0), 0.0));
    for (key, field) in keys.iter_mut().zip(fields) {
        key.field = field;
    }
    let motion = Motion {
        keys,
        interpolation: Interpolation::Smooth,
    };
    let step = 1e-6;
    for key in &motion.keys[1..4] {
        let at = |t: f64| motion.at(t).unwrap();
        let (before, after) = (at(key.frame - step), at(key.frame + step));
        let jerk = (after.eye - key.eye) - (key.eye - before.eye);
        assert!(jerk.length() < 1e-10, "{jerk}");
        let jerk = (after.field - key.field) - (key.field - before.field);
        assert!(jerk.abs() < 1e-10, "{jerk}");
    }
    for pair in motion.keys.windows(2) {
        let (low, high) = (
            pair[0].field.min(pair[1].field),
            pair[0].field.max(pair[1].field),
        );
        let mut last = pair[0].field;
        for i in 0..=100 {
            let t = pair[0].frame + (pair[1].frame - pair[0].frame) * f64::from(i) / 100.0;
            let field = motion.at(t).unwrap().field;
            assert!((low - 1e-12..=high + 1e-12).contains(&field), "{field}");
            let falls = pair[1].field < pair[0].field;
            assert!(if falls {
                field <= last + 1e-12
            } else {
                field >= last - 1e-12
            });
            last = field;
        }
    }
}

#[test]
fn a_turntable_keeps_its_distances_and_comes_round() {
    for up in [DVec3::Y, DVec3::new(0.2, 0.3, 2.0)] {
        let still = Camera {
            up,
            ..camera(DVec3::new(1.0, 3.0, 7.0), DVec3::new(0.5, 1.0, -1.0))
        };
        let axis = up.normalize();
        let arm = |camera: &Camera| camera.eye - camera.look_at;
        let flat = |v: DVec3| v - v.dot(axis) * axis;
        for i in 0..12 {
            let angle = TAU * f64::from(i) / 12.0;
            let turned = still.turned(angle);
            assert_eq!((turned.look_at, turned.up), (still.look_at, still.up));
            assert!((arm(&turned).length() - arm(&still).length()).abs() < 1e-12);
            assert!((arm(&turned).dot(axis) - arm(&still).dot(axis)).abs() < 1e-12);
            let (from, to) = (flat(arm(&still)), flat(arm(&turned)));
            let swept = from.cross(to).dot(axis).atan2(from.dot(to)).rem_euclid(TAU);
            assert!((swept - angle).abs() < 1e-9, "{swept} is not {angle}");
        }
        close(still.turned(TAU).eye, still.eye);
    }
}

fn read(camera: &str) -> Camera {
    let text = format!("(camera: {camera}, objects: [])");
    let mut scene = SceneDescription::from_text("camera.ron", &text).unwrap();
    scene.cameras.remove(0)
}

#[test]
fn scene_files_have_all_projections() {
    let at = "eye: (0, 1, 5), look_at: (0, 0, 0)";
    let flat = read(&format!("Orthographic({at}, height: 2.5)"));
    assert_eq!(flat.projection, Projection::Orthographic { height: 2.5 });
    assert_eq!((flat.eye, flat.up), (DVec3::new(0.0, 1.0, 5.0), DVec3::Y));
    let all = read(&format!("Panorama({at}, up: (0, 2, 0))"));
    assert_eq!((all.projection, all.up), (Projection::Panorama, DVec3::Y));
}

#[test]
fn what_a_key_leaves_out_is_as_before_it() {
    let camera = read(
        "Perspective(eye: (0, 1, 5), look_at: (0, 0, 0), vfov: 40, motion: Linear(keys: [
            (frame: 3),
            (frame: 10, eye: (4, 1, 0), vfov: 20),
            (frame: 12, look_at: (0, 1, 0), up: (0, 0, 3)),
        ]))",
    );
    let forty = 40_f64.to_radians();
    let [a, b, c] = camera.motion.as_ref().unwrap().keys[..] else {
        panic!("three keys");
    };
    assert_eq!(
        (a.frame, a.eye, a.look_at),
        (3.0, camera.eye, camera.look_at)
    );
    assert_eq!((a.up, a.field), (DVec3::Y, forty));
    assert_eq!((b.frame, b.eye), (10.0, DVec3::new(4.0, 1.0, 0.0)));
    assert_eq!((b.look_at, b.field), (DVec3::ZERO, 20_f64.to_radians()));
    assert_eq!((c.eye, c.look_at), (b.eye, DVec3::Y));
    assert_eq!((c.up, c.field), (DVec3::Z, b.field));
    let middle = camera.at(6.5);
    close(middle.eye, DVec3::new(2.0, 1.0, 2.5));
    assert!((middle.projection.field().unwrap() - 30_f64.to_radians()).abs() < 1e-12);
    let flat = read(
        "Orthographic(eye: (0, 1, 5), look_at: (0, 0, 0), height: 4,
            motion: Smooth(keys: [(frame: 0), (frame: 8, height: 2)]))",
    );
    assert_eq!(
        flat.at(4.0).projection,
        Projection::Orthographic { height: 3.0 }
    );
    assert_eq!(flat.motion.unwrap().interpolation, Interpolation::Smooth);
}
