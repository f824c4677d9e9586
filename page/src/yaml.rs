//! Plain data as YAML that people read: mappings in lines, lists and what is in them in one.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, Serializer};

/// Writes data whose keys are names.
pub fn to_string(data: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    data.serialize(&mut Serializer::with_formatter(&mut bytes, Lines::default()))?;
    bytes.push(b'\n');
    let text = String::from_utf8(bytes).expect("JSON is UTF-8");
    // Before a mapping; a text has no line of its own.
    Ok(text.replace(": \n", ":\n"))
}

/// JSON whose mappings are lines, and whose keys have no quotes: texts and numbers are YAML's as they are.
#[derive(Default)]
struct Lines {
    /// Of each mapping around, whether it has a key already.
    mappings: Vec<bool>,
    n_lists: usize,
    is_key: bool,
}

impl Formatter for Lines {
    /// Whole numbers are written as people write them: `9` robots, and not `9.0`.
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        if value.fract() == 0.0 && value.abs() < 1e15 {
            return write!(writer, "{value:.0}");
        }
        CompactFormatter.write_f64(writer, value)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.mappings.push(false);
        if self.n_lists > 0 { writer.write_all(b"{") } else { Ok(()) }
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        let has_keys = self.mappings.pop().unwrap_or_default();
        match (self.n_lists > 0, has_keys) {
            (true, _) => writer.write_all(b"}"),
            (false, false) => writer.write_all(b"{}"),
            (false, true) => Ok(()),
        }
    }

    fn begin_object_key<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        is_first: bool,
    ) -> io::Result<()> {
        self.is_key = true;
        if let Some(has_keys) = self.mappings.last_mut() {
            *has_keys = true;
        }
        if self.n_lists > 0 {
            return if is_first { Ok(()) } else { writer.write_all(b", ") };
        }
        if !is_first || self.mappings.len() > 1 {
            writer.write_all(b"\n")?;
        }
        (1..self.mappings.len()).try_for_each(|_| writer.write_all(b"  "))
    }

    fn end_object_key<W: ?Sized + Write>(&mut self, _writer: &mut W) -> io::Result<()> {
        self.is_key = false;
        Ok(())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.n_lists += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.n_lists -= 1;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        is_first: bool,
    ) -> io::Result<()> {
        if is_first { Ok(()) } else { writer.write_all(b", ") }
    }

    fn begin_string<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.is_key { Ok(()) } else { writer.write_all(b"\"") }
    }

    fn end_string<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.begin_string(writer)
    }
}
