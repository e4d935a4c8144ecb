//! Pieces of a scene by their indices, which stay while pieces come and go.

/// A list whose empty places are filled again.
pub(super) struct Slots<T> {
    all: Vec<T>,
    empty: Vec<usize>,
}

impl<T> Default for Slots<T> {
    fn default() -> Self {
        Self { all: Vec::new(), empty: Vec::new() }
    }
}

impl<T> Slots<T> {
    /// Adds a piece; gives its index.
    pub(super) fn add(&mut self, piece: T) -> usize {
        match self.empty.pop() {
            Some(index) => {
                self.all[index] = piece;
                index
            }
            None => {
                self.all.push(piece);
                self.all.len() - 1
            }
        }
    }

    /// Puts `nothing` where a piece is, whose index another gets that is added; an index that holds none stays as it is.
    pub(super) fn forget(&mut self, index: usize, nothing: T) {
        if index < self.all.len() && !self.empty.contains(&index) {
            self.all[index] = nothing;
            self.empty.push(index);
        }
    }

    /// All items, an empty one at each empty place.
    pub(super) fn all(&self) -> &[T] {
        &self.all
    }
}
