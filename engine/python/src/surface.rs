//! Single surfaces for `petzval surface`.

use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::questions::{scaled, unknown_key};
use glam::DVec3;
use petzval_optics::single_surface::{Outcome, SingleSurface};
use petzval_optics::surface::{Conic, LAST_POWER, Shape};
use pyo3::prelude::*;
use serde_json::{Value, json};

/// A ray and the surface that it is to hit.
struct Case {
    id: Value,
    surface: SingleSurface,
    origin: DVec3,
    direction: DVec3,
}

/// The keys of a case, and those of its surface.
const KEYS: [&str; 7] = ["id", "surface", "side", "n1", "n2", "origin", "direction"];
const SURFACE_KEYS: [&str; 7] = ["radius", "k", "semi_diameter", "mirror", "obstruction", "terms", "radius_x"];
/// Keys of a case, and of the whole, by which a file of known answers may say more to who keeps it.
const NOTES: [&str; 4] = ["category", "note", "expect", "ulp_sensitivity"];
const NOTES_OF_ALL: [&str; 3] = ["note", "count", "status_counts"];

/// The input and output of `petzval surface trace`.
#[pyfunction]
#[pyo3(signature = (cases_json, *, precision = "f64"))]
pub(crate) fn trace_surfaces_json(py: Python<'_>, cases_json: &str, precision: &str) -> Result<String, Error> {
    let trace: fn(&Case) -> Option<Outcome> = match precision {
        "f64" => |case| Some(case.surface.trace::<f64>(case.origin, case.direction)),
        "f32" => |case| Some(case.surface.trace::<f32>(case.origin, case.direction)),
        "printed" => |case| case.surface.trace_as_printed(case.origin, case.direction),
        _ => return Err(invalid(format!("precision {precision}: there is no such; give f64, f32 or printed"))),
    };
    let document: Value =
        serde_json::from_str(cases_json).map_err(|e| invalid(format!("the cases are not JSON: {e}")))?;
    if let Some(complaint) = unknown_key(&document, &["cases"], &NOTES_OF_ALL) {
        return Err(invalid(format!("the cases' JSON: {complaint}; see `petzval surface trace --help`")));
    }
    let cases = document["cases"]
        .as_array()
        .ok_or_else(|| invalid("the cases' JSON has no list \"cases\"; see `petzval surface trace --help`"))?
        .iter()
        .enumerate()
        .map(|(i, case)| Reader::new(i, case).case())
        .collect::<Result<Vec<_>, Error>>()?;
    let outcomes = without_gil(py, || cases.iter().map(trace).collect::<Vec<_>>())?;
    let answers = cases.iter().zip(outcomes).map(|(case, outcome)| {
        let outcome = outcome.ok_or_else(|| {
            let id = words(&case.id);
            invalid(format!(
                "case {id}: the paper prints no equations for \"terms\" or \"radius_x\"; trace it with f64"
            ))
        })?;
        Ok(answer(&case.id, &outcome))
    });
    Ok(json!({ "cases": answers.collect::<Result<Vec<_>, Error>>()? }).to_string())
}

fn words(id: &Value) -> String {
    id.as_str().map_or_else(|| id.to_string(), str::to_owned)
}

fn answer(id: &Value, outcome: &Outcome) -> Value {
    let (status, direction) = match outcome.direction {
        Ok(direction) => ("ok", Some(direction.to_array())),
        Err(reason) => (reason.name(), None),
    };
    json!({
        "id": id,
        "status": status,
        "t": outcome.hit.map(|hit| hit.t_mm),
        "point": outcome.hit.map(|hit| hit.point.to_array()),
        "normal": outcome.hit.map(|hit| hit.normal.to_array()),
        "direction": direction,
    })
}

/// Reads one case, and says which field of which case is wrong.
struct Reader<'a> {
    id: Value,
    case: &'a Value,
}

impl<'a> Reader<'a> {
    fn new(index: usize, case: &'a Value) -> Self {
        let id = if case["id"].is_null() { json!(index) } else { case["id"].clone() };
        Self { id, case }
    }

    fn case(self) -> Result<Case, Error> {
        self.check_keys(self.case, "", &KEYS, &NOTES)?;
        self.check_keys(&self.case["surface"], "surface.", &SURFACE_KEYS, &[])?;
        let surface = self.surface()?;
        let (origin, direction) = (self.vector("origin")?, self.vector("direction")?);
        let direction = scaled(direction).ok_or_else(|| self.wrong("direction", "has no length"))?;
        Ok(Case { id: self.id, surface, origin, direction })
    }

    fn check_keys(&self, value: &Value, within: &str, keys: &[&str], notes: &[&str]) -> Result<(), Error> {
        unknown_key(value, keys, notes).map_or(Ok(()), |complaint| {
            let id = words(&self.id);
            Err(invalid(format!("case {id}: {within}{complaint}; see `petzval surface trace --help`")))
        })
    }

    fn surface(&self) -> Result<SingleSurface, Error> {
        let is_mirror = match &self.case["surface"]["mirror"] {
            Value::Null => false,
            value => value.as_bool().ok_or_else(|| self.wrong("surface.mirror", "is neither true nor false"))?,
        };
        let side = self.number_or("side", 1.0)?;
        if side.abs() != 1.0 {
            return Err(self.wrong("side", "is neither 1 nor -1"));
        }
        let from = self.positive("n1", None)?;
        let to = self.positive("n2", is_mirror.then_some(from))?;
        let semi_diameter_mm = self.positive("surface.semi_diameter", Some(f64::INFINITY))?;
        let obstruction_mm = self.number_or("surface.obstruction", 0.0)?;
        if obstruction_mm < 0.0 {
            return Err(self.wrong("surface.obstruction", "is below 0"));
        }
        let shape = self.shape()?;
        Ok(SingleSurface { shape, side, from, to, is_mirror, semi_diameter_mm, obstruction_mm })
    }

    fn shape(&self) -> Result<Shape, Error> {
        let base = Conic::new(self.number("surface.radius")?, self.number_or("surface.k", 0.0)?);
        let terms = self.terms()?;
        let radius_x = self.present("surface.radius_x").map(|_| self.number("surface.radius_x")).transpose()?;
        let shape = Shape::from_numbers(base, &terms, radius_x);
        if shape.is_finite() { Ok(shape) } else { Err(self.wrong("surface.radius", "is too small")) }
    }

    /// Pairs of power and coefficient.
    fn terms(&self) -> Result<Vec<(u32, f64)>, Error> {
        let key = "surface.terms";
        let Some(list) = self.present(key) else { return Ok(Vec::new()) };
        let term = |pair: &Value| {
            let [power, coefficient] = pair.as_array()?.as_slice() else { return None };
            let power = u32::try_from(power.as_u64()?).ok().filter(|p| (2..=LAST_POWER).contains(p))?;
            Some((power, number(coefficient)?))
        };
        let terms = list.as_array().and_then(|list| list.iter().map(term).collect());
        terms.ok_or_else(|| self.wrong(key, &format!("is no list of [power from 2 to {LAST_POWER}, coefficient]")))
    }

    /// The value at `key`, which may be a key within `surface`; `None` if there is none.
    fn present(&self, key: &str) -> Option<&'a Value> {
        let value = key.split('.').fold(self.case, |value, part| &value[part]);
        (!value.is_null()).then_some(value)
    }

    fn number(&self, key: &str) -> Result<f64, Error> {
        self.present(key).and_then(number).ok_or_else(|| self.wrong(key, "is no finite number"))
    }

    fn number_or(&self, key: &str, missing: f64) -> Result<f64, Error> {
        if self.present(key).is_some() { self.number(key) } else { Ok(missing) }
    }

    fn positive(&self, key: &str, missing: Option<f64>) -> Result<f64, Error> {
        let value = match missing {
            Some(missing) => self.number_or(key, missing)?,
            None => self.number(key)?,
        };
        if value > 0.0 { Ok(value) } else { Err(self.wrong(key, "is not above 0")) }
    }

    fn vector(&self, key: &str) -> Result<DVec3, Error> {
        let list = self.present(key).and_then(Value::as_array).filter(|list| list.len() == 3);
        let numbers: Option<Vec<f64>> = list.and_then(|list| list.iter().map(number).collect());
        numbers.map(|v| DVec3::from_slice(&v)).ok_or_else(|| self.wrong(key, "is not three finite numbers"))
    }

    fn wrong(&self, key: &str, what: &str) -> Error {
        let id = words(&self.id);
        invalid(format!("case {id}: \"{key}\" {what}; see `petzval surface trace --help`"))
    }
}

/// A number, or the decimal digits of one.
fn number(value: &Value) -> Option<f64> {
    let number = match value {
        Value::String(text) => text.trim().parse().ok(),
        other => other.as_f64(),
    };
    number.filter(|x| x.is_finite())
}
