//! Finds the few elements that may equal another one, without sorting them all.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

/// Positions of hashes that fall on the same bit of a large field as another one, ascending: all that are equal, and
/// one in some 30 of the others.
pub(super) fn alike(hashes: &[u64]) -> Vec<u32> {
    let words = (hashes.len() / 2).next_power_of_two();
    let field = || -> Vec<AtomicU64> { (0..words).map(|_| AtomicU64::new(0)).collect() };
    let (once, again) = (field(), field());
    let place = |hash: u64| ((hash >> 32) as usize & (words - 1), 1_u64 << (hash & 63));
    hashes.par_iter().for_each(|&hash| {
        let (word, bit) = place(hash);
        if once[word].fetch_or(bit, Ordering::Relaxed) & bit != 0 {
            again[word].fetch_or(bit, Ordering::Relaxed);
        }
    });
    (hashes.par_iter().zip(0..hashes.len() as u32))
        .filter(|&(&hash, _)| {
            let (word, bit) = place(hash);
            again[word].load(Ordering::Relaxed) & bit != 0
        })
        .map(|(_, position)| position)
        .collect()
}

/// A hash of three numbers, all bits of which depend on all of theirs.
pub(super) fn mix([x, y, z]: [u32; 3]) -> u64 {
    let mut h = 0_u64;
    for x in [x, y, z] {
        h = (h ^ u64::from(x)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        h ^= h >> 32;
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_equal_ones_and_few_others_are_found() {
        let element = |i: u32| if i % 1000 == 7 { i / 5000 } else { i };
        let hashes: Vec<u64> = (0..200_000).map(|i| mix([element(i), 3, 5])).collect();
        let found = alike(&hashes);
        assert!(found.is_sorted());
        assert!(
            (0..200_000)
                .filter(|i| i % 1000 == 7)
                .all(|i| found.binary_search(&i).is_ok())
        );
        assert!(found.len() < 20_000, "{}", found.len());
    }
}
