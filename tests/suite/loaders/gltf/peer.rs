//! Our reader against the crate `gltf`, which others wrote, on files that it can read.

use glam::{DMat4, DVec3, Mat4, Vec3};
use serde_json::{Value, json};
use solidtrace::scene::Model;

use super::{CUBE_INDICES, Files, cube_positions, document, floats, glb, read};

/// World-space corners of every triangle that the crate finds, in its order.
fn peer_triangles(bytes: &[u8]) -> Vec<[Vec3; 3]> {
    let file = ::gltf::Gltf::from_slice(bytes).unwrap();
    let blob = file.blob.clone().unwrap();
    let mut found = Vec::new();
    let mut todo: Vec<(::gltf::Node, Mat4)> = (file.default_scene().unwrap().nodes())
        .map(|node| (node, Mat4::IDENTITY))
        .collect();
    todo.reverse();
    while let Some((node, above)) = todo.pop() {
        let place = above * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(::gltf::Mesh::primitives) {
            let reader = primitive.reader(|_| Some(&blob));
            let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            for corner in indices.chunks(3) {
                let world = |i: u32| place.transform_point3(positions[i as usize]);
                found.push([world(corner[0]), world(corner[1]), world(corner[2])]);
            }
        }
        let children: Vec<_> = node.children().map(|child| (child, place)).collect();
        todo.extend(children.into_iter().rev());
    }
    found
}

fn our_triangles(model: &Model) -> Vec<[DVec3; 3]> {
    (model.parts.iter())
        .flat_map(|part| {
            let mesh = &model.meshes[part.mesh];
            let world = |p: Vec3| part.model_from_mesh.point(p.as_dvec3());
            (0..mesh.triangles.len() as u32).map(move |i| mesh.corners(i).map(world))
        })
        .collect()
}

/// A tree of nodes over one cube: translations, rotations, scales, a matrix; nested three deep.
fn nodes() -> Value {
    let sheared = DMat4::from_cols_array(&[
        1.0, 0.2, 0.0, 0.0, 0.0, 2.0, 0.5, 0.0, 0.3, 0.0, 1.0, 0.0, 4.0, 5.0, 6.0, 1.0,
    ]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    json!([
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, half, 0, half], "children": [1, 2]},
        {"mesh": 0, "scale": [2, -1, 0.5]},
        {"translation": [0, 10, 0], "children": [3]},
        {"mesh": 0, "matrix": sheared.to_cols_array()},
    ])
}

#[test]
fn triangles_are_where_the_crate_gltf_puts_them() {
    let files = Files::new();
    let bytes_of = |size: usize| -> Vec<u8> {
        (CUBE_INDICES.iter())
            .flat_map(|&i| u32::from(i).to_le_bytes()[..size].to_vec())
            .collect()
    };
    for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        let (mut scene, binary) = document(
            &json!({"attributes": {"POSITION": 0}, "indices": 1}),
            &[
                json!({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
                       "min": [-1, -1, -1], "max": [1, 1, 1]}),
                json!({"bufferView": 1, "componentType": component, "count": 36, "type": "SCALAR"}),
            ],
            &[floats(&cube_positions()), bytes_of(size)],
        );
        scene["nodes"] = nodes();
        let peer = peer_triangles(&glb(&scene, &binary));
        let ours = our_triangles(&read(&files, &(scene, binary)));
        assert_eq!((ours.len(), peer.len()), (36, 36));
        for (ours, peer) in ours.iter().flatten().zip(peer.iter().flatten()) {
            assert!((*ours - peer.as_dvec3()).length() < 1e-5, "{ours} {peer}");
        }
    }
}
