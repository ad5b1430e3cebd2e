/// How trees are built and walked. No choice changes a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AccelOptions {
    /// Time to build against time to trace.
    pub quality: Quality,
    /// The instructions that walk the trees of meshes.
    pub kernel: Kernel,
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

/// The instructions that walk the trees of meshes. All give the same hits to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Plain Rust.
    Portable,
}

impl Kernel {
    /// Those that this processor has, the fastest last.
    pub fn available() -> Vec<Self> {
        vec![Self::Portable]
    }

    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
        }
    }
}

impl Default for Kernel {
    /// The fastest.
    fn default() -> Self {
        Self::available().pop().unwrap_or(Self::Portable)
    }
}
