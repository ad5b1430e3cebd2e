use std::marker::PhantomData;
use std::ops::Deref;

use bytemuck::Pod;
use memmap2::MmapMut;
use rayon::prelude::*;

/// An array in pages of 2 MiB where the system has them: rays that jump about a large tree miss the table of pages
/// less often.
#[derive(Debug)]
pub(in crate::accel) struct Pages<T> {
    map: MmapMut,
    len: usize,
    holds: PhantomData<T>,
}

impl<T: Pod + Send + Sync> Pages<T> {
    /// `len` elements, made by `make` on all threads.
    pub(in crate::accel) fn new(len: usize, make: impl Fn(usize) -> T + Sync) -> Self {
        let size = (len * size_of::<T>()).max(1);
        let mut map = MmapMut::map_anon(size).expect("there is memory for the tree");
        #[cfg(target_os = "linux")]
        let _ = map.advise(memmap2::Advice::HugePage);
        let elements: &mut [T] = bytemuck::cast_slice_mut(&mut map[..len * size_of::<T>()]);
        (elements.par_iter_mut().enumerate())
            .with_min_len(256)
            .for_each(|(i, element)| *element = make(i));
        Self {
            map,
            len,
            holds: PhantomData,
        }
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the map starts a page, holds so many elements, and any bits are one.
        unsafe { std::slice::from_raw_parts(self.map.as_ptr().cast(), self.len) }
    }
}
