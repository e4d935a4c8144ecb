//! Several targets at once, in single precision: a target is a choice, and its density that of the chosen point, so all
//! that rounding moves is which of two neighbours is aimed at.

use glam::DVec3;

use super::cell::{Cell, GUIDE};
use super::lanes::Spots;
use super::outline::ANGLES;
use super::{DEFENSIVE_SHARE, PupilMap};

/// The data of a sector that a target needs.
#[derive(Clone, Copy, Debug, Default)]
struct AimedSector {
    corner: [f32; 2],
    /// Vector to the next corner.
    edge: [f32; 2],
    /// Share of the area in the sectors before it.
    start: f32,
    /// Reciprocal of the slice's own share.
    inverse_share: f32,
    /// Squared, where it begins on the way to its outer edge; and the rest from there to the edge.
    begin: f32,
    rest: f32,
}

/// Added to a number from 0 to 2²² and no less, it makes the lowest bits of the sum the nearest whole number: quicker than a cast that
/// minds all numbers.
const WHOLE: f32 = (1u32 << 23) as f32;

/// The sectors of a cell where only the film point's distance from the axis counts.
#[derive(Clone, Debug)]
pub(super) struct CellSectors {
    guide: [u8; GUIDE],
    /// The slices; behind the last one is one that is never reached.
    slices: [AimedSector; ANGLES + 1],
}

impl CellSectors {
    /// The slices of a cell; of no use for a cell that is dark.
    pub(super) fn new(cell: &Cell) -> Self {
        let mut all = Self { guide: [0; GUIDE], slices: [AimedSector::default(); ANGLES + 1] };
        all.slices[ANGLES].start = f32::INFINITY;
        for (part, first) in all.guide.iter_mut().zip(cell.guide()) {
            *part = *first;
        }
        for (slice, sector) in all.slices.iter_mut().zip(cell.sectors()) {
            let begin = (sector.inner * sector.inner) as f32;
            *slice = AimedSector {
                corner: sector.corner.as_vec2().to_array(),
                edge: sector.edge.as_vec2().to_array(),
                start: sector.start as f32,
                // Finite also where there is nothing to choose.
                inverse_share: sector.inverse_share.min(f64::from(f32::MAX)) as f32,
                begin,
                rest: 1.0 - begin,
            };
        }
        all
    }

    /// The sector that `u` chooses, of part number `part` of the area.
    #[inline]
    fn choose(&self, u: f32, part: u8) -> &AimedSector {
        let mut i = usize::from(self.guide[usize::from(part)]);
        // Nearly always that or the next: without a jump that nobody can foresee.
        i += usize::from(self.slices[i + 1].start <= u);
        while self.slices[i + 1].start <= u {
            i += 1;
        }
        &self.slices[i]
    }
}

/// `N` of [`super::PupilSample`], by their components.
#[derive(Clone, Copy, Debug)]
pub struct PupilSamples<const N: usize> {
    /// x and y in lens space, mm.
    pub target: [[f32; N]; 2],
    /// Densities with which the samples were chosen, per mm² of the reference plane.
    pub pdf_per_mm2: [f32; N],
}

impl PupilMap {
    /// [`Self::sample`] for each of `N` film points (x, y and z, mm) and two numbers for each, in single precision.
    #[inline]
    pub fn samples<const N: usize>(&self, film: &[[f32; N]; 3], u: &[[f32; N]; 2]) -> PupilSamples<N> {
        const { assert!(N > 0 && N <= 32) };
        let mut all = PupilSamples { target: [[0.0; N]; 2], pdf_per_mm2: [0.0; N] };
        let mut alone =
            if self.is_plain { self.samples_on_plain_film(film, u, &mut all) } else { u32::MAX >> (32 - N) };
        while alone != 0 {
            let i = alone.trailing_zeros() as usize;
            let point = DVec3::new(film[0][i].into(), film[1][i].into(), film[2][i].into());
            let one = self.sample(point, [u[0][i].into(), u[1][i].into()]);
            (all.target[0][i], all.target[1][i]) = (one.target.x as f32, one.target.y as f32);
            all.pdf_per_mm2[i] = one.pdf_per_mm2 as f32;
            alone &= alone - 1;
        }
        all
    }

    /// All but those that are returned as bits: they go anywhere on the glass.
    #[inline]
    fn samples_on_plain_film<const N: usize>(
        &self,
        film: &[[f32; N]; 3],
        u: &[[f32; N]; 2],
        all: &mut PupilSamples<N>,
    ) -> u32 {
        let (share, of_rest) = (DEFENSIVE_SHARE as f32, (1.0 / (1.0 - DEFENSIVE_SHARE)) as f32);
        let (cells_per_mm, last) = (self.radius.cells_per_unit as f32, (self.radius.cells - 1) as f32);
        let [mut cell, mut rest, mut cosine, mut sine, mut within] = [[0.0f32; N]; 5];
        let (mut part, mut number) = ([0u8; N], [0u32; N]);
        for i in 0..N {
            let (x, y) = (film[0][i], film[1][i]);
            let radius = (x * x + y * y).sqrt();
            let inverse = radius.max(f32::MIN_POSITIVE).recip();
            (cosine[i], sine[i]) = (if radius > 0.0 { x * inverse } else { 1.0 }, y * inverse);
            let place = radius * cells_per_mm;
            cell[i] = place.min(last).max(0.0).trunc();
            rest[i] = place - cell[i];
            within[i] = (u[0][i] - share) * of_rest;
            // Never a later one: where it lies on a border, this or the one before.
            part[i] = ((within[i] * GUIDE as f32).clamp(0.5, (GUIDE - 1) as f32) + (WHOLE - 0.5)).to_bits() as u8;
            number[i] = (cell[i] + WHOLE).to_bits() & !WHOLE.to_bits();
        }
        let here = Spots::of(&self.spots, &cell);
        // Of the sector: the point of its edge, and its inner end.
        let [mut ex, mut ey, mut begin, mut to_edge] = [[0.0f32; N]; 4];
        let mut alone = 0;
        for i in 0..N {
            if within[i] < 0.0 || here.density[i] == 0.0 {
                alone |= 1 << i;
                continue;
            }
            let slice = self.slices[number[i] as usize].choose(within[i], part[i]);
            let across = ((within[i] - slice.start) * slice.inverse_share).min(1.0);
            ex[i] = slice.corner[0] + slice.edge[0] * across;
            ey[i] = slice.corner[1] + slice.edge[1] * across;
            (begin[i], to_edge[i]) = (slice.begin, slice.rest);
        }
        let glass_squared = (self.glass_radius * self.glass_radius) as f32;
        let glass_density = (DEFENSIVE_SHARE * self.glass_density) as f32;
        for i in 0..N {
            let between = rest[i].clamp(0.0, 1.0);
            let semi_along = here.semi_along[i] + here.semi_along_growth[i] * between;
            let semi_across = here.semi_across[i] + here.semi_across_growth[i] * between;
            let out = (begin[i] + u[1][i] * to_edge[i]).sqrt();
            let along = ex[i] * out * semi_along + (here.along[i] + here.along_way[i] * rest[i]);
            let across = ey[i] * out * semi_across + (here.across[i] + here.across_way[i] * rest[i]);
            let (x, y) = (cosine[i] * along - sine[i] * across, sine[i] * along + cosine[i] * across);
            let anywhere = if x * x + y * y <= glass_squared { glass_density } else { 0.0 };
            (all.target[0][i], all.target[1][i]) = (x, y);
            all.pdf_per_mm2[i] = here.density[i] / (semi_along * semi_across) + anywhere;
        }
        alone
    }
}

#[cfg(test)]
mod tests {
    use super::super::cases::{ROUNDS, for_each_map, part, place};

    /// Several in single precision are those alone but for roundings, for plain maps and others.
    #[test]
    fn together_as_alone() {
        for_each_map(|map, film, which| {
            let (mut same, mut other) = (0, 0);
            for round in 0..ROUNDS {
                let part = |i: usize, by: f64| part(round, i, by);
                let places: [glam::Vec3; 8] = std::array::from_fn(|i| place(film, [part(i, 0.618), part(i, 0.755)]));
                let films = [0, 1, 2].map(|axis| places.map(|p| p[axis]));
                let u = [0.3137, 0.4729].map(|by| std::array::from_fn(|i| part(i, by)));
                let samples = map.samples(&films, &u);
                for i in 0..8 {
                    let one = map.sample(places[i].as_dvec3(), [u[0][i].into(), u[1][i].into()]);
                    let away = [0, 1].map(|axis| f64::from(samples.target[axis][i]) - one.target[axis]);
                    let by = f64::from(samples.pdf_per_mm2[i]) / one.pdf_per_mm2 - 1.0;
                    // 24 bits of the choice along the edge of a sector, a hundredth of the whole; on the border of two
                    // cells, or of the glass, rounding decides.
                    let is_near = away[0].hypot(away[1]) < 3e-5 * map.glass_radius_mm() && by.abs() < 2e-6;
                    if is_near { same += 1 } else { other += 1 }
                }
            }
            assert!(other * 3000 < same, "{which}: {same} {other}");
        });
    }
}
