//! Mattes of several pictures, joined: names that cover a pixel, by the samples that saw them.

use std::collections::BTreeMap;

/// Joins a pixel of a Cryptomatte layer. `parts` are by picture its samples and its ranks, number of the name and coverage each;
/// gives as many ranks as the longest of them, those that cover most first, among equals the smaller bits.
pub(crate) fn joined(parts: &[(f64, Vec<[f32; 2]>)]) -> Vec<[f32; 2]> {
    let total: f64 = parts.iter().map(|(samples, _)| samples).sum();
    let mut covers: BTreeMap<u32, f64> = BTreeMap::new();
    for (samples, ranks) in parts {
        for [name, part] in ranks.iter().filter(|[_, part]| *part > 0.0) {
            *covers.entry(name.to_bits()).or_default() += samples * f64::from(*part);
        }
    }
    let mut order: Vec<(u32, f64)> = covers.into_iter().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let ranks = parts.iter().map(|(_, ranks)| ranks.len()).max().unwrap_or(0);
    let mut out: Vec<[f32; 2]> =
        order.into_iter().take(ranks).map(|(name, sum)| [f32::from_bits(name), (sum / total) as f32]).collect();
    out.resize(ranks, [0.0; 2]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_counted_by_samples() {
        let parts =
            [(10.0, vec![[2.0, 0.5], [3.0, 0.25], [0.0, 0.0]]), (30.0, vec![[3.0, 0.5], [5.0, 0.125], [0.0, 0.0]])];
        assert_eq!(joined(&parts), [[3.0, 0.4375], [2.0, 0.125], [5.0, 0.09375]]);
        // More names than ranks: the weakest go.
        let parts = [(1.0, vec![[2.0, 0.5]]), (1.0, vec![[3.0, 0.25]])];
        assert_eq!(joined(&parts), [[2.0, 0.25]]);
    }
}
