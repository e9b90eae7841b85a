//! A digest by which damage or another input is noticed. It keeps nothing secret.

/// FNV-1a of 64 bits, of G. Fowler, L. C. Noll and K.-P. Vo.
#[must_use]
pub fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    #[test]
    fn fnv1a_has_the_published_values() {
        assert_eq!(
            [&b""[..], b"a", b"foobar"].map(|text| super::fnv1a(text.iter().copied())),
            [0xcbf2_9ce4_8422_2325, 0xaf63_dc4c_8601_ec8c, 0x8594_4171_f739_67e8]
        );
    }
}
