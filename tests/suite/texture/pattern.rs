//! Patterns against their formulas, and what is made of textures.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2};
use solidtrace::color::Rgb;
use solidtrace::math::Transform;
use solidtrace::texture::{Pattern, Ramp, Texture, TexturePoint, harmonics};

use super::{at, at_uv};

fn grey(pattern: Pattern) -> Texture {
    Texture::Pattern {
        pattern,
        colors: Ramp::between(Rgb::ZERO, Rgb::ONE),
    }
}

const PLACES: [DVec3; 5] = [
    DVec3::new(0.3, 0.7, 0.2),
    DVec3::new(-1.4, 2.2, 0.9),
    DVec3::new(10.1, -3.3, 4.7),
    DVec3::new(-0.01, -0.02, -0.03),
    DVec3::new(55.5, 66.25, -7.125),
];

#[test]
fn cells_alternate_and_faces_on_their_boundaries_have_the_colours_inside() {
    let checker = Pattern::Checker { step: 2.0 };
    for (p, value) in [
        ((1.0, 1.0, 1.0), 0.0),
        ((3.0, 1.0, 1.0), 1.0),
        ((-1.0, 1.0, 1.0), 1.0),
        ((-1.0, -1.0, 1.0), 0.0),
        ((-1.0, -1.0, -1.0), 1.0),
        ((3.0, 5.0, 7.0), 0.0),
    ] {
        assert_eq!(checker.value(&at(p)), value, "{p:?}");
    }
    // A face in the plane z = 4, to either side of which its last bit may lie.
    for z in [4.0_f64.next_down(), 4.0, 4.0_f64.next_up()] {
        let face = |n: DVec3| TexturePoint {
            n,
            ..at((1.0, 1.0, z))
        };
        assert_eq!(checker.value(&face(DVec3::Z)), 1.0);
        assert_eq!(checker.value(&face(DVec3::NEG_Z)), 0.0);
    }
    let squares = Pattern::UvChecker { step: 0.25 };
    for (u, v, value) in [
        (0.1, 0.1, 0.0),
        (0.3, 0.1, 1.0),
        (0.3, 0.3, 0.0),
        (-0.1, 0.1, 1.0),
        (0.25, 0.0, 1.0),
        (0.5, 0.0, 0.0),
    ] {
        assert_eq!(squares.value(&at_uv(u, v)), value, "{u} {v}");
    }
}

#[test]
fn marble_and_wood_follow_the_reports_formulas() {
    for p in PLACES {
        let marble = |grain| Pattern::Marble {
            grain,
            octaves: 40,
            alpha: 0.5,
        };
        let plain = p.element_sum().sin() + 0.5;
        assert!((marble(0.0).value(&at(p)) - plain).abs() < 1e-15);
        let bent = (p.x + p.y + p.z + 15.0 * harmonics(p, 40)).sin() + 0.5;
        assert!((marble(15.0).value(&at(p)) - bent).abs() < 1e-12);

        let wood = Pattern::Wood {
            grain: 15.0,
            octaves: 5,
        };
        let rings = (15.0 * harmonics(p, 5)).fract();
        assert!((wood.value(&at(p)) - (1.0 - (PI * rings).cos()) / 2.0).abs() < 1e-12);
    }
}

#[test]
fn shells_are_a_sine_of_the_distance() {
    for p in PLACES {
        let rings = Pattern::Rings {
            step: 0.5,
            grain: 0.0,
        };
        let sine = (TAU * p.length() / 0.5).sin();
        assert!((rings.value(&at(p)) - (0.5 + 0.5 * sine)).abs() < 1e-12);
    }
}

#[test]
fn where_noise_is_zero_patterns_have_their_middle() {
    // Whole multiples of the scale, where every octave is 0.
    for p in PLACES.map(|p| 3.0 * p.floor()) {
        let p = at(p.with_y(2.0 * p.y));
        let (scale, octaves) = (3.0, 6);
        let clouds = |cover| Pattern::Clouds {
            scale,
            octaves,
            cover,
        };
        let depth = 0.25;
        assert_eq!(Pattern::Noise { scale, octaves }.value(&p), 0.5);
        assert_eq!(Pattern::Turbulence { scale, octaves }.value(&p), 0.0);
        assert_eq!(Pattern::Fire { scale, octaves }.value(&p), 1.0);
        assert_eq!(clouds(0.25).value(&p), 0.0);
        assert_eq!(clouds(0.5).value(&p), 0.0);
        let dense = clouds(0.5 + depth).value(&p);
        assert!((dense - (1.0 - (-8.0 * depth).exp())).abs() < 1e-12);
    }
}

#[test]
fn ramps_are_straight_between_their_stops_and_level_beyond() {
    let ramp = Ramp::new(vec![
        (0.0, Rgb::X),
        (0.5, Rgb::Y),
        (0.5, Rgb::Z),
        (2.0, Rgb::ONE),
    ]);
    let ramp = ramp.unwrap();
    for (t, color) in [
        (-1.0, Rgb::X),
        (0.0, Rgb::X),
        (0.25, Rgb::new(0.5, 0.5, 0.0)),
        (0.5, Rgb::Z),
        (1.25, Rgb::new(0.5, 0.5, 1.0)),
        (2.0, Rgb::ONE),
        (9.0, Rgb::ONE),
        (f32::NAN, Rgb::X),
    ] {
        assert_eq!(ramp.at(t), color, "{t}");
    }
    assert_eq!(Ramp::new(Vec::new()), None);
    assert_eq!(Ramp::new(vec![(1.0, Rgb::X), (0.0, Rgb::Y)]), None);
    assert_eq!(Ramp::new(vec![(f32::NAN, Rgb::X)]), None);
}

#[test]
fn a_transform_moves_a_texture_as_it_moves_an_object() {
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 0.5, -3.0),
        DQuat::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 0.7),
        DVec3::new(1.0, -2.0, 0.5),
    );
    let pattern = grey(Pattern::Noise {
        scale: 1.0,
        octaves: 2,
    });
    let moved = Texture::Transform {
        of: Arc::new(pattern.clone()),
        texture_from_object: Box::new(Transform::new(place).unwrap().inverse()),
    };
    for p in PLACES {
        let there = moved.eval_scalar(&at(place.transform_point3(p)));
        assert!((there - pattern.eval_scalar(&at(p))).abs() < 1e-6);
    }
    // Surface coordinates likewise: twice as large and shifted.
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.0),
        DQuat::IDENTITY,
        DVec3::new(0.25, 0.0, 0.0),
    );
    let squares = Texture::Transform {
        of: Arc::new(grey(Pattern::UvChecker { step: 0.5 })),
        texture_from_object: Box::new(Transform::new(place).unwrap().inverse()),
    };
    assert_eq!(squares.eval_scalar(&at_uv(1.2, 0.5)), 0.0);
    assert_eq!(squares.eval_scalar(&at_uv(1.3, 0.5)), 1.0);
}

#[test]
fn scale_and_mix_are_products_and_blends() {
    let constant = |r, g, b| Arc::new(Texture::Constant(Rgb::new(r, g, b)));
    let (a, b) = (constant(0.2, 0.4, 0.8), constant(1.0, 0.0, 0.4));
    let scaled = Texture::Scale {
        of: a.clone(),
        by: Rgb::new(0.5, 1.0, 0.25),
    };
    assert_eq!(scaled.eval(&at(DVec3::ZERO)), Rgb::new(0.1, 0.4, 0.2));
    for (by, expected) in [
        (0.0, Rgb::new(0.2, 0.4, 0.8)),
        (0.25, Rgb::new(0.4, 0.3, 0.7)),
        (1.0, Rgb::new(1.0, 0.0, 0.4)),
    ] {
        let (a, b) = (a.clone(), b.clone());
        let mix = Texture::Mix {
            a,
            b,
            by: constant(by, by, by),
        };
        assert!(mix.eval(&at(DVec3::ZERO)).abs_diff_eq(expected, 1e-6));
        assert_eq!(mix.parts(), 4);
    }
    // As scalars: greys are themselves to the bit, colours their luminance (ITU-R BT.709).
    for x in [0.0, 0.1, 0.3, 0.7, 1.0, 1e-20, 37.0] {
        assert_eq!(constant(x, x, x).eval_scalar(&at(DVec3::ZERO)), x);
    }
    let [r, g, b] = [
        constant(1.0, 0.0, 0.0),
        constant(0.0, 1.0, 0.0),
        constant(0.0, 0.0, 1.0),
    ]
    .map(|t| t.eval_scalar(&at(DVec3::ZERO)));
    let weights = Vec2::new(r, b);
    assert!(weights.abs_diff_eq(Vec2::new(0.2126, 0.0722), 1e-7));
    assert!((g - 0.7152).abs() < 1e-7);
}
