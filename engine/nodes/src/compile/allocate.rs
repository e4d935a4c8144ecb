//! The last step: results that are not read are dropped, and virtual registers become few real ones.

use super::emit::FIRST_VIRTUAL;
use super::{Compiler, Report};
use crate::context::Raycast;
use crate::program::{FIRST_CONSTANT, Instruction, Layer, Operand, Operation, Program, REGISTERS};
use glam::Vec3A;

impl Compiler<'_> {
    pub(super) fn finish(
        mut self,
        mut surface: Vec<Layer>,
        mut volume: Vec<Layer>,
        mut displacement: Option<Operand>,
    ) -> (Program, Vec<Report>) {
        let ends = || ends(&surface, &volume, displacement.as_ref());
        let last_use = last_uses(&self.code, ends());
        match allocate(&mut self.code, &last_use) {
            Some(places) => {
                let settle = |operand: &mut Operand| {
                    if operand.0 >= FIRST_VIRTUAL {
                        *operand = Operand(u16::from(places[usize::from(operand.0 - FIRST_VIRTUAL)]));
                    }
                };
                for layer in surface.iter_mut().chain(&mut volume) {
                    settle(&mut layer.weight);
                    layer.inputs.iter_mut().for_each(|(_, operand)| settle(operand));
                }
                displacement.iter_mut().for_each(settle);
                (self.program.surface, self.program.volume) = (surface, volume);
                self.program.displacement = displacement;
                self.program.code = std::mem::take(&mut self.code);
                self.drop_constants();
                self.drop_attributes();
            }
            None => {
                let node = self.graph.surface.as_ref().map_or(0, |link| link.node);
                self.report(node, "the material holds too many values at once, it is black");
            }
        }
        (self.program, self.reports)
    }

    /// Constants that only folding needed.
    fn drop_constants(&mut self) {
        let program = &mut self.program;
        let mut kept: Vec<Vec3A> = Vec::new();
        let mut places = vec![None; program.constants.len()];
        let mut keep = |operand: &mut Operand| {
            if operand.0 >= FIRST_CONSTANT {
                let old = usize::from(operand.0 - FIRST_CONSTANT);
                let new = *places[old].get_or_insert_with(|| {
                    kept.push(program.constants[old]);
                    kept.len() - 1
                });
                *operand = Operand(FIRST_CONSTANT + new as u16);
            }
        };
        for instruction in &mut program.code {
            let count = usize::from(instruction.count);
            instruction.operands[..count].iter_mut().for_each(&mut keep);
        }
        for layer in program.surface.iter_mut().chain(&mut program.volume) {
            keep(&mut layer.weight);
            layer.inputs.iter_mut().for_each(|(_, operand)| keep(operand));
        }
        program.displacement.iter_mut().for_each(&mut keep);
        program.constants = kept;
    }
}

impl Compiler<'_> {
    /// Attributes that no instruction is left to read.
    fn drop_attributes(&mut self) {
        let program = &mut self.program;
        let mut kept = Vec::new();
        for instruction in &mut program.code {
            if let Operation::Attribute(index, _) | Operation::Raycast(Raycast { attribute: Some(index), .. }) =
                &mut instruction.operation
            {
                let attribute = &program.attributes[usize::from(*index)];
                let place = kept.iter().position(|other| other == attribute).unwrap_or_else(|| {
                    kept.push(attribute.clone());
                    kept.len() - 1
                });
                *index = place as u16;
            }
        }
        program.attributes = kept;
    }
}

/// Everything that the renderer reads after a run.
fn ends<'a>(
    surface: &'a [Layer],
    volume: &'a [Layer],
    displacement: Option<&'a Operand>,
) -> impl Iterator<Item = Operand> + 'a {
    let layers = surface.iter().chain(volume);
    layers
        .flat_map(|layer| std::iter::once(&layer.weight).chain(layer.inputs.iter().map(|(_, operand)| operand)))
        .chain(displacement)
        .copied()
}

/// The place, for each instruction, where its result is last read; none where it never is.
fn last_uses(code: &[Instruction], ends: impl Iterator<Item = Operand>) -> Vec<Option<usize>> {
    let mut last = vec![None; code.len()];
    for operand in ends.filter(|operand| operand.0 >= FIRST_VIRTUAL) {
        last[usize::from(operand.0 - FIRST_VIRTUAL)] = Some(code.len());
    }
    for place in (0..code.len()).rev() {
        if last[place].is_none() {
            continue;
        }
        for operand in code[place].operands().iter().filter(|operand| operand.0 >= FIRST_VIRTUAL) {
            last[usize::from(operand.0 - FIRST_VIRTUAL)].get_or_insert(place);
        }
    }
    last
}

/// Keeps the operations whose results are read, and gives each result the lowest free register. None where there are too few.
fn allocate(code: &mut Vec<Instruction>, last_use: &[Option<usize>]) -> Option<Vec<u8>> {
    let mut places = vec![0_u8; code.len()];
    let mut owner: Vec<Option<usize>> = Vec::new();
    let mut kept = Vec::with_capacity(code.len());
    for (number, mut instruction) in code.drain(..).enumerate() {
        let Some(end) = last_use[number] else { continue };
        let count = usize::from(instruction.count);
        for operand in &mut instruction.operands[..count] {
            if operand.0 >= FIRST_VIRTUAL {
                *operand = Operand(u16::from(places[usize::from(operand.0 - FIRST_VIRTUAL)]));
            }
        }
        // What is read here for the last time may be written over: operands are read first.
        owner.iter_mut().filter(|end| end.is_some_and(|end| end <= number)).for_each(|end| *end = None);
        let free = owner.iter().position(Option::is_none).unwrap_or_else(|| {
            owner.push(None);
            owner.len() - 1
        });
        if free >= REGISTERS {
            return None;
        }
        owner[free] = Some(end);
        places[number] = free as u8;
        instruction.result = free as u16;
        kept.push(instruction);
    }
    *code = kept;
    Some(places)
}
