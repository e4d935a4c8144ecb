//! The density of several targets at once, in single precision.
//!
//! Rays of one packet come from film points near each other: they nearly always share a cell of the map.

use glam::{DVec2, DVec3};

use super::cell::Cell;
use super::ellipse::Ellipse;
use super::{DEFENSIVE_SHARE, PupilMap};

macro_rules! spots {
    ($($(#[$doc:meta])* $field:ident),*) => {
        /// A cell where only the film point's distance from the axis counts: the numbers that most densities need.
        #[derive(Clone, Copy, Debug)]
        pub(super) struct Spot {
            $($(#[$doc])* $field: f32,)*
        }

        /// Spots of several film points.
        pub(super) struct Spots<const N: usize> {
            $(pub(super) $field: [f32; N],)*
        }

        impl<const N: usize> Spots<N> {
            /// The spots of the cells with these numbers, which are whole and often all the same.
            #[inline]
            pub(super) fn of(all: &[Spot], cell: &[f32; N]) -> Self {
                let first = &all[cell[0] as i32 as usize];
                let mut spots = Self { $($field: [first.$field; N],)* };
                if cell.iter().any(|&c| c != cell[0]) {
                    for i in 1..N {
                        let spot = &all[cell[i] as i32 as usize];
                        $(spots.$field[i] = spot.$field;)*
                    }
                }
                spots
            }
        }
    };
}

spots! {
    /// The ellipse's centre at the near end of the cell, mm along and across the meridian.
    along,
    across,
    /// The way of the ellipse's centre from the near end of the cell to the far end.
    along_way,
    across_way,
    /// The ellipse's axes at the near end, and their growth to the far end.
    semi_along,
    semi_across,
    semi_along_growth,
    semi_across_growth,
    /// Density of the samples in the outline, in units of the ellipse.
    density,
    /// Squared radii between which every direction is inside.
    surely_from,
    surely_to
}

impl Spot {
    pub(super) fn new(cell: &Cell, near: Ellipse, far: Ellipse) -> Self {
        let [surely_from, surely_to] = cell.surely().map(|squared| squared as f32);
        let (way, growth) = (far.centre - near.centre, far.semi_axes - near.semi_axes);
        Self {
            along: near.centre.x as f32,
            across: near.centre.y as f32,
            along_way: way.x as f32,
            across_way: way.y as f32,
            semi_along: near.semi_axes.x as f32,
            semi_across: near.semi_axes.y as f32,
            semi_along_growth: growth.x as f32,
            semi_across_growth: growth.y as f32,
            // Without any outline the cell's density is 0, and the whole glass takes all samples.
            density: ((1.0 - DEFENSIVE_SHARE) * cell.density()) as f32,
            surely_from,
            surely_to,
        }
    }
}

impl PupilMap {
    /// [`Self::pdf`] of `N` targets (x and y, mm) from as many film points (x, y and z, mm).
    #[inline]
    pub fn pdfs<const N: usize>(&self, film: &[[f32; N]; 3], target: &[[f32; N]; 2]) -> [f32; N] {
        if self.spots.is_empty() {
            return self.pdfs_one_by_one(film, target);
        }
        let (cells_per_mm, last) = (self.radius.cells_per_unit as f32, (self.radius.cells - 1) as f32);
        let [mut cell, mut rest, mut cosine, mut sine] = [[0.0f32; N]; 4];
        for i in 0..N {
            let (x, y) = (film[0][i], film[1][i]);
            let radius = (x * x + y * y).sqrt();
            let inverse = radius.max(f32::MIN_POSITIVE).recip();
            (cosine[i], sine[i]) = (if radius > 0.0 { x * inverse } else { 1.0 }, y * inverse);
            let place = radius * cells_per_mm;
            cell[i] = place.min(last).max(0.0).trunc();
            rest[i] = place - cell[i];
        }
        let here = Spots::of(&self.spots, &cell);
        let glass_squared = (self.glass_radius * self.glass_radius) as f32;
        let glass = [1.0, DEFENSIVE_SHARE].map(|share| (share * self.glass_density) as f32);
        let [mut densities, mut inner, mut alongs, mut acrosses] = [[0.0f32; N]; 4];
        let mut unsure = 0u32;
        for i in 0..N {
            let (x, y) = (target[0][i], target[1][i]);
            let between = rest[i].clamp(0.0, 1.0);
            let semi_along = here.semi_along[i] + here.semi_along_growth[i] * between;
            let semi_across = here.semi_across[i] + here.semi_across_growth[i] * between;
            let inverse_gain = (semi_along * semi_across).recip();
            let along = x * cosine[i] + y * sine[i] - (here.along[i] + here.along_way[i] * rest[i]);
            let across = y * cosine[i] - x * sine[i] - (here.across[i] + here.across_way[i] * rest[i]);
            let (along, across) = (along * (semi_across * inverse_gain), across * (semi_along * inverse_gain));
            let density = here.density[i] * inverse_gain;
            (alongs[i], acrosses[i], inner[i]) = (along, across, density);
            let squared = along * along + across * across;
            let is_surely = squared > here.surely_from[i] && squared < here.surely_to[i];
            let anywhere = if density > 0.0 { glass[1] } else { glass[0] };
            let on_glass = if x * x + y * y <= glass_squared { anywhere } else { 0.0 };
            densities[i] = on_glass + if is_surely { density } else { 0.0 };
            unsure |= u32::from(!is_surely && density > 0.0) << i;
        }
        while unsure != 0 {
            let i = unsure.trailing_zeros() as usize;
            let cell_here = &self.cells[cell[i] as i32 as usize];
            if cell_here.contains_by_sector(DVec2::new(alongs[i].into(), acrosses[i].into())) {
                densities[i] += inner[i];
            }
            unsure &= unsure - 1;
        }
        densities
    }

    fn pdfs_one_by_one<const N: usize>(&self, film: &[[f32; N]; 3], target: &[[f32; N]; 2]) -> [f32; N] {
        std::array::from_fn(|i| self.pdf_of(film, target, i))
    }

    fn pdf_of<const N: usize>(&self, film: &[[f32; N]; 3], target: &[[f32; N]; 2], i: usize) -> f32 {
        let at = |numbers: &[[f32; N]], axis: usize| f64::from(numbers[axis][i]);
        let film = DVec3::new(at(film, 0), at(film, 1), at(film, 2));
        self.pdf(film, DVec3::new(at(target, 0), at(target, 1), self.reference_z)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::super::cases::{ROUNDS, for_each_map, part, place};
    use super::*;

    /// Several at once have the densities that they have alone, for plain maps and others.
    #[test]
    fn together_as_alone() {
        for_each_map(|map, film, which| {
            let (mut same, mut other, mut lit) = (0, 0, 0);
            for round in 0..ROUNDS {
                let part = |i: usize, by: f64| part(round, i, by);
                // Side by side, and every other round all over the film.
                let places: [glam::Vec3; 8] = std::array::from_fn(|i| {
                    let at = if round % 2 == 0 { 0 } else { i };
                    place(film, [part(at, 0.618) + i as f32 * 3e-4, part(at, 0.755)])
                });
                let films = [0, 1, 2].map(|axis| places.map(|p| p[axis]));
                let radius = map.glass_radius as f32;
                let target: [[f32; 8]; 2] =
                    [0.5707, 0.8321].map(|by| std::array::from_fn(|i| (part(i, by) * 2.0 - 1.0) * radius));
                let together = map.pdfs(&films, &target);
                for i in 0..8 {
                    let alone = map.pdf_of(&films, &target, i);
                    let film = DVec3::new(films[0][i].into(), films[1][i].into(), films[2][i].into());
                    lit += usize::from(f64::from(alone) * map.pupil_area_mm2(film) > 0.5);
                    // On an edge rounding decides.
                    if (together[i] / alone - 1.0).abs() < 1e-5 || together[i] == alone {
                        same += 1
                    } else {
                        other += 1
                    }
                }
            }
            assert!(other * 3000 < same && lit > 500, "{which}: {same} {other} {lit}");
        });
    }
}
