use std::ops::AddAssign;

/// Why answers may differ though none of them is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// A hit lies within rounding of where the ray starts or ends.
    End,
    /// A triangle more than a thousand times as long as high is concerned.
    Sliver,
    /// The ray meets a triangle at less than one degree.
    Grazing,
    /// The ray passes an edge within rounding.
    Edge,
}

/// What one ray showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Whether ours hits.
    pub hit: bool,
    /// Whether Embree hits another triangle at the same distance.
    pub tie: bool,
    /// The largest `|dt|` of Embree's hits on our triangle, as a part of the bound on rounding.
    pub dt: f64,
    /// Whether Embree's answer, fast and robust, is another than ours.
    pub differs: [bool; 2],
    /// Whether ours is wrong.
    pub ours_wrong: bool,
    /// Whether Embree's answer, fast and robust, is wrong.
    pub embree_wrong: [bool; 2],
    /// Where answers differ and none is wrong.
    pub reason: Option<Reason>,
}

/// What comparing many rays found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Rays traced.
    pub rays: u64,
    /// Of them, how many we say hit.
    pub hits: u64,
    /// Rays to which not all engines gave the same answer.
    pub differences: u64,
    /// Rays that we answered wrong: the arbiter says so, or our own queries differ from each other.
    pub ours_wrong: u64,
    /// Differences in which the arbiter finds Embree's fast scene wrong.
    pub embree_wrong: u64,
    /// Differences in which the arbiter finds Embree's robust scene wrong.
    pub robust_wrong: u64,
    /// Differences in which nobody is wrong, by [`Reason`].
    pub edge: u64,
    /// As `edge`.
    pub sliver: u64,
    /// As `edge`.
    pub grazing: u64,
    /// As `edge`.
    pub end: u64,
    /// Different triangles at the same distance.
    pub ties: u64,
    /// The largest `|dt|` of hits on one triangle, as a part of the bound on Embree's rounding.
    pub worst_dt: f64,
}

impl AddAssign<&Outcome> for Tally {
    fn add_assign(&mut self, one: &Outcome) {
        let reason = |reason| u64::from(one.reason == Some(reason));
        *self += Self {
            rays: 1,
            hits: one.hit.into(),
            differences: one.differs.contains(&true).into(),
            ours_wrong: one.ours_wrong.into(),
            embree_wrong: one.embree_wrong[0].into(),
            robust_wrong: one.embree_wrong[1].into(),
            edge: reason(Reason::Edge),
            sliver: reason(Reason::Sliver),
            grazing: reason(Reason::Grazing),
            end: reason(Reason::End),
            ties: one.tie.into(),
            worst_dt: one.dt,
        };
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.differences += other.differences;
        self.ours_wrong += other.ours_wrong;
        self.embree_wrong += other.embree_wrong;
        self.robust_wrong += other.robust_wrong;
        self.edge += other.edge;
        self.sliver += other.sliver;
        self.grazing += other.grazing;
        self.end += other.end;
        self.ties += other.ties;
        self.worst_dt = self.worst_dt.max(other.worst_dt);
    }
}
