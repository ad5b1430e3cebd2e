//! Meshes with holes: refused as operands, or taken by winding number.

use glam::{DAffine3, DVec3, Vec3};
use solidtrace::accel::{CsgTree, HOLE};
use solidtrace::geometry::{Csg, CsgOp, MeshId, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use crate::support::meshes::box_mesh;

fn at(p: [f64; 3]) -> Transform {
    Transform::new(DAffine3::from_translation(DVec3::from(p))).unwrap()
}

#[test]
fn an_open_mesh_is_refused_and_taken_by_winding_number_on_request() {
    let mut lidless = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    // The two triangles of the top.
    lidless
        .triangles
        .retain(|t| !t.iter().all(|&v| lidless.positions[v as usize].y == 1.0));
    let tree = |operand: Operand| {
        let mut csg = Csg::default();
        csg.push(operand, &Transform::IDENTITY, 0..1);
        csg.push(
            Operand::Solid(Solid::Sphere { radius: 0.5 }),
            &at([0.0, -1.0, 0.0]),
            0..1,
        );
        csg.combine(CsgOp::Difference, 2);
        CsgTree::build(&csg, std::slice::from_ref(&lidless))
    };
    let error = tree(Operand::Mesh(MeshId(0))).unwrap_err();
    assert!(
        error.message().contains("4 boundary edges in 1 loop"),
        "{error}"
    );
    let open = tree(Operand::OpenMesh(MeshId(0))).unwrap();
    // From below through the ball's cut; out through the missing lid.
    let up = open.crossings(&Ray::new(DVec3::new(0.01, -3.0, 0.02), DVec3::Y));
    assert_eq!(up.len(), 2, "{up:#?}");
    let depth = (0.25_f64 - 0.01 * 0.01 - 0.02 * 0.02).sqrt();
    assert!(up[0].enter && up[0].negated && (up[0].t - 2.0 - depth).abs() < 1e-12);
    // The lid hides half of all directions from a point in its plane: there is the mouth.
    let mouth = -3.0 + up[1].t;
    assert_eq!(up[1].face, HOLE);
    assert!(!up[1].enter && (mouth - 1.0).abs() < 0.01, "{mouth}");
    assert!(open.contains(DVec3::new(0.0, 0.0, 0.0)) && !open.contains(DVec3::new(0.0, 1.5, 0.0)));
}
