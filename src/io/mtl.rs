//! MTL, the materials of OBJ files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Place, Result};
use crate::material::{Fresnel, Material, Principled, Surface};
use crate::texture::{Bitmap, Texture};

use super::lines::{Line, Lines, Word, Words};
use super::{read_bitmap, read_file};

/// Albedo where a material gives neither `Kd` nor `map_Kd`.
const DEFAULT_ALBEDO: Rgb = Rgb::splat(0.8);

/// One `newmtl` block as written. Textures are read when [`Definition::material`] asks for them.
#[derive(Default)]
pub(super) struct Definition {
    pub(super) name: String,
    diffuse: Option<Rgb>,
    emission: Option<Rgb>,
    specular: Option<Rgb>,
    ior: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    illum: Option<f32>,
    /// Phong's exponent.
    shininess: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    diffuse_map: Option<Map>,
    emission_map: Option<Place>,
}

/// A picture and the line that names it.
struct Map {
    file: PathBuf,
    place: Place,
}

/// The file that a name in `model` means: relative to its folder, with either kind of slash.
pub(super) fn relative_to(model: &Path, name: &str) -> PathBuf {
    let folder = model.parent().unwrap_or(Path::new(""));
    folder.join(name.replace('\\', "/"))
}

/// Reads the materials of `path` in the file's order; statements that bear on nothing here are ignored.
///
/// # Errors
/// Where the file cannot be read, a number does not parse or is out of range, or a name is missing.
pub(super) fn read(path: &Path, warnings: &mut Vec<String>) -> Result<Vec<Definition>> {
    let bytes = read_file(path)?;
    let mut lines = Lines::new(path, &bytes);
    let mut definitions: Vec<Definition> = Vec::new();
    while let Some(line) = lines.next() {
        let mut words = line.words();
        let Some(keyword) = words.next() else {
            continue;
        };
        if keyword.text == b"newmtl" {
            let name = line.argument();
            if name.is_empty() {
                return Err(line.error(keyword, "the material has no name"));
            }
            definitions.push(Definition {
                name,
                ..Definition::default()
            });
        } else if let Some(definition) = definitions.last_mut() {
            definition.statement(line, keyword, words, warnings)?;
        }
    }
    Ok(definitions)
}

impl Definition {
    fn statement(
        &mut self,
        line: Line<'_>,
        keyword: Word<'_>,
        words: Words<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<()> {
        match keyword.text {
            b"Kd" => self.diffuse = color(line, keyword, words, warnings)?,
            b"Ke" => self.emission = color(line, keyword, words, warnings)?,
            b"Ks" => self.specular = color(line, keyword, words, warnings)?,
            b"Ni" => self.ior = Some(number(line, keyword, words)?),
            b"d" => self.opacity = Some(number(line, keyword, words)?),
            b"Tr" => self.transparency = Some(number(line, keyword, words)?),
            b"illum" => self.illum = Some(number(line, keyword, words)?),
            b"Ns" => self.shininess = Some(number(line, keyword, words)?),
            b"Pr" => self.roughness = Some(number(line, keyword, words)?),
            b"Pm" => self.metallic = Some(number(line, keyword, words)?),
            b"map_Kd" => {
                let (name, moved) = map_name(line, keyword, words)?;
                if moved {
                    warnings.push(warning(
                        &line.place(),
                        "the map's scale and offset are not applied",
                    ));
                }
                self.diffuse_map = Some(Map {
                    file: relative_to(line.file, &line.tail(name)),
                    place: line.place_at(name.start),
                });
            }
            b"map_Ke" => self.emission_map = Some(line.place()),
            _ => {}
        }
        Ok(())
    }

    /// The material that comes nearest: a mirror for `illum 3` with `Ks`; glass, of roughness `Pr`, for `illum` 4, 6 and 7
    /// and for what lets more than half through (`d`, else `Tr`), if `Ni` is above 1; principled where there is a
    /// highlight (`Ks`, unless `illum` is 0 or 1) or `Pr` or `Pm`; else diffuse.
    /// Colours are linear. `textures` keeps what has been read.
    ///
    /// # Errors
    /// Where the texture cannot be read or is not a picture; the place is the MTL's line.
    pub(super) fn material(
        &self,
        textures: &mut HashMap<PathBuf, Arc<Bitmap>>,
        warnings: &mut Vec<String>,
    ) -> Result<Material> {
        let illum = self.illum.unwrap_or(2.0) as u32;
        let opacity = (self.opacity)
            .or(self.transparency.map(|t| 1.0 - t))
            .unwrap_or(1.0);
        let clear = matches!(illum, 4 | 6 | 7) || opacity < 0.5;
        let surface = match (illum, self.specular, self.ior) {
            (3, Some(color), _) if color != Rgb::ZERO => Surface::Mirror {
                color: Texture::Constant(color.min(Rgb::ONE)),
            },
            (_, _, Some(ior)) if clear && ior > 1.0 => Surface::Dielectric {
                ior,
                fresnel: Fresnel::Exact,
                roughness: self.roughness.unwrap_or(0.0).min(1.0).into(),
                absorption: Rgb::ZERO,
            },
            _ => self.opaque(illum, self.albedo(textures)?),
        };
        if let Some(place) = &self.emission_map {
            warnings.push(warning(
                place,
                "map_Ke is not supported; the material does not emit",
            ));
        }
        let emits = self.emission_map.is_none();
        Ok(Material {
            name: self.name.clone(),
            surface,
            emission: self.emission.filter(|_| emits).unwrap_or_default(),
            ..Material::default()
        })
    }

    /// Half of white `Ks` stands for the 4 % that most things reflect, as common writers have it; a highlight of
    /// exponent `Ns` is as wide as one of GGX whose alpha squared is `2 / (Ns + 2)`.
    fn opaque(&self, illum: u32, color: Texture) -> Surface {
        let highlight = self.specular.filter(|ks| illum > 1 && *ks != Rgb::ZERO);
        if highlight.is_none() && self.roughness.is_none() && self.metallic.is_none() {
            return Surface::Diffuse { color };
        }
        let exponent = self.shininess.unwrap_or(0.0);
        let roughness = (self.roughness).unwrap_or((2.0 / (exponent + 2.0)).powf(0.25));
        let defaults = Principled::new(color);
        Surface::Principled(Box::new(Principled {
            metallic: self.metallic.unwrap_or(0.0).min(1.0).into(),
            roughness: roughness.min(1.0).into(),
            specular_color: Texture::Constant(highlight.map_or(Rgb::ONE, |ks| 2.0 * ks)),
            ..defaults
        }))
    }

    fn albedo(&self, textures: &mut HashMap<PathBuf, Arc<Bitmap>>) -> Result<Texture> {
        let color = self.diffuse.map(|kd| kd.min(Rgb::ONE));
        let Some(map) = &self.diffuse_map else {
            return Ok(Texture::Constant(color.unwrap_or(DEFAULT_ALBEDO)));
        };
        let image = if let Some(image) = textures.get(&map.file) {
            Arc::clone(image)
        } else {
            let image = Arc::new(read_bitmap(&map.file, Encoding::Srgb).map_err(|e| {
                let name = map.file.display();
                Error::new(e.kind(), format!("the texture {name}: {}", e.message()))
                    .at(map.place.clone())
                    .help("textures are PNG, JPEG, BMP, TGA, HDR or EXR files beside the MTL file")
            })?);
            textures.insert(map.file.clone(), Arc::clone(&image));
            image
        };
        Ok(Texture::image(image, color.unwrap_or(Rgb::ONE)))
    }
}

/// One number for all channels, or three; not negative. `None` for a spectrum or CIE colour.
fn color(
    line: Line<'_>,
    keyword: Word<'_>,
    words: Words<'_>,
    warnings: &mut Vec<String>,
) -> Result<Option<Rgb>> {
    let words: Vec<Word<'_>> = words.collect();
    if words
        .first()
        .is_some_and(|w| matches!(w.text, b"spectral" | b"xyz"))
    {
        warnings.push(warning(&line.place(), "only RGB colours are read"));
        return Ok(None);
    }
    let values = (words.iter())
        .map(|&word| not_negative(line, word))
        .collect::<Result<Vec<f32>>>()?;
    match values[..] {
        [value] => Ok(Some(Rgb::splat(value))),
        [r, g, b] => Ok(Some(Rgb::new(r, g, b))),
        _ => Err((line.error(
            keyword,
            format!("{} has {} numbers", keyword.shown(), values.len()),
        ))
        .help("a colour is one number or three")),
    }
}

fn number(line: Line<'_>, keyword: Word<'_>, mut words: Words<'_>) -> Result<f32> {
    let word = words.find(|w| w.text != b"-halo");
    let word =
        word.ok_or_else(|| line.error(keyword, format!("{} has no number", keyword.shown())))?;
    not_negative(line, word)
}

fn not_negative(line: Line<'_>, word: Word<'_>) -> Result<f32> {
    let value = line.number(word)?;
    if value < 0.0 {
        return Err(line.error(word, format!("{} is negative", word.shown())));
    }
    Ok(value)
}

/// The first word of a map's file name, after the options, and whether these move or scale the map.
fn map_name<'a>(line: Line<'a>, keyword: Word<'a>, words: Words<'a>) -> Result<(Word<'a>, bool)> {
    let mut words = words.peekable();
    let mut moved = false;
    while let Some(word) = words.next() {
        let (least, most) = match word.text {
            b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-texres" | b"-bm" | b"-boost"
            | b"-imfchan" | b"-type" => (1, 1),
            b"-mm" => (2, 2),
            b"-o" | b"-s" | b"-t" => (1, 3),
            _ => return Ok((word, moved)),
        };
        let neutral = if word.text == b"-s" { 1.0 } else { 0.0 };
        for i in 0..most {
            let value = words.peek().and_then(|&w| line.number(w).ok());
            if i >= least && value.is_none() {
                break;
            }
            words.next();
            moved |= most == 3 && value != Some(neutral);
        }
    }
    Err(
        (line.error(keyword, format!("{} names no file", keyword.shown())))
            .help("the file name comes after the options"),
    )
}

fn warning(place: &Place, what: &str) -> String {
    let line = place.line.unwrap_or_default();
    format!("{}:{line}: {what}", place.file.display())
}
