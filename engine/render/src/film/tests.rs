//! Tiles, sums and their means.

use super::*;

#[test]
fn tiles_cover_the_picture_once() {
    for (w, h) in [(1, 1), (32, 32), (33, 31), (160, 90)] {
        let film = Film::new(w, h, true, false);
        let mut seen = vec![0; (w * h) as usize];
        for i in 0..film.tile_count() {
            let r = film.rect(i);
            for y in r.y..r.y + r.height {
                for x in r.x..r.x + r.width {
                    seen[(y * w + x) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
    }
}

#[test]
fn means_and_changes() {
    let film = Film::new(40, 8, false, false);
    for green in [4.0, 0.0] {
        let mut patch = film.patch(0);
        let r = film.rect(0);
        for (x, y) in (0..r.height).flat_map(|y| (0..r.width).map(move |x| (x, y))) {
            patch.add(x, y, Rgb::new(2.0, green, 1.5 * green));
            patch.add_alpha(x, y, 2.0);
        }
        assert!(film.add_pass(0, 7, patch.clone(), 2).is_err());
        film.add_pass(0, if green > 0.0 { 0 } else { 1 }, patch, 2).unwrap();
    }
    let changed = film.take_changed();
    assert_eq!(changed.len(), 1);
    assert_eq!(changed[0].pixels[0], [1.0, 1.0, 1.5, 1.0]);
    assert!(film.take_changed().is_empty());
    assert_eq!(film.samples_everywhere(&(0..film.tile_count()).collect::<Vec<_>>()), 0);
    assert_eq!(film.picture().iter().filter(|p| p[3] > 0.0).count(), 256);
}

/// Tiles that are at different counts of samples: light beyond an edge is divided by the count of its own tile.
#[test]
fn light_beyond_an_edge_counts_once() {
    let film = Film::new(70, 40, true, false);
    let mut expected = vec![0.0f32; 70 * 40];
    for tile in 0..film.tile_count() {
        let samples = 1 + tile as u32;
        let (r, mut patch) = (film.rect(tile), film.patch(tile));
        for k in 0..200u32 {
            // Near and far places.
            let (dx, dy) = ((k * 7919) % 90, (k * 104_729) % 31);
            let (x, y) = ((r.x + dx).saturating_sub(40).min(69), (r.y + dy).saturating_sub(10).min(39));
            patch.add(x, y, Rgb::splat(samples as f32));
            if patch.rect.index(x, y).is_some() {
                expected[(y * 70 + x) as usize] += 1.0;
            } else {
                // Divided by the receiving tile's own count.
                let to = (0..film.tile_count()).find(|&t| film.rect(t).index(x, y).is_some()).unwrap();
                expected[(y * 70 + x) as usize] += samples as f32 / (1 + to) as f32;
            }
        }
        film.add_pass(tile, 0, patch, samples).unwrap();
    }
    for (pixel, expected) in film.picture().iter().zip(expected) {
        assert!((pixel[0] - expected).abs() < 1e-4, "{pixel:?} {expected}");
    }
}

/// A film takes up tiles of the passes and samples that a render comes to, and none of more tiles than it has.
#[test]
fn only_tiles_of_a_render_are_taken_up() {
    let film = Film::new(40, 8, false, false);
    let patch = film.patch(0);
    film.add_pass(0, 0, patch, 2).unwrap();
    let state = film.state();
    let pieces: Vec<Vec<u8>> = state.pieces().iter().map(|piece| piece.bytes().unwrap()).collect();
    let kept = |pieces: &[Vec<u8>]| KeptFilm { films: 1, pieces: pieces.to_vec() };
    let empty = || Film::new(40, 8, false, false);
    let is_state = |tile: KeptTile| (tile.tile, tile.passes, tile.samples) == (0, 1, [2; 2]);
    assert_eq!(empty().restore(kept(&pieces), &is_state), Ok(()));
    assert_eq!(empty().restore(kept(&pieces), &|_| false), Err(NotThisFilm));
    assert_eq!(empty().join_kept(kept(&pieces), &[0], &is_state), Ok(()));
    assert_eq!(empty().join_kept(kept(&pieces), &[0], &|_| false), Err(NotThisFilm));
    // Variant, film, and the length of the list: 100 tiles of a film of two.
    assert_eq!(empty().restore(kept(&[vec![0, 0, 100]]), &is_state), Err(NotThisFilm));
}
