//! Materials: a principled surface for each glTF material.

mod texture;

use std::collections::HashMap;
use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::Result;
use crate::material::{Material, Principled, Relief, Surface, absorption};
use crate::texture::{Bitmap, Texture};

use super::accessor::Document;
use super::json::Json;

/// Reads all materials in order, as principled surfaces: the core's factors and textures, and those of
/// `KHR_materials_specular`, `_ior`, `_transmission`, `_volume`, `_clearcoat`, `_sheen`, `_anisotropy` and
/// `_iridescence`, but for textures in an alpha channel, the coat's normals and brushes' directions. Colour textures are sRGB, normal maps data, factors linear; emission is the factor times its texture times
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
        let surface = Surface::Principled(Box::new(self.principled(source)?));
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

    fn principled(&mut self, source: &Json<'_>) -> Result<Principled> {
        let mut principled = Principled {
            metallic: 1.0.into(),
            ..Principled::new(1.0.into())
        };
        if let Some(pbr) = source.get("pbrMetallicRoughness")? {
            const MAP: &str = "metallicRoughnessTexture";
            let [r, g, b, _] = pbr.numbers_or("baseColorFactor", [1.0; 4])?;
            let factor = Rgb::new(r as f32, g as f32, b as f32).clamp(Rgb::ZERO, Rgb::ONE);
            principled.base_color = self.color(&pbr, "baseColorTexture", factor)?;
            let (metallic, roughness) = (
                share(&pbr, "metallicFactor", 1.0)?,
                share(&pbr, "roughnessFactor", 1.0)?,
            );
            principled.metallic = self.number(&pbr, MAP, Rgb::Z, metallic)?;
            principled.roughness.value = self.number(&pbr, MAP, Rgb::Y, roughness)?;
        }
        if let Some(e) = self.extension(source, "ior", &[])? {
            let ior = e.number_or("ior", 1.5)?;
            // 0 stands for an index without bounds.
            principled.ior = match ior {
                0.0 => 1e4,
                ior if ior >= 1.0 => ior as f32,
                _ => return Err(e.error(format!("the index of refraction {ior} is below 1"))),
            };
        }
        // The strength's texture is in the alpha channel, which is not read.
        if let Some(e) = self.extension(source, "specular", &["specularTexture"])? {
            principled.specular = share(&e, "specularFactor", 1.0)?.into();
            let color = factors(&e, "specularColorFactor", 1.0)?;
            principled.specular_color = self.color(&e, "specularColorTexture", color)?;
        }
        self.inside(source, &mut principled)?;
        self.layers(source, &mut principled)?;
        Ok(principled)
    }

    /// What light goes through. Without a thickness the surface is a sheet.
    fn inside(&mut self, source: &Json<'_>, principled: &mut Principled) -> Result<()> {
        if let Some(e) = self.extension(source, "transmission", &[])? {
            let factor = share(&e, "transmissionFactor", 0.0)?;
            principled.transmission = self.number(&e, "transmissionTexture", Rgb::X, factor)?;
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
        if let Some(e) = self.extension(source, "clearcoat", &["clearcoatNormalTexture"])? {
            let factor = share(&e, "clearcoatFactor", 0.0)?;
            principled.clearcoat = self.number(&e, "clearcoatTexture", Rgb::X, factor)?;
            let factor = share(&e, "clearcoatRoughnessFactor", 0.0)?;
            principled.clearcoat_roughness =
                self.number(&e, "clearcoatRoughnessTexture", Rgb::Y, factor)?;
        }
        // The roughness's texture is in the alpha channel.
        if let Some(e) = self.extension(source, "sheen", &["sheenRoughnessTexture"])? {
            let color = factors(&e, "sheenColorFactor", 0.0)?.min(Rgb::ONE);
            principled.sheen_color = self.color(&e, "sheenColorTexture", color)?;
            principled.sheen_roughness = share(&e, "sheenRoughnessFactor", 0.0)?.into();
        }
        // This texture's red and green are a direction.
        if let Some(e) = self.extension(source, "anisotropy", &["anisotropyTexture"])? {
            principled.roughness.anisotropy = share(&e, "anisotropyStrength", 0.0)?.into();
            principled.roughness.rotation = (e.number_or("anisotropyRotation", 0.0)? as f32).into();
        }
        if let Some(e) = self.extension(source, "iridescence", &[])? {
            let factor = share(&e, "iridescenceFactor", 0.0)?;
            principled.iridescence = self.number(&e, "iridescenceTexture", Rgb::X, factor)?;
            principled.iridescence_ior = e.number_or("iridescenceIor", 1.3)?.max(1.0) as f32;
            principled.iridescence_thickness = self.film_thickness(&e)?;
        }
        Ok(())
    }

    /// In nanometres: the greatest, or between the least and the greatest as a texture's green has it.
    fn film_thickness(&mut self, film: &Json<'_>) -> Result<Texture> {
        let nanometres = |key, default| {
            let thickness = film.number_or(key, default)?;
            Ok(thickness.clamp(0.0, 10_000.0) as f32)
        };
        let least = nanometres("iridescenceThicknessMinimum", 100.0)?;
        let greatest = nanometres("iridescenceThicknessMaximum", 400.0)?;
        let share = self.number(film, "iridescenceThicknessTexture", Rgb::Y, 1.0)?;
        if share.is(1.0) {
            return Ok(greatest.into());
        }
        Ok(Texture::Mix {
            a: Arc::new(least.into()),
            b: Arc::new(greatest.into()),
            by: Arc::new(share),
        })
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

    /// Section 3.9.3 of the specification: green is up, which is where v grows once it is turned over.
    fn relief(&mut self, source: &Json<'_>) -> Result<Option<Relief>> {
        let Some(info) = source.get("normalTexture")? else {
            return Ok(None);
        };
        let scale = info.number_or("scale", 1.0)?;
        let texture = self.texture(&info, Encoding::Linear, Rgb::ONE)?;
        Ok(texture.map(|texture| Relief::NormalMap { texture, scale }))
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
