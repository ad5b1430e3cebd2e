//! Whether a mesh is closed, and what is said of one that is not.

use glam::{DVec3, Vec3};
use solidtrace::geometry::{EdgeFault, Mesh};

use crate::random::SplitMix;
use crate::support::meshes::{box_mesh, bumpy_sphere, moved, slivers, torus_mesh};

fn cube() -> Mesh {
    box_mesh(Vec3::NEG_ONE, Vec3::ONE)
}

fn closed_meshes() -> Vec<Mesh> {
    vec![
        cube(),
        bumpy_sphere(20),
        torus_mesh(40, 20, 1.0, 0.4),
        slivers(15),
    ]
}

/// Boundary, flipped and non-manifold edges, and loops.
fn counts(mesh: &Mesh) -> [usize; 4] {
    let open = mesh.openness().expect("an open mesh");
    assert_eq!(
        open.open_edges(),
        open.boundary + open.flipped + open.nonmanifold
    );
    [open.boundary, open.flipped, open.nonmanifold, open.loops]
}

fn add(mesh: &mut Mesh, other: &Mesh) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&other.positions);
    (mesh.triangles).extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
}

#[test]
fn closed_meshes_are_closed_wherever_they_are() {
    for mesh in closed_meshes() {
        for (scale, offset) in [(1.0, Vec3::ZERO), (1e-6, Vec3::ZERO), (1e6, Vec3::ZERO)] {
            assert_eq!(moved(mesh.clone(), scale, offset).openness(), None);
        }
    }
    assert_eq!(moved(cube(), 1.0, Vec3::splat(1e6)).openness(), None);
}

#[test]
fn vertices_in_one_place_are_one_vertex() {
    for mesh in closed_meshes() {
        // Every triangle with vertices of its own, as glTF has them along seams; -0 is 0.
        let corners = mesh.triangles.iter().flatten().enumerate();
        let split = Mesh {
            positions: corners
                .map(|(i, &v)| {
                    let p = mesh.positions[v as usize] + 0.0;
                    // Twice a change of sign, which 0 survives as -0.
                    if i % 2 == 0 { p } else { -(0.0 - p) }
                })
                .collect(),
            triangles: (0..mesh.triangles.len() as u32)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect(),
            ..Mesh::default()
        };
        assert_eq!(split.openness(), None);
    }
}

#[test]
fn a_missing_triangle_leaves_a_loop_of_three_edges() {
    for mut mesh in closed_meshes() {
        let [a, b, c] = mesh.corners(5);
        mesh.triangles.remove(5);
        assert_eq!(counts(&mesh), [3, 0, 0, 1]);
        // The neighbours run along the hole the other way round.
        let open = mesh.openness().unwrap();
        let mut missing = vec![[b, a], [c, b], [a, c]];
        let mut last = 0;
        for edge in &open.edges {
            assert_eq!(edge.fault, EdgeFault::Boundary);
            let [from, to] = edge.ends;
            missing.retain(|ends| *ends != [from, to]);
            let corners = mesh.corners(edge.triangle);
            assert!((0..3).any(|i| [corners[i], corners[(i + 1) % 3]] == [from, to]));
            assert!(edge.triangle >= last);
            last = edge.triangle;
        }
        assert_eq!(missing, Vec::<[Vec3; 2]>::new());
    }
    let mut mesh = torus_mesh(40, 20, 1.0, 0.4);
    mesh.triangles.remove(800);
    mesh.triangles.remove(5);
    assert_eq!(counts(&mesh), [6, 0, 0, 2]);
}

#[test]
fn a_flipped_triangle_has_three_flipped_edges() {
    for mut mesh in closed_meshes() {
        mesh.triangles[7].swap(0, 2);
        assert_eq!(counts(&mesh), [0, 3, 0, 0]);
        let open = mesh.openness().unwrap();
        assert!(
            open.edges
                .iter()
                .all(|e| e.fault == EdgeFault::Flipped && e.triangle <= 7)
        );
    }
}

#[test]
fn a_fin_makes_its_edge_non_manifold() {
    for mut mesh in closed_meshes() {
        let [a, b, _] = mesh.triangles[3];
        mesh.positions.push(Vec3::new(5.0, 6.0, 7.0));
        (mesh.triangles).push([a, b, mesh.positions.len() as u32 - 1]);
        assert_eq!(counts(&mesh), [2, 0, 1, 1]);
    }
}

#[test]
fn solids_that_touch_overlap_or_nest_are_closed() {
    for offset in [
        Vec3::new(2.0, 2.0, 0.0),
        Vec3::new(2.0, 0.0, 0.0),
        Vec3::splat(2.0),
        Vec3::splat(0.5),
        Vec3::ZERO,
    ] {
        let mut mesh = cube();
        add(&mut mesh, &moved(cube(), 1.0, offset));
        assert_eq!(mesh.openness(), None, "{offset}");
    }
    // A hollow cube: the inner surface faces inward.
    let mut hollow = cube();
    let mut inner = moved(cube(), 0.5, Vec3::ZERO);
    inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    add(&mut hollow, &inner);
    assert_eq!(hollow.openness(), None);
}

#[test]
fn triangles_that_weld_away_do_not_count() {
    let mut mesh = cube();
    mesh.positions.push(mesh.positions[0]);
    mesh.triangles.extend([[0, 8, 1], [3, 3, 3], [0, 0, 8]]);
    assert_eq!(mesh.openness(), None);
    mesh.triangles.drain(..12);
    assert_eq!(counts(&mesh), [0; 4]);
    assert_eq!(mesh.openness().unwrap().volume, 0.0);
}

#[test]
fn a_mesh_without_an_inside_is_refused() {
    let mut mesh = moved(cube(), 1.0, Vec3::splat(1e5));
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let open = mesh.openness().unwrap();
    assert_eq!((open.volume, open.open_edges()), (-8.0, 0));
    let error = open.error(Some("dice"), |_| None).to_string();
    assert!(
        error.contains("the mesh `dice` is inside out: its volume is -8"),
        "{error}"
    );
    assert!(error.contains("flip"), "{error}");
    // A sheet with two sides.
    let sheet = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
        ..Mesh::default()
    };
    let error = sheet.openness().unwrap().error(None, |_| None);
    assert_eq!(error.message(), "the mesh encloses no volume");
}

#[test]
fn the_error_has_all_counts_and_the_first_ten_edges() {
    let mut mesh = torus_mesh(40, 20, 1.0, 0.4);
    mesh.triangles.truncate(1590);
    mesh.triangles[100].swap(0, 1);
    let open = mesh.openness().unwrap();
    let error = open.error(None, |triangle| Some(1000 + triangle));
    let lines: Vec<&str> = error.message().lines().collect();
    assert_eq!(
        lines[0],
        format!(
            "the mesh is not closed: {} boundary edges in 1 loop, 3 flipped edges, 0 non-manifold edges",
            open.boundary
        )
    );
    assert_eq!(lines.len(), 12);
    for (line, edge) in lines[1..].iter().zip(&open.edges) {
        let [p, q] = edge.ends;
        assert!(line.contains(&format!(
            "({}, {}, {}) to ({}, {}, {})",
            p.x, p.y, p.z, q.x, q.y, q.z
        )));
        let place = format!("triangle {}, line {}", edge.triangle, 1000 + edge.triangle);
        assert!(line.ends_with(&place), "{line}");
    }
    assert_eq!(
        lines[11].trim(),
        format!("and {} more", open.open_edges() - 10)
    );
    assert!(error.to_string().contains("--open-mesh-operands winding"));
    let without = open.error(None, |_| None);
    assert!(!without.message().contains("line"));
}

#[test]
fn counts_equal_those_of_a_plain_count_for_random_triangles() {
    let mut random = SplitMix(3);
    for _ in 0..2000 {
        let vertices = 4 + random.next() % 5;
        let mesh = Mesh {
            positions: (0..vertices)
                .map(|_| Vec3::from_array([0; 3].map(|_| (random.next() % 3) as f32)))
                .collect(),
            triangles: (0..=random.next() % 12)
                .map(|_| [0; 3].map(|_| (random.next() % vertices) as u32))
                .collect(),
            ..Mesh::default()
        };
        let mut edges: Vec<([Vec3; 2], i32, usize)> = Vec::new();
        for i in 0..mesh.triangles.len() as u32 {
            let corners = mesh.corners(i);
            if (0..3).any(|i| corners[i] == corners[(i + 1) % 3]) {
                continue;
            }
            for i in 0..3 {
                let [p, q] = [corners[i], corners[(i + 1) % 3]];
                match edges
                    .iter_mut()
                    .find(|(ends, ..)| *ends == [p, q] || *ends == [q, p])
                {
                    Some((ends, sum, count)) => {
                        *sum += if *ends == [p, q] { 1 } else { -1 };
                        *count += 1;
                    }
                    None => edges.push(([p, q], 1, 1)),
                }
            }
        }
        edges.retain(|(_, sum, _)| *sum != 0);
        let of = |wanted: fn(usize) -> bool| edges.iter().filter(|e| wanted(e.2)).count();
        // Merging pieces of the boundary until nothing changes.
        let mut pieces: Vec<Vec<Vec3>> = Vec::new();
        for (ends, ..) in edges.iter().filter(|e| e.2 == 1) {
            let (joined, apart): (Vec<_>, Vec<_>) =
                (pieces.into_iter()).partition(|piece| ends.iter().any(|p| piece.contains(p)));
            pieces = apart;
            pieces.push(joined.into_iter().flatten().chain(*ends).collect());
        }
        let volume: f64 = (0..mesh.triangles.len() as u32)
            .map(|i| {
                let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
                DVec3::dot(a, b.cross(c)) / 6.0
            })
            .sum();
        if edges.is_empty() && volume > 1e-9 {
            assert_eq!(mesh.openness(), None);
        } else if !edges.is_empty() {
            let plain = [of(|n| n == 1), of(|n| n == 2), of(|n| n > 2), pieces.len()];
            assert_eq!(counts(&mesh), plain, "{mesh:?}");
        }
    }
}
