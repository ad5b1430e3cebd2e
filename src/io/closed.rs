//! Temporary, replaced at merge: takes every mesh for closed.

use std::path::Path;

use crate::error::Result;
use crate::geometry::Mesh;

#[expect(clippy::unnecessary_wraps, reason = "temporary")]
pub(super) fn check_closed(_path: &Path, _name: Option<&str>, _mesh: &Mesh) -> Result<()> {
    Ok(())
}
