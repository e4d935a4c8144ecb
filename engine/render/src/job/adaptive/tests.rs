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

/// The states of a tile that a render comes to are taken from a file, and no others: a look beyond the next one would end in a panic, an earlier
/// one would be waited for without end.
#[test]
fn only_states_of_a_render_are_taken_up() {
    let settings = Settings { samples: 100, noise_threshold: 0.1, min_samples: 16, ..Settings::default() };
    let adaptive = Adaptive::new(&settings, 1, 64);
    let state = |look: u32, ends: [u32; 2], open: [bool; 2]| AdaptiveState {
        plans: vec![BlockPlan { ends, open, look }],
        done: 0,
        planned: 0,
    };
    let looks: Vec<usize> =
        (1..).zip(&adaptive.passes).filter(|(_, p)| p.next_look.is_some()).map(|(i, _)| i).collect();
    let (first, next) = (looks[0], adaptive.passes[looks[0] - 1].next_look.unwrap());
    let may = |state: &AdaptiveState, passes: usize, samples: [u32; 2], is_together: bool| {
        adaptive.may_come_to(state, KeptTile { tile: 0, passes: passes as u32, samples }, is_together)
    };
    // Before the first look, at it, and after one half has been given no more.
    let before = adaptive.passes[0].count;
    assert!(may(&state(16, [16; 2], [true; 2]), 1, [before; 2], false));
    assert!(may(&state(next, [next; 2], [true; 2]), first, [16; 2], false));
    assert!(may(&state(next, [20, next], [false, true]), first, [16; 2], false));
    // Denoising is looked at once all tiles are there.
    assert!(may(&state(16, [16; 2], [true; 2]), first, [16; 2], true));
    assert!(!may(&state(16, [16; 2], [true; 2]), first, [16; 2], false));
    for (look, ends, open, passes, samples) in [
        (next + 1, [next + 1; 2], [true; 2], first, [16; 2]),
        (u32::MAX, [u32::MAX; 2], [true; 2], first, [16; 2]),
        (next, [next, next + 1], [true, false], first, [16; 2]),
        (next, [20, next], [true, true], first, [16; 2]),
        (next, [next; 2], [true; 2], first, [16, 17]),
        (16, [16; 2], [true; 2], 0, [0; 2]),
        (16, [16; 2], [true; 2], adaptive.passes.len() + 1, [16; 2]),
    ] {
        assert!(!may(&state(look, ends, open), passes, samples, true), "{look} {ends:?} {open:?} {passes} {samples:?}");
    }
    let elsewhere = KeptTile { tile: 1, passes: 1, samples: [before; 2] };
    assert!(!adaptive.may_come_to(&state(16, [16; 2], [true; 2]), elsewhere, true));
}
