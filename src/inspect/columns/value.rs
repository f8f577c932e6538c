//! Values of figures and settings, for programs and for people.

use serde::ser::{Serialize, Serializer};

/// What is shown for a value that is not defined.
pub const DASH: &str = "–";

/// One figure or setting of a tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Undefined, or not measured: `null`, shown as a dash.
    Missing,
    Text(String),
    Count(u64),
    Real(f64),
}

impl Value {
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Missing | Self::Text(_) => None,
            Self::Count(n) => Some(*n as f64),
            Self::Real(x) => Some(*x),
        }
    }

    /// The value for programs: all digits, nothing for a missing one.
    pub fn plain(&self) -> String {
        match self {
            Self::Missing => String::new(),
            Self::Text(text) => text.clone(),
            Self::Count(n) => n.to_string(),
            Self::Real(x) => x.to_string(),
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Missing => serializer.serialize_none(),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Count(n) => serializer.serialize_u64(*n),
            Self::Real(x) => serializer.serialize_f64(*x),
        }
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<usize> for Value {
    fn from(n: usize) -> Self {
        Self::Count(n as u64)
    }
}

impl From<Option<u32>> for Value {
    fn from(n: Option<u32>) -> Self {
        n.map_or(Self::Missing, |n| Self::Count(u64::from(n)))
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        if x.is_finite() { Self::Real(x) } else { Self::Missing }
    }
}

impl From<Option<f64>> for Value {
    fn from(x: Option<f64>) -> Self {
        x.map_or(Self::Missing, Self::from)
    }
}

/// A number with commas between thousands.
pub fn grouped(number: f64, decimals: usize) -> String {
    let plain = format!("{:.decimals$}", number.abs());
    let (whole, fraction) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    let mut out = String::with_capacity(plain.len() + whole.len() / 3 + 1);
    if number < 0.0 && plain.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        out.push('-');
    }
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out + fraction
}
