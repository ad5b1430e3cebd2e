//! Large arrays in large pages, and a word to the processor's caches.

#![allow(unsafe_code)]

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::Zeroable;
use memmap2::MmapMut;
use rayon::prelude::*;

/// Asks for the cache line at an address, of which nothing else is asked.
#[inline(always)]
pub(crate) fn fetch<T>(place: *const T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch of any address does no harm.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

/// An array whose length stays. A large one stands in pages of 2 MiB where the system has them: rays that jump about
/// a tree miss the table of pages less often, and memory that is used for the first time costs a visit to the
/// system for 2 MiB and not for 4 KiB.
pub(crate) struct Pages<T> {
    start: *mut T,
    len: usize,
    /// Whose memory it is.
    _store: Store<T>,
}

enum Store<T> {
    Heap { _elements: Vec<T> },
    Map { _map: MmapMut },
}

/// Arrays of so many bytes are large.
const LARGE: usize = 1 << 20;

// SAFETY: it owns its elements as a vector does.
unsafe impl<T: Send> Send for Pages<T> {}
unsafe impl<T: Sync> Sync for Pages<T> {}

impl<T: Zeroable + Copy + Send + Sync> Pages<T> {
    /// `len` elements whose bytes are all 0.
    ///
    /// # Panics
    /// Where there is no memory.
    pub(crate) fn zeroed(len: usize) -> Self {
        let size = len * size_of::<T>();
        if size < LARGE {
            let mut elements = bytemuck::zeroed_vec(len);
            return Self {
                start: elements.as_mut_ptr(),
                len,
                _store: Store::Heap {
                    _elements: elements,
                },
            };
        }
        let mut map = MmapMut::map_anon(size).expect("there is memory");
        #[cfg(target_os = "linux")]
        let _ = map.advise(memmap2::Advice::HugePage);
        // The system clears pages when they are first written to: here, on all threads.
        map.par_chunks_mut(LARGE).for_each(|pages| pages[0] = 0);
        Self {
            // A map starts a page, and no type here is aligned to more.
            start: map.as_mut_ptr().cast(),
            len,
            _store: Store::Map { _map: map },
        }
    }

    /// `len` elements, made on all threads.
    pub(crate) fn new(len: usize, make: impl Fn(usize) -> T + Sync) -> Self {
        let mut pages = Self::zeroed(len);
        (pages.par_iter_mut().enumerate())
            .with_min_len(256)
            .for_each(|(i, element)| *element = make(i));
        pages
    }
}

impl<T> Deref for Pages<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        // SAFETY: the store has so many elements there, made of zeros, which are one, or written since.
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }
}

impl<T> DerefMut for Pages<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as above, and nobody else has them.
        unsafe { std::slice::from_raw_parts_mut(self.start, self.len) }
    }
}

impl<T: Zeroable + Copy + Send + Sync> Clone for Pages<T> {
    fn clone(&self) -> Self {
        Self::new(self.len, |i| self[i])
    }
}

impl<T: PartialEq> PartialEq for Pages<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Eq> Eq for Pages<T> {}

impl<T: fmt::Debug> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_arrays_hold_what_is_written() {
        for len in [0, 1, 1000, LARGE / 4 + 5] {
            let mut pages: Pages<u64> = Pages::zeroed(len);
            assert!(pages.len() == len && pages.iter().all(|&x| x == 0));
            for (i, x) in pages.iter_mut().enumerate() {
                *x = 3 * i as u64;
            }
            assert!((0..len).all(|i| pages[i] == 3 * i as u64));
            assert_eq!(pages, pages.clone());
            assert_eq!(pages, Pages::new(len, |i| 3 * i as u64));
        }
    }
}
