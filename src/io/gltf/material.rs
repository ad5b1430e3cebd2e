//! Materials: the nearest of ours for each glTF material.

use std::sync::Arc;

use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::material::{Fresnel, Material, Surface};
use crate::texture::{Bitmap, Texture};

use super::super::texture::decode_bitmap;
use super::accessor::Document;
use super::buffer::read_uri;
use super::json::Json;

/// Reads all materials in order. Transmission above 0.5 (`KHR_materials_transmission`) is glass with the index
/// of `KHR_materials_ior`; metal with roughness below 0.2 and without textures is a mirror; all else is diffuse.
/// Base colour textures are sRGB, factors linear; emission is the factor times `KHR_materials_emissive_strength`.
///
/// # Errors
/// Where a field is of the wrong type or a base colour texture is no picture.
pub(super) fn read_all(
    document: &Document<'_>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Material>> {
    let mut reader = Reader {
        document,
        images: vec![None; document.root.list("images")?.len()],
        warnings,
    };
    let sources = document.root.list("materials")?;
    (sources.iter().enumerate())
        .map(|(i, source)| reader.material(i, source))
        .collect()
}

struct Reader<'d, 'a> {
    document: &'d Document<'a>,
    images: Vec<Option<Arc<Bitmap>>>,
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
        Ok(Material {
            name: source.name().unwrap_or_else(|| format!("material {index}")),
            surface,
            emission: self.emission(source)?,
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
        let image = match pbr.get("baseColorTexture")? {
            Some(info) => self.image(&info)?,
            None => None,
        };
        Ok(match image {
            Some(image) => Surface::Diffuse {
                color: Texture::Image {
                    image,
                    scale: factor,
                },
            },
            None if metallic > 0.5 && roughness < 0.2 && !textured => Surface::Mirror {
                color: Texture::Constant(factor),
            },
            None => Surface::Diffuse {
                color: Texture::Constant(factor),
            },
        })
    }

    fn emission(&mut self, source: &Json<'_>) -> Result<Rgb> {
        let strength = (source.extension("KHR_materials_emissive_strength")?)
            .map_or(Ok(1.0), |e| e.number_or("emissiveStrength", 1.0))?;
        let factor = source.numbers_or("emissiveFactor", [0.0; 3])?;
        let emission = Rgb::from_array(factor.map(|x| (x * strength) as f32));
        if !emission.is_finite() || emission.min_element() < 0.0 {
            return Err(source.error(format!("the emission {emission} is negative or not finite")));
        }
        if emission != Rgb::ZERO && source.get("emissiveTexture")?.is_some() {
            self.warnings.push(
                source.warning("emissive textures are not supported; the material does not emit"),
            );
            return Ok(Rgb::ZERO);
        }
        Ok(emission)
    }

    /// The picture of a texture reference; `None`, with a warning, where only an unknown extension has one.
    fn image(&mut self, info: &Json<'_>) -> Result<Option<Arc<Bitmap>>> {
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
        let (index, source) = self.document.root.element("images", &reference)?;
        if let Some(image) = &self.images[index] {
            return Ok(Some(Arc::clone(image)));
        }
        let bytes = match source.get("uri")? {
            Some(uri) => read_uri(&uri)?,
            None => self.document.view(&source.need("bufferView")?)?.0.into(),
        };
        let image = decode_bitmap(&bytes, None).map_err(|e: Error| e.at(source.place()))?;
        let image = Arc::new(image);
        self.images[index] = Some(Arc::clone(&image));
        Ok(Some(image))
    }
}
