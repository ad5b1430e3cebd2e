//! Argument values that are one of several words.

use clap::ValueEnum;

use crate::color::Tonemap;
use crate::integrator::LayerKind;
use crate::sampling::SamplerKind;
use crate::scene::IntegratorSettings;

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum IntegratorName {
    Path,
    Direct,
    Whitted,
    Normals,
    Depth,
    Flat,
    Ao,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum SamplerName {
    Sobol,
    Independent,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum TonemapName {
    Srgb,
    Gamma22,
    None,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum LayerName {
    /// bounce0, bounce1, ...: light by how often it was scattered; the last has the rest
    Bounces,
    /// emitted, light, bsdf: light seen directly, found by aiming at lights, or by directions from surfaces
    Strategies,
    /// Colour of the first surface, unlit
    Albedo,
    /// Its shading normal
    Normal,
    /// Its distance
    Depth,
}

impl IntegratorName {
    /// Keeps the scene's parameters where it already uses this integrator.
    pub(super) fn choose(self, settings: &mut IntegratorSettings) {
        match (self, &settings) {
            (Self::Path, IntegratorSettings::Path { .. })
            | (Self::Direct, IntegratorSettings::Direct { .. })
            | (Self::Whitted, IntegratorSettings::Whitted { .. })
            | (Self::Ao, IntegratorSettings::Ao { .. }) => {}
            (Self::Path, _) => *settings = IntegratorSettings::path(),
            (Self::Direct, _) => *settings = IntegratorSettings::direct(),
            (Self::Whitted, _) => *settings = IntegratorSettings::whitted(),
            (Self::Normals, _) => *settings = IntegratorSettings::Normals,
            (Self::Depth, _) => *settings = IntegratorSettings::Depth,
            (Self::Flat, _) => *settings = IntegratorSettings::Flat,
            (Self::Ao, _) => *settings = IntegratorSettings::Ao { radius: None },
        }
    }
}

impl SamplerName {
    pub(super) fn kind(self) -> SamplerKind {
        match self {
            Self::Sobol => SamplerKind::Sobol,
            Self::Independent => SamplerKind::Independent,
        }
    }
}

impl TonemapName {
    pub(super) fn tonemap(self) -> Tonemap {
        match self {
            Self::Srgb => Tonemap::Srgb,
            Self::Gamma22 => Tonemap::Gamma22,
            Self::None => Tonemap::None,
        }
    }
}

impl LayerName {
    pub(super) fn kind(self) -> LayerKind {
        match self {
            Self::Bounces => LayerKind::Bounces,
            Self::Strategies => LayerKind::Strategies,
            Self::Albedo => LayerKind::Albedo,
            Self::Normal => LayerKind::Normal,
            Self::Depth => LayerKind::Depth,
        }
    }
}
