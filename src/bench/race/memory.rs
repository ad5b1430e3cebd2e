use std::fs;

/// Runs `work` and tells by how many bytes the program grew meanwhile at most; `None` where the system does not say.
pub(super) fn peak_of<T>(work: impl FnOnce() -> T) -> (T, Option<usize>) {
    // Linux then forgets the largest size so far.
    let before = (fs::write("/proc/self/clear_refs", "5").ok()).and_then(|()| resident("VmRSS:"));
    let result = work();
    let peak = resident("VmHWM:")
        .zip(before)
        .map(|(peak, before)| peak.saturating_sub(before));
    (result, peak)
}

/// A size in bytes from the kernel's account of this program.
fn resident(label: &str) -> Option<usize> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(label))?;
    let kib: usize = line.trim().strip_suffix(" kB")?.trim().parse().ok()?;
    Some(1024 * kib)
}
