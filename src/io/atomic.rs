//! Writing a file so that it is there whole or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// A file in the making: a temporary one in the folder of its place, gone if it is dropped.
pub(super) struct Pending {
    file: NamedTempFile,
    /// As the caller says it.
    path: PathBuf,
    /// Where that leads.
    target: PathBuf,
    overwrite: bool,
}

impl Pending {
    /// # Errors
    /// As [`write_atomically`].
    pub(super) fn new(path: &Path, overwrite: bool) -> Result<Self> {
        let target = resolve(path, overwrite)?;
        let file = create_beside(&target).map_err(|cause| Error::write(path, cause))?;
        Ok(Self {
            file,
            path: path.to_owned(),
            target,
            overwrite,
        })
    }

    /// The temporary file.
    pub(super) fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Where the temporary file is, for other programs.
    pub(super) fn temporary(&self) -> &Path {
        self.file.path()
    }

    /// Where it is to be.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Flushes it to the disk and gives it its name.
    ///
    /// # Errors
    /// As [`write_atomically`].
    pub(super) fn keep(self) -> Result<()> {
        let Self {
            file, path, target, ..
        } = self;
        let failed = |cause: std::io::Error| Error::write(&path, cause);
        if let Ok(old) = fs::metadata(&target) {
            file.as_file()
                .set_permissions(old.permissions())
                .map_err(failed)?;
        }
        file.as_file().sync_all().map_err(failed)?;
        if self.overwrite {
            file.persist(&target).map_err(|e| failed(e.error))?;
        } else {
            // The file may have come into being since `resolve` looked.
            file.persist_noclobber(&target)
                .map_err(|e| match e.error.kind() {
                    std::io::ErrorKind::AlreadyExists => exists(&path),
                    _ => failed(e.error),
                })?;
        }
        // The file is whole and in its place. Not every file system can flush a folder: that is no failure.
        if cfg!(unix) {
            let _ = File::open(folder(&target)).and_then(|folder| folder.sync_all());
        }
        Ok(())
    }
}

/// Writes `bytes` to `path`: to a temporary file in the same folder, flushed to the disk, then renamed.
/// Whatever fails, an old file keeps its content, and no reader ever sees half a file.
/// A new file gets the permissions the user's umask asks for, a replaced one keeps its own;
/// a symbolic link is followed.
///
/// # Errors
/// Where the folder does not take the file, or something is at `path` that must not be replaced:
/// a file unless `overwrite`, and anything that is not a regular file.
pub fn write_atomically(path: &Path, bytes: &[u8], overwrite: bool) -> Result<()> {
    let pending = Pending::new(path, overwrite)?;
    (pending.file().write_all(bytes)).map_err(|cause| Error::write(path, cause))?;
    pending.keep()
}

/// Finds out before a long render whether [`write_atomically`] can succeed, and leaves nothing behind.
///
/// # Errors
/// As [`write_atomically`].
pub fn check_writable(path: &Path, overwrite: bool) -> Result<()> {
    Pending::new(path, overwrite).map(drop)
}

/// Where `path` leads, once it is clear that it may be written.
fn resolve(path: &Path, overwrite: bool) -> Result<PathBuf> {
    if path.file_name().is_none() {
        return Err(Error::write(path, "the path names no file"));
    }
    let folder = folder(path);
    if !folder.is_dir() {
        let what = if folder.exists() {
            "is not a folder"
        } else {
            "does not exist"
        };
        return Err(Error::write(path, format!("`{}` {what}", folder.display()))
            .help("create the folder or choose another one"));
    }
    let Ok(link) = fs::symlink_metadata(path) else {
        return Ok(path.to_owned());
    };
    let target = if link.is_symlink() {
        fs::canonicalize(path).map_err(|cause| {
            Error::write(path, format!("it is a link that leads nowhere ({cause})"))
                .help("remove the link or create what it points to")
        })?
    } else {
        path.to_owned()
    };
    if !target.is_file() {
        let what = if target.is_dir() {
            "a folder"
        } else {
            "something that is not a regular file"
        };
        return Err(Error::write(path, format!("{what} has this name"))
            .help("choose another name for the output"));
    }
    if overwrite {
        Ok(target)
    } else {
        Err(exists(path))
    }
}

fn exists(path: &Path) -> Error {
    Error::write(path, "it exists already")
        .help("pass --force to replace it, or choose another name")
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of `target`, with the permissions of a file that anybody creates.
fn create_beside(target: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".solidtrace-").suffix(".part");
    // What a new file asks for, before the umask takes its share.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder(target))
}
