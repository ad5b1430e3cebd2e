//! The clear sky: physics that must hold, and formulas of others.

use std::f32::consts::PI;

use glam::DVec3;
use solidtrace::color::{Rgb, luminance};
use solidtrace::integrator::integrator;
use solidtrace::light::{DistantLight, Light, LightSampler, Sky};
use solidtrace::sampling::random_direction;

use crate::lights::floor;

use super::irradiance;

fn toward(elevation: f64, azimuth: f64) -> DVec3 {
    let (rise, level) = elevation.to_radians().sin_cos();
    let (right, ahead) = azimuth.to_radians().sin_cos();
    DVec3::new(level * right, rise, -level * ahead)
}

fn sky(elevation: f64, turbidity: f64) -> Sky {
    Sky {
        sun: toward(elevation, 0.0),
        turbidity,
        ground: Rgb::splat(0.2),
        scale: 1.0,
        disk: true,
    }
}

/// The sky's picture alone, and its sun.
fn parts(sky: &Sky) -> (LightSampler, DistantLight) {
    let mut lights = sky.lights();
    let Some(Light::Distant(sun)) = lights.pop() else {
        panic!("no sun");
    };
    (LightSampler::new(lights), sun)
}

fn seen(picture: &LightSampler, direction: DVec3) -> Rgb {
    picture
        .beyond(direction)
        .map(|(radiance, _)| radiance)
        .sum()
}

#[test]
fn the_sky_is_bright_everywhere_brighter_around_the_sun_and_blue_overhead() {
    let mut rng = rand::SeedableRng::seed_from_u64(4);
    let rng: &mut rand_pcg::Pcg32 = &mut rng;
    for elevation in [1.0, 10.0, 35.0, 70.0] {
        for turbidity in [2.0, 6.0] {
            let what = format!("{elevation} degrees, turbidity {turbidity}");
            let (picture, _) = parts(&sky(elevation, turbidity));
            for _ in 0..2000 {
                let direction = random_direction(rng);
                let radiance = seen(&picture, direction);
                assert!(
                    radiance.min_element() > 0.0 && radiance.is_finite(),
                    "{what}: {radiance} at {direction}"
                );
            }
            let at_sun = luminance(seen(&picture, toward(elevation, 0.0)));
            for azimuth in [60.0, 120.0, 180.0, 270.0] {
                let elsewhere = luminance(seen(&picture, toward(elevation, azimuth)));
                // Through thick haze a sun at the horizon is hardly to be seen.
                let least = if elevation < 5.0 { 1.0 } else { 2.0 };
                assert!(
                    at_sun > least * elsewhere,
                    "{what}: {at_sun} and {elsewhere}"
                );
            }
        }
    }
    for elevation in [10.0, 30.0] {
        let zenith = seen(&parts(&sky(elevation, 2.0)).0, DVec3::Y);
        assert!(
            zenith.z > 1.5 * zenith.x && zenith.z > zenith.y && zenith.y > zenith.x,
            "{zenith}"
        );
    }
}

#[test]
fn sunlight_fades_and_reddens_as_the_air_is_thick() {
    // At 680, 550 and 440 nm: Bruneton's air, 8 km of it, his ozone, a triangle of 30 km, and Preetham's haze.
    let depth = |turbidity: f32, rayleigh: f32, ozone: f32, wave: f32| {
        8.0 * rayleigh + 15.0 * ozone + (0.046_08 * turbidity - 0.045_86) * wave.powf(-1.3)
    };
    for turbidity in [1.0, 3.0, 8.0] {
        let (_, sun) = parts(&sky(90.0, turbidity));
        let expected = [
            depth(turbidity as f32, 5.802e-3, 0.650e-3, 0.68),
            depth(turbidity as f32, 13.558e-3, 1.881e-3, 0.55),
            depth(turbidity as f32, 33.1e-3, 0.085e-3, 0.44),
        ]
        .map(|depth| PI * (-depth).exp());
        for (found, expected) in sun.irradiance.to_array().into_iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{turbidity}: {found}, {expected}"
            );
        }
    }
    // Kasten and Young 1989: how much air a ray goes through, in units of that overhead. Nearly all of the depth in blue is
    // air's own where there is no haze.
    let (_, overhead) = parts(&sky(90.0, 1.0));
    for elevation in [5_f64, 10.0, 20.0, 45.0] {
        let (_, sun) = parts(&sky(elevation, 1.0));
        let mass =
            1.0 / (elevation.to_radians().sin() + 0.505_72 * (elevation + 6.079_95).powf(-1.6364));
        let found = (sun.irradiance.z / PI).ln() / (overhead.irradiance.z / PI).ln();
        assert!(
            (f64::from(found) / mass - 1.0).abs() < 0.03,
            "{elevation}: {found}, {mass}"
        );
    }
    let (_, evening) = parts(&sky(3.0, 3.0));
    let [r, g, b] = evening.irradiance.to_array();
    assert!(r > 2.0 * g && g > 2.0 * b, "{}", evening.irradiance);
}

#[test]
fn the_zenith_is_as_bright_as_it_was_measured_to_be() {
    // Karayel, Navvab, Ne'eman and Selkowitz 1984, a fit to three years in San Francisco, in kcd/m²; and 133 klx, what the sun
    // sheds outside of the air.
    for turbidity in [2.5, 3.5, 5.0] {
        for elevation in [15_f64, 30.0, 45.0, 60.0] {
            let measured = (1.376 * turbidity - 1.81) * elevation.to_radians().tan() + 0.38;
            let (picture, _) = parts(&sky(elevation, turbidity));
            let found = f64::from(133.0 / PI * luminance(seen(&picture, DVec3::Y)));
            let what = format!("turbidity {turbidity}, sun at {elevation}");
            println!("{what}: {found:.2} kcd/m², measured {measured:.2}");
            let ratio = found / measured;
            assert!((0.6..1.7).contains(&ratio), "{what}: {found}, {measured}");
        }
    }
}

#[test]
fn the_ground_shows_what_sun_and_sky_shed_on_it() {
    for elevation in [8.0, 50.0] {
        let day = sky(elevation, 3.0);
        let mut scene = floor(0.0);
        scene.lights = day.lights();
        let path = integrator(&scene.integrator);
        let shed = irradiance(scene, path.as_ref(), 1 << 14) as f32;
        let (picture, _) = parts(&day);
        let ground = seen(&picture, DVec3::NEG_Y).y * PI / 0.2;
        assert!(
            (ground / shed - 1.0).abs() < 0.01,
            "{elevation}: {ground}, {shed}"
        );
    }
}

#[test]
fn the_sky_turns_with_the_sun_and_scales() {
    let day = sky(20.0, 3.0);
    let turned = Sky {
        sun: toward(20.0, 75.0),
        scale: 3.0,
        ..day
    };
    let ((a, sun), (b, turned_sun)) = (parts(&day), parts(&turned));
    assert!(
        (turned_sun.irradiance / sun.irradiance - 3.0)
            .abs()
            .max_element()
            < 1e-5
    );
    for (elevation, azimuth) in [(20.0, 0.0), (40.0, 30.0), (5.0, 200.0), (-20.0, 10.0)] {
        let (here, there) = (
            seen(&a, toward(elevation, azimuth)),
            seen(&b, toward(elevation, azimuth + 75.0)),
        );
        assert!(
            (there / here - 3.0).abs().max_element() < 0.01,
            "{here}, {there}"
        );
        // What is left of the sun mirrors what is right of it.
        let mirrored = seen(&a, toward(elevation, -azimuth));
        assert!(
            (mirrored / here - 1.0).abs().max_element() < 1e-3,
            "{here}, {mirrored}"
        );
    }
}

#[test]
fn without_its_disk_or_below_the_horizon_there_is_no_sun() {
    let hidden = Sky {
        disk: false,
        ..sky(20.0, 3.0)
    };
    assert_eq!(hidden.lights().len(), 1);
    let dusk = sky(-3.0, 3.0).lights();
    assert_eq!(dusk.len(), 1);
    let picture = LightSampler::new(dusk);
    let (west, east) = (
        seen(&picture, toward(2.0, 0.0)),
        seen(&picture, toward(2.0, 180.0)),
    );
    assert!(
        east.min_element() >= 0.0 && luminance(west) > luminance(east),
        "{west}, {east}"
    );
    assert!(west.x > west.z, "dusk is red: {west}");
}
