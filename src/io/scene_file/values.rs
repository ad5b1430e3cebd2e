//! Reading single values from the tree: numbers in their ranges, points, colours, names.

use glam::DVec3;

use crate::color::Rgb;
use crate::scene::description::{Offset, Reference};

use super::tree::{Fault, Node, Result, Value};

/// Coordinates, lengths and factors stay within this and its inverse, so that products of a few of them, squared,
/// neither overflow nor vanish.
const LARGEST: f64 = 1e12;

impl Node<'_> {
    /// Says that something else stands here than `wanted`.
    pub(super) fn fault(&self, wanted: &str) -> Fault {
        Fault::new(
            self.offset,
            format!("expected {wanted}, found {}", self.shown()),
        )
    }

    /// The value as written, cut where it is long.
    fn shown(&self) -> String {
        let line = self.source.lines().next().unwrap_or_default();
        let mut shown: String = line.chars().take(40).collect();
        if shown.len() < self.source.len() {
            shown.push('…');
        }
        format!("`{shown}`")
    }

    /// Says that the value breaks a `rule`.
    pub(super) fn refuse(&self, rule: &str) -> Fault {
        Fault::new(self.offset, format!("{} {rule}", self.shown()))
    }

    /// Whether it is `None`, or JSON's `null`.
    pub(super) fn is_none(&self) -> bool {
        matches!(self.value, Value::Word("None" | "null"))
    }

    /// Nothing, or what `read` makes of it.
    pub(super) fn unless_none<'n, T>(
        &'n self,
        read: impl FnOnce(&'n Self) -> Result<T>,
    ) -> Result<Option<T>> {
        (!self.is_none()).then(|| read(self)).transpose()
    }

    /// Any finite number.
    pub(super) fn number(&self) -> Result<f64> {
        match self.value {
            Value::Number(n) if n.is_finite() => Ok(n),
            Value::Number(_) => Err(self.refuse("is not a finite number")),
            _ => Err(self.fault("a number")),
        }
    }

    /// A number in `min..=max`.
    pub(super) fn within(&self, min: f64, max: f64) -> Result<f64> {
        let n = self.number()?;
        let inside = (min..=max).contains(&n);
        (inside.then_some(n)).ok_or_else(|| self.refuse(&format!("is not in {min}..={max}")))
    }

    /// A coordinate.
    pub(super) fn coordinate(&self) -> Result<f64> {
        let n = self.number()?;
        let near = n.abs() <= LARGEST;
        (near.then_some(n)).ok_or_else(|| self.refuse("is too far out: at most 1e12 is"))
    }

    /// A length above 0.
    pub(super) fn length(&self) -> Result<f64> {
        match self.number()? {
            n if n <= 0.0 => Err(self.refuse("must be above 0")),
            n if !(1.0 / LARGEST..=LARGEST).contains(&n) => {
                Err(self.refuse("is beyond what can be rendered: 1e-12 to 1e12"))
            }
            n => Ok(n),
        }
    }

    /// A length that may be 0.
    pub(super) fn length_or_zero(&self) -> Result<f64> {
        match self.number()? {
            0.0 => Ok(0.0),
            n if n < 0.0 => Err(self.refuse("must be at least 0")),
            _ => self.length(),
        }
    }

    /// A whole number in `min..=max`.
    pub(super) fn count(&self, min: u32, max: u32) -> Result<u32> {
        let n = self.number()?;
        if n.fract() != 0.0 {
            return Err(self.refuse("is not a whole number"));
        }
        self.within(f64::from(min), f64::from(max))?;
        Ok(n as u32)
    }

    /// `true` or `false`.
    pub(super) fn boolean(&self) -> Result<bool> {
        match self.value {
            Value::Word("true") => Ok(true),
            Value::Word("false") => Ok(false),
            _ => Err(self.fault("`true` or `false`")),
        }
    }

    /// Text in quotes, not empty.
    pub(super) fn text(&self) -> Result<String> {
        match &self.value {
            Value::String(text) if text.trim().is_empty() => Err(self.refuse("is empty")),
            Value::String(text) => Ok(text.clone().into_owned()),
            _ => Err(self.fault("text in double quotes")),
        }
    }

    /// The name of something else, or of a file.
    pub(super) fn reference(&self) -> Result<Reference> {
        Ok(Reference {
            name: self.text()?,
            offset: Offset(self.offset),
        })
    }

    /// A list of any length.
    pub(super) fn items(&self) -> Result<&[Self]> {
        match &self.value {
            Value::List(None, items) => Ok(items),
            _ => Err(self.fault("a list, `[..]`")),
        }
    }

    /// Exactly `N` values; `form` shows what is wanted.
    pub(super) fn tuple<const N: usize>(&self, form: &str) -> Result<&[Self; N]> {
        let Value::List(None, items) = &self.value else {
            return Err(self.fault(form));
        };
        <&[Self; N]>::try_from(items.as_slice()).map_err(|_| {
            let count = items.len();
            self.refuse(&format!("has {count} values, but {form} takes {N}"))
        })
    }

    /// Three values; `form` shows what is wanted.
    pub(super) fn three(&self, form: &str, read: fn(&Self) -> Result<f64>) -> Result<DVec3> {
        let [x, y, z] = self.tuple(form)?;
        Ok(DVec3::new(read(x)?, read(y)?, read(z)?))
    }

    /// A point.
    pub(super) fn point(&self) -> Result<DVec3> {
        self.three("`(x, y, z)`", Self::coordinate)
    }

    /// Edge lengths.
    pub(super) fn lengths(&self) -> Result<DVec3> {
        self.three("`(x, y, z)`", Self::length)
    }

    /// Lengths that may be 0.
    pub(super) fn lengths_or_zero(&self) -> Result<DVec3> {
        self.three("`(x, y, z)`", Self::length_or_zero)
    }

    /// Factors other than 0, one for each axis or one for all.
    pub(super) fn factors(&self) -> Result<DVec3> {
        let factor = |node: &Self| match node.number()? {
            0.0 => Err(node.refuse("would flatten the object: a factor is not 0")),
            n if !(1.0 / LARGEST..=LARGEST).contains(&n.abs()) => {
                Err(node.refuse("is beyond what can be rendered: 1e-12 to 1e12"))
            }
            n => Ok(n),
        };
        match self.value {
            Value::Number(_) => factor(self).map(DVec3::splat),
            _ => self.three("one factor or `(x, y, z)`", factor),
        }
    }

    /// A direction as a unit vector.
    pub(super) fn direction(&self) -> Result<DVec3> {
        let v = self.point()?;
        (v.try_normalize()).ok_or_else(|| self.refuse("has no direction: it is too short"))
    }

    /// Light per channel, unbounded above.
    pub(super) fn radiance(&self) -> Result<Rgb> {
        // Far above any light, far below where sums of f32 overflow.
        let channel = |node: &Self| node.within(0.0, 1e12);
        Ok(self.three("`(r, g, b)`", channel)?.as_vec3())
    }

    /// A share of light per channel.
    pub(super) fn albedo(&self) -> Result<Rgb> {
        let channel = |node: &Self| {
            let share = node.within(0.0, 1.0);
            share.map_err(|f| {
                f.help("a surface cannot reflect more light than it gets; a lamp is `Emissive`")
            })
        };
        Ok(self.three("`(r, g, b)`", channel)?.as_vec3())
    }
}
