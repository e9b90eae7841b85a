//! Patches with their reflectance and emission.

use crate::error::Error;
use crate::patch::Patch;
use crate::value::Value;

/// Patches with their reflectance and the radiosity that they emit.
#[derive(Debug, Clone, Default)]
pub struct CurvedScene {
    pub(crate) patches: Vec<Patch>,
    /// Reflectance and emission of each.
    pub(crate) values: Vec<[Value; 2]>,
}

impl CurvedScene {
    /// A scene without patches.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a patch and returns its index. `reflectance` is in [0, 1), `emitted` a radiosity, both numbers or functions.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn add(&mut self, patch: Patch, reflectance: impl Into<Value>, emitted: impl Into<Value>) -> Result<usize, Error> {
        let (index, values) = (self.patches.len(), [reflectance.into(), emitted.into()]);
        for (value, quantity, fits) in [
            (&values[0], "reflectance", (0.0..1.0).contains(&values[0].largest())),
            (&values[1], "emission", (0.0..f64::INFINITY).contains(&values[1].largest())),
        ] {
            if !fits {
                let largest = if quantity == "reflectance" { 1.0 } else { f64::INFINITY };
                let (value, point) = (value.largest(), patch.spot([0.5; 2]).point);
                return Err(Error::Value { patch: index, quantity, value, point, largest });
            }
        }
        self.patches.push(patch);
        self.values.push(values);
        Ok(index)
    }
}
