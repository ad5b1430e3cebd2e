//! Materials: a principled surface for each glTF material.

use std::sync::Arc;

use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::material::{Material, Principled, Surface, absorption};
use crate::texture::{Bitmap, Texture};

use super::super::texture::decode_bitmap;
use super::accessor::Document;
use super::buffer::read_uri;
use super::json::Json;

/// Reads all materials in order, as principled surfaces: the core's factors and base colour texture, and the factors of
/// `KHR_materials_specular`, `_ior`, `_transmission`, `_volume`, `_clearcoat`, `_sheen`, `_anisotropy` and
/// `_iridescence`. Base colour textures are sRGB, factors linear; emission is the factor times
/// `KHR_materials_emissive_strength`.
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
        let surface = Surface::Principled(Box::new(self.principled(source)?));
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

    fn principled(&mut self, source: &Json<'_>) -> Result<Principled> {
        let mut color = Texture::Constant(Rgb::ONE);
        let (mut metallic, mut roughness) = (1.0, 1.0);
        if let Some(pbr) = source.get("pbrMetallicRoughness")? {
            color = self.base_color(&pbr)?;
            metallic = share(&pbr, "metallicFactor", 1.0)?;
            roughness = share(&pbr, "roughnessFactor", 1.0)?;
            if pbr.get("metallicRoughnessTexture")?.is_some() {
                self.warnings.push(pbr.warning(
                    "metallicRoughnessTexture is not read; the material is no metal, of its roughness factor",
                ));
                metallic = 0.0;
            }
        }
        let mut principled = Principled {
            metallic,
            roughness: roughness.into(),
            ..Principled::new(color, Texture::Constant)
        };
        if let Some(e) = self.extension(source, "ior", &[])? {
            let ior = e.number_or("ior", 1.5)?;
            // 0 stands for an index without bounds.
            principled.ior = match ior {
                0.0 => 1e4,
                ior if ior >= 1.0 => ior as f32,
                _ => return Err(e.error(format!("the index of refraction {ior} is below 1"))),
            };
        }
        if let Some(e) = self.extension(
            source,
            "specular",
            &["specularTexture", "specularColorTexture"],
        )? {
            principled.specular = share(&e, "specularFactor", 1.0)?;
            principled.specular_color = Texture::Constant(factors(&e, "specularColorFactor", 1.0)?);
        }
        self.inside(source, &mut principled)?;
        self.layers(source, &mut principled)?;
        Ok(principled)
    }

    /// What light goes through. Without a thickness the surface is a sheet.
    fn inside(&mut self, source: &Json<'_>, principled: &mut Principled) -> Result<()> {
        if let Some(e) = self.extension(source, "transmission", &["transmissionTexture"])? {
            principled.transmission = share(&e, "transmissionFactor", 0.0)?;
        }
        principled.thin = true;
        // The thickness is for renderers that do not follow light through the body: here its shape tells.
        if let Some(e) = self.extension(source, "volume", &[])? {
            principled.thin = e.number_or("thicknessFactor", 0.0)? <= 0.0;
            let color = factors(&e, "attenuationColor", 1.0)?;
            let distance = e.number_or("attenuationDistance", f64::INFINITY)?;
            if distance <= 0.0 {
                return Err(e.error(format!(
                    "the attenuation distance {distance} is not above 0"
                )));
            }
            principled.absorption = absorption(color, distance);
        }
        Ok(())
    }

    /// What lies on top.
    fn layers(&mut self, source: &Json<'_>, principled: &mut Principled) -> Result<()> {
        const COAT: [&str; 3] = [
            "clearcoatTexture",
            "clearcoatRoughnessTexture",
            "clearcoatNormalTexture",
        ];
        const FILM: [&str; 2] = ["iridescenceTexture", "iridescenceThicknessTexture"];
        if let Some(e) = self.extension(source, "clearcoat", &COAT)? {
            principled.clearcoat = share(&e, "clearcoatFactor", 0.0)?;
            principled.clearcoat_roughness = share(&e, "clearcoatRoughnessFactor", 0.0)?;
        }
        if let Some(e) = self.extension(
            source,
            "sheen",
            &["sheenColorTexture", "sheenRoughnessTexture"],
        )? {
            let color = factors(&e, "sheenColorFactor", 0.0)?;
            principled.sheen_color = Texture::Constant(color.min(Rgb::ONE));
            principled.sheen_roughness = share(&e, "sheenRoughnessFactor", 0.0)?;
        }
        if let Some(e) = self.extension(source, "anisotropy", &["anisotropyTexture"])? {
            principled.roughness.anisotropy = share(&e, "anisotropyStrength", 0.0)?;
            principled.roughness.rotation = e.number_or("anisotropyRotation", 0.0)? as f32;
        }
        if let Some(e) = self.extension(source, "iridescence", &FILM)? {
            principled.iridescence = share(&e, "iridescenceFactor", 0.0)?;
            principled.iridescence_ior = e.number_or("iridescenceIor", 1.3)?.max(1.0) as f32;
            let thickness = e.number_or("iridescenceThicknessMaximum", 400.0)?;
            principled.iridescence_thickness = thickness.clamp(0.0, 10_000.0) as f32;
        }
        Ok(())
    }

    /// A material extension, with a warning for each of its `textures` that the material has.
    fn extension<'b>(
        &mut self,
        source: &Json<'b>,
        name: &str,
        textures: &[&str],
    ) -> Result<Option<Json<'b>>> {
        let Some(extension) = source.extension(&format!("KHR_materials_{name}"))? else {
            return Ok(None);
        };
        for texture in textures {
            if let Some(texture) = extension.get(texture)? {
                self.warnings
                    .push(texture.warning("this texture is not read; its factor alone counts"));
            }
        }
        Ok(Some(extension))
    }

    fn base_color(&mut self, pbr: &Json<'_>) -> Result<Texture> {
        let [r, g, b, _] = pbr.numbers_or("baseColorFactor", [1.0; 4])?;
        let factor = Rgb::new(r as f32, g as f32, b as f32).clamp(Rgb::ZERO, Rgb::ONE);
        let image = match pbr.get("baseColorTexture")? {
            Some(info) => self.image(&info)?,
            None => None,
        };
        Ok(match image {
            Some(image) => Texture::Image {
                image,
                scale: factor,
            },
            None => Texture::Constant(factor),
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

/// The member `key`, a share in 0..=1.
fn share(of: &Json<'_>, key: &str, default: f64) -> Result<f32> {
    Ok(of.number_or(key, default)?.clamp(0.0, 1.0) as f32)
}

/// The member `key`, a colour without negative channels.
fn factors(of: &Json<'_>, key: &str, default: f64) -> Result<Rgb> {
    let color = of.numbers_or(key, [default; 3])?;
    Ok(Rgb::from_array(color.map(|x| x.max(0.0) as f32)))
}
