//! Lists of numbers in as few bytes as can be written and read at the speed of memory, bit by bit.
//!
//! Most numbers of a film are zero or end in zeros: a tile's edge that no light reached, sums in double precision of a few numbers of single
//! precision, counts. So each column of a list (a channel of all pixels) is written as its numbers that are not zero, without the bytes that
//! are zero in all of them, and a bit for each number that says whether it is.
//!
//! Layout: the number of rows (4 bytes, little-endian), then the columns. A column begins with the width of a number in bytes (0: all are
//! zero) and the number of zero bytes below, with [`HAS_ZEROS`] where a bit for each row follows, and [`IS_ALIKE`] where one number stands for
//! all that are not zero.

use super::data::{DataSums, VectorSums};
use serde::de::{Error, Visitor};
use serde::{Deserializer, Serializer};

/// Rows of the longest list.
pub(super) const MOST_ROWS: usize = 1 << 16;
/// Rows of the longest list of a tile's pixels, with those that its light spreads to.
const MOST_PIXELS: usize = 1 << 12;
const HAS_ZEROS: u8 = 0x80;
const IS_ALIKE: u8 = 0x40;

/// A row of a list: some numbers of at most 64 bits.
pub(super) trait Row: Copy {
    /// Number of columns.
    const COLUMNS: usize;
    /// Rows of the longest list of such, which may come from a file that says anything.
    const MOST: usize = MOST_PIXELS;
    /// A row of zeros.
    const ZERO: Self;
    /// The bits of a column's number.
    fn bits(&self, column: usize) -> u64;
    /// Sets a column's number by its bits.
    fn set(&mut self, column: usize, bits: u64);
}

impl Row for i64 {
    const COLUMNS: usize = 1;
    const MOST: usize = MOST_ROWS;
    const ZERO: Self = 0;
    // Small numbers of both signs have zero bytes above.
    fn bits(&self, _: usize) -> u64 {
        ((self << 1) ^ (self >> 63)) as u64
    }
    fn set(&mut self, _: usize, bits: u64) {
        *self = (bits >> 1) as i64 ^ -((bits & 1) as i64);
    }
}

impl Row for u32 {
    const COLUMNS: usize = 1;
    const ZERO: Self = 0;
    fn bits(&self, _: usize) -> u64 {
        u64::from(*self)
    }
    fn set(&mut self, _: usize, bits: u64) {
        *self = bits as u32;
    }
}

impl Row for f32 {
    const COLUMNS: usize = 1;
    const ZERO: Self = 0.0;
    fn bits(&self, _: usize) -> u64 {
        u64::from(self.to_bits())
    }
    fn set(&mut self, _: usize, bits: u64) {
        *self = Self::from_bits(bits as u32);
    }
}

impl Row for [f32; 4] {
    const COLUMNS: usize = 4;
    const ZERO: Self = [0.0; 4];
    fn bits(&self, column: usize) -> u64 {
        u64::from(self[column].to_bits())
    }
    fn set(&mut self, column: usize, bits: u64) {
        self[column] = f32::from_bits(bits as u32);
    }
}

impl Row for [f64; 4] {
    const COLUMNS: usize = 4;
    const ZERO: Self = [0.0; 4];
    fn bits(&self, column: usize) -> u64 {
        self[column].to_bits()
    }
    fn set(&mut self, column: usize, bits: u64) {
        self[column] = f64::from_bits(bits);
    }
}

impl Row for DataSums {
    const COLUMNS: usize = 8;
    const ZERO: Self = Self { rays: 0.0, hits: 0.0, position: glam::Vec3::ZERO, normal: glam::Vec3::ZERO };
    fn bits(&self, column: usize) -> u64 {
        let number = match column {
            0 => self.rays,
            1 => self.hits,
            2..5 => self.position[column - 2],
            _ => self.normal[column - 5],
        };
        u64::from(number.to_bits())
    }
    fn set(&mut self, column: usize, bits: u64) {
        let number = f32::from_bits(bits as u32);
        match column {
            0 => self.rays = number,
            1 => self.hits = number,
            2..5 => self.position[column - 2] = number,
            _ => self.normal[column - 5] = number,
        }
    }
}

impl Row for VectorSums {
    const COLUMNS: usize = 5;
    const ZERO: Self = Self { rays: 0.0, sum: glam::Vec4::ZERO };
    fn bits(&self, column: usize) -> u64 {
        u64::from(if column == 0 { self.rays } else { self.sum[column - 1] }.to_bits())
    }
    fn set(&mut self, column: usize, bits: u64) {
        let number = f32::from_bits(bits as u32);
        if column == 0 { self.rays = number } else { self.sum[column - 1] = number }
    }
}

/// Writes a list; `#[serde(with = "packed")]`.
pub(super) fn serialize<T: Row, S: Serializer>(rows: &[T], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_bytes(&pack(rows))
}

/// Reads a list; `#[serde(with = "packed")]`.
pub(super) fn deserialize<'de, T: Row, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    struct Packed<T>(std::marker::PhantomData<T>);

    impl<T: Row> Visitor<'_> for Packed<T> {
        type Value = Vec<T>;

        fn expecting(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            to.write_str("a packed list of numbers")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
            unpack(bytes).ok_or_else(|| E::custom("no packed list of numbers"))
        }
    }

    from.deserialize_bytes(Packed(std::marker::PhantomData))
}

/// The bytes of a list of at most [`Row::MOST`] rows.
fn pack<T: Row>(rows: &[T]) -> Vec<u8> {
    debug_assert!(rows.len() <= T::MOST);
    let mut out = Vec::with_capacity(4 + size_of_val(rows));
    out.extend_from_slice(&(rows.len() as u32).to_le_bytes());
    for column in 0..T::COLUMNS {
        pack_column(rows, column, &mut out);
    }
    out
}

fn pack_column<T: Row>(rows: &[T], column: usize, out: &mut Vec<u8>) {
    let (mut all, mut same, mut zeros, mut first) = (0, 0, 0, 0);
    for row in rows {
        let bits = row.bits(column);
        if first == 0 {
            first = bits;
        }
        all |= bits;
        same |= if bits == 0 { 0 } else { bits ^ first };
        zeros += usize::from(bits == 0);
    }
    if all == 0 {
        return out.push(0);
    }
    let below = all.trailing_zeros() / 8;
    let width = (64 - all.leading_zeros()).div_ceil(8) - below;
    let is_alike = same == 0;
    let flags = if zeros > 0 { HAS_ZEROS } else { 0 } | if is_alike { IS_ALIKE } else { 0 };
    out.extend_from_slice(&[width as u8, below as u8 | flags]);
    if zeros > 0 {
        out.extend(rows.chunks(8).map(|eight| {
            eight.iter().enumerate().fold(0, |byte, (i, row)| byte | u8::from(row.bits(column) != 0) << i)
        }));
    }
    if is_alike {
        return out.extend_from_slice(&(first >> (8 * below)).to_le_bytes()[..width as usize]);
    }
    // Each number with the bytes above, over which the next one is written.
    let begin = out.len();
    let width = width as usize;
    out.resize(begin + (rows.len() - zeros) * width + size_of::<u64>(), 0);
    let mut at = begin;
    for row in rows {
        let bits = row.bits(column);
        out[at..at + size_of::<u64>()].copy_from_slice(&(bits >> (8 * below)).to_le_bytes());
        at += if bits == 0 { 0 } else { width };
    }
    out.truncate(at);
}

/// The list that these bytes are; `None` if they are none.
fn unpack<T: Row>(bytes: &[u8]) -> Option<Vec<T>> {
    let mut rows = Vec::new();
    unpack_into(bytes, &mut rows)?;
    Some(rows)
}

/// Puts the list that these bytes are in place of another one; `None` if they are none.
pub(super) fn unpack_into<T: Row>(bytes: &[u8], rows: &mut Vec<T>) -> Option<()> {
    let (count, mut bytes) = bytes.split_at_checked(4)?;
    let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
    if count > T::MOST {
        return None;
    }
    rows.clear();
    rows.resize(count, T::ZERO);
    for column in 0..T::COLUMNS {
        bytes = unpack_column(bytes, rows, column)?;
    }
    bytes.is_empty().then_some(())
}

/// Reads a column; the bytes behind it.
fn unpack_column<'a, T: Row>(bytes: &'a [u8], rows: &mut [T], column: usize) -> Option<&'a [u8]> {
    let (&width, bytes) = bytes.split_first()?;
    if width == 0 {
        return Some(bytes);
    }
    let (&how, bytes) = bytes.split_first()?;
    let (width, below) = (usize::from(width), u32::from(how & !(HAS_ZEROS | IS_ALIKE)));
    if width + below as usize > size_of::<u64>() {
        return None;
    }
    let (mask, bytes) = bytes.split_at_checked(if how & HAS_ZEROS == 0 { 0 } else { rows.len().div_ceil(8) })?;
    let is_there = |i: usize| mask.get(i / 8).is_none_or(|byte| byte >> (i % 8) & 1 == 1);
    let number = |bytes: &[u8]| {
        let mut eight = [0; size_of::<u64>()];
        eight[..width].copy_from_slice(bytes);
        u64::from_le_bytes(eight) << (8 * below)
    };
    if how & IS_ALIKE != 0 {
        let (one, rest) = bytes.split_at_checked(width)?;
        let bits = number(one);
        rows.iter_mut().enumerate().filter(|(i, _)| is_there(*i)).for_each(|(_, row)| row.set(column, bits));
        return Some(rest);
    }
    let count = if mask.is_empty() { rows.len() } else { (0..rows.len()).filter(|&i| is_there(i)).count() };
    let (numbers, rest) = bytes.split_at_checked(count * width)?;
    let keep = u64::MAX >> (64 - 8 * width);
    let mut at = 0;
    for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| is_there(*i)) {
        // Eight bytes at once, but at the end.
        let bits = match numbers.get(at..at + size_of::<u64>()) {
            Some(eight) => (u64::from_le_bytes(eight.try_into().ok()?) & keep) << (8 * below),
            None => number(&numbers[at..at + width]),
        };
        row.set(column, bits);
        at += width;
    }
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back<T: Row>(rows: &[T]) -> usize {
        let bytes = pack(rows);
        let back: Vec<T> = unpack(&bytes).unwrap();
        assert_eq!(back.len(), rows.len());
        for (one, other) in rows.iter().zip(&back) {
            (0..T::COLUMNS).for_each(|column| assert_eq!(one.bits(column), other.bits(column)));
        }
        // What is cut off, or has more behind it, is no list.
        assert!(
            unpack::<T>(&bytes[..bytes.len() - 1]).is_none() && unpack::<T>(&[&bytes[..], &[0]].concat()).is_none()
        );
        bytes.len()
    }

    #[test]
    fn numbers_come_back_bit_by_bit() {
        let numbers = |n: u64| n.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        for count in [0, 1, 7, 8, 9, 2304] {
            for some in [1, 3, 1 << 20] {
                let is_there = |n: &u64| n.is_multiple_of(some);
                let word = |n| if is_there(&n) { numbers(n + 1) } else { 0 };
                there_and_back(&(0..count).map(|n| word(n) as i64).collect::<Vec<_>>());
                there_and_back(&(0..count).map(|n| word(n) as u32).collect::<Vec<_>>());
                there_and_back(&(0..count).map(|n| f32::from_bits(word(n) as u32)).collect::<Vec<_>>());
                there_and_back(
                    &(0..count).map(|n| [0, 1, 2, 3].map(|c| f64::from_bits(word(n) >> (9 * c)))).collect::<Vec<_>>(),
                );
            }
        }
        // Zero with a sign, infinity, no number.
        there_and_back(&[[0.0f64, -0.0, f64::INFINITY, f64::NAN]; 3]);
        there_and_back(&[i64::MIN, i64::MAX, -1, 0, 1]);
    }

    #[test]
    fn what_ends_in_zeros_takes_few_bytes() {
        // A number of single precision in double precision, and one that all have; most rows have neither.
        let row = |i: usize| if i.is_multiple_of(4) { [f64::from(0.1 + i as f32), 0.0, 0.0, 1.0] } else { [0.0; 4] };
        let bytes = there_and_back(&(0..800).map(row).collect::<Vec<_>>());
        assert!(bytes < 200 * 5 + 2 * 100 + 30, "{bytes}");
    }

    /// Any bytes are refused or are a list, of bounded length.
    #[test]
    fn damage_is_no_panic() {
        let whole = pack(&(0..50).map(|i| [f64::from(i) * 0.3, 0.0, 1.0, f64::from(i % 3)]).collect::<Vec<_>>());
        for place in 0..whole.len() {
            for bit in 0..8 {
                let mut bytes = whole.clone();
                bytes[place] ^= 1 << bit;
                let _ = unpack::<[f64; 4]>(&bytes);
            }
        }
        assert!(unpack::<u32>(&[255, 255, 255, 255, 0]).is_none());
        // Nor are a few bytes more pixels than a tile has.
        let zeros = |rows: u32, columns: usize| [&rows.to_le_bytes()[..], &vec![0; columns]].concat();
        assert_eq!(unpack::<[f64; 4]>(&zeros(2304, 4)).map(|list| list.len()), Some(2304));
        assert!(unpack::<[f64; 4]>(&zeros(1 << 16, 4)).is_none());
        assert_eq!(unpack::<i64>(&zeros(1 << 16, 1)).map(|list| list.len()), Some(1 << 16));
    }
}
