//! Tables as comma-separated values.

use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// Where a table goes.
pub(crate) enum Csv {
    Stdout,
    File(Output),
}

impl Csv {
    /// Makes sure that the table can be written; `-` is stdout, which JSON must not be on as well.
    pub(crate) fn open(place: &Path, inputs: &[&Path], console: &Console) -> Result<Self, Failure> {
        if place != Path::new("-") {
            return Ok(Self::File(Output::open(place, inputs)?));
        }
        if console.is_json() {
            return Err(Failure::Input(
                "--csv - and --json cannot both go to stdout; name a file for --csv".to_owned(),
            ));
        }
        Ok(Self::Stdout)
    }
}

/// A header with the names of the fields, and a line for each row; what is not known is empty.
pub(crate) fn table(rows: &[impl Serialize]) -> Result<Vec<u8>, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::Internal(format!("no table can be made: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (i, row) in rows.iter().enumerate() {
        let value = serde_json::to_value(row).map_err(|e| failed(&e))?;
        let fields = value.as_object().ok_or_else(|| failed(&"a row has no fields"))?;
        if i == 0 {
            writer.write_record(fields.keys()).map_err(|e| failed(&e))?;
        }
        writer.write_record(fields.values().map(cell)).map_err(|e| failed(&e))?;
    }
    writer.into_inner().map_err(|e| failed(&e))
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
