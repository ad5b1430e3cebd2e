/// How trees are built and walked. No choice changes a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AccelOptions {
    /// Time to build against time to trace.
    pub quality: Quality,
    /// The instructions that walk the trees; plain Rust where the processor lacks them.
    pub kernel: Kernel,
}

impl AccelOptions {
    /// With a kernel that the processor has.
    pub(super) fn supported(mut self) -> Self {
        if !Kernel::available().contains(&self.kernel) {
            self.kernel = Kernel::Portable;
        }
        self
    }
}

/// Time to build against time to trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For a picture that is quickly done.
    Fast,
    /// Good rays for a build that takes about as long as reading the file.
    #[default]
    Balanced,
    /// For pictures that take many minutes.
    Best,
}

/// The instructions that walk the trees. All give the same hits to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Plain Rust.
    Portable,
    /// AVX2 and FMA: 8 boxes and 8 triangles at once.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512: 16 boxes and 8 triangles at once.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kernel {
    /// Those that this processor has, the fastest last.
    pub fn available() -> Vec<Self> {
        let mut kernels = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            let all = |features: &[bool]| features.iter().all(|&has| has);
            let avx2 = all(&[
                is_x86_feature_detected!("avx2"),
                is_x86_feature_detected!("fma"),
                is_x86_feature_detected!("bmi1"),
                is_x86_feature_detected!("bmi2"),
                is_x86_feature_detected!("lzcnt"),
                is_x86_feature_detected!("popcnt"),
            ]);
            let avx512 = all(&[
                is_x86_feature_detected!("avx512f"),
                is_x86_feature_detected!("avx512vl"),
                is_x86_feature_detected!("avx512dq"),
                is_x86_feature_detected!("avx512bw"),
            ]);
            if avx2 {
                kernels.push(Self::Avx2);
            }
            if avx2 && avx512 {
                kernels.push(Self::Avx512);
            }
        }
        kernels
    }

    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        }
    }
}

impl Default for Kernel {
    /// The fastest.
    fn default() -> Self {
        Self::available().pop().unwrap_or(Self::Portable)
    }
}
