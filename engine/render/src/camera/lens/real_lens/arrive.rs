//! The wavelengths of a packet at a flat film, all at once in single precision.
//!
//! The wavelengths that do not lead come from rays of single precision: their places are good to some 1e-6 of the
//! lens's size, far less than a pixel, and so are their densities.

use super::super::mount::Mount;
use super::packet::{HeroSample, Request, Splats};
use super::{FilmLine, LensSample, RealLens};
use crate::sampler::raster::Raster;
use glam::DVec3;
use petzval_optics::trace::{LINES, Leaving};
use wide::f32x8;

// A register for a packet.
const _: () = assert!(LINES == 8);

/// The film and its lines, in single precision, for rays that leave the lens.
pub(in crate::camera) struct ShortFilm {
    /// Right, up, and away from the scene, with where the picture's middle lies along them, mm from the last vertex.
    axes: [([f32; 3], f32); 3],
    /// Fractions of the picture in a millimetre.
    per_mm: [f32; 2],
    /// The last vertex, lens space.
    vertex_z_mm: f32,
    /// The sets of lines.
    sets: Vec<Set>,
}

/// The data of each line of a set.
struct Set {
    /// One over the index squared of the medium before the film.
    per_etendue: [f32; LINES],
    gain: [f32; LINES],
    /// 1, or 0 for those that only fill the packet up.
    is_one: [f32; LINES],
}

impl ShortFilm {
    /// The film of a mount and the data of its lines; `None` if the film is curved.
    pub(in crate::camera) fn new(
        mount: &Mount,
        vertex_z_mm: f64,
        lines: &[FilmLine],
        sets: usize,
        size: usize,
    ) -> Option<Self> {
        let (axes, middle) = mount.frame.flat()?;
        let from_vertex = middle - DVec3::new(0.0, 0.0, vertex_z_mm);
        let info = &mount.info;
        let set = |set: usize| {
            let line = |i: usize| &lines[set + i.min(size - 1) * sets];
            Set {
                per_etendue: std::array::from_fn(|i| line(i).index_squared.recip() as f32),
                gain: std::array::from_fn(|i| line(i).gain as f32),
                is_one: std::array::from_fn(|i| if i < size { 1.0 } else { 0.0 }),
            }
        };
        let axis = |axis: DVec3| (axis.as_vec3().to_array(), axis.dot(from_vertex) as f32);
        Some(Self {
            axes: [axis(axes.x_axis), axis(axes.y_axis), axis(axes.z_axis)],
            // The picture on the film is turned by half a turn.
            per_mm: [info.picture_width_mm, info.picture_height_mm].map(|side| -side.recip() as f32),
            vertex_z_mm: vertex_z_mm as f32,
            sets: (0..sets).map(set).collect(),
        })
    }
}

/// The numbers of a register whose bits are set.
#[inline(always)]
fn those(bits: u32) -> f32x8 {
    let mut numbers = [0.0; LINES];
    for (i, number) in numbers.iter_mut().enumerate() {
        *number = (bits >> i & 1) as f32;
    }
    f32x8::new(numbers).simd_gt(f32x8::ZERO)
}

#[inline(always)]
fn dot(axis: &[f32; 3], [x, y, z]: [f32x8; 3]) -> f32x8 {
    x * axis[0] + y * axis[1] + z * axis[2]
}

impl RealLens {
    /// The result of a ray that one wavelength led to, when all wavelengths of its set have left the lens on their way
    /// back; as [`Self::joined`] has it.
    pub(in crate::camera) fn joined_in_short(
        &self,
        film: &ShortFilm,
        request: &Request,
        lead: &LensSample,
        leaving: &Leaving<'_, f32>,
        raster: &Raster,
    ) -> HeroSample {
        let (set, leader) = self.leader(request.u_wavelength);
        let lines = &film.sets[set];
        let [x, y, z, dx, dy, dz] = leaving.numbers;
        let (p, d) =
            ([f32x8::new(*x), f32x8::new(*y), f32x8::new(*z)], [f32x8::new(*dx), f32x8::new(*dy), f32x8::new(*dz)]);
        let is_leader = those(1 << leader);
        let [right, up, away] = &film.axes;
        let slope = dot(&away.0, d);
        let way = (f32x8::splat(away.1) - dot(&away.0, p)) / slope;
        let hit = [p[0] + d[0] * way, p[1] + d[1] * way, p[2] + d[2] * way];
        let is_there = (those(leaving.through()) & way.simd_gt(f32x8::ZERO)) | is_leader;
        // The leader's own place is known without the rounding of the way back; who is lost is nowhere.
        let place = |axis: &([f32; 3], f32), per_mm: f32, own: f32| {
            let own = f32x8::splat(own);
            is_leader.bitselect(own, is_there.bitselect((dot(&axis.0, hit) - axis.1) * per_mm, own))
        };
        let place = [
            place(right, film.per_mm[0], request.place.x).to_array(),
            place(up, film.per_mm[1], request.place.y).to_array(),
        ];
        let landings = raster.land_many(&place, request.pixel_numbers(raster));
        // The reference plane of the pupil's map touches the last vertex.
        let to_vertex = p[2] / d[2];
        let target = [(p[0] - d[0] * to_vertex).to_array(), (p[1] - d[1] * to_vertex).to_array()];
        let film_point = [hit[0].to_array(), hit[1].to_array(), (hit[2] + film.vertex_z_mm).to_array()];
        let pdf = f32x8::new(self.map.pdfs(&film_point, &target));
        let to_plane = way + to_vertex;
        let lead_density = pdf * (to_plane * to_plane) / (slope * d[2]).abs();
        let lead_density = is_leader.bitselect(f32x8::splat(lead.density as f32), lead_density);
        let samples = f32x8::new(landings.density) * f32x8::new(lines.per_etendue) * f32x8::new(lines.is_one);
        let samples = is_there.bitselect(samples, f32x8::ZERO);
        let is_lit = samples.simd_gt(f32x8::ZERO);
        let density = is_lit.bitselect(samples * lead_density, f32x8::ZERO).reduce_add();
        let mut weights = samples * f32x8::new(lines.gain) * density.recip();
        if let Some(lost) = &self.transmission {
            // Towards the scene, as a ray from the film goes.
            let [across, up] = target.map(f32x8::new);
            let through = lost.at_set(set, [across, up, -d[0], -d[1]]);
            // The leader may have been lost on the way back, by rounding.
            weights *= is_leader.bitselect(f32x8::splat(lead.part), through);
        }
        let weights = weights.to_array();
        let mut splats = Splats::default();
        let sets = film.sets.len();
        let mut lit = is_lit.to_bitmask();
        while lit != 0 {
            let i = lit.trailing_zeros() as usize;
            let pixel = if i == leader { request.pixel } else { [landings.x[i], landings.y[i]] };
            splats.push_at(pixel, set + i * sets, weights[i]);
            lit &= lit - 1;
        }
        HeroSample { ray: self.mount.to_render(&lead.out), splats, set, density: f64::from(density) }
    }
}
