//! A model without a scene around it: stood upright, framed from the front right, lit by a soft studio.

use std::f64::consts::FRAC_PI_6;

use glam::{DMat3, DVec3, Vec3};

use crate::camera::{Camera, Projection};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::geometry::{Shape, Solid};
use crate::material::{Material, MaterialId, Surface};
use crate::math::{Bounds, Transform};
use crate::scene::{FilmSettings, Instance, Model, Scene};
use crate::texture::Texture;

/// Vertical field of view.
const VFOV: f64 = FRAC_PI_6;
/// Where the camera stands, seen from the model: degrees to the right of the front, and above the horizon. The
/// height hides the floor's horizon just above the picture.
const CAMERA: (f64, f64) = (30.0, 16.0);
/// Share of the picture's half height and half width that stays free around the model.
const MARGIN: f64 = 0.08;
/// What lies around the studio.
const ENVIRONMENT: f32 = 0.25;
/// The lamps: degrees from the camera to the right and above the horizon, and the irradiance, in units of pi, on a
/// surface that faces the lamp. Key, fill, rim. All are higher than the camera, whose picture ends below the
/// horizon: so none is in it, from whichever side.
const LAMPS: [(f64, f64, f32); 3] = [(-55.0, 48.0, 0.65), (60.0, 40.0, 0.1), (160.0, 55.0, 0.4)];
/// Distance and radius of a lamp, in radii of the model. Both scale with it, and so the exposure does not.
const LAMP_DISTANCE: f64 = 3.4;
const LAMP_RADIUS: f64 = 0.8;

/// Makes a scene of a model. Its own cameras and lights are used where it has them. `guess_up` is for formats that
/// do not say which way is up; without it that is y, and the front z.
///
/// # Errors
/// Where the model has no triangles.
pub fn bare_scene(mut model: Model, guess_up: bool) -> Result<Scene> {
    let mut scene = Scene {
        cameras: std::mem::take(&mut model.cameras),
        lights: std::mem::take(&mut model.lights),
        ..Scene::default()
    };
    scene.instances = scene.adopt(model);
    if guess_up {
        let upright = Transform::rigid(upright(&scene), DVec3::ZERO);
        for instance in &mut scene.instances {
            instance.world_from_object = upright.after(&instance.world_from_object);
        }
    }
    let bounds = Bounds::of_points(vertices(&scene));
    let radius = 0.5 * bounds.size().length();
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Error::input(
            "the model has nothing to show: no two vertices differ",
        ));
    }
    let lit = !scene.lights.is_empty();
    let framed = scene.cameras.is_empty();
    if framed {
        frame(&mut scene);
    }
    if !lit {
        scene.environment = Rgb::splat(ENVIRONMENT);
        light(&mut scene, bounds.center(), radius);
        if framed {
            let mut point = bounds.center();
            point.y = bounds.min.y - 1e-4 * radius;
            lay_floor(&mut scene, point);
        }
    }
    Ok(scene)
}

/// All vertices of all instances of meshes, in world space.
fn vertices(scene: &Scene) -> impl Iterator<Item = DVec3> {
    triangles(scene).flatten()
}

/// The corners of all triangles, in world space.
fn triangles(scene: &Scene) -> impl Iterator<Item = [DVec3; 3]> {
    scene.instances.iter().flat_map(|instance| {
        let Shape::Mesh(id) = instance.shape else {
            unreachable!("a model's parts are meshes");
        };
        let mesh = &scene.meshes[id.0 as usize];
        let corners = (0..mesh.triangles.len() as u32).map(|i| mesh.corners(i));
        corners.map(|corners| corners.map(|p| instance.world_from_object.point(p.as_dvec3())))
    })
}

/// The rotation that stands a model up whose format names no up axis: y is up, unless the model stands on the plane
/// z = 0, not on y = 0, and is tallest along z.
///
/// A model with z up shows its front along -y, as modellers do; but where more of its triangles face +y, that is its
/// front, since a face has more detail than the back of a head.
fn upright(scene: &Scene) -> DMat3 {
    let bounds = Bounds::of_points(vertices(scene));
    let size = bounds.size();
    let stands_on = |axis: usize| bounds.min[axis].abs() <= 0.01 * size[axis];
    if !stands_on(2) || stands_on(1) || size.z < size.max_element() {
        return DMat3::IDENTITY;
    }
    let (mut front, mut back) = (0_usize, 0_usize);
    for [a, b, c] in triangles(scene) {
        let toward = (b - a).cross(c - a).y;
        front += usize::from(toward < 0.0);
        back += usize::from(toward > 0.0);
    }
    let forward = if back > front + front / 20 {
        DVec3::Y
    } else {
        DVec3::NEG_Y
    };
    // The rows say which of the model's directions become x, y and z.
    DMat3::from_cols(DVec3::Z.cross(forward), DVec3::Z, forward).transpose()
}

/// The unit vector `azimuth` degrees to the right of +z and `elevation` degrees above the horizon.
fn toward(azimuth: f64, elevation: f64) -> DVec3 {
    let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation.to_radians().sin_cos();
    DVec3::new(cos_e * sin_a, sin_e, cos_e * cos_a)
}

/// Adds the nearest camera in its direction that has all vertices in view.
///
/// With the picture's axes x, y and the depth z along the view, a vertex is inside the left edge of a camera at c
/// where x - c.x >= -(z - c.z) tan, and so for the other three: each pair of edges bounds c.z by two maxima over the
/// vertices, and the lesser bound holds for both.
fn frame(scene: &mut Scene) {
    let forward = -toward(CAMERA.0, CAMERA.1);
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let in_view = |p: DVec3| DVec3::new(p.dot(right), p.dot(up), p.dot(forward));

    let extent = Bounds::of_points(vertices(scene).map(in_view)).size();
    let (width, height) = FilmSettings::default().size;
    if extent.y > 1.5 * extent.x {
        scene.film.size = (height, width);
    }
    let aspect = f64::from(scene.film.size.0) / f64::from(scene.film.size.1);
    let tan_y = (1.0 - MARGIN) * (0.5 * VFOV).tan();
    let tan = DVec3::new(aspect * tan_y, tan_y, 0.0);
    let (mut low, mut high) = (DVec3::NEG_INFINITY, DVec3::NEG_INFINITY);
    for p in vertices(scene).map(in_view) {
        high = high.max(p - p.z * tan);
        low = low.max(-p - p.z * tan);
    }
    let depth = -0.5 * (high + low) / tan;
    let middle = 0.5 * (high - low);
    let c = DVec3::new(middle.x, middle.y, depth.x.min(depth.y));
    let eye = c.x * right + c.y * up + c.z * forward;
    let focus = 0.5 * (high.z - low.z) - c.z;
    scene.cameras.push(Camera {
        name: None,
        eye,
        look_at: eye + focus * forward,
        up: DVec3::Y,
        projection: Projection::pinhole(VFOV),
        motion: None,
    });
}

/// Adds the lamps around the model, outside the picture that [`frame`] takes.
fn light(scene: &mut Scene, center: DVec3, radius: f64) {
    for (azimuth, elevation, irradiance) in LAMPS {
        let away = LAMP_DISTANCE * radius * toward(CAMERA.0 + azimuth, elevation);
        // A sphere of radiance L that fills the share sin² of the hemisphere gives pi L sin².
        let share = (LAMP_RADIUS / LAMP_DISTANCE).powi(2) as f32;
        let lamp = Material {
            name: "studio lamp".to_owned(),
            surface: matt(0.0),
            emission: Rgb::splat(irradiance / share),
            ..Material::default()
        };
        let solid = Solid::Sphere {
            radius: LAMP_RADIUS * radius,
        };
        let place = Transform::rigid(DMat3::IDENTITY, center + away);
        add(scene, "studio lamp", solid, place, lamp);
    }
}

/// Adds a level, light grey plane through `point`.
fn lay_floor(scene: &mut Scene, point: DVec3) {
    let axes = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    let floor = Material {
        name: "studio floor".to_owned(),
        surface: matt(0.5),
        ..Material::default()
    };
    add(
        scene,
        "studio floor",
        Solid::Plane,
        Transform::rigid(axes, point),
        floor,
    );
}

fn add(scene: &mut Scene, name: &str, solid: Solid, place: Transform, material: Material) {
    scene.materials.push(material);
    scene.instances.push(Instance {
        name: Some(name.to_owned()),
        shape: Shape::Solid(solid),
        materials: vec![MaterialId(scene.materials.len() as u32 - 1)],
        world_from_object: place,
        smooth: true,
    });
}

fn matt(albedo: f32) -> Surface {
    Surface::Diffuse {
        color: Texture::Constant(Vec3::splat(albedo)),
    }
}
