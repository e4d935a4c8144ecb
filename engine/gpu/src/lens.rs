// SPDX-License-Identifier: GPL-3.0-or-later
//! A lens laid out for a device: one way of travel, at one wavelength or several.

use petzval_optics::interface::Interface;
use petzval_optics::surface::{Asphere, LAST_POWER, Pose, Shape};
use petzval_optics::system::System;
use petzval_optics::trace::{Action, GradientNumbers, Step, Tracer, Travel};
use petzval_optics::vector::Vector;

use crate::error::GpuError;
use crate::number::Number;

/// The change of a ray's direction at a surface, by the numbers of surface.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bend {
    Refract = 0,
    Pass = 1,
    Reflect = 2,
}

/// The shape of a surface, by the numbers of bindings.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Conic = 0,
    Asphere = 1,
    Toroid = 2,
}

/// One surface on the way of the rays. Lengths in mm.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) form: Form,
    pub(crate) curvature: f64,
    pub(crate) conic: f64,
    pub(crate) across: f64,
    pub(crate) even: Vec<f64>,
    pub(crate) odd: Vec<f64>,
    pub(crate) to_here: f64,
    pub(crate) side: f64,
    pub(crate) clear_squared: f64,
    pub(crate) obstruction_squared: f64,
    /// The surface's axes x, y, z and its vertex; `None`: on the axis, upright.
    pub(crate) pose: Option<[[f64; 3]; 4]>,
    pub(crate) bend: Bend,
    pub(crate) is_stop: bool,
    pub(crate) is_far: bool,
    /// Index of the surface, counted from the scene.
    pub(crate) surface: usize,
    /// Ratio and excess of the interface by wavelength; beside a gradient the indices before and behind without it.
    pub(crate) interfaces: Vec<[f64; 2]>,
    /// The media before and behind the surface, where they are gradients.
    pub(crate) gradients: [Option<GradientNumbers>; 2],
}

/// The opening of the diaphragm, in mm: the numbers by which a device tests hits on the stop.
#[derive(Clone, Debug)]
pub(crate) struct Opening {
    pub(crate) radius_squared: f64,
    pub(crate) apothem: f64,
    pub(crate) bulge: f64,
    /// The arc of curved blades.
    pub(crate) slope: f64,
    pub(crate) bound: f64,
    pub(crate) sides: Vec<[f64; 2]>,
    pub(crate) mask: Option<MaskTexture>,
}

/// A picture whose bright part is the opening.
#[derive(Clone, Debug)]
pub(crate) struct MaskTexture {
    /// Number of values along each side.
    pub(crate) side: usize,
    /// Brightness less a half, rows from below.
    pub(crate) values: Vec<f32>,
    /// Cosine and sine of the mask's rotation, over the stop's radius in mm.
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

/// A lens for rays of one way of travel, at one wavelength or several, in the numbers that a device needs.
#[derive(Clone, Debug)]
pub struct LensTable {
    pub(crate) stages: Vec<Stage>,
    pub(crate) opening: Opening,
    pub(crate) travel: Travel,
    pub(crate) wavelengths: usize,
    /// The tracer of the first wavelength, by which rays enter and leave.
    pub(crate) tracer: Tracer,
}

/// The contents of `numbers` of bindings.wgsl.
struct NumberTable {
    all: Vec<f64>,
    places: Vec<Places>,
}

/// Offsets of the numbers of a stage in [`NumberTable`].
struct Places {
    terms: u32,
    pose: u32,
    fields: [u32; 2],
}

/// The buffers of a lens.
pub(crate) struct Buffers {
    pub(crate) steps: Vec<u8>,
    pub(crate) numbers: Vec<u8>,
    pub(crate) interfaces: Vec<u8>,
}

impl LensTable {
    /// The lens for rays that go `travel`, at vacuum wavelengths in nm, at least one. Rays name theirs by its number among these.
    pub fn new(system: &System, wavelengths_nm: &[f64], travel: Travel) -> Result<Self, GpuError> {
        let tracers: Vec<Tracer> = wavelengths_nm.iter().map(|&nm| system.at_wavelength(nm)).collect();
        let tracer = tracers.first().ok_or(GpuError::NoWavelength)?.clone();
        let diaphragm = system.diaphragm();
        let count = tracer.surface_count();
        let stages = (0..count).map(|i| {
            let steps: Vec<&Step> = tracers.iter().map(|tracer| &tracer.steps(travel)[i]).collect();
            let surface = if travel == Travel::FromScene { i } else { count - 1 - i };
            let mut stage = Stage::new(&steps, surface);
            let beside: Vec<_> = tracers.iter().filter_map(|tracer| tracer.gradients(travel, i)).collect();
            if let Some(first) = beside.first() {
                stage.interfaces = beside.iter().map(|beside| beside.indices).collect();
                stage.gradients = [first.before.clone(), first.behind.clone()];
            }
            stage
        });
        let (a, b, radius) = (diaphragm.apothem_mm(), diaphragm.bulge(), diaphragm.radius_mm());
        let (sin, cos) = diaphragm.rotation_rad().sin_cos();
        let mask = diaphragm.mask().map(|mask| MaskTexture {
            side: mask.side(),
            values: mask.values().to_vec(),
            cos: cos / radius,
            sin: sin / radius,
        });
        let opening = Opening {
            radius_squared: radius * radius,
            apothem: a,
            bulge: b,
            slope: 1.0 - 2.0 * a * b,
            bound: a + b * (radius * radius - 2.0 * a * a),
            sides: diaphragm.sides().to_vec(),
            mask,
        };
        Ok(Self { stages: stages.collect(), opening, travel, wavelengths: wavelengths_nm.len(), tracer })
    }

    /// Number of surfaces that a ray comes by.
    pub fn surface_count(&self) -> usize {
        self.stages.len()
    }

    /// Number of wavelengths that the lens was laid out for.
    pub fn wavelength_count(&self) -> usize {
        self.wavelengths
    }

    /// True if the index of some medium changes from place to place.
    pub fn has_gradients(&self) -> bool {
        self.stages.iter().any(Stage::is_beside_gradient)
    }

    /// The direction of the rays through the lens.
    pub fn travel(&self) -> Travel {
        self.travel
    }

    /// The numbers of the lens, and the offsets in them of the fields before and behind each stage; 0 without a field.
    fn numbers(&self) -> NumberTable {
        let Opening { radius_squared, apothem, bulge, slope, bound, ref sides, ref mask } = self.opening;
        let mut all = vec![radius_squared, apothem * apothem, apothem, bulge, slope, bound];
        all.extend(sides.iter().flatten());
        if let Some(mask) = mask {
            all.extend([mask.cos, mask.sin]);
            all.extend(mask.values.iter().copied().map(f64::from));
        }
        let mut places = Vec::with_capacity(self.stages.len());
        for stage in &self.stages {
            let terms = all.len() as u32;
            all.extend(stage.even.iter().chain(&stage.odd));
            let pose = all.len() as u32;
            all.extend(stage.pose.iter().flatten().flatten());
            let fields = stage.gradients.each_ref().map(|gradient| {
                let Some(gradient) = gradient else { return 0 };
                let at = all.len() as u32;
                all.extend(field(gradient));
                at
            });
            places.push(Places { terms, pose, fields });
        }
        NumberTable { all, places }
    }

    /// Offsets of the fields of the gradients before and behind each stage.
    pub(crate) fn field_places(&self) -> Vec<[u32; 2]> {
        self.numbers().places.iter().map(|places| places.fields).collect()
    }

    /// The buffers with the structs of bindings.wgsl.
    pub(crate) fn buffers<N: Number>(&self) -> Buffers {
        let NumberTable { all, places } = self.numbers();
        let mut steps = Vec::new();
        let mut interfaces = Vec::new();
        for (stage, places) in self.stages.iter().zip(places) {
            let Places { terms, pose, fields } = places;
            interfaces.extend(stage.interfaces.iter().flatten().copied());
            let reals = [
                stage.curvature,
                stage.conic,
                stage.to_here,
                stage.side,
                stage.clear_squared,
                stage.obstruction_squared,
                stage.across,
            ];
            let flags = [stage.is_stop, stage.is_far, stage.pose.is_some(), stage.is_beside_gradient()];
            let flags = flags.iter().enumerate().fold(0, |bits, (i, &flag)| bits | u32::from(flag) << i);
            let words = [
                stage.form as u32,
                stage.bend as u32,
                flags,
                stage.surface as u32,
                terms,
                stage.even.len() as u32,
                stage.odd.len() as u32,
                pose,
                fields[0],
                fields[1],
            ];
            steps.extend(bytes::<N>(&reals));
            steps.extend_from_slice(bytemuck::cast_slice(&words));
            // Structs are as long as a multiple of their widest number.
            steps.resize(steps.len().next_multiple_of(size_of::<N>()), 0);
        }
        Buffers { steps, numbers: bytes::<N>(&all), interfaces: bytes::<N>(&interfaces) }
    }
}

impl Stage {
    /// The numbers of a step, from the same step at every wavelength.
    fn new(steps: &[&Step], surface: usize) -> Self {
        let step = steps[0];
        let (form, profile) = match step.shape {
            Shape::Conic(_) => (Form::Conic, step.shape.profile()),
            Shape::Asphere(asphere) => (Form::Asphere, asphere),
            Shape::Toroid(toroid) => (Form::Toroid, toroid.profile),
        };
        let across = if let Shape::Toroid(toroid) = step.shape { toroid.across } else { 0.0 };
        let [even, odd] = terms(&profile);
        // Two media may agree at one wavelength.
        let interfaces = steps.iter().map(|step| match step.action {
            Action::Refract(Interface { ratio, excess }) => [ratio, excess],
            Action::Pass | Action::Reflect => [1.0, 0.0],
        });
        let bend = match step.action {
            Action::Reflect => Bend::Reflect,
            _ if steps.iter().any(|step| matches!(step.action, Action::Refract(_))) => Bend::Refract,
            _ => Bend::Pass,
        };
        Self {
            form,
            curvature: profile.base.curvature,
            conic: profile.base.conic,
            across,
            even,
            odd,
            to_here: step.to_here,
            side: step.side,
            clear_squared: step.clear_squared,
            obstruction_squared: step.obstruction_squared,
            pose: step.pose.as_ref().map(axes),
            bend,
            is_stop: step.is_stop,
            is_far: step.is_far,
            surface,
            interfaces: interfaces.collect(),
            gradients: [None, None],
        }
    }

    pub(crate) fn is_beside_gradient(&self) -> bool {
        self.gradients.iter().any(Option::is_some)
    }
}

/// A gradient as field.wgsl reads it.
fn field(gradient: &GradientNumbers) -> Vec<f64> {
    let length = gradient.rows.iter().map(Vec::len).max().unwrap_or(0);
    let pose = gradient.pose.unwrap_or_else(Pose::identity);
    let mut numbers = vec![gradient.rows.len() as f64, length as f64, gradient.vertex_z, gradient.from];
    numbers.extend(axes(&pose).iter().flatten());
    numbers.extend([gradient.step, f64::from(gradient.most_steps)]);
    for row in &gradient.rows {
        numbers.extend((0..length).map(|i| row.get(i).copied().unwrap_or(0.0)));
    }
    numbers
}

/// The coefficients of even powers from 2 and of odd powers from 3, each to its last that is not 0.
fn terms(profile: &Asphere) -> [Vec<f64>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for (power, coefficient) in profile.terms() {
        debug_assert!(power <= LAST_POWER);
        let of_power = &mut found[power as usize % 2];
        of_power.resize(power as usize / 2, 0.0);
        of_power[power as usize / 2 - 1] = coefficient;
    }
    found
}

/// The axes of a surface, and its vertex, seen from its place on the axis.
fn axes(pose: &Pose) -> [[f64; 3]; 4] {
    let unit = |i: usize| Vector { x: f64::from(i == 0), y: f64::from(i == 1), z: f64::from(i == 2) };
    let column = |v: Vector<f64>| [v.x, v.y, v.z];
    let [x, y, z] = [0, 1, 2].map(|i| column(pose.direction_out(unit(i))));
    [x, y, z, column(pose.point_out(unit(3)))]
}

/// Numbers of the device's kind. A length that is infinite is the largest.
pub(crate) fn bytes<N: Number>(numbers: &[f64]) -> Vec<u8> {
    let number = |&x: &f64| if x == f64::INFINITY { N::LARGEST } else { N::from_f64(x) };
    let numbers: Vec<N> = numbers.iter().map(number).collect();
    bytemuck::cast_slice(&numbers).to_vec()
}
