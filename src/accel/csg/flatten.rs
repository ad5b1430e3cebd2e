//! From a tree of set operations to a formula that a sweep can count: `or` and `and` in alternating levels over
//! operands, each possibly negated, with everything left out that cannot matter.

use crate::geometry::{Csg, CsgOp, CsgStep};
use crate::math::Bounds;

/// An operator of the formula: true operands make an `or` true, false ones an `and` false.
#[derive(Clone, Copy, Debug)]
pub(super) struct Operator {
    pub(super) or: bool,
    /// Itself for the root, which is the first.
    pub(super) parent: u32,
    /// How many of its operands count (are true below an `or`, false below an `and`) where all solids are outside.
    pub(super) count: i32,
}

/// An operand of the formula: a leaf of the tree, or its complement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Literal {
    /// Index of the leaf in the tree.
    pub(super) leaf: u32,
    pub(super) parent: u32,
    pub(super) negated: bool,
    /// The part of the leaf's box in which it can matter.
    pub(super) bounds: Bounds,
}

/// A formula in negation normal form.
#[derive(Debug)]
pub(super) struct Formula {
    pub(super) operators: Vec<Operator>,
    pub(super) literals: Vec<Literal>,
    /// The box around the solid; empty where nothing is left of it.
    pub(super) bounds: Bounds,
}

/// What the tree was before flattening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Authored {
    pub(super) operators: usize,
    pub(super) depth: usize,
}

impl Formula {
    /// Flattens `csg`, whose leaves have the boxes `bounds`.
    pub(super) fn new(csg: &Csg, bounds: &[Bounds]) -> (Self, Authored) {
        let (tree, authored) = Tree::of(csg);
        let mut formula = tree.normal_form(csg, bounds);
        formula.restrict();
        formula.simplify();
        (formula, authored)
    }

    /// Shrinks every box to where its operand can matter: a conjunction is false outside of any of its operands
    /// (the S-bounds of Cameron and Yap 1992, "Refinement methods for geometric bounds in constructive solid
    /// geometry", with one pass up and one down).
    fn restrict(&mut self) {
        let neutral = |or: bool| if or { Bounds::EMPTY } else { Bounds::ALL };
        let mut bounds: Vec<Bounds> = self.operators.iter().map(|op| neutral(op.or)).collect();
        let gather = |into: &mut Bounds, or: bool, part: Bounds| {
            *into = if or {
                into.union(part)
            } else {
                into.intersection(part)
            };
        };
        for literal in &self.literals {
            let parent = literal.parent as usize;
            let part = if literal.negated {
                Bounds::ALL
            } else {
                literal.bounds
            };
            gather(&mut bounds[parent], self.operators[parent].or, part);
        }
        // Operators stand behind their parents.
        for i in (1..self.operators.len()).rev() {
            let parent = self.operators[i].parent as usize;
            let part = bounds[i];
            gather(&mut bounds[parent], self.operators[parent].or, part);
        }
        for i in 1..self.operators.len() {
            bounds[i] = bounds[i].intersection(bounds[self.operators[i].parent as usize]);
        }
        for literal in &mut self.literals {
            literal.bounds = literal.bounds.intersection(bounds[literal.parent as usize]);
        }
        self.bounds = bounds[0];
    }

    /// Leaves out the operands whose boxes are empty, which are always outside, and what they decide; and sets the
    /// counts.
    fn simplify(&mut self) {
        let operators = &mut self.operators;
        let mut value: Vec<Option<bool>> = vec![None; operators.len()];
        let mut size = vec![0_u32; operators.len()];
        for literal in &self.literals {
            let parent = literal.parent as usize;
            if !literal.bounds.is_empty() {
                size[parent] += 1;
            } else if literal.negated == operators[parent].or {
                value[parent] = Some(literal.negated);
            }
        }
        for i in (0..operators.len()).rev() {
            if value[i].is_none() && size[i] == 0 {
                value[i] = Some(!operators[i].or);
            }
            if i > 0 {
                let parent = operators[i].parent as usize;
                match value[i] {
                    Some(constant) if constant == operators[parent].or => {
                        value[parent] = Some(constant);
                    }
                    Some(_) => {}
                    None => size[parent] += 1,
                }
            }
        }
        for i in 1..operators.len() {
            value[i] = value[i].or(value[operators[i].parent as usize]);
        }
        self.literals.retain(|literal| {
            !literal.bounds.is_empty() && value[literal.parent as usize].is_none()
        });
        if value[0].is_some() {
            self.bounds = Bounds::EMPTY;
            // Nothing is left: an `or` of nothing is false.
            operators[0].or = true;
        }

        // Operators without a value, renumbered.
        let mut number = vec![0_u32; operators.len()];
        let mut kept = Vec::new();
        for (i, operator) in operators.iter().enumerate() {
            if value[i].is_none() || i == 0 {
                number[i] = kept.len() as u32;
                kept.push(Operator {
                    parent: number[operator.parent as usize],
                    ..*operator
                });
            }
        }
        for literal in &mut self.literals {
            literal.parent = number[literal.parent as usize];
            let parent = &mut kept[literal.parent as usize];
            parent.count += i32::from(literal.negated == parent.or);
        }
        for i in (1..kept.len()).rev() {
            let truth = (kept[i].count > 0) == kept[i].or;
            let parent = kept[i].parent as usize;
            kept[parent].count += i32::from(truth == kept[parent].or);
        }
        self.operators = kept;
    }
}

/// Where the operands of each step of a post-order stand.
struct Tree {
    /// For each step where its list in `operands` starts.
    first: Vec<u32>,
    /// Steps, leaves having none.
    operands: Vec<u32>,
}

impl Tree {
    fn of(csg: &Csg) -> (Self, Authored) {
        let mut tree = Self {
            first: Vec::with_capacity(csg.steps.len()),
            operands: Vec::with_capacity(csg.steps.len()),
        };
        let mut authored = Authored::default();
        // (step, depth) of the results so far.
        let mut stack: Vec<(u32, usize)> = Vec::new();
        for (i, step) in csg.steps.iter().enumerate() {
            tree.first.push(tree.operands.len() as u32);
            let depth = match *step {
                CsgStep::Leaf => 0,
                CsgStep::Combine(_, count) => {
                    let taken = stack.drain(stack.len() - count as usize..);
                    let mut deepest = 0;
                    for (operand, depth) in taken {
                        tree.operands.push(operand);
                        deepest = deepest.max(depth);
                    }
                    authored.operators += 1;
                    deepest + 1
                }
            };
            authored.depth = authored.depth.max(depth);
            stack.push((i as u32, depth));
        }
        (tree, authored)
    }

    /// Negations go down to the leaves by De Morgan's laws; an operator of its parent's kind becomes one with it.
    fn normal_form(&self, csg: &Csg, bounds: &[Bounds]) -> Formula {
        // Leaves count upward in the post-order.
        let mut leaf_of = Vec::with_capacity(csg.steps.len());
        let mut leaves = 0;
        for step in &csg.steps {
            leaf_of.push(leaves);
            leaves += u32::from(*step == CsgStep::Leaf);
        }
        let mut formula = Formula {
            operators: vec![Operator {
                or: true,
                parent: 0,
                count: 0,
            }],
            literals: Vec::with_capacity(csg.len()),
            bounds: Bounds::EMPTY,
        };
        // (step, its parent in the formula, whether it is negated)
        let mut todo = vec![(csg.steps.len() as u32 - 1, 0, false)];
        let mut root = true;
        while let Some((step, parent, negated)) = todo.pop() {
            match csg.steps[step as usize] {
                CsgStep::Leaf => {
                    let leaf = leaf_of[step as usize];
                    formula.literals.push(Literal {
                        leaf,
                        parent,
                        negated,
                        bounds: bounds[leaf as usize],
                    });
                }
                CsgStep::Combine(op, count) => {
                    let or = (op == CsgOp::Union) != negated;
                    let node = if root {
                        formula.operators[0].or = or;
                        0
                    } else if formula.operators[parent as usize].or == or {
                        parent
                    } else {
                        formula.operators.push(Operator {
                            or,
                            parent,
                            count: 0,
                        });
                        formula.operators.len() as u32 - 1
                    };
                    root = false;
                    let first = self.first[step as usize] as usize;
                    let operands = &self.operands[first..first + count as usize];
                    // Backwards, so that the first is looked at first.
                    for (i, &operand) in operands.iter().enumerate().rev() {
                        let subtracted = op == CsgOp::Difference && i > 0;
                        todo.push((operand, node, negated != subtracted));
                    }
                }
            }
        }
        formula
    }
}
