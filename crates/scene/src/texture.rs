//! Textures: values on a grid of texels, and where a face has them.
//!
//! A [`Texture`] is constant on each texel: the value at `(u, v)` is that of the texel `(floor(u columns), floor(v rows))`, the
//! texel (0, 0) being the one next to u = v = 0. No filter is applied, so that the texture is known exactly, its integrals over
//! polygons too. Outside the unit square it continues as [`Wrap`] says. Its values have no unit: a material's reflectance or
//! radiance is its own value times that of its texture.
//!
//! A [`Chart`] gives `(u, v)` as an affine function of the position on a face.

pub(crate) mod chart;
pub(crate) mod cut;
pub(crate) mod image;

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::extremes::largest;

/// The quantity of a material that a texture varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The reflectance.
    Reflectance,
    /// The emitted radiance.
    Radiance,
}

impl Quantity {
    /// Both, in the order of their values.
    pub const ALL: [Self; 2] = [Self::Reflectance, Self::Radiance];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Reflectance => "reflectance",
            Self::Radiance => "radiance",
        }
    }
}

/// How a texture continues outside the unit square, in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Wrap {
    /// As if copies of it lay side by side.
    #[default]
    Repeat,
    /// As if every other copy were turned over.
    Mirror,
    /// With its last texel.
    Clamp,
}

impl Wrap {
    fn index(self, index: i64, count: usize) -> usize {
        let n = i64::try_from(count).unwrap_or(i64::MAX);
        let within = match self {
            Self::Repeat => index.rem_euclid(n),
            Self::Mirror => {
                let twice = index.rem_euclid(n.saturating_mul(2));
                if twice < n { twice } else { n.saturating_mul(2) - 1 - twice }
            }
            Self::Clamp => index.clamp(0, n - 1),
        };
        usize::try_from(within).unwrap_or(0)
    }
}

/// Values on a grid of texels, some in each texel. Clones share them.
///
/// ```
/// use radgrad_scene::Texture;
/// let board = Texture::from_fn("board", [8, 8], 1, |column, row| vec![f64::from(u8::from((column + row) % 2 == 0))])?;
/// assert_eq!(board.value_at([0.01, 0.01]), [1.0]);
/// assert_eq!(board.value_at([0.13, 0.01]), [0.0]);
/// assert_eq!(board.value_at([1.01, -0.01]), [0.0], "it repeats");
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct Texture {
    name: String,
    columns: usize,
    rows: usize,
    channels: usize,
    wrap: [Wrap; 2],
    texels: Arc<Vec<f64>>,
    /// The largest value of each channel.
    largest: Arc<Vec<f64>>,
}

impl fmt::Debug for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, columns, rows, channels, wrap, .. } = self;
        write!(f, "Texture {{ {name:?}, {columns} x {rows} texels of {channels}, {wrap:?} }}")
    }
}

impl Texture {
    /// A texture of `[columns, rows]` texels with `channels` values each, given row by row from v = 0, in each row from u = 0.
    ///
    /// # Errors
    /// If there is no texel or channel, or not one value for each, or a value is negative or not finite.
    pub fn new(name: impl Into<String>, [columns, rows]: [usize; 2], channels: usize, texels: Vec<f64>) -> Result<Self, Error> {
        let name = name.into();
        let refused = |rule| Err(Error::Texture { texture: name.clone(), rule });
        if columns == 0 || rows == 0 || channels == 0 {
            return refused(format!("it has {columns} x {rows} texels of {channels} values: it needs at least one of each"));
        }
        if columns.checked_mul(rows).and_then(|n| n.checked_mul(channels)) != Some(texels.len()) {
            return refused(format!("{} values were given: expected {columns} x {rows} x {channels}", texels.len()));
        }
        if let Some(index) = texels.iter().position(|value| !(0.0..f64::INFINITY).contains(value)) {
            let (texel, value) = (index / channels, texels[index]);
            let [column, row] = [texel % columns, texel / columns];
            return refused(format!("texel ({column}, {row}) is {value}: it must be finite and not negative"));
        }
        let mut maxima = vec![0.0; channels];
        for texel in texels.chunks_exact(channels) {
            maxima.iter_mut().zip(texel).for_each(|(maximum, value)| *maximum = largest(*maximum, *value));
        }
        let (texels, largest) = (Arc::new(texels), Arc::new(maxima));
        Ok(Self { columns, rows, channels, wrap: [Wrap::default(); 2], texels, largest, name })
    }

    /// A texture whose texels a function of column and row gives.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_fn(
        name: impl Into<String>,
        [columns, rows]: [usize; 2],
        channels: usize,
        texel: impl Fn(usize, usize) -> Vec<f64>,
    ) -> Result<Self, Error> {
        let texels = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
        Self::new(name, [columns, rows], channels, texels.flat_map(|[column, row]| texel(column, row)).collect())
    }

    /// The same, continued otherwise along u and v.
    #[must_use]
    pub fn wrapped(self, wrap: [Wrap; 2]) -> Self {
        Self { wrap, ..self }
    }

    /// The same with its rows in the other order: of an image, whose first row is the highest.
    #[must_use]
    pub fn turned_over(mut self) -> Self {
        let width = self.columns * self.channels;
        let (upper, lower) = Arc::make_mut(&mut self.texels).split_at_mut(self.rows / 2 * width);
        let (below, above) = (lower.chunks_exact_mut(width).rev(), upper.chunks_exact_mut(width));
        above.zip(below).for_each(|(above, below)| above.swap_with_slice(below));
        self
    }

    /// Its name: that of its file, where it has one.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Columns and rows.
    #[must_use]
    pub const fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Values in each texel.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// All texels' values, row by row from v = 0, in each row from u = 0.
    #[must_use]
    pub fn texels(&self) -> &[f64] {
        &self.texels
    }

    /// How it continues along u and v.
    #[must_use]
    pub const fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// The values of a texel; columns and rows outside the grid are taken as it continues.
    #[must_use]
    pub fn texel(&self, [column, row]: [i64; 2]) -> &[f64] {
        let (column, row) = (self.wrap[0].index(column, self.columns), self.wrap[1].index(row, self.rows));
        let first = (row * self.columns + column) * self.channels;
        &self.texels[first..first + self.channels]
    }

    /// The values at a point. On the edge between two texels, those of the one with larger coordinates.
    #[must_use]
    pub fn value_at(&self, [u, v]: [f64; 2]) -> &[f64] {
        self.texel([floor(u * self.columns as f64), floor(v * self.rows as f64)])
    }

    /// The largest value in a channel; 0 if there is no such channel.
    #[must_use]
    pub fn largest(&self, channel: usize) -> f64 {
        self.largest.get(channel).copied().unwrap_or(0.0)
    }

    /// All values with their texel `[column, row]` and channel.
    pub(crate) fn values(&self) -> impl Iterator<Item = (f64, [usize; 2], usize)> {
        let place = move |index: usize| {
            let texel = index / self.channels;
            ([texel % self.columns, texel / self.columns], index % self.channels)
        };
        self.texels.iter().enumerate().map(move |(index, &value)| (value, place(index).0, place(index).1))
    }
}

/// The largest integer that is not above `x`; the nearest that fits where there is none.
#[expect(clippy::cast_possible_truncation, reason = "a floor, and casts saturate")]
pub(crate) fn floor(x: f64) -> i64 {
    x.floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_continues_as_it_is_told() {
        let plain = Texture::new("t", [3, 1], 1, vec![1.0, 2.0, 3.0]).unwrap();
        for (wrap, expected) in [
            (Wrap::Repeat, [3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0]),
            (Wrap::Mirror, [1.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 1.0]),
            (Wrap::Clamp, [1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0]),
        ] {
            let texture = plain.clone().wrapped([wrap; 2]);
            let texels = [-1, 0, 1, 2, 3, 4, 5, 6].map(|column| texture.texel([column, 0])[0]);
            assert_eq!(texels, expected, "{wrap:?}");
        }
    }

    #[test]
    fn a_wrong_texture_is_refused_with_the_texel() {
        let error = |size, texels: &[f64]| Texture::new("t", size, 1, texels.to_vec()).unwrap_err().to_string();
        assert_eq!(error([0, 2], &[]), "texture `t`: it has 0 x 2 texels of 1 values: it needs at least one of each");
        assert_eq!(error([2, 2], &[0.0; 3]), "texture `t`: 3 values were given: expected 2 x 2 x 1");
        let wrong = error([2, 2], &[0.0, 0.0, 0.0, -1.0]);
        assert_eq!(wrong, "texture `t`: texel (1, 1) is -1: it must be finite and not negative");
    }
}
