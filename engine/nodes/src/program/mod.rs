//! A compiled graph: instructions over registers, and the layers of the surface whose inputs they compute.

mod evaluate;
mod instruction;
mod lanes;
mod layer;
mod slice;

pub use instruction::Operand;
pub(crate) use instruction::{FIRST_CONSTANT, Instruction, MOST_OPERANDS, Operation};
pub use lanes::LaneRegisters;
pub use layer::{Layer, LayerKind};
pub use slice::Slice;

use crate::context::{Attribute, Context, Field, Textures};
use crate::ies::Ies;
use crate::sky::{Sky, SunDisc};
use crate::table::Table;
use glam::{Affine3A, Vec3A};

/// Number of values that a program may hold at once.
pub(crate) const REGISTERS: usize = 256;

/// Working memory of programs: make one a thread, and run any program in it.
pub struct Registers {
    values: [Vec3A; REGISTERS],
    /// Further results of the last instruction that has any.
    further: [Vec3A; 3],
}

impl Registers {
    /// The results of an instruction with result 0.
    pub(crate) fn results(&self) -> (Vec3A, [Vec3A; 3]) {
        (self.values[0], self.further)
    }
}

impl Default for Registers {
    fn default() -> Self {
        Self { values: [Vec3A::ZERO; REGISTERS], further: [Vec3A::ZERO; 3] }
    }
}

/// A material's graph, ready to run.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The closures of the surface, which add up.
    pub surface: Vec<Layer>,
    /// The closures of the volume, which add up.
    pub volume: Vec<Layer>,
    /// The displacement of the surface, in world space.
    pub displacement: Option<Operand>,
    /// The attributes that the program reads, by their place here.
    pub attributes: Vec<Attribute>,
    pub(crate) code: Vec<Instruction>,
    pub(crate) constants: Vec<Vec3A>,
    pub(crate) tables: Vec<Table>,
    pub(crate) maps: Vec<Affine3A>,
    pub(crate) skies: Vec<Sky>,
    pub(crate) luminaires: Vec<Ies>,
}

impl Program {
    /// Computes everything that the layers need at a point. Nothing is allocated.
    pub fn run<C: Context, T: Textures>(&self, context: &C, textures: &T, registers: &mut Registers) {
        for instruction in &self.code {
            self.step(instruction, context, textures, registers);
        }
    }

    /// The value of an operand, after [`run`](Self::run). A number stands in all three parts.
    #[inline]
    pub fn value(&self, operand: Operand, registers: &Registers) -> Vec3A {
        if operand.0 < FIRST_CONSTANT {
            registers.values[usize::from(operand.0 as u8)]
        } else {
            self.constants[usize::from(operand.0 - FIRST_CONSTANT)]
        }
    }

    /// The value of an operand that is spatially constant.
    pub fn constant(&self, operand: Operand) -> Option<Vec3A> {
        (operand.0 >= FIRST_CONSTANT).then(|| self.constants[usize::from(operand.0 - FIRST_CONSTANT)])
    }

    /// The fields of the point that it reads.
    pub fn reads(&self) -> impl Iterator<Item = Field> + '_ {
        self.code.iter().filter_map(|instruction| instruction.operation.read_field())
    }

    /// The suns that the program's skies show.
    pub fn suns(&self) -> impl Iterator<Item = SunDisc> + '_ {
        self.skies.iter().filter_map(Sky::sun)
    }

    /// Number of instructions of a run.
    pub fn instructions(&self) -> usize {
        self.code.len()
    }
}
