//! What surrounds the scene, as light.

use std::sync::Arc;

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Place, Result};
use crate::light::{EnvironmentMap, Light};
use crate::scene::description::{EnvironmentDescription, Reference};
use crate::texture::Bitmap;

use super::super::read_bitmap;
use super::Loader;

/// The same bound as for colours that are written out.
const LARGEST_RADIANCE: f32 = 1e12;

impl Loader<'_> {
    /// Adds the environment to the scene.
    pub(super) fn environment(&mut self) -> Result<()> {
        match &self.description.environment {
            EnvironmentDescription::Constant(color) => self.scene.environment = *color,
            EnvironmentDescription::Image {
                file,
                rotate,
                scale,
            } => {
                let bitmap = self.surroundings(file, *scale)?;
                let map = EnvironmentMap::new(bitmap, *rotate);
                (self.scene.lights).push(Light::Environment(Arc::new(map)));
            }
            EnvironmentDescription::Sky(sky) => self.scene.lights.extend(sky.lights()),
        }
        Ok(())
    }

    /// A picture of light from all directions, `scale` times as bright; pixels below 0 are taken as 0.
    fn surroundings(&mut self, file: &Reference, scale: f32) -> Result<Bitmap> {
        let path = self.find(file)?;
        let mut bitmap =
            read_bitmap(&path, Encoding::Srgb).map_err(|e| e.at(self.place(file.offset)))?;
        let width = bitmap.width;
        let pixel = |i: usize| format!("pixel ({}, {})", i % width, i / width);
        let mut below = None;
        for (i, color) in bitmap.pixels.iter_mut().enumerate() {
            if color.min_element() < 0.0 {
                below.get_or_insert((i, *color));
                *color = color.max(Rgb::ZERO);
            }
            *color *= scale;
            if color.max_element() > LARGEST_RADIANCE {
                return Err(Error::input(format!(
                    "{} of the environment is {color}: more than {LARGEST_RADIANCE:e} is no light",
                    pixel(i)
                ))
                .at(Place::file(path))
                .help("lower `scale`, or save the picture anew"));
            }
        }
        if let Some((i, color)) = below {
            self.scene.warnings.push(format!(
                "{}: {} of the environment is {color}; what is below 0 is taken as 0",
                path.display(),
                pixel(i)
            ));
        }
        Ok(bitmap)
    }
}
