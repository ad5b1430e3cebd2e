//! Sheared, mirrored, tiny and huge operands far from the origin.

use glam::{DAffine3, DMat3, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::math::Ray;

use super::oracle::{Leaf, Naive, Tree, random_ray, rng};

/// Where an f64 keeps the places of a tree of [`on_grid`] to the bit.
const FAR: [DVec3; 2] = [
    DVec3::new(131072.0, -131072.0, 65536.0),
    DVec3::new(-65536.0, 131072.0, 131072.0),
];

/// `p` on a grid of 2^-30.
fn on_grid(p: DVec3) -> DVec3 {
    let grid = f64::from(1 << 30);
    (p * grid).round() / grid
}

/// The tree with each of its leaves replaced.
fn map(tree: &Tree, change: &mut impl FnMut(&Leaf) -> Leaf) -> Tree {
    match tree {
        Tree::Leaf(leaf) => Tree::Leaf(change(leaf)),
        Tree::Node(op, operands) => Tree::Node(
            *op,
            operands
                .iter()
                .map(|operand| map(operand, change))
                .collect(),
        ),
    }
}

/// The leaf's place stretched along its own axes by 1e-3 to 1e3, up to twice the whole.
fn stretched(leaf: &Leaf, rng: &mut Pcg64Mcg) -> Leaf {
    let mut factor = || match rng.random_range(0..4) {
        0 => 10_f64.powf(rng.random_range(-3.0..3.0)),
        _ => 1.0,
    };
    let scale = DMat3::from_diagonal(DVec3::new(factor(), factor(), factor()));
    let place = leaf.place;
    Leaf::new(
        leaf.solid,
        DAffine3::from_mat3_translation(place.matrix3 * scale, on_grid(place.translation)),
    )
}

#[test]
fn trees_at_a_hundred_thousand_are_met_as_at_the_origin() {
    let (mut crossings, mut doubtful) = (0, 0);
    for seed in 0..150 {
        let mut rng = rng(seed);
        let random = Tree::random(&mut rng, 4);
        let tree = map(&random, &mut |leaf| stretched(leaf, &mut rng));
        let far = FAR[seed as usize % 2];
        let moved = map(&tree, &mut |leaf| {
            let place = leaf.place;
            Leaf::new(
                leaf.solid,
                DAffine3::from_mat3_translation(place.matrix3, place.translation + far),
            )
        });
        let (judged, leaves) = (moved.build(), tree.leaves());
        for _ in 0..100 {
            let near = random_ray(&mut rng);
            let near = Ray::new(on_grid(near.origin), near.direction);
            let naive = Naive::of(&tree, &leaves, &near);
            let ray = Ray::new(near.origin + far, near.direction);
            let found = judged.crossings(&ray);
            assert!(
                naive.agrees(&found),
                "{ray:?}: {found:#?} for {naive:#?} of {moved:#?}"
            );
            assert!(
                found.windows(2).all(|w| w[0].enter != w[1].enter),
                "{ray:?}: {found:#?}"
            );
            crossings += naive.crossings.len();
            doubtful += usize::from(!naive.complete);
        }
    }
    assert!(
        crossings > 8_000 && doubtful < 1_000,
        "{crossings} {doubtful}"
    );
}
