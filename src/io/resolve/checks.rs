//! What must hold before anything is resolved: trees are whole, and instances lead to definitions that exist and
//! do not contain themselves.

use std::collections::HashMap;

use crate::error::{Error, Result, did_you_mean};
use crate::scene::description::{ObjectTree, Offset, Reference, ShapeDescription};

use super::Loader;

/// Definitions may hold instances of other definitions this deep.
const MAX_NESTING: usize = 64;

impl<'a> Loader<'a> {
    pub(super) fn check(&self) -> Result<()> {
        let mut heights = HashMap::new();
        for (name, tree) in &self.description.definitions {
            self.check_tree(tree)?;
            let height = self.height(tree, &mut vec![name], &mut heights)?;
            heights.insert(name, height);
        }
        for tree in &self.description.objects {
            self.check_tree(tree)?;
            self.height(tree, &mut Vec::new(), &mut heights)?;
        }
        Ok(())
    }

    /// Whether every operator of a tree, which a program may have put together, has its operands.
    fn check_tree(&self, tree: &ObjectTree) -> Result<()> {
        let fail = |message: String, offset| Err(Error::input(message).at(self.place(offset)));
        let mut results = 0;
        for object in &tree.0 {
            let operands = object.shape.operands();
            match object.shape {
                ShapeDescription::Csg { operands: 0, .. } => {
                    return fail("an operator has no operands".into(), object.offset);
                }
                ShapeDescription::Repeat(repeat) if repeat.copies() == 0 => {
                    let counts = repeat.count;
                    return fail(
                        format!("the `Repeat` {counts:?} makes no copies"),
                        object.offset,
                    );
                }
                _ if operands > results => {
                    return fail(
                        format!(
                            "an operator takes {operands} objects, but there are {results} before it"
                        ),
                        object.offset,
                    );
                }
                _ => results = results - operands + 1,
            }
        }
        if results == 1 {
            return Ok(());
        }
        let offset = tree.0.last().map_or(Offset::default(), |o| o.offset);
        fail(
            format!("{results} objects in one tree where no operator joins them"),
            offset,
        )
    }

    /// How many definitions are inside one another in a tree; `within` are those that led to it, and those whose
    /// own is known are in `heights`.
    fn height(
        &self,
        tree: &'a ObjectTree,
        within: &mut Vec<&'a str>,
        heights: &mut HashMap<&'a str, usize>,
    ) -> Result<usize> {
        let mut height = 0;
        for object in &tree.0 {
            let ShapeDescription::Instance { of } = &object.shape else {
                continue;
            };
            let (name, inner) = self.definition(of)?;
            if within.contains(&name) {
                let circle = within.join("` → `");
                let message =
                    format!("the definition `{name}` contains itself: `{circle}` → `{name}`");
                return Err(Error::input(message).at(self.place(of.offset)).help(
                    "a definition cannot hold an instance of itself, directly or through others",
                ));
            }
            let below = match heights.get(name) {
                Some(&known) => known,
                None if within.len() == MAX_NESTING => MAX_NESTING,
                None => {
                    within.push(name);
                    let below = self.height(inner, within, heights)?;
                    within.pop();
                    heights.insert(name, below);
                    below
                }
            };
            if within.len() + 1 + below > MAX_NESTING {
                let message = format!("more than {MAX_NESTING} definitions inside one another");
                return Err(Error::input(message).at(self.place(of.offset)));
            }
            height = height.max(1 + below);
        }
        Ok(height)
    }

    /// The definition of that name, as the scene spells it.
    pub(super) fn definition(&self, of: &Reference) -> Result<(&'a str, &'a ObjectTree)> {
        let found = self.definitions.get_key_value(&*of.name);
        found.map(|(&name, &tree)| (name, tree)).ok_or_else(|| {
            let help = did_you_mean(&of.name, self.definitions.keys().copied());
            Error::input(format!("there is no definition `{}`", of.name))
                .at(self.place(of.offset))
                .help(help)
        })
    }
}
