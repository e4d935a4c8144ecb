//! Light by groups of emitters, beside the whole.

use crate::Rgb;

/// What paths found of the light of groups 1 to `count`; where no group is asked for, one branch for each light found.
#[derive(Default)]
pub(super) struct Groups {
    count: u16,
    /// Path by path.
    sums: Vec<Rgb>,
}

impl Groups {
    pub(super) fn new(count: u16) -> Self {
        Self { count, sums: Vec::new() }
    }

    /// The group that an emitter of that number is in, as far as it is asked for; 0 is none.
    #[inline(always)]
    pub(super) fn of(&self, number: impl FnOnce() -> u16) -> u16 {
        if self.count == 0 { 0 } else { self.known(number()) }
    }

    fn known(&self, number: u16) -> u16 {
        if number <= self.count { number } else { 0 }
    }

    /// Forgets all paths.
    pub(super) fn clear(&mut self) {
        self.sums.clear();
    }

    /// Adds a path.
    #[inline(always)]
    pub(super) fn start(&mut self) {
        if self.count != 0 {
            self.start_one();
        }
    }

    #[cold]
    fn start_one(&mut self) {
        self.sums.resize(self.sums.len() + usize::from(self.count), Rgb::ZERO);
    }

    /// Adds light that a path found, of what [`Groups::of`] said.
    #[inline(always)]
    pub(super) fn add(&mut self, path: u32, of: u16, light: Rgb) {
        if of != 0 {
            self.add_to_one(path, of, light);
        }
    }

    #[cold]
    fn add_to_one(&mut self, path: u32, of: u16, light: Rgb) {
        self.sums[path as usize * usize::from(self.count) + usize::from(of) - 1] += light;
    }

    /// What a path found, group by group.
    #[inline(always)]
    pub(super) fn found(&self, path: usize) -> &[Rgb] {
        let count = usize::from(self.count);
        if count == 0 { &[] } else { &self.sums[path * count..][..count] }
    }
}
