use bytemuck::Zeroable;
use obvhs::aabb::Aabb;

/// Set in a link to a leaf; the rest is its index. A link to a node counts the [`STEP`]s to where it begins.
pub(in crate::accel) const LEAF: u32 = 1 << 31;

/// Bytes between places where a node may begin: a shift finds it sooner than a product would.
pub(super) const STEP: usize = 32;

/// No link.
pub(super) const NONE: u32 = u32::MAX;

/// The boxes of up to `N` children as planes, and links to them.
///
/// A lane without a child has a box that nothing meets.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(in crate::accel) struct Node<const N: usize> {
    /// `[min, max][axis][child]`.
    pub planes: [[[f32; N]; 3]; 2],
    /// Links.
    pub children: [u32; N],
}

// SAFETY: numbers.
unsafe impl<const N: usize> Zeroable for Node<N> {}

impl<const N: usize> Node<N> {
    /// Without children.
    pub(super) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; N]; 3], [[f32::NEG_INFINITY; N]; 3]],
        children: [u32::MAX; N],
    };

    /// Where the planes stand, in bytes, that a ray meets first along each axis; by the bits of its direction's signs.
    /// Those that it meets last are what the opposite ray meets first.
    pub(super) const FIRST: [[usize; 3]; 8] = {
        let mut first = [[0; 3]; 8];
        let mut negative = 0;
        while negative < 8 {
            let mut axis = 0;
            while axis < 3 {
                first[negative][axis] = ((negative >> axis & 1) * 3 + axis) * N * size_of::<f32>();
                axis += 1;
            }
            negative += 1;
        }
        first
    };

    /// The link to the node with this index.
    ///
    /// # Panics
    /// Beyond 2³¹ steps.
    pub(super) fn link(index: usize) -> u32 {
        let link = index * (size_of::<Self>() / STEP);
        assert!(link < LEAF as usize, "a tree of more than 64 GiB");
        link as u32
    }

    pub(super) fn set(&mut self, lane: usize, aabb: &Aabb, link: u32) {
        for axis in 0..3 {
            self.planes[0][axis][lane] = aabb.min[axis];
            self.planes[1][axis][lane] = aabb.max[axis];
        }
        self.children[lane] = link;
    }

    /// The child in `mask`, which has no two bits set, or [`NONE`].
    #[inline(always)]
    pub(super) fn only(&self, mask: u32) -> u32 {
        if mask == 0 {
            NONE
        } else {
            self.children[mask.trailing_zeros() as usize & (N - 1)]
        }
    }
}
