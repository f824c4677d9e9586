//! Makes up values for any message, from a seed, by playing the part of a data format.
//!
//! serde asks for one value after the other and gets made-up ones: strings of lengths that disturb
//! the alignment, sequences of none to three elements, negative and fractional numbers that every
//! text format keeps exactly.

use std::fmt;

use serde::de::{self, DeserializeOwned, DeserializeSeed, Deserializer, SeqAccess, Visitor};

/// Makes up one message.
pub fn sample<M: DeserializeOwned>(seed: u64) -> M {
    M::deserialize(&mut Sampler { state: seed }).expect("every request gets a value")
}

struct Sampler {
    state: u64,
}

impl Sampler {
    /// The next draw of `SplitMix64`.
    fn draw(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Up to 2¹⁵ in size, in steps of 1/8: exact as f32 and in decimal.
    fn fraction(&mut self) -> f32 {
        f32::from(self.draw() as u16 as i16) / 8.0
    }
}

/// Nothing can go wrong, but serde wants a type for it.
#[derive(Debug)]
struct Impossible(String);

impl fmt::Display for Impossible {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for Impossible {}

impl de::Error for Impossible {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// Hands out that many elements.
struct Elements<'a> {
    sampler: &'a mut Sampler,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Impossible;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Impossible> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.sampler).map(Some)
    }
}

/// Answers a request for a number with some bits of a draw.
macro_rules! numbers {
    ($($ask:ident => $visit:ident as $number:ty,)+) => {
        $(fn $ask<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
            visitor.$visit(self.draw() as $number)
        })+
    };
}

impl<'de> Deserializer<'de> for &mut Sampler {
    type Error = Impossible;

    numbers! {
        deserialize_i8 => visit_i8 as i8,
        deserialize_i16 => visit_i16 as i16,
        deserialize_i32 => visit_i32 as i32,
        deserialize_i64 => visit_i64 as i64,
        deserialize_u8 => visit_u8 as u8,
        deserialize_u16 => visit_u16 as u16,
        deserialize_u32 => visit_u32 as u32,
        deserialize_u64 => visit_u64 as u64,
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
        visitor.visit_bool(self.draw() % 2 == 1)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
        visitor.visit_f32(self.fraction())
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
        visitor.visit_f64(f64::from(self.fraction()) / 3.0)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
        let n_characters = (self.draw() % 8) as usize;
        visitor.visit_string("aß€ z\n9/".chars().cycle().take(n_characters).collect())
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Impossible> {
        let left = (self.draw() % 4) as usize;
        visitor.visit_seq(Elements { sampler: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, Impossible> {
        visitor.visit_seq(Elements { sampler: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Impossible> {
        visitor.visit_seq(Elements { sampler: self, left: fields.len() })
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Impossible> {
        Err(de::Error::custom("no message has a field of this kind"))
    }

    serde::forward_to_deserialize_any! {
        i128 u128 char str bytes byte_buf option unit unit_struct newtype_struct tuple_struct map
        enum identifier ignored_any
    }
}
