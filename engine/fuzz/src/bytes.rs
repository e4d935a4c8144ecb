//! Numbers and choices from a fuzzer's bytes.
//!
//! Where the bytes have ended, all that follows is 0, so that an input of any length means something.

/// The bytes that are left of an input.
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// All of an input.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// True if nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The bytes that are left.
    pub fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// The next so many bytes, fewer where the input ends.
    pub fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, left) = self.0.split_at(count.min(self.0.len()));
        self.0 = left;
        taken
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut array = [0; N];
        let taken = self.take(N);
        array[..taken.len()].copy_from_slice(taken);
        array
    }

    /// A byte.
    pub fn byte(&mut self) -> u8 {
        self.array::<1>()[0]
    }

    /// A number below `count`, which is at most 256.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count.max(1)
    }

    /// A choice with about this chance in 256 where bytes are even; false at the input's end.
    pub fn once_in(&mut self, chance: u8) -> bool {
        self.byte() > 255 - chance
    }

    /// A number of four bytes.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// A number from -1 to 1 in steps of 2⁻¹⁵.
    pub fn part(&mut self) -> f64 {
        f64::from(i16::from_le_bytes(self.array())) / 32768.0
    }

    /// Any number of 64 bits, also one that is none.
    pub fn any_f64(&mut self) -> f64 {
        f64::from_le_bytes(self.array())
    }

    /// A number of 32 bits: most often a small one, sometimes any, also one that is none.
    pub fn any_f32(&mut self) -> f32 {
        match self.byte() {
            0..=9 => f32::from_le_bytes(self.array()),
            10 => f32::NAN,
            11 => f32::INFINITY,
            12 => f32::MAX,
            13 => f32::MIN_POSITIVE,
            14 => 1e-30,
            15 => 1e18,
            16..=31 => 0.0,
            32..=47 => 1.0,
            _ => 4.0 * self.part() as f32,
        }
    }
}
