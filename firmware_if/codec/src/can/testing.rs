//! What the tests of this module share: golden files, and frames as candump writes them.

use drover_contract::{CanFrame, CanId};
use serde_json::Value;

/// A golden file of `tests/golden/can`.
pub(crate) fn golden(name: &str) -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/can/");
    let text = std::fs::read_to_string(format!("{path}{name}")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The entries of a list in a golden file.
pub(crate) fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap()
}

/// A frame out of `111#0096`: three digits of identifier are a standard one, eight an extended one.
pub(crate) fn frame(text: &str) -> CanFrame {
    let (id, data) = text.split_once('#').unwrap();
    let raw = u32::from_str_radix(id, 16).unwrap();
    let id = if id.len() == 3 { CanId::Standard(raw as u16) } else { CanId::Extended(raw) };
    let bytes = (0..data.len()).step_by(2).map(|at| u8::from_str_radix(&data[at..at + 2], 16).unwrap());
    CanFrame::new(id, &bytes.collect::<Vec<u8>>()).unwrap()
}

/// The frames of a golden row.
pub(crate) fn frames(row: &Value) -> Vec<CanFrame> {
    list(row, "frames").iter().map(|text| frame(text.as_str().unwrap())).collect()
}
