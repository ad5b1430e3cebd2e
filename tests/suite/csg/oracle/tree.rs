//! Trees of set operations as a truth table over placed solids, and random ones.

use std::array::from_fn;
use std::slice::Iter;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgTree;
use solidtrace::geometry::{Csg, CsgOp, MeshId, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use super::lathe::cuboid;

/// A solid in its place.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    pub solid: Solid,
    pub place: DAffine3,
    pub back: DAffine3,
}

/// A set operation over trees; its leaves are counted from the left.
#[derive(Clone, Debug)]
pub enum Tree {
    Leaf(Leaf),
    Node(CsgOp, Vec<Tree>),
}

/// Bottom, top radius of the cones, for a greater one of 1.
pub const CONES: [(f64, f64); 4] = [(1.0, 0.0), (0.0, 1.0), (1.0, 0.5), (0.3, 1.0)];

/// Minor radius of the tori, for a major one of 1.
pub const TORI: [f64; 4] = [0.02, 0.1, 0.35, 0.8];

/// No more leaves than about this.
const LEAVES: usize = 24;

impl Leaf {
    pub fn new(solid: Solid, place: DAffine3) -> Self {
        Self {
            solid,
            place,
            back: place.inverse(),
        }
    }

    /// `ray` in the solid's space; `t` is the same.
    pub fn ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.back.transform_point3(ray.origin),
            direction: self.back.transform_vector3(ray.direction),
            ..*ray
        }
    }
}

impl Tree {
    pub fn leaf(solid: Solid, place: DAffine3) -> Self {
        Self::Leaf(Leaf::new(solid, place))
    }

    pub fn union(operands: impl Into<Vec<Self>>) -> Self {
        Self::Node(CsgOp::Union, operands.into())
    }

    pub fn intersection(operands: impl Into<Vec<Self>>) -> Self {
        Self::Node(CsgOp::Intersection, operands.into())
    }

    pub fn difference(operands: impl Into<Vec<Self>>) -> Self {
        Self::Node(CsgOp::Difference, operands.into())
    }

    /// All solids, operators and kinds of transforms, up to `depth` operators above a leaf.
    pub fn random(rng: &mut Pcg64Mcg, depth: u32) -> Self {
        let mut room = LEAVES;
        Self::grow(rng, depth, &mut room)
    }

    fn grow(rng: &mut Pcg64Mcg, depth: u32, room: &mut usize) -> Self {
        if depth == 0 || *room == 0 {
            *room = room.saturating_sub(1);
            return Self::leaf(random_solid(rng), random_place(rng));
        }
        let op = match rng.random_range(0..10) {
            0..4 => CsgOp::Union,
            4..7 => CsgOp::Intersection,
            _ => CsgOp::Difference,
        };
        let operands = (0..rng.random_range(1..5)).map(|_| {
            let shallower = rng.random_range(0..depth);
            Self::grow(rng, shallower, room)
        });
        Self::Node(op, operands.collect())
    }

    pub fn leaves(&self) -> Vec<Leaf> {
        match self {
            Self::Leaf(leaf) => vec![*leaf],
            Self::Node(_, operands) => operands.iter().flat_map(Self::leaves).collect(),
        }
    }

    /// The same tree as the crate has it; operands count as leaves do.
    pub fn csg(&self) -> Csg {
        let mut csg = Csg::default();
        self.push(&mut csg, &|leaf| (Operand::Solid(leaf.solid), leaf.place));
        csg
    }

    fn push(&self, csg: &mut Csg, operand: &impl Fn(&Leaf) -> (Operand, DAffine3)) {
        match self {
            Self::Leaf(leaf) => {
                let (operand, place) = operand(leaf);
                let place = Transform::new(place).expect("places have an inverse");
                csg.push(operand, &place, 0..1);
            }
            Self::Node(op, operands) => {
                for tree in operands {
                    tree.push(csg, operand);
                }
                csg.combine(*op, operands.len());
            }
        }
    }

    /// What is judged.
    pub fn build(&self) -> CsgTree {
        CsgTree::build(&self.csg(), &[]).expect("the tree is whole")
    }

    /// The same with meshes for boxes.
    pub fn build_with_meshes(&self) -> CsgTree {
        let mut csg = Csg::default();
        self.push(&mut csg, &|leaf| match leaf.solid {
            Solid::Box { half } => {
                let stretch = DAffine3::from_scale(half);
                (Operand::Mesh(MeshId(0)), leaf.place * stretch)
            }
            solid => (Operand::Solid(solid), leaf.place),
        });
        CsgTree::build(&csg, &[cuboid(1.0)]).expect("the mesh is closed")
    }

    /// Whether a point is inside, given for each leaf whether the point is in that; `None` is unknown (Kleene's
    /// logic of three values).
    pub fn holds(&self, inside: &[Option<bool>]) -> Option<bool> {
        self.value(&mut inside.iter())
    }

    fn value(&self, inside: &mut Iter<Option<bool>>) -> Option<bool> {
        let Self::Node(op, operands) = self else {
            return *inside.next().expect("a value for each leaf");
        };
        let decisive = *op == CsgOp::Union;
        let mut result = Some(!decisive);
        for (i, operand) in operands.iter().enumerate() {
            let value = operand.value(inside);
            let subtracted = *op == CsgOp::Difference && i > 0;
            let value = value.map(|value| value != subtracted);
            if value == Some(decisive) || result == Some(decisive) {
                result = Some(decisive);
            } else if value.is_none() {
                result = None;
            }
        }
        result
    }
}

/// A direction.
pub fn unit(rng: &mut Pcg64Mcg) -> DVec3 {
    loop {
        let v = DVec3::from_array(from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
            return v.normalize();
        }
    }
}

/// Any of the six solids, 0.3 to 1.2 large.
pub fn random_solid(rng: &mut Pcg64Mcg) -> Solid {
    let mut length = || rng.random_range(0.3..1.2);
    let (a, b, c) = (length(), length(), length());
    match rng.random_range(0..11) {
        0 | 1 => Solid::Sphere { radius: a },
        2 | 3 => Solid::Box {
            half: DVec3::new(a, b, c),
        },
        4 | 5 => Solid::Cylinder {
            radius: a,
            height: 2.0 * b,
        },
        6 | 7 => {
            let (from, to) = CONES[rng.random_range(0..CONES.len())];
            Solid::Cone {
                from_radius: from * a,
                to_radius: to * a,
                height: 2.0 * b,
            }
        }
        8 | 9 => Solid::Torus {
            major: a,
            minor: TORI[rng.random_range(0..TORI.len())] * a,
        },
        _ => Solid::Plane,
    }
}

/// Near the origin, and turned; half of the places are rigid, the others stretched, sheared or mirrored as well.
pub fn random_place(rng: &mut Pcg64Mcg) -> DAffine3 {
    let mut turn = || {
        DMat3::from_quat(DQuat::from_axis_angle(
            unit(rng),
            rng.random_range(0.0..6.3),
        ))
    };
    let (outer, inner) = (turn(), turn());
    let mut vector =
        |low: f64, high: f64| DVec3::from_array(from_fn(|_| rng.random_range(low..high)));
    let origin = vector(-0.9, 0.9);
    let scale = DMat3::from_diagonal(vector(0.4, 1.8));
    let shear = vector(-0.8, 0.8);
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(shear.x, 1.0, 0.0),
        DVec3::new(shear.y, shear.z, 1.0),
    );
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let linear = match rng.random_range(0..6) {
        0 => outer * scale,
        1 => outer * shear * inner,
        2 => outer * mirror * scale * shear * inner,
        _ => outer,
    };
    DAffine3::from_mat3_translation(linear, origin)
}

/// A ray at trees of [`Tree::random`], from within or from a distance of 7; directions are of any length.
pub fn random_ray(rng: &mut Pcg64Mcg) -> Ray {
    let mut in_ball = |radius: f64| radius * rng.random::<f64>().cbrt() * unit(rng);
    let (near, target) = (in_ball(2.0), in_ball(1.8));
    let origin = match rng.random_range(0..3) {
        0 => near,
        _ => 7.0 * unit(rng),
    };
    let length = 10_f64.powf(rng.random_range(-1.0..1.0));
    Ray::new(origin, length * (target - origin).normalize())
}
