//! Textures with their pictures read and their names resolved.

use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Result, did_you_mean};
use crate::material::Relief;
use crate::scene::description::{Reference, ReliefDescription, TextureDescription};
use crate::texture::Texture;

use super::super::read_bitmap;
use super::Loader;

/// Names may lead from one texture to the next this often.
const MAX_CHAIN: usize = 64;
/// A texture may be made of so many, each as often as it is used: all are evaluated at every point.
const MAX_PARTS: usize = 256;

/// What a texture is resolved for.
#[derive(Clone, Copy)]
struct Use {
    /// How its pictures are decoded where they do not say.
    encoding: Encoding,
    /// It may name those of the scene's textures that come before this one.
    before: usize,
    /// How many names led to it.
    chain: usize,
}

impl<'a> Loader<'a> {
    /// A texture that is a colour ([`Encoding::Srgb`]) or data ([`Encoding::Linear`]).
    pub(super) fn texture(
        &mut self,
        texture: &'a TextureDescription,
        encoding: Encoding,
    ) -> Result<Texture> {
        let at = Use {
            encoding,
            before: self.description.textures.len(),
            chain: 0,
        };
        self.texture_for(texture, at)
    }

    pub(super) fn relief(&mut self, relief: &'a ReliefDescription) -> Result<Relief> {
        Ok(match relief {
            ReliefDescription::Bump { texture, height } => Relief::Bump {
                texture: self.texture(texture, Encoding::Linear)?,
                height: *height,
            },
            ReliefDescription::NormalMap { texture, scale } => Relief::NormalMap {
                texture: self.texture(texture, Encoding::Linear)?,
                scale: *scale,
            },
        })
    }

    /// Makes sure that textures that nothing uses are right, too.
    pub(super) fn check_textures(&mut self) -> Result<()> {
        for (i, (name, texture)) in self.description.textures.iter().enumerate() {
            let used = [Encoding::Srgb, Encoding::Linear]
                .iter()
                .any(|&encoding| self.textures.contains_key(&(&**name, encoding)));
            if !used {
                let at = Use {
                    encoding: Encoding::Srgb,
                    before: i,
                    chain: 0,
                };
                self.texture_for(texture, at)?;
            }
        }
        Ok(())
    }

    fn texture_for(&mut self, texture: &'a TextureDescription, at: Use) -> Result<Texture> {
        Ok(match texture {
            TextureDescription::Constant(color) => Texture::Constant(*color),
            TextureDescription::Pattern { pattern, colors } => Texture::Pattern {
                pattern: *pattern,
                colors: colors.clone(),
            },
            TextureDescription::Image {
                file,
                encoding,
                sampling,
            } => {
                let key = (self.find(file)?, encoding.unwrap_or(at.encoding));
                if !self.bitmaps.contains_key(&key) {
                    let bitmap =
                        read_bitmap(&key.0, key.1).map_err(|e| e.at(self.place(file.offset)))?;
                    self.bitmaps.insert(key.clone(), Arc::new(bitmap));
                }
                Texture::Image {
                    image: self.bitmaps[&key].clone(),
                    scale: Rgb::ONE,
                    sampling: *sampling,
                }
            }
            TextureDescription::Named(name) => self.named_texture(name, at)?,
            TextureDescription::Scale { of, by } => Texture::Scale {
                of: Arc::new(self.texture_for(of, at)?),
                by: *by,
            },
            TextureDescription::Channel { of, by } => Texture::Channel {
                of: Arc::new(self.texture_for(of, at)?),
                by: *by,
            },
            TextureDescription::Transform { of, transform } => Texture::Transform {
                of: Arc::new(self.texture_for(of, at)?),
                texture_from_object: Box::new(transform.inverse()),
            },
            TextureDescription::Mix { a, b, by } => Texture::Mix {
                a: Arc::new(self.texture_for(a, at)?),
                b: Arc::new(self.texture_for(b, at)?),
                by: Arc::new(self.texture_for(
                    by,
                    Use {
                        encoding: Encoding::Linear,
                        ..at
                    },
                )?),
            },
        })
    }

    fn named_texture(&mut self, name: &Reference, at: Use) -> Result<Texture> {
        let description = self.description;
        let textures = &description.textures;
        let place = || description.source.place(name.offset);
        let fail =
            |message: String, help: String| Err(Error::input(message).at(place()).help(help));
        let Some(&index) = self.texture_indices.get(&*name.name) else {
            let known = textures[..at.before].iter().map(|(name, _)| &**name);
            return fail(
                format!("there is no texture `{}`", name.name),
                did_you_mean(&name.name, known),
            );
        };
        if index >= at.before {
            return fail(
                format!("the texture `{}` does not come before this one", name.name),
                "a texture can name those above it, so that none is part of itself".to_owned(),
            );
        }
        let (known, texture) = &textures[index];
        let key = (&**known, at.encoding);
        if let Some(texture) = self.textures.get(&key) {
            return Ok(texture.clone());
        }
        if at.chain == MAX_CHAIN {
            return fail(
                format!("more than {MAX_CHAIN} names lead from one texture to the next"),
                "write some of them in place of their names".to_owned(),
            );
        }
        let inner = Use {
            before: index,
            chain: at.chain + 1,
            ..at
        };
        let texture = self.texture_for(texture, inner)?;
        if texture.parts() > MAX_PARTS {
            return fail(
                format!(
                    "the texture `{}` is made of more than {MAX_PARTS} others",
                    name.name
                ),
                "each counts as often as it is used: mix fewer".to_owned(),
            );
        }
        self.textures.insert(key, texture.clone());
        Ok(texture)
    }
}
