//! Objects that are made of others.

use glam::DVec3;

use crate::geometry::CsgOp;
use crate::scene::Repeat;
use crate::scene::description::ShapeDescription;

use super::fields::Fields;
use super::tree::{Node, Result};

/// The copies that one `Repeat` may make.
const MAX_COPIES: u32 = 1 << 24;

/// A set operation; its operands are left to read.
pub(super) fn operator<'n, 't>(
    name: &str,
    f: &mut Fields<'n, 't>,
    operands: &mut Vec<&'n Node<'t>>,
) -> Result<ShapeDescription> {
    let op = match name {
        "Union" => CsgOp::Union,
        "Intersection" => CsgOp::Intersection,
        _ => CsgOp::Difference,
    };
    if op == CsgOp::Difference {
        // Nothing to subtract is fine, as when all of it is commented out.
        operands.push(f.required("from", Ok)?);
        operands.extend(f.required("subtract", Node::items)?);
    } else {
        operands.extend(f.required("of", |node| match node.items()? {
            [] => Err(node.refuse("is empty: it takes at least one object")),
            items => Ok(items),
        })?);
    }
    let operands = operands.len();
    Ok(ShapeDescription::Csg { op, operands })
}

/// A grid of copies; what it copies is left to read.
pub(super) fn repeat<'n, 't>(
    f: &mut Fields<'n, 't>,
    operands: &mut Vec<&'n Node<'t>>,
) -> Result<Repeat> {
    let repeat = Repeat {
        count: f.required("count", count)?,
        step: f.required("step", |node| {
            let [x, y, z] = node.tuple("`((x, y, z), (x, y, z), (x, y, z))`")?;
            Ok([x.point()?, y.point()?, z.point()?])
        })?,
        jitter: f.or("jitter", DVec3::ZERO, Node::lengths_or_zero)?,
        seed: f.or("seed", 0, |node| node.count(0, u32::MAX))?.into(),
    };
    operands.push(f.required("of", Ok)?);
    Ok(repeat)
}

fn count(node: &Node) -> Result<[u32; 3]> {
    let [x, y, z] = node.tuple("`(x, y, z)`")?;
    let most = MAX_COPIES;
    let count = [x.count(1, most)?, y.count(1, most)?, z.count(1, most)?];
    let copies: u128 = count.iter().map(|&n| u128::from(n)).product();
    if copies > MAX_COPIES.into() {
        let rule = format!("makes {copies} copies, but at most {MAX_COPIES} are possible");
        return Err(node.refuse(&rule));
    }
    Ok(count)
}
