use glam::DVec3;
use serde_json::json;
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::light::Light;
use solidtrace::scene::Model;

use super::{Files, glb, read, set, triangle};

#[test]
fn nodes_compose_from_the_root_down_and_share_their_mesh() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    let half = 0.5_f64.sqrt();
    document["scenes"] = json!([{"nodes": [1, 0]}]);
    document["nodes"] = json!([
        {"name": "alone", "mesh": 0},
        {"translation": [10, 0, 0], "rotation": [0, 0, half, half], "scale": [2, 2, 2], "children": [2, 3]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]},
        {"mesh": 0, "scale": [1, 0, 1]},
    ]);
    let model = read(&files, &(document.clone(), binary.clone()));
    assert_eq!(model.meshes.len(), 1);
    assert_eq!(model.parts.len(), 2);
    // (1, 2, 3), doubled, turned by a quarter about z, moved by 10.
    let place = &model.parts[0].model_from_mesh;
    assert!(
        place
            .point(DVec3::ZERO)
            .abs_diff_eq(DVec3::new(6.0, 2.0, 6.0), 1e-12)
    );
    assert!(place.vector(DVec3::X).abs_diff_eq(2.0 * DVec3::Y, 1e-12));
    assert_eq!(model.parts[1].name.as_deref(), Some("alone"));
    assert!(model.parts[1].model_from_mesh.is_identity());
    assert!(
        model.warnings[0].contains("/nodes/3"),
        "{:?}",
        model.warnings
    );
    // Without scenes, all nodes that have no parent.
    let object = document.as_object_mut().unwrap();
    object.remove("scene");
    object.remove("scenes");
    let names = |model: Model| model.parts.into_iter().map(|p| p.name).collect::<Vec<_>>();
    assert_eq!(
        names(read(&files, &(document, binary))),
        [Some("alone".to_owned()), None]
    );
}

#[test]
fn cameras_look_along_minus_z_and_lights_keep_their_numbers() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    let half = 0.5_f64.sqrt();
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    document["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4, 5, 6, 7]}]);
    document["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0, "translation": [1, 2, 3], "rotation": [0, half, 0, half], "scale": [3, 3, 3], "name": "node"},
        {"camera": 1},
        {"extensions": light(0), "translation": [0, 4, 0]},
        {"extensions": light(1)},
        {"extensions": light(2), "rotation": [half, 0, 0, half], "scale": [2, 2, 2]},
        {"extensions": light(3)},
        {"extensions": light(4), "rotation": [0, half, 0, half], "scale": [3, 3, 3]},
    ]);
    document["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.75, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1.25, "zfar": 9, "znear": 1}},
    ]);
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 8},
        {"type": "area"},
        {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "spot", "spot": {}},
        {"type": "directional", "color": [0.5, 1, 2], "intensity": 3},
    ]}});
    let model = read(&files, &(document.clone(), binary.clone()));
    assert_eq!(model.cameras.len(), 2);
    let flat = Projection::Orthographic { height: 2.5 };
    assert_eq!(model.cameras[1].projection, flat);
    let camera = &model.cameras[0];
    assert_eq!(camera.name.as_deref(), Some("node"));
    assert_eq!(camera.eye, DVec3::new(1.0, 2.0, 3.0));
    // A quarter turn about y takes -z to -x.
    assert!((camera.look_at - camera.eye).abs_diff_eq(DVec3::NEG_X, 1e-12));
    assert!(camera.up.abs_diff_eq(DVec3::Y, 1e-12));
    assert_eq!(camera.projection, Projection::pinhole(0.75));
    let [
        Light::Point(point),
        Light::Point(spot),
        Light::Point(wide),
        Light::Distant(distant),
    ] = &model.lights[..]
    else {
        panic!("{:?}", model.lights);
    };
    assert_eq!(point.position, 4.0 * DVec3::Y);
    assert_eq!(point.intensity, Rgb::new(8.0, 4.0, 2.0));
    assert_eq!(point.cone, None);
    let cone = spot.cone.unwrap();
    // A quarter turn about x takes -z to y.
    assert!(cone.axis.abs_diff_eq(DVec3::Y, 1e-12), "{cone:?}");
    let cosines = |inner: f64, outer: f64| [inner.cos(), outer.cos()];
    assert_eq!([cone.cos_inner, cone.cos_outer], cosines(0.25, 0.5));
    let cone = wide.cone.unwrap();
    let default = cosines(0.0, std::f64::consts::FRAC_PI_4);
    assert_eq!([cone.cos_inner, cone.cos_outer], default);
    // It shines along -z, which is turned to -x, so it stands at +x.
    assert!(distant.direction.abs_diff_eq(DVec3::X, 1e-12));
    assert_eq!(distant.irradiance, Rgb::new(1.5, 3.0, 6.0));
    assert_eq!(distant.angle, 0.0);
    assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
    for (pointer, value, place) in [
        (
            "/cameras/0/perspective/yfov",
            json!(0),
            "/cameras/0/perspective/yfov",
        ),
        (
            "/cameras/0/perspective/yfov",
            json!(3.2),
            "/cameras/0/perspective/yfov",
        ),
        (
            "/cameras/0/perspective",
            json!({}),
            "/cameras/0/perspective",
        ),
        (
            "/cameras/1/orthographic/ymag",
            json!(0),
            "/cameras/1/orthographic/ymag",
        ),
        ("/cameras/1/type", json!("fish-eye"), "/cameras/1/type"),
        (
            "/extensions/KHR_lights_punctual/lights/0/intensity",
            json!(-1),
            "/extensions/KHR_lights_punctual/lights/0",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/2/spot/outerConeAngle",
            json!(1.6),
            "/extensions/KHR_lights_punctual/lights/2/spot",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/2/spot/innerConeAngle",
            json!(0.5),
            "/extensions/KHR_lights_punctual/lights/2/spot",
        ),
        (
            "/nodes/3/extensions/KHR_lights_punctual/light",
            json!(5),
            "/nodes/3/extensions/KHR_lights_punctual/light",
        ),
    ] {
        let mut changed = document.clone();
        set(&mut changed, pointer, value);
        let error = files.error("a.glb", glb(&changed, &binary));
        assert_eq!(
            error.place().unwrap().pointer.as_deref(),
            Some(place),
            "{error}"
        );
    }
}
