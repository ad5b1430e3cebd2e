//! The ray engine beside its peers: what is raced over, the rays that are asked, and (feature `bench`) the race.

#[cfg(feature = "bench")]
mod race;
mod rays;
mod subject;

#[cfg(feature = "bench")]
pub use race::{
    Answers, Build, Engine, KindReport, REFERENCE, RaceOptions, Report, Row, plot, race,
};
pub use rays::{RayKind, RaySets};
pub use subject::Subject;
