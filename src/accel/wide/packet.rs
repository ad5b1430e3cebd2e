//! Rays from one origin, 64 at a time: what a camera sends.
//!
//! Seen from the origin along the axis that all of them follow most, rays are points of a plane at distance 1, and boxes
//! and triangles have rectangles in it. Rectangles tell which rays may meet what.

use std::array::from_fn;

use glam::DVec3;

use crate::accel::ray::{SLACK, TreeRay, fits_kernels};
use crate::math::Ray;

use super::kernel::{Kernel, MOST_WAITING};
use super::node::Node;
use super::stream::Root;

/// Rays in a packet.
pub(in crate::accel) const PACKET: usize = 64;

/// Rays of a packet that are decided on at once.
pub(in crate::accel) const GROUP: usize = 8;

/// What a group of rays meets of a triangle.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Met {
    /// A bit for each ray that meets it.
    pub mask: u8,
    /// A bit for each that comes from the side that the triangle faces away from.
    pub inside: u8,
    pub t: [f64; GROUP],
    /// Barycentric weights of the second and third corner.
    pub u: [f64; GROUP],
    pub v: [f64; GROUP],
}

/// Points of rays, and how far along the main axis each one still looks, rounded up.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(in crate::accel) struct Points {
    pub x: [f32; PACKET],
    pub y: [f32; PACKET],
    pub reach: [f32; PACKET],
}

/// A rectangle, closed, and how near what is in it begins along the main axis.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Window {
    pub x: [f32; 2],
    pub y: [f32; 2],
    pub near: f32,
}

/// Windows side by side.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Windows<const M: usize> {
    x: [[f32; M]; 2],
    y: [[f32; M]; 2],
    near: [f32; M],
}

impl<const M: usize> Windows<M> {
    const EMPTY: Self = {
        let nothing = [[f32::INFINITY; M], [f32::NEG_INFINITY; M]];
        Self {
            x: nothing,
            y: nothing,
            near: [f32::INFINITY; M],
        }
    };

    #[inline(always)]
    pub(in crate::accel) fn at(&self, i: usize) -> Window {
        let Self { x, y, near } = self;
        Window {
            x: [x[0][i], x[1][i]],
            y: [y[0][i], y[1][i]],
            near: near[i],
        }
    }
}

/// Rays with one origin, one main axis and directions that are alike.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Packet {
    pub points: Points,
    /// Holds all points.
    window: Window,
    pub axes: [u32; 3],
    /// 1, or -1 where the main axis is followed downward.
    sign: f32,
    /// As in [`crate::accel::ray::ExactRay`].
    shear: [[f64; PACKET]; 2],
    length: [f64; PACKET],
    pub origin: DVec3,
    pub tmin: f64,
}

/// A packet's origin relative to a tree's centre, in the order of the packet's axes, and what f32 coordinates may be
/// off then.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Seat {
    origin: [f32; 3],
    slack: f32,
}

/// Packets are no wider.
const WIDEST: f32 = 0.3;

/// More than the relative rounding of a quotient and a product.
const ROUNDING: f32 = 1.0 / (1 << 21) as f32;

/// Divides where depths are not positive.
const TINY: f32 = 1e-30;

impl Packet {
    /// `None` where the rays are not alike.
    #[inline(always)]
    pub(in crate::accel) fn new(rays: &[Ray; PACKET], limits: &[f64; PACKET]) -> Option<Self> {
        let first = &rays[0];
        if first.origin != rays[1].origin {
            return None;
        }
        let TreeRay { axes, shear, .. } = TreeRay::new(first, first.origin, 0.0);
        let [x, y, z] = axes.map(|axis| axis as usize);
        let (mut components, mut alike) = ([[0.0; PACKET]; 3], true);
        for (i, ray) in rays.iter().enumerate() {
            components[0][i] = ray.direction.x;
            components[1][i] = ray.direction.y;
            components[2][i] = ray.direction.z;
            alike &= ray.origin.cmpeq(first.origin).all() & (ray.tmin == first.tmin);
        }
        let (x, y, z) = (&components[x], &components[y], &components[z]);
        let sign = shear.z.signum();
        let mut odd = [0_u64; PACKET];
        for i in 0..PACKET {
            let main = z[i] * f64::from(sign);
            odd[i] = u64::from(!(main > 0.0 && x[i].abs() <= main && y[i].abs() <= main));
        }
        if !alike || odd.iter().fold(0, |all, odd| all | odd) != 0 {
            return None;
        }
        let shear: [[f64; PACKET]; 2] = [from_fn(|i| x[i] / z[i]), from_fn(|i| y[i] / z[i])];
        let points = Points {
            x: from_fn(|i| (shear[0][i] * f64::from(sign)) as f32),
            y: from_fn(|i| (shear[1][i] * f64::from(sign)) as f32),
            reach: from_fn(|i| reach(limits[i], z[i])),
        };
        let window = Window {
            x: range(&points.x),
            y: range(&points.y),
            near: 0.0,
        };
        let narrow = |[from, to]: [f32; 2]| to - from < WIDEST;
        (narrow(window.x) && narrow(window.y)).then_some(Self {
            points,
            window,
            axes,
            sign,
            shear,
            length: *z,
            origin: first.origin,
            tmin: first.tmin,
        })
    }

    /// Before a tree; `None` where kernels cannot take it there.
    pub(in crate::accel) fn seat<const N: usize>(&self, root: &Root<'_, N>) -> Option<Seat> {
        let Root { center, extent, .. } = *root;
        let ray = Ray {
            tmin: self.tmin,
            ..Ray::new(self.origin, DVec3::X)
        };
        if !fits_kernels(&ray, center, extent) {
            return None;
        }
        let from = (self.origin - center).as_vec3a();
        Some(Seat {
            slack: SLACK * (from.abs().max_element() + extent),
            origin: self.axes.map(|axis| from[axis as usize]),
        })
    }

    /// What the rays from number `first` on meet of a triangle with these corners, relative to `center` and in the
    /// order of the packet's axes.
    #[inline(always)]
    pub(in crate::accel) fn decide<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        first: usize,
        center: DVec3,
        corners: [[f32; 3]; 3],
    ) -> Met {
        let from = (self.origin - center).to_array();
        let [x, y, z] = self.axes.map(|axis| from[axis as usize]);
        let corners =
            corners.map(|[a, b, c]| [f64::from(a) - x, f64::from(b) - y, f64::from(c) - z]);
        let group = |row: &[f64; PACKET]| -> [f64; GROUP] { from_fn(|i| row[first + i]) };
        let shear = [&group(&self.shear[0]), &group(&self.shear[1])];
        kernel.decide(shear, &group(&self.length), corners)
    }

    /// Ray number `i` now ends at `limit`.
    #[inline(always)]
    pub(in crate::accel) fn shorten(&mut self, i: usize, limit: f64) {
        self.points.reach[i] = reach(limit, self.length[i]);
    }

    /// The windows of a node's boxes, and a bit for each that the packet sees.
    #[inline(always)]
    fn windows<const N: usize>(&self, seat: &Seat, node: &Node<N>) -> (Windows<N>, u32) {
        let [x, y, z] = self.axes.map(|axis| axis as usize);
        let Seat { origin, slack } = *seat;
        let (near, far) = if self.sign > 0.0 { (0, 1) } else { (1, 0) };
        let (near, far) = (&node.planes[near][z], &node.planes[far][z]);
        let mut windows = Windows::EMPTY;
        let mut seen = [0; N];
        // Loops, and not functions of `i`, for these may not be inlined, and then lose the kernel's instructions.
        for i in 0..N {
            let near = (near[i] - origin[2]) * self.sign - slack;
            let far = (far[i] - origin[2]) * self.sign + slack;
            let (by_near, by_far) = (1.0 / near.max(TINY), 1.0 / far.max(TINY));
            let least = |plane: f32, from: f32| {
                let least = plane - from - slack;
                let least = least * if least >= 0.0 { by_far } else { by_near };
                least - least.abs() * ROUNDING
            };
            let greatest = |plane: f32, from: f32| {
                let greatest = plane - from + slack;
                let greatest = greatest * if greatest >= 0.0 { by_near } else { by_far };
                greatest + greatest.abs() * ROUNDING
            };
            windows.x[0][i] = least(node.planes[0][x][i], origin[0]);
            windows.x[1][i] = greatest(node.planes[1][x][i], origin[0]);
            windows.y[0][i] = least(node.planes[0][y][i], origin[1]);
            windows.y[1][i] = greatest(node.planes[1][y][i], origin[1]);
            windows.near[i] = near;
            seen[i] = u32::from(self.overlaps(&windows, i) & (far >= 0.0)) << i;
        }
        (windows, seen.iter().fold(0, |all, bit| all | bit))
    }

    /// The windows of triangles, given as planes `[axis][corner][triangle]`, and a bit for each that the packet sees.
    #[inline(always)]
    pub(in crate::accel) fn triangle_windows<const M: usize>(
        &self,
        seat: &Seat,
        planes: &[[[f32; M]; 3]; 3],
    ) -> (Windows<M>, u32) {
        let [x, y, z] = self.axes.map(|axis| &planes[axis as usize]);
        let Seat { origin, slack } = *seat;
        let mut windows = Windows::EMPTY;
        let mut seen = [0; M];
        for i in 0..M {
            let (mut near, mut far) = (f32::INFINITY, f32::NEG_INFINITY);
            let (mut x0, mut x1) = (f32::INFINITY, f32::NEG_INFINITY);
            let (mut y0, mut y1) = (f32::INFINITY, f32::NEG_INFINITY);
            for corner in 0..3 {
                let depth = (z[corner][i] - origin[2]) * self.sign;
                near = lesser(near, depth);
                far = greater(far, depth);
                let by = 1.0 / depth;
                let (px, py) = (
                    (x[corner][i] - origin[0]) * by,
                    (y[corner][i] - origin[1]) * by,
                );
                let (wx, wy) = (
                    slack * by.abs() * (2.0 + 2.0 * px.abs()),
                    slack * by.abs() * (2.0 + 2.0 * py.abs()),
                );
                x0 = lesser(x0, px - wx);
                x1 = greater(x1, px + wx);
                y0 = lesser(y0, py - wy);
                y1 = greater(y1, py + wy);
            }
            // Beside or behind the origin a triangle has no rectangle of its corners' points.
            let beside = near <= 8.0 * slack;
            let or = |x: f32, limit: f32| if beside { limit } else { x };
            windows.x[0][i] = or(x0, f32::NEG_INFINITY);
            windows.x[1][i] = or(x1, f32::INFINITY);
            windows.y[0][i] = or(y0, f32::NEG_INFINITY);
            windows.y[1][i] = or(y1, f32::INFINITY);
            windows.near[i] = near - slack;
            seen[i] = u32::from(self.overlaps(&windows, i) & (far >= -slack)) << i;
        }
        (windows, seen.iter().fold(0, |all, bit| all | bit))
    }

    /// Whether a window has a point in common with the packet's.
    #[inline(always)]
    fn overlaps<const M: usize>(&self, windows: &Windows<M>, i: usize) -> bool {
        let Windows { x, y, .. } = windows;
        let across = (x[0][i] <= self.window.x[1]) & (self.window.x[0] <= x[1][i]);
        let up = (y[0][i] <= self.window.y[1]) & (self.window.y[0] <= y[1][i]);
        across & up
    }
}

#[inline(always)]
fn reach(limit: f64, length: f64) -> f32 {
    (limit * length.abs()) as f32 * (1.0 + ROUNDING) + f32::MIN_POSITIVE
}

/// The lesser of two, or the first where the second is no number: one instruction, which `f32::min` is not.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The least and the greatest.
#[inline(always)]
fn range(points: &[f32; PACKET]) -> [f32; 2] {
    const LANES: usize = 16;
    let (mut least, mut greatest) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    for part in points.as_chunks::<LANES>().0 {
        for i in 0..LANES {
            least[i] = lesser(least[i], part[i]);
            greatest[i] = greater(greatest[i], part[i]);
        }
    }
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            least[i] = lesser(least[i], least[i + half]);
            greatest[i] = greater(greatest[i], greatest[i + half]);
        }
        half /= 2;
    }
    [least[0], greatest[0]]
}

/// What a packet finds in a tree.
pub(in crate::accel) trait Catch<const N: usize> {
    /// The rays in `mask` are at the root of a subtree. Whether that is dealt with, as all leaves must be.
    fn take<K: Kernel<N>>(&mut self, kernel: K, packet: &mut Packet, link: u32, mask: u64) -> bool;
}

#[derive(Clone, Copy)]
struct Pending {
    near: f32,
    link: u32,
    mask: u64,
}

/// Takes the rays in `mask` through a tree.
#[inline(always)]
pub(in crate::accel) fn walk_packet<K: Kernel<N>, const N: usize, C: Catch<N>>(
    kernel: K,
    root: &Root<'_, N>,
    seat: &Seat,
    packet: &mut Packet,
    mask: u64,
    catch: &mut C,
) {
    let mut stack = [Pending {
        near: 0.0,
        link: 0,
        mask: 0,
    }; MOST_WAITING + 32];
    stack[0] = Pending {
        near: f32::NEG_INFINITY,
        link: root.walk.root,
        mask,
    };
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let Pending { near, link, mask } = stack[len];
        let everywhere = Window {
            x: packet.window.x,
            y: packet.window.y,
            near,
        };
        let mask = mask & kernel.within(&packet.points, &everywhere);
        if mask == 0 {
            continue;
        }
        if catch.take(kernel, packet, link, mask) {
            continue;
        }
        // SAFETY: links of a tree lead to its nodes.
        let node = unsafe { root.walk.node(link) };
        let (windows, mut seen) = packet.windows(seat, node);
        let first = len;
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize & (N - 1);
            seen &= seen - 1;
            let window = windows.at(lane);
            let inside = mask & kernel.within(&packet.points, &window);
            if inside == 0 {
                continue;
            }
            let mut place = len;
            while place > first && stack[place - 1].near < window.near {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = Pending {
                near: window.near,
                link: node.children[lane],
                mask: inside,
            };
            len += 1;
        }
    }
}
