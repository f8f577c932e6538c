//! One array as NumPy writes it (`.npy`): a magic number, a header that is a Python dictionary, and the numbers.

use std::io::Read;

use super::super::fault::{Fault, excerpt};
use crate::task::Task;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Headers are one line; longer ones are damage.
const MOST_HEADER: usize = 1 << 16;
/// Bytes between two looks at the task.
const CHUNK: usize = 1 << 20;

/// The kinds of numbers that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Float,
    Signed,
    Unsigned,
}

/// How the numbers are stored: little-endian or of one byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dtype {
    pub kind: Kind,
    pub bytes: usize,
}

/// An array's header.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    pub dtype: Dtype,
    pub shape: Vec<usize>,
}

/// A number as it was stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    Float(f64),
    Integer(i128),
}

/// Reads the header of the array `name`.
pub fn header(name: &str, from: &mut impl Read) -> Result<Header, Fault> {
    let broken = |reason: &str| Fault::of_file(format!("the array {name} {reason}"));
    let short = |_| broken("ends within its header");
    let mut start = [0; 8];
    from.read_exact(&mut start).map_err(short)?;
    if start[..6] != *MAGIC {
        return Err(broken("is not in NumPy's form"));
    }
    let len = if start[6] == 1 {
        let mut len = [0; 2];
        from.read_exact(&mut len).map_err(short)?;
        usize::from(u16::from_le_bytes(len))
    } else {
        let mut len = [0; 4];
        from.read_exact(&mut len).map_err(short)?;
        u32::from_le_bytes(len) as usize
    };
    if len > MOST_HEADER {
        return Err(broken("has a header that is too long"));
    }
    let mut text = vec![0; len];
    from.read_exact(&mut text).map_err(short)?;
    let text = String::from_utf8_lossy(&text);
    let unreadable = || broken(&format!("has a header that cannot be read: {}", excerpt(&text)));
    let descr = quoted_after(&text, "'descr'").ok_or_else(unreadable)?;
    let dtype = dtype(descr).ok_or_else(|| {
        broken(&format!(
            "holds numbers of the kind '{}'; allowed are little-endian floats of 4 or 8 bytes and integers of 1 to 8",
            excerpt(descr)
        ))
    })?;
    if after(&text, "'fortran_order'").is_none_or(|rest| !rest.starts_with("False")) {
        return Err(broken("is stored in Fortran order; save it as np.ascontiguousarray(...)"));
    }
    let shape = after(&text, "'shape'").and_then(shape).ok_or_else(unreadable)?;
    Ok(Header { dtype, shape })
}

/// What follows a key of the dictionary.
fn after<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(key)?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

fn quoted_after<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    let rest = after(text, key)?.strip_prefix('\'')?;
    Some(rest.split_once('\'')?.0)
}

fn dtype(descr: &str) -> Option<Dtype> {
    let (order, kind) = descr.split_at_checked(1)?;
    let (kind, bytes) = kind.split_at_checked(1)?;
    let dtype = match (kind, bytes) {
        ("f", "4") => Dtype { kind: Kind::Float, bytes: 4 },
        ("f", "8") => Dtype { kind: Kind::Float, bytes: 8 },
        ("i", "1" | "2" | "4" | "8") => Dtype { kind: Kind::Signed, bytes: bytes.parse().ok()? },
        ("u", "1" | "2" | "4" | "8") => Dtype { kind: Kind::Unsigned, bytes: bytes.parse().ok()? },
        _ => return None,
    };
    (order == "<" || (order == "|" && dtype.bytes == 1)).then_some(dtype)
}

/// `(3, 4)`, `(3,)` or `()`.
fn shape(text: &str) -> Option<Vec<usize>> {
    let (inside, _) = text.strip_prefix('(')?.split_once(')')?;
    let sizes = inside.split(',').map(str::trim).filter(|size| !size.is_empty());
    // Python 2 wrote long integers with an L behind them.
    sizes.map(|size| size.trim_end_matches('L').parse().ok()).collect()
}

/// Reads `count` numbers, in pieces, so that a header that promises more than there is takes no memory.
pub fn numbers<T>(
    name: &str,
    from: &mut impl Read,
    dtype: Dtype,
    count: usize,
    convert: impl Fn(Number) -> Result<T, String>,
    task: &Task,
) -> Result<Vec<T>, Fault> {
    let mut all = Vec::new();
    let mut buffer = vec![0; (CHUNK / 8 * dtype.bytes).min(count.saturating_mul(dtype.bytes))];
    let mut left = count;
    while left > 0 {
        task.check()?;
        let numbers = left.min(buffer.len() / dtype.bytes);
        let piece = &mut buffer[..numbers * dtype.bytes];
        from.read_exact(piece).map_err(|error| {
            Fault::of_file(format!("the array {name} ends after {} of {count} numbers ({error})", all.len()))
        })?;
        task.advance(piece.len() as u64);
        all.reserve(numbers);
        for bytes in piece.chunks_exact(dtype.bytes) {
            let value = convert(number(dtype.kind, bytes));
            all.push(
                value.map_err(|reason| Fault::of_file(format!("{name}: number {} {reason}", all.len())))?,
            );
        }
        left -= numbers;
    }
    Ok(all)
}

#[inline]
fn number(kind: Kind, bytes: &[u8]) -> Number {
    let mut wide = [0_u8; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let unsigned = u64::from_le_bytes(wide);
    match kind {
        Kind::Float if bytes.len() == 4 => Number::Float(f32::from_bits(unsigned as u32).into()),
        Kind::Float => Number::Float(f64::from_bits(unsigned)),
        Kind::Unsigned => Number::Integer(unsigned.into()),
        Kind::Signed => {
            let shift = 64 - 8 * bytes.len() as u32;
            Number::Integer(((unsigned << shift) as i64 >> shift).into())
        }
    }
}

/// A float; integers are welcome. Double precision is rounded to the nearest: rounding keeps the order of numbers, so a
/// box still contains the triangles that it did.
#[inline]
pub fn float(number: Number) -> Result<f32, String> {
    Ok(match number {
        Number::Float(x) => x as f32,
        Number::Integer(n) => n as f32,
    })
}

/// An index that fits 32 bits with a sign.
#[inline]
pub fn index(number: Number) -> Result<i32, String> {
    match number {
        Number::Integer(n) => n
            .try_into()
            .map_err(|_| format!("is {n}, which does not fit 32 bits with a sign (an empty slot is -1)")),
        Number::Float(x) => Err(format!("is {x}, but this array holds indices: save it as np.int32")),
    }
}
