//! YAML and JSON as a tree whose every value knows its place.

use super::problem::{CalibrationProblem, Placed, malformed};
use crate::prescription::Place;
use saphyr_parser::{Event, Marker, Parser};

/// Deeper files are no calibrations.
const DEEPEST: usize = 64;

/// A value, and its beginning in the file.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) place: Place,
    pub(super) value: Value,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Scalar(String),
    List(Vec<Node>),
    Map(Vec<(String, Node)>),
}

/// A list or mapping that is not yet closed.
struct Open {
    place: Place,
    value: Value,
    /// The key whose value comes next.
    key: Option<String>,
}

fn place(marker: &Marker) -> Place {
    Place { line: marker.line().max(1), column: marker.col() + 1 }
}

/// The first document of a text.
pub(super) fn parse(text: &str) -> Result<Node, Placed> {
    // OpenCV's first line is no directive that YAML knows; of the same length, so that places stay.
    let text = match text.strip_prefix("%YAML:1.0") {
        Some(rest) => format!("#YAML:1.0{rest}"),
        None => text.to_owned(),
    };
    let mut open: Vec<Open> = Vec::new();
    let mut last = Place { line: 1, column: 1 };
    for event in Parser::new_from_str(&text) {
        let (event, span) =
            event.map_err(|error| (place(error.marker()), CalibrationProblem::Syntax(error.info().to_owned())))?;
        last = place(&span.start);
        let done = match event {
            Event::Scalar(text, ..) => Node { place: last, value: Value::Scalar(text.into_owned()) },
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if open.len() >= DEEPEST {
                    return Err((last, CalibrationProblem::Syntax("it is nested too deeply".to_owned())));
                }
                let is_list = matches!(event, Event::SequenceStart(..));
                let value = if is_list { Value::List(Vec::new()) } else { Value::Map(Vec::new()) };
                open.push(Open { place: last, value, key: None });
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(one) => Node { place: one.place, value: one.value },
                None => continue,
            },
            Event::Alias(_) => {
                let what = "an alias (*) stands here; write the value itself";
                return Err((last, CalibrationProblem::Unsupported(what.to_owned())));
            }
            _ => continue,
        };
        let Some(into) = open.last_mut() else { return Ok(done) };
        match &mut into.value {
            Value::List(list) => list.push(done),
            Value::Map(map) => match (into.key.take(), done) {
                (Some(key), value) => map.push((key, value)),
                (None, Node { value: Value::Scalar(key), .. }) => into.key = Some(key),
                (None, other) => return Err(malformed(other.place, "a list", "a key")),
            },
            Value::Scalar(_) => {}
        }
    }
    Err((last, CalibrationProblem::NoCamera))
}

impl Node {
    /// The value of a key of a mapping.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        self.entries().iter().find(|(known, _)| known == key).map(|(_, node)| node)
    }

    /// The value of the first of several keys that is there.
    pub(super) fn any(&self, keys: &[&str]) -> Option<&Self> {
        keys.iter().find_map(|key| self.get(key))
    }

    /// The keys and values of a mapping, in order; of something else none.
    pub(super) fn entries(&self) -> &[(String, Self)] {
        match &self.value {
            Value::Map(map) => map,
            _ => &[],
        }
    }

    /// The items of a list; of something else none.
    pub(super) fn items(&self) -> &[Self] {
        match &self.value {
            Value::List(list) => list,
            _ => &[],
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Scalar(text) => Some(text),
            _ => None,
        }
    }

    /// The node's content, for a message.
    pub(super) fn shown(&self) -> &str {
        match &self.value {
            Value::Scalar(text) => text,
            Value::List(_) => "a list",
            Value::Map(_) => "a mapping",
        }
    }

    pub(super) fn number(&self) -> Result<f64, Placed> {
        number(self.text().unwrap_or_default()).ok_or_else(|| malformed(self.place, self.shown(), "a number"))
    }

    /// A side of a picture in pixels.
    pub(super) fn pixels(&self) -> Result<u32, Placed> {
        let value = self.number()?;
        let is_count = value.fract() == 0.0 && (1.0..=1e6).contains(&value);
        if is_count { Ok(value as u32) } else { Err(malformed(self.place, self.shown(), "a number of pixels")) }
    }

    /// The numbers of a list, of a list of lists row by row, of a text, or of the mapping that OpenCV and ROS write for a matrix.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, Placed> {
        match &self.value {
            Value::Map(_) => match self.get("data") {
                Some(data) => {
                    let all = data.numbers()?;
                    // What is broken off or edited by hand.
                    if let (Some(rows), Some(cols)) = (self.get("rows"), self.get("cols")) {
                        let count = rows.number()? * cols.number()?;
                        if count != all.len() as f64 {
                            let expected = format!("{} x {}", rows.shown(), cols.shown());
                            return Err((data.place, CalibrationProblem::Count { found: all.len(), expected }));
                        }
                    }
                    Ok(all)
                }
                None => Err(malformed(self.place, "a mapping without data", "a list of numbers")),
            },
            Value::List(list) => {
                let mut all = Vec::new();
                for one in list {
                    match &one.value {
                        Value::Scalar(_) => all.push(one.number()?),
                        _ => all.extend(one.numbers()?),
                    }
                }
                Ok(all)
            }
            // A key without a value, as where a file is broken off.
            Value::Scalar(text) if text.trim().is_empty() => Err(malformed(self.place, "nothing", "a list of numbers")),
            Value::Scalar(text) => {
                let all: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
                all.ok_or_else(|| malformed(self.place, text, "numbers"))
            }
        }
    }

    /// The numbers of the node; an error if their count is none of `counts`.
    pub(super) fn counted(&self, counts: &[usize]) -> Result<Vec<f64>, Placed> {
        let all = self.numbers()?;
        if counts.contains(&all.len()) {
            return Ok(all);
        }
        let expected = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let expected = if counts.len() > 1 { format!("one of {expected}") } else { expected };
        Err((self.place, CalibrationProblem::Count { found: all.len(), expected }))
    }
}

/// A finite number; OpenCV writes `1.` for 1.
pub(super) fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite())
}
