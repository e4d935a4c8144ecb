//! Light by groups of emitters, beside the whole.
//!
//! A kind rather than a value: where no group is asked for, nothing of it is left in the code that follows paths.

use crate::Rgb;

/// Where paths note the light that they found by its emitters' groups.
pub trait Groups {
    /// What is known of an emitter's group.
    type Of: Copy;

    /// The group that an emitter of that number is in; 0 is none.
    fn of(&self, number: impl FnOnce() -> u16) -> Self::Of;

    /// Forgets all paths.
    fn clear(&mut self);

    /// Adds a path.
    fn start(&mut self);

    /// Adds light that a path found.
    fn add(&mut self, path: u32, of: Self::Of, light: Rgb);

    /// What a path found, group by group.
    fn found(&self, path: usize) -> &[Rgb];
}

/// Notes nothing.
#[derive(Default)]
pub struct NoGroups;

impl Groups for NoGroups {
    type Of = ();

    #[inline(always)]
    fn of(&self, _: impl FnOnce() -> u16) {}

    #[inline(always)]
    fn clear(&mut self) {}

    #[inline(always)]
    fn start(&mut self) {}

    #[inline(always)]
    fn add(&mut self, _: u32, (): (), _: Rgb) {}

    #[inline(always)]
    fn found(&self, _: usize) -> &[Rgb] {
        &[]
    }
}

/// Notes the light of groups number 1 and on.
pub struct ByGroup {
    count: u16,
    /// Path by path.
    sums: Vec<Rgb>,
}

impl ByGroup {
    /// For that many groups.
    pub fn new(count: u16) -> Self {
        Self { count, sums: Vec::new() }
    }
}

impl Groups for ByGroup {
    type Of = u16;

    fn of(&self, number: impl FnOnce() -> u16) -> u16 {
        let number = number();
        if number <= self.count { number } else { 0 }
    }

    fn clear(&mut self) {
        self.sums.clear();
    }

    fn start(&mut self) {
        self.sums.resize(self.sums.len() + usize::from(self.count), Rgb::ZERO);
    }

    fn add(&mut self, path: u32, of: u16, light: Rgb) {
        if of != 0 {
            self.sums[path as usize * usize::from(self.count) + usize::from(of) - 1] += light;
        }
    }

    fn found(&self, path: usize) -> &[Rgb] {
        let count = usize::from(self.count);
        &self.sums[path * count..][..count]
    }
}
