//! Materials: the nearest of ours for each glTF material.

use std::collections::HashMap;
use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Result};
use crate::material::{Fresnel, Material, Relief, Surface};
use crate::texture::{Bitmap, PixelFilter, Sampling, Texture, Wrap};

use super::super::texture::decode_bitmap;
use super::accessor::Document;
use super::buffer::read_uri;
use super::json::Json;

/// Reads all materials in order. Transmission above 0.5 (`KHR_materials_transmission`) is glass with the index
/// of `KHR_materials_ior`; metal with roughness below 0.2 and without textures is a mirror; all else is diffuse.
/// Colour textures are sRGB, normal maps data, factors linear; emission is the factor times its texture times
/// `KHR_materials_emissive_strength`.
///
/// # Errors
/// Where a field is of the wrong type or a texture is no picture.
pub(super) fn read_all(
    document: &Document<'_>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Material>> {
    let mut reader = Reader {
        document,
        images: vec![HashMap::new(); document.root.list("images")?.len()],
        warnings,
    };
    let sources = document.root.list("materials")?;
    (sources.iter().enumerate())
        .map(|(i, source)| reader.material(i, source))
        .collect()
}

struct Reader<'d, 'a> {
    document: &'d Document<'a>,
    /// What has been read of each picture, as colours or as data.
    images: Vec<HashMap<Encoding, Arc<Bitmap>>>,
    warnings: &'d mut Vec<String>,
}

impl Reader<'_, '_> {
    fn material(&mut self, index: usize, source: &Json<'_>) -> Result<Material> {
        let transmission = (source.extension("KHR_materials_transmission")?)
            .map_or(Ok(0.0), |e| e.number_or("transmissionFactor", 0.0))?;
        let surface = if transmission > 0.5 {
            let ior = (source.extension("KHR_materials_ior")?)
                .map_or(Ok(1.5), |e| e.number_or("ior", 1.5))?;
            if ior < 1.0 {
                return Err(source.error(format!("the index of refraction {ior} is below 1")));
            }
            Surface::Dielectric {
                ior: ior as f32,
                fresnel: Fresnel::Exact,
            }
        } else {
            self.opaque(source)?
        };
        if source
            .get("alphaMode")?
            .map_or(Ok("OPAQUE"), |mode| mode.text())?
            != "OPAQUE"
        {
            self.warnings
                .push(source.warning("transparency by alpha is not supported"));
        }
        let mut emission = emission(source)?;
        let mut emission_texture = None;
        if emission != Rgb::ZERO
            && let Some(info) = source.get("emissiveTexture")?
        {
            emission_texture = self.texture(&info, Encoding::Srgb, Rgb::ONE)?;
            if emission_texture.is_none() {
                emission = Rgb::ZERO;
            }
        }
        Ok(Material {
            name: source.name().unwrap_or_else(|| format!("material {index}")),
            surface,
            emission,
            emission_texture,
            relief: self.relief(source)?,
        })
    }

    fn opaque(&mut self, source: &Json<'_>) -> Result<Surface> {
        let Some(pbr) = source.get("pbrMetallicRoughness")? else {
            return Ok(Surface::Diffuse {
                color: Texture::Constant(Rgb::ONE),
            });
        };
        let [r, g, b, _] = pbr.numbers_or("baseColorFactor", [1.0; 4])?;
        let factor = Rgb::new(r as f32, g as f32, b as f32).clamp(Rgb::ZERO, Rgb::ONE);
        let metallic = pbr.number_or("metallicFactor", 1.0)?;
        let roughness = pbr.number_or("roughnessFactor", 1.0)?;
        let textured = pbr.get("metallicRoughnessTexture")?.is_some();
        let color = match pbr.get("baseColorTexture")? {
            Some(info) => self.texture(&info, Encoding::Srgb, factor)?,
            None => None,
        };
        Ok(match color {
            Some(color) => Surface::Diffuse { color },
            None if metallic > 0.5 && roughness < 0.2 && !textured => Surface::Mirror {
                color: Texture::Constant(factor),
            },
            None => Surface::Diffuse {
                color: Texture::Constant(factor),
            },
        })
    }

    /// Section 3.9.3 of the specification: green is up, which is where v grows once it is turned over.
    fn relief(&mut self, source: &Json<'_>) -> Result<Option<Relief>> {
        let Some(info) = source.get("normalTexture")? else {
            return Ok(None);
        };
        let scale = info.number_or("scale", 1.0)?;
        let texture = self.texture(&info, Encoding::Linear, Rgb::ONE)?;
        Ok(texture.map(|texture| Relief::NormalMap { texture, scale }))
    }

    /// What a texture reference refers to, times `scale`; `None`, with a warning, where only an unknown extension has
    /// its picture.
    fn texture(
        &mut self,
        info: &Json<'_>,
        encoding: Encoding,
        scale: Rgb,
    ) -> Result<Option<Texture>> {
        if info.count_or("texCoord", 0)? != 0 {
            self.warnings
                .push(info.warning("only TEXCOORD_0 is read; it is used instead"));
        }
        if info.extension("KHR_texture_transform")?.is_some() {
            self.warnings
                .push(info.warning("the texture's transform is not applied"));
        }
        let (_, texture) = self
            .document
            .root
            .element("textures", &info.need("index")?)?;
        let Some(reference) = texture.get("source")? else {
            self.warnings
                .push(texture.warning("the texture has no picture of a known format"));
            return Ok(None);
        };
        let sampling = self.sampling(&texture)?;
        let (index, source) = self.document.root.element("images", &reference)?;
        let image = self.image(index, &source, encoding)?;
        Ok(Some(Texture::Image {
            image,
            scale,
            sampling,
        }))
    }

    fn image(
        &mut self,
        index: usize,
        source: &Json<'_>,
        encoding: Encoding,
    ) -> Result<Arc<Bitmap>> {
        if let Some(image) = self.images[index].get(&encoding) {
            return Ok(Arc::clone(image));
        }
        let bytes = match source.get("uri")? {
            Some(uri) => read_uri(&uri)?,
            None => self.document.view(&source.need("bufferView")?)?.0.into(),
        };
        let image = decode_bitmap(&bytes, None, encoding);
        let image = Arc::new(image.map_err(|e: Error| e.at(source.place()))?);
        self.images[index].insert(encoding, Arc::clone(&image));
        Ok(image)
    }

    /// Section 5.26 of the specification; of the filters that for magnification counts, as pictures have one size here.
    fn sampling(&self, texture: &Json<'_>) -> Result<Sampling> {
        let Some(reference) = texture.get("sampler")? else {
            return Ok(Sampling::default());
        };
        let (_, sampler) = self.document.root.element("samplers", &reference)?;
        let wrap = |name| match sampler.count_or(name, 10497)? {
            10497 => Ok(Wrap::Repeat),
            33071 => Ok(Wrap::Clamp),
            33648 => Ok(Wrap::Mirror),
            other => Err((sampler.need(name)?).error(format!("{other} is not a way to wrap"))),
        };
        Ok(Sampling {
            wrap: [wrap("wrapS")?, wrap("wrapT")?],
            filter: match sampler.count_or("magFilter", 9729)? {
                9728 => PixelFilter::Nearest,
                9729 => PixelFilter::Bilinear,
                other => {
                    let filter = sampler.need("magFilter")?;
                    return Err(filter.error(format!("{other} is not a filter")));
                }
            },
        })
    }
}

fn emission(source: &Json<'_>) -> Result<Rgb> {
    let strength = (source.extension("KHR_materials_emissive_strength")?)
        .map_or(Ok(1.0), |e| e.number_or("emissiveStrength", 1.0))?;
    let factor = source.numbers_or("emissiveFactor", [0.0; 3])?;
    let emission = Rgb::from_array(factor.map(|x| (x * strength) as f32));
    if !emission.is_finite() || emission.min_element() < 0.0 {
        return Err(source.error(format!("the emission {emission} is negative or not finite")));
    }
    Ok(emission)
}
