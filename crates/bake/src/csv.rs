//! Tables of comma-separated values.

use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// Destination of a table.
pub(crate) enum Csv {
    Stdout,
    File(Output),
}

impl Csv {
    /// Checks that the table can be written to `path`, or to stdout for `-`. Fails if JSON goes to stdout as well.
    pub(crate) fn open(path: &Path, inputs: &[&Path], console: &Console) -> Result<Self, Failure> {
        let output = Output::open(path, inputs)?;
        if !output.is_stdout() {
            return Ok(Self::File(output));
        }
        if console.is_json() {
            return Err(Failure::Input(
                "--csv - and --json cannot both go to stdout; name a file for --csv".to_owned(),
            ));
        }
        Ok(Self::Stdout)
    }
}

/// Formats rows as a table: a header with the names of the fields, and a line for each row. Unknown values are empty.
pub(crate) fn table(rows: &[impl Serialize]) -> Result<Vec<u8>, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::Internal(format!("cannot write the table: {e}"));
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

/// Formats a value as a cell.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
