//! Films: through the program ffmpeg where it is installed, else as animated PNG.

use std::fs::File;
use std::io::{BufWriter, Read, Seek, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::color::Tonemap;
use crate::error::{Error, ErrorKind, Place, Result};

use super::atomic::Pending;
use super::png::encoder;

/// What all frames of a film have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VideoSettings {
    /// Width and height of the frames.
    pub size: (u32, u32),
    /// How many there will be, at least 1.
    pub frames: u32,
    /// Frames a second, at least 1.
    pub fps: u16,
    /// The curve that the frames' bytes went through.
    pub tonemap: Tonemap,
    /// Whether a file that is there is replaced.
    pub overwrite: bool,
}

/// A film being written, frame by frame; the file appears when it is finished, and not before.
pub struct Video {
    /// Dropped first: a program still at work must not find its file gone.
    encoder: VideoEncoder,
    pending: Pending,
}

enum VideoEncoder {
    Apng(Box<png::Writer<BufWriter<File>>>),
    Ffmpeg(Ffmpeg),
}

impl Video {
    /// Starts the film `path`: `.png` is an animated PNG that repeats for ever, `.mp4` is made by ffmpeg. Where there is
    /// no ffmpeg an `.mp4` becomes a `.png` of the same name; [`Video::path`] tells.
    ///
    /// # Errors
    /// Where the extension is another, the file cannot be written, or ffmpeg does not start.
    pub fn create(path: &Path, settings: &VideoSettings) -> Result<Self> {
        match extension(path)? {
            Extension::Png => Self::apng(path, settings),
            Extension::Mp4 => {
                let pending = Pending::new(path, settings.overwrite)?;
                match Ffmpeg::start(&pending, settings)? {
                    Some(ffmpeg) => Ok(Self {
                        encoder: VideoEncoder::Ffmpeg(ffmpeg),
                        pending,
                    }),
                    None => Self::apng(&path.with_extension("png"), settings),
                }
            }
        }
    }

    fn apng(path: &Path, settings: &VideoSettings) -> Result<Self> {
        let pending = Pending::new(path, settings.overwrite)?;
        let start = || {
            let file = BufWriter::new(pending.file().try_clone()?);
            let mut encoder = encoder(file, settings.size, settings.tonemap);
            encoder.set_animated(settings.frames, 0)?;
            encoder.set_frame_delay(1, settings.fps)?;
            encoder.write_header()
        };
        let writer = start().map_err(|cause| Error::write(path, cause))?;
        Ok(Self {
            encoder: VideoEncoder::Apng(Box::new(writer)),
            pending,
        })
    }

    /// The file that it will be.
    pub fn path(&self) -> &Path {
        self.pending.path()
    }

    /// Adds the next frame: three bytes a pixel, row by row.
    ///
    /// # Errors
    /// Where the frame has another size, there are more than were announced, or the file cannot be written.
    pub fn add(&mut self, frame: &[u8]) -> Result<()> {
        match &mut self.encoder {
            VideoEncoder::Apng(writer) => (writer.write_image_data(frame))
                .map_err(|cause| Error::write(self.pending.path(), cause)),
            VideoEncoder::Ffmpeg(ffmpeg) => (ffmpeg.write(frame))
                .map_err(|cause| ffmpeg.failure(&cause).at(Place::file(self.pending.path()))),
        }
    }

    /// Ends the film and puts the file into its place.
    ///
    /// # Errors
    /// Where frames are missing, ffmpeg fails, or the file cannot be written.
    pub fn finish(self) -> Result<()> {
        let path = self.pending.path();
        match self.encoder {
            VideoEncoder::Apng(writer) => {
                writer.finish().map_err(|cause| Error::write(path, cause))?;
            }
            VideoEncoder::Ffmpeg(mut ffmpeg) => {
                ffmpeg.finish().map_err(|e| e.at(Place::file(path)))?;
            }
        }
        self.pending.keep()
    }
}

enum Extension {
    Png,
    Mp4,
}

fn extension(path: &Path) -> Result<Extension> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_lowercase().as_str() {
        "png" => Ok(Extension::Png),
        "mp4" => Ok(Extension::Mp4),
        _ => Err(Error::new(
            ErrorKind::Usage,
            format!("films cannot be written as `.{extension}`"),
        )
        .at(Place::file(path))
        .help("use .mp4 (ffmpeg makes it) or .png (animated)")),
    }
}

/// The program at work, fed through a pipe; ended if it is dropped before its time.
struct Ffmpeg {
    child: Child,
    /// What it says, in a file: nobody need read along.
    said: File,
}

impl Ffmpeg {
    /// Nothing if the program is not installed.
    fn start(pending: &Pending, settings: &VideoSettings) -> Result<Option<Self>> {
        let failed = |cause| Error::write(pending.path(), format!("ffmpeg: {cause}"));
        let said = tempfile::tempfile().map_err(failed)?;
        let (width, height) = settings.size;
        // Players want even sides, half the colours, and the matrix that goes with television's colours.
        let child = Command::new("ffmpeg")
            .args(["-nostdin", "-y", "-loglevel", "error", "-f", "rawvideo"])
            .args(["-pixel_format", "rgb24"])
            .args(["-video_size", &format!("{width}x{height}")])
            .args(["-framerate", &settings.fps.to_string(), "-i", "pipe:0"])
            .args([
                "-vf",
                "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
            ])
            .args(["-pix_fmt", "yuv420p", "-colorspace", "bt709"])
            .args(["-color_primaries", "bt709", "-color_trc", "bt709"])
            .args(["-color_range", "tv", "-q:v", "2"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(pending.temporary())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(said.try_clone().map_err(failed)?)
            .spawn();
        match child {
            Ok(child) => Ok(Some(Self { child, said })),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(failed(e)),
        }
    }

    fn write(&mut self, frame: &[u8]) -> std::io::Result<()> {
        let pipe = self.child.stdin.as_mut();
        pipe.ok_or(std::io::ErrorKind::BrokenPipe)?.write_all(frame)
    }

    fn finish(&mut self) -> Result<()> {
        drop(self.child.stdin.take());
        match self.child.wait() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(self.failure(&status)),
            Err(cause) => Err(self.failure(&cause)),
        }
    }

    /// What it said last, or else the cause that we know.
    fn failure(&mut self, cause: &dyn std::fmt::Display) -> Error {
        // What it has to say is complete when it has ended.
        drop(self.child.stdin.take());
        let _ = self.child.wait();
        let mut said = Vec::new();
        let _ = self.said.rewind();
        let _ = self.said.read_to_end(&mut said);
        let said = String::from_utf8_lossy(&said);
        let lines: Vec<&str> = said
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        let last = lines[lines.len().saturating_sub(3)..].join("\n ");
        let message = if last.is_empty() {
            format!("ffmpeg failed: {cause}")
        } else {
            format!("ffmpeg failed ({cause}):\n {last}")
        };
        Error::new(ErrorKind::Write, message)
            .help("write a .png, which is animated and needs no ffmpeg, or numbered pictures")
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // Both fail where it has ended already, which is as well.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
