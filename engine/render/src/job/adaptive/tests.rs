//! The plan; its effect on pictures is tested in `tests/all/adaptive_sampling.rs`.

use super::*;

#[test]
fn passes_end_at_looks() {
    for (least, most) in [(4, 4), (4, 5), (16, 64), (16, 100), (5, 1000), (16, 16384), (40, 7)] {
        let list = passes(least, most);
        assert_eq!(list.iter().map(|p| p.count).sum::<u32>(), most);
        assert!(list.windows(2).all(|w| w[0].first + w[0].count == w[1].first));
        let mut look = least;
        for pass in list.iter().filter(|p| p.next_look.is_some()) {
            assert_eq!(pass.first + pass.count, look);
            look = (look * BETWEEN_LOOKS).min(most);
            assert_eq!(pass.next_look, Some(look));
        }
        assert_eq!(look, most.max(least));
        // The error at the first look is known from batches.
        assert!(list.iter().filter(|p| p.first + p.count <= least).count() >= 2 || most < least);
    }
}
