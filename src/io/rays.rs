//! Rays in and hits out as CSV.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use crate::error::{Error, ErrorKind, Place, Result};
use crate::math::Ray;

/// Columns that a ray file must have; `tmin` and `tmax` may follow.
const REQUIRED: [&str; 6] = ["ox", "oy", "oz", "dx", "dy", "dz"];

/// Reads rays one after the other from a CSV file with the columns `ox,oy,oz,dx,dy,dz` and optionally
/// `tmin,tmax`, in any order; other columns are passed over.
pub struct RayReader {
    path: std::path::PathBuf,
    records: csv::Reader<std::fs::File>,
    record: csv::StringRecord,
    /// Where each of the required columns, `tmin` and `tmax` stand.
    columns: [Option<usize>; 8],
}

impl RayReader {
    /// # Errors
    /// Where the file cannot be read or lacks a column.
    pub fn open(path: &Path) -> Result<Self> {
        let file = std::fs::File::open(path).map_err(|e| Error::read(path, &e))?;
        let mut records = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(file);
        let header = records.headers().map_err(|e| broken(path, &e))?.clone();
        let names = REQUIRED.into_iter().chain(["tmin", "tmax"]);
        let mut columns = [None; 8];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = header
                .iter()
                .position(|h| h.trim_start_matches('\u{feff}') == name);
            if column.is_none() && REQUIRED.contains(&name) {
                let found = header.iter().collect::<Vec<_>>().join(",");
                return Err(Error::input(format!("there is no column `{name}` in `{found}`"))
                    .at(Place::line(path, 1, &found))
                    .help("the first line names the columns: ox,oy,oz,dx,dy,dz and optionally tmin,tmax"));
            }
        }
        Ok(Self {
            path: path.to_owned(),
            records,
            record: csv::StringRecord::new(),
            columns,
        })
    }

    /// Up to `most` further rays; none at the end.
    ///
    /// # Errors
    /// Names the line, column and value of what is no ray.
    pub fn read(&mut self, most: usize) -> Result<Vec<Ray>> {
        let mut rays = Vec::new();
        while rays.len() < most {
            let more = self.records.read_record(&mut self.record);
            if !more.map_err(|e| broken(&self.path, &e))? {
                break;
            }
            rays.push(self.ray()?);
        }
        Ok(rays)
    }

    fn ray(&self) -> Result<Ray> {
        let number = |i: usize, default: f64| {
            let Some(column) = self.columns[i] else {
                return Ok(default);
            };
            let text = &self.record[column];
            (text.parse::<f64>().ok())
                .filter(|x| x.is_finite() || i >= 6 && !x.is_nan())
                .ok_or_else(|| self.wrong(&format!("`{text}` is not a number"), column))
        };
        let mut n = [0.0; 8];
        for (i, n) in n.iter_mut().enumerate() {
            *n = number(i, if i == 7 { f64::INFINITY } else { 0.0 })?;
        }
        let [ox, oy, oz, dx, dy, dz, tmin, tmax] = n;
        let ray = Ray {
            origin: DVec3::new(ox, oy, oz),
            direction: DVec3::new(dx, dy, dz),
            tmin,
            tmax,
        };
        let column = |i: usize| self.columns[i].unwrap_or(0);
        if ray.direction == DVec3::ZERO {
            return Err(self.wrong("the direction is zero", column(3)));
        }
        if tmin < 0.0 {
            return Err(self.wrong(&format!("tmin is negative: {tmin}"), column(6)));
        }
        if tmin > tmax {
            let message = format!("tmin {tmin} is beyond tmax {tmax}");
            return Err(self.wrong(&message, column(6)));
        }
        Ok(ray)
    }

    fn wrong(&self, message: &str, column: usize) -> Error {
        let line = self.record.position().map_or(0, csv::Position::line) as usize;
        let fields: Vec<&str> = self.record.iter().collect();
        let before: usize = fields[..column].iter().map(|f| f.chars().count() + 1).sum();
        let place = Place::column(&self.path, line, before + 1, &fields.join(","));
        Error::input(message).at(place)
    }
}

fn broken(path: &Path, cause: &csv::Error) -> Error {
    let place = match cause.position() {
        Some(position) => Place {
            line: Some(position.line() as usize),
            ..Place::file(path)
        },
        None => Place::file(path),
    };
    Error::input(format!("the file is not a table of rays: {cause}"))
        .at(place)
        .help("each line needs as many fields as the first")
}

/// A line of the hit file.
#[derive(Clone, Debug, PartialEq)]
pub struct HitRecord {
    /// Ray parameter.
    pub t: f64,
    /// The point.
    pub p: DVec3,
    /// Geometric normal: outward for solids, against the ray for surfaces.
    pub n: DVec3,
    /// Surface coordinates.
    pub uv: [f32; 2],
    /// The object's name, or its index.
    pub object: String,
    /// The triangle's index in its file, or 0.
    pub primitive: u32,
    /// The material's name.
    pub material: String,
}

/// Writes the header of a hit file.
///
/// # Errors
/// Where `out` does not take it.
pub fn write_hit_header(out: &mut dyn Write) -> Result<()> {
    out.write_all(b"hit,t,px,py,pz,nx,ny,nz,u,v,object,primitive,material\n")
        .map_err(|e| not_written(&e))
}

/// Writes one line for each ray; numbers are as short as they can be and still read back exactly.
///
/// # Errors
/// Where `out` does not take them.
pub fn write_hits(out: &mut dyn Write, hits: &[Option<HitRecord>]) -> Result<()> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_writer(out);
    for hit in hits {
        match hit {
            Some(hit) => writer.serialize((
                1,
                hit.t,
                hit.p.to_array(),
                hit.n.to_array(),
                hit.uv,
                &hit.object,
                hit.primitive,
                &hit.material,
            )),
            None => writer.write_record(["0", "", "", "", "", "", "", "", "", "", "", "", ""]),
        }
        .map_err(|e| not_written(&e.into()))?;
    }
    writer.flush().map_err(|e| not_written(&e))
}

/// Writes one line with only its first field for each ray: whether it is blocked.
///
/// # Errors
/// Where `out` does not take them.
pub fn write_blocked(out: &mut dyn Write, blocked: &[bool]) -> Result<()> {
    let lines: String = (blocked.iter())
        .map(|&b| {
            if b {
                "1,,,,,,,,,,,,\n"
            } else {
                "0,,,,,,,,,,,,\n"
            }
        })
        .collect();
    out.write_all(lines.as_bytes()).map_err(|e| not_written(&e))
}

fn not_written(cause: &std::io::Error) -> Error {
    Error::new(ErrorKind::Write, format!("cannot write the hits: {cause}"))
}
