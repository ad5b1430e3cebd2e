//! Rays, intervals, bounds, transforms and frames. Geometry is f64 throughout; triangle kernels and
//! shading convert to f32 at their own doors.

mod bounds;
mod frame;
mod interval;
mod ray;
pub mod roots;
mod transform;

pub use bounds::{Bounds, round_down, round_up};
pub use frame::Frame;
pub use interval::Interval;
pub use ray::Ray;
pub use transform::Transform;
