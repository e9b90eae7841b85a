//! The receiver: a point of a surface with its normal and reflectance.

use glam::DVec3;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::number::Number;
use radgrad_numbers::offset::unit_vector;
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::error::Error;

/// A point on a diffuse surface: position `x`, unit normal `n1`, reflectance `rho`.
///
/// ```
/// use radgrad_core::{DVec3, Receiver};
/// let receiver = Receiver::new(DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0), 0.5)?;
/// assert_eq!(receiver.normal(), DVec3::Z);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Receiver {
    position: DVec3,
    /// The normal as given.
    given: DVec3,
    /// The same, times a power of two that brings its largest component to [1, 2).
    direction: Vec3<f64>,
    /// Unit normal in double-double.
    precise_normal: Vec3<DoubleDouble>,
    normal: DVec3,
    reflectance: f64,
    /// `rho/pi`.
    albedo: DoubleDouble,
}

impl Receiver {
    /// A receiver at `position` facing along `normal` (of any length), reflecting the fraction `reflectance` of the light it
    /// receives.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Error, Receiver};
    /// assert!(Receiver::new(DVec3::ZERO, DVec3::Z, 0.8).is_ok());
    /// assert_eq!(Receiver::new(DVec3::ZERO, DVec3::ZERO, 0.8), Err(Error::Normal { value: DVec3::ZERO }));
    /// assert_eq!(Receiver::new(DVec3::ZERO, DVec3::Z, 1.2), Err(Error::Reflectance { value: 1.2 }));
    /// ```
    ///
    /// # Errors
    /// If a coordinate is not finite, the normal is zero, or the reflectance is outside [0, 1].
    pub fn new(position: DVec3, normal: DVec3, reflectance: f64) -> Result<Self, Error> {
        if !position.is_finite() {
            return Err(Error::PositionNotFinite { value: position });
        }
        if !normal.is_finite() || normal == DVec3::ZERO {
            return Err(Error::Normal { value: normal });
        }
        if !(0.0..=1.0).contains(&reflectance) {
            return Err(Error::Reflectance { value: reflectance });
        }
        let given = normal;
        let direction = Vec3::from(normal) * normalising_power(normal.abs().max_element());
        let (precise_normal, _) = unit_vector(direction.map(DoubleDouble::from));
        let albedo = DoubleDouble::from(reflectance).divided_by(DoubleDouble::pi());
        let normal = precise_normal.map(DoubleDouble::to_f64).into();
        Ok(Self { position, given, direction, precise_normal, normal, reflectance, albedo })
    }

    /// Position `x`.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Receiver};
    /// let receiver = Receiver::new(DVec3::new(0.1, 0.2, 0.3), DVec3::Z, 1.0)?;
    /// assert_eq!(receiver.position(), DVec3::new(0.1, 0.2, 0.3));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn position(&self) -> DVec3 {
        self.position
    }

    /// Unit normal `n1`, each component correct to one ulp.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Receiver};
    /// let receiver = Receiver::new(DVec3::ZERO, DVec3::new(3.0, 0.0, 4.0), 1.0)?;
    /// assert!((receiver.normal() - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The normal as given, of whatever length.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Receiver};
    /// let steep = DVec3::new(1e-14, 0.0, 1e308);
    /// let receiver = Receiver::new(DVec3::ZERO, steep, 1.0)?;
    /// assert_eq!((receiver.given_normal(), receiver.normal().z), (steep, 1.0)); // its x is 1e-322, of which a double has two digits
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn given_normal(&self) -> DVec3 {
        self.given
    }

    /// The same, and the power of two that makes it [`Self::direction`], which loses components far below the largest.
    #[inline]
    pub(crate) fn exact_direction(&self) -> (DVec3, f64) {
        (self.given, normalising_power(self.given.abs().max_element()))
    }

    /// The normal with its largest component in [1, 2): the input times a power of two, exact but for components below the normal
    /// range of doubles.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Receiver};
    /// let receiver = Receiver::new(DVec3::ZERO, DVec3::new(3.0, 0.0, 4.0), 1.0)?;
    /// assert_eq!(receiver.direction(), DVec3::new(0.75, 0.0, 1.0));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        self.direction.into()
    }

    pub(crate) const fn precise_normal(&self) -> Vec3<DoubleDouble> {
        self.precise_normal
    }

    /// Reflectance `rho`, in [0, 1].
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Receiver};
    /// assert_eq!(Receiver::new(DVec3::ZERO, DVec3::Z, 0.25)?.reflectance(), 0.25);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn reflectance(&self) -> f64 {
        self.reflectance
    }

    /// `rho/pi`, off by less than 32 units.
    pub(crate) const fn albedo(&self) -> DoubleDouble {
        self.albedo
    }
}

/// The receiver's unit normal `n1`: a double-double with components off by less than 32 units, rounded.
#[inline]
pub(crate) fn unit_normal<T: Real>(receiver: &Receiver) -> Vec3<T> {
    if T::Number::BEYOND_DOUBLE_DOUBLE {
        return Vec3::from(receiver.given_normal()).map(T::exact).unit();
    }
    receiver.precise_normal().map(|c| T::from_double_double(c, 32.0 * ROUNDOFF_OF_DOUBLE_DOUBLE))
}

/// `rho / pi`.
#[inline]
pub(crate) fn albedo<T: Real>(receiver: &Receiver) -> T {
    if T::Number::BEYOND_DOUBLE_DOUBLE {
        return T::exact(receiver.reflectance()) / T::pi();
    }
    let albedo = receiver.albedo();
    T::from_double_double(albedo, 32.0 * ROUNDOFF_OF_DOUBLE_DOUBLE * albedo.hi)
}
