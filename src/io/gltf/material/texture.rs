//! Textures: pictures, each decoded once as colours and once as data, and how they are looked up.

use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Result};
use crate::texture::{Bitmap, PixelFilter, Sampling, Texture, Wrap};

use super::super::super::texture::decode_bitmap;
use super::super::buffer::read_uri;
use super::super::json::Json;
use super::Reader;

impl Reader<'_, '_> {
    /// The colour `factor` times the texture `key` of `of`, where there is one.
    pub(super) fn color(&mut self, of: &Json<'_>, key: &str, factor: Rgb) -> Result<Texture> {
        let texture = match of.get(key)? {
            Some(info) => self.texture(&info, Encoding::Srgb, factor)?,
            None => None,
        };
        Ok(texture.unwrap_or(Texture::Constant(factor)))
    }

    /// `factor` times a channel (1 in `channel`) of the texture `key` of `of`, where there is one.
    pub(super) fn number(
        &mut self,
        of: &Json<'_>,
        key: &str,
        channel: Rgb,
        factor: f32,
    ) -> Result<Texture> {
        let texture = match of.get(key)? {
            Some(info) => self.texture(&info, Encoding::Linear, Rgb::ONE)?,
            None => None,
        };
        Ok(texture.map_or(factor.into(), |texture| Texture::Channel {
            of: Arc::new(texture),
            by: factor * channel,
        }))
    }

    /// What a texture reference refers to, times `scale`; `None`, with a warning, where only an unknown extension has
    /// its picture.
    pub(super) fn texture(
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
