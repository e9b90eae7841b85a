//! Data as bytes, for files of this version of the program: numbers in little-endian order, sequences after their length.

use std::sync::OnceLock;

use radgrad_core::DVec3;

/// Data that bytes stand for.
pub(crate) trait Bytes: Sized {
    /// Appends its bytes.
    fn put(&self, to: &mut Vec<u8>);

    /// From the first of these bytes, which are taken away; `None` if they are no such data.
    fn take(from: &mut &[u8]) -> Option<Self>;
}

/// Of a structure, its fields one after the other.
macro_rules! bytes_of {
    ($name:ident { $($field:ident),* $(,)? }) => {
        impl $crate::bytes::Bytes for $name {
            fn put(&self, to: &mut Vec<u8>) {
                $($crate::bytes::Bytes::put(&self.$field, to);)*
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: $crate::bytes::Bytes::take(from)?),* })
            }
        }
    };
}
pub(crate) use bytes_of;

impl Bytes for u64 {
    fn put(&self, to: &mut Vec<u8>) {
        to.extend(self.to_le_bytes());
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (first, rest) = from.split_first_chunk()?;
        *from = rest;
        Some(Self::from_le_bytes(*first))
    }
}

impl Bytes for f64 {
    fn put(&self, to: &mut Vec<u8>) {
        self.to_bits().put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        u64::take(from).map(Self::from_bits)
    }
}

impl Bytes for usize {
    fn put(&self, to: &mut Vec<u8>) {
        (*self as u64).put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        Self::try_from(u64::take(from)?).ok()
    }
}

impl Bytes for bool {
    fn put(&self, to: &mut Vec<u8>) {
        to.push(u8::from(*self));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (first, rest) = from.split_first()?;
        *from = rest;
        match first {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }
}

impl Bytes for DVec3 {
    fn put(&self, to: &mut Vec<u8>) {
        self.to_array().put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        <[f64; 3]>::take(from).map(Self::from)
    }
}

impl<T: Bytes> Bytes for Option<T> {
    fn put(&self, to: &mut Vec<u8>) {
        self.is_some().put(to);
        self.iter().for_each(|value| value.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        if bool::take(from)? { T::take(from).map(Some) } else { Some(None) }
    }
}

impl<T: Bytes> Bytes for OnceLock<T> {
    fn put(&self, to: &mut Vec<u8>) {
        self.get().is_some().put(to);
        self.get().into_iter().for_each(|value| value.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        <Option<T> as Bytes>::take(from).map(|value| value.map_or_else(Self::new, Self::from))
    }
}

impl<T: Bytes> Bytes for Vec<T> {
    fn put(&self, to: &mut Vec<u8>) {
        self.len().put(to);
        self.iter().for_each(|item| item.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        // An item takes a byte at least: a length that is none takes no memory.
        let length = usize::take(from).filter(|length| *length <= from.len())?;
        let mut items = Self::new();
        for _ in 0..length {
            items.push(T::take(from)?);
        }
        Some(items)
    }
}

impl<T: Bytes, const N: usize> Bytes for [T; N] {
    fn put(&self, to: &mut Vec<u8>) {
        self.iter().for_each(|item| item.put(to));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let items = (0..N).map(|_| T::take(from)).collect::<Option<Vec<T>>>()?;
        items.try_into().ok()
    }
}

impl<A: Bytes, B: Bytes> Bytes for (A, B) {
    fn put(&self, to: &mut Vec<u8>) {
        self.0.put(to);
        self.1.put(to);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        Some((A::take(from)?, B::take(from)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_comes_back_and_what_is_cut_short_is_none() {
        let data: Vec<(Option<[f64; 2]>, bool)> = vec![(Some([f64::INFINITY, -0.0]), true), (None, false)];
        let mut bytes = Vec::new();
        data.put(&mut bytes);
        let mut rest = &bytes[..];
        assert_eq!(Vec::<(Option<[f64; 2]>, bool)>::take(&mut rest), Some(data));
        assert!(rest.is_empty());
        for end in 0..bytes.len() {
            assert_eq!(Vec::<(Option<[f64; 2]>, bool)>::take(&mut &bytes[..end]), None, "{end}");
        }
        assert_eq!(Vec::<f64>::take(&mut &[0xff; 8][..]), None);
    }
}
