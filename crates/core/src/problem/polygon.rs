//! Simple planar polygons; a [`Polygon`] is always valid.
//!
//! A [`Polygon`] is simple, planar up to the rounding of its vertices, and counter-clockwise seen from its lit side (HS95 section
//! 2; conventions of `ARCHITECTURE.md`). Every tolerance is relative to the polygon's own size or to the rounding of its
//! coordinates, so that a change of unit or of origin changes no answer. Lengths are in the unit of the caller throughout.

use std::ops::{Add, Mul, Sub};

use fearless_simd::{Simd, SimdBase, f64x4};
use glam::DVec3;
use radgrad_numbers::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use radgrad_numbers::exact::orientation;
use radgrad_numbers::number::{Number, ROUNDOFF};
use radgrad_numbers::offset::{exact_offset, offset, unit_vector};
use radgrad_numbers::power::normalising_power;
use radgrad_numbers::real::Real;
use radgrad_numbers::vec3::Vec3;

use crate::error::Error;
use crate::problem::fan::FanTriangle;

/// A simple planar polygon, convex or not, counter-clockwise seen from its lit side.
///
/// ```
/// use radgrad_core::{DVec3, Polygon};
/// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 3.0));
/// let polygon = Polygon::new(square.to_vec())?;
/// assert_eq!(polygon.normal(), DVec3::Z);
/// assert_eq!(polygon.area(), 1.0);
/// # Ok::<(), radgrad_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    vertices: Vec<DVec3>,
    /// The same for four edges at a time.
    four_edges: Vec<FourEdges>,
    /// Triangles that add up to it.
    fan: Vec<FanTriangle>,
    /// Unit normal in double-double, so that heights over the plane keep their digits near contact.
    precise_normal: Vec3<DoubleDouble>,
    normal_error: f64,
    normal: DVec3,
    /// Three vertices, in order, that are not on one line.
    corners: [usize; 3],
    /// Area times the square of `power`, which brings the size to about 1: it cannot underflow.
    normalised_area: f64,
    power: f64,
    size: f64,
    planarity_defect: f64,
    half_slab: f64,
    precision: f64,
    /// Seen along the coordinate axis that shows it largest, exactly.
    is_convex: bool,
}

/// Vertices may be off the plane by this fraction of the polygon's size: enough for coordinates computed in double
/// precision, far too little to flatten a warped face unseen.
const PLANARITY: f64 = 4e-12;

/// Rounding of one coordinate moves a vertex by at most half an ulp per axis; four of them cover a plane through rounded
/// vertices.
pub(crate) const COORDINATE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Twice the area over the squared size, below which the double-double normal itself has no digits left.
const DEGENERATE: f64 = 1.0 / (1u128 << 80) as f64;

impl Polygon {
    /// A polygon through `vertices`, counter-clockwise seen from the lit side; the last vertex is joined to the first.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Error, Polygon};
    /// let point = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    /// let arrow = [point(0.0, 0.0, 0.0), point(2.0, -1.0, 0.0), point(1.0, 0.0, 0.0), point(2.0, 1.0, 0.0)];
    /// assert_eq!(Polygon::new(arrow.to_vec())?.area(), 1.0); // concave is fine
    /// let crossed = [point(0.0, 0.0, 0.0), point(1.0, 1.0, 0.0), point(1.0, 0.0, 0.0), point(0.0, 1.0, 0.0)];
    /// assert!(Polygon::new(crossed.to_vec()).is_err());
    /// let warped = [point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(1.0, 1.0, 0.1), point(0.0, 1.0, 0.0)];
    /// assert!(matches!(Polygon::new(warped.to_vec()), Err(Error::NotPlanar { .. })));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there are fewer than three vertices, a coordinate is not finite, two consecutive vertices are the same point, all are
    /// on one line, one is off the plane by more than `4e-12` of the size plus the rounding of the coordinates, or two edges
    /// meet.
    pub fn new(vertices: Vec<DVec3>) -> Result<Self, Error> {
        Self::checked(vertices, 0.0)
    }

    /// A polygon through vertices of which each coordinate may be off by `precision`, as those of a renderer's quadrilaterals in
    /// single precision are: it may be off a plane by as much as that explains, and its [`Self::planarity_defect`] goes into every
    /// bound. The precision itself does not: the truth is that of the vertices as given.
    ///
    /// Where rounding has exchanged two neighbours, so that the outline runs back over itself, or made them one, both are moved by at
    /// most the precision. A precision of 0 makes it [`Self::new`].
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// let single = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).as_vec3().as_dvec3();
    /// let quad = [single(0.1, 0.2, 0.7), single(1.1, 0.3, 0.9), single(1.3, 1.1, 1.3), single(0.3, 1.0, 1.1)];
    /// assert!(Polygon::new(quad.to_vec()).is_err());
    /// let quad = Polygon::from_rounded(quad.to_vec(), 2f64.powi(-24))?;
    /// assert!(quad.planarity_defect() < 1e-6);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Self::new`], flatness judged as above; and if the precision is negative or not finite.
    pub fn from_rounded(mut vertices: Vec<DVec3>, precision: f64) -> Result<Self, Error> {
        if !(precision.is_finite() && precision >= 0.0) {
            return Err(Error::Precision { value: precision });
        }
        for _ in 0..vertices.len() {
            match Self::checked(vertices.clone(), precision) {
                Err(Error::NotSimple { first, second, .. }) if unfold(&mut vertices, [first, second], precision) => {}
                Err(Error::RepeatedVertex { first, .. }) if unfold(&mut vertices, [first, first], precision) => {}
                result => return result,
            }
        }
        Self::checked(vertices, precision)
    }

    /// The polygon through the images of its vertices under a map that multiplies lengths by `scale`, and their precision with
    /// them.
    ///
    /// ```
    /// use radgrad_core::{DVec3, Polygon};
    /// let triangle = Polygon::from_rounded(vec![DVec3::X, DVec3::Y, DVec3::Z], 1e-6)?;
    /// let halved = triangle.map(0.5, |vertex| vertex * 0.5)?;
    /// assert_eq!((halved.vertices()[0].x, halved.precision()), (0.5, 5e-7));
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Self::from_rounded`].
    pub fn map(&self, scale: f64, image: impl FnMut(DVec3) -> DVec3) -> Result<Self, Error> {
        Self::from_rounded(self.vertices.iter().copied().map(image).collect(), self.precision * scale.abs())
    }

    fn checked(vertices: Vec<DVec3>, precision: f64) -> Result<Self, Error> {
        let count = vertices.len();
        if count < 3 {
            return Err(Error::TooFewVertices { count });
        }
        if let Some(index) = vertices.iter().position(|v| !v.is_finite()) {
            return Err(Error::VertexNotFinite { index, value: vertices[index] });
        }
        if let Some(first) = (0..count).find(|&i| vertices[i] == vertices[(i + 1) % count]) {
            return Err(Error::RepeatedVertex { first, second: (first + 1) % count, value: vertices[first] });
        }
        let origin = vertices[0];
        let (low, high) = vertices.iter().fold((origin, origin), |(low, high), v| (low.min(*v), high.max(*v)));
        let size = (high - low).max_element();
        let power = normalising_power(size);
        let offsets: Vec<Vec3<DoubleDouble>> = vertices.iter().map(|&v| exact_offset(v, origin, power)).collect();
        let (precise_normal, norm) = unit_vector(twice_area(&offsets));
        if norm <= DEGENERATE {
            return Err(without_area(&vertices, &offsets, precision));
        }
        let turn = |i: usize| precise_normal.dot(offsets[i].cross(offsets[i + 1])).hi;
        let widest = (1..count - 1).max_by(|&i, &j| turn(i).total_cmp(&turn(j))).unwrap_or(1);
        let planarity_defect = if is_flat(&vertices, [0, widest, widest + 1]) {
            0.0
        } else {
            let heights = Heights::new(&offsets, precise_normal, norm);
            let largest = low.abs().max(high.abs()).max_element() * power;
            heights
                .defect(PLANARITY + COORDINATE_ROUNDING * largest, precision.min(size) * power)
                .map_err(|defect| defect.in_unit(power, size))?
                / power
        };
        // A cross product of normalised edges errs by 4 units of double-double of their lengths' product, at most 3;
        // normalising it adds 32 units.
        let normal_error = count as f64 * 16.0 * ROUNDOFF_OF_DOUBLE_DOUBLE / norm + 32.0 * ROUNDOFF_OF_DOUBLE_DOUBLE;
        let normal = precise_normal.map(DoubleDouble::to_f64);
        let projected = if count > 3 { projected(&vertices, normal.into()) } else { Vec::new() };
        if let Some([first, second]) = meeting_edges(&projected) {
            return Err(Error::NotSimple { first, second, precision });
        }
        let corner = |i: usize| projected[i % count];
        Ok(Self {
            is_convex: (0..projected.len()).all(|i| robust::orient2d(corner(i), corner(i + 1), corner(i + 2)) >= 0.0),
            normal: normal.into(),
            fan: FanTriangle::triangulate(&vertices, normal, power, 0.5 * norm, normal_error),
            normalised_area: 0.5 * norm,
            power,
            four_edges: FourEdges::in_order(&vertices),
            vertices,
            precise_normal,
            normal_error,
            corners: [0, widest, widest + 1],
            size,
            // Heights err by the normal's error and 8 units over at most three sizes.
            half_slab: if planarity_defect == 0.0 {
                0.0
            } else {
                (planarity_defect + 4.0 * size * (normal_error + 8.0 * ROUNDOFF_OF_DOUBLE_DOUBLE)) * (1.0 + 4.0 * f64::EPSILON)
            },
            planarity_defect,
            precision,
        })
    }

    /// The vertices as given.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
    /// assert_eq!(Polygon::new(corners.clone())?.vertices(), corners);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Unit normal `n2` to the lit side.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
    /// assert_eq!(Polygon::new(vec![a, b, c])?.normal(), DVec3::Z);
    /// assert_eq!(Polygon::new(vec![c, b, a])?.normal(), DVec3::NEG_Z);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Area, in the unit of the vertices squared; 0 where that is below the range of a double.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 4.0])?;
    /// assert_eq!(triangle.area(), 6.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area_scaled(1.0)
    }

    /// Area after all lengths were multiplied by a power of two.
    pub(crate) fn area_scaled(&self, power: f64) -> f64 {
        let ratio = power / self.power;
        self.normalised_area * ratio * ratio
    }

    /// Largest extent along a coordinate axis.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let triangle = Polygon::new(vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 4.0])?;
    /// assert_eq!(triangle.size(), 4.0);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn size(&self) -> f64 {
        self.size
    }

    /// Largest distance of a vertex from the plane through vertex 0 with normal [`Self::normal`]: 0 where all are exactly in one
    /// plane, as those of a triangle are, else the effect of the coordinates' rounding.
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let square = |z: f64| Polygon::new(vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, z), DVec3::Y]);
    /// assert_eq!(square(0.0)?.planarity_defect(), 0.0);
    /// let defect = square(1e-13)?.planarity_defect();
    /// assert!(defect > 0.0 && defect <= 1e-13);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn planarity_defect(&self) -> f64 {
        self.planarity_defect
    }

    /// The distance by which each coordinate of a vertex may be off: as given to [`Self::from_rounded`], 0 for [`Self::new`].
    ///
    /// ```
    /// # use radgrad_core::{DVec3, Polygon};
    /// let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
    /// assert_eq!(Polygon::new(corners.clone())?.precision(), 0.0);
    /// assert_eq!(Polygon::from_rounded(corners, 1e-6)?.precision(), 1e-6);
    /// # Ok::<(), radgrad_core::Error>(())
    /// ```
    #[must_use]
    pub const fn precision(&self) -> f64 {
        self.precision
    }

    /// A height over the plane that no vertex is above, and whose negative none is below: 0 where all are exactly in one plane.
    #[inline]
    pub(crate) const fn half_slab(&self) -> f64 {
        self.half_slab
    }

    /// Bound on the error of [`Self::precise_normal`], a relative one since that has length 1.
    pub(crate) const fn normal_error(&self) -> f64 {
        self.normal_error
    }

    /// Whether the normal errs by less than a roundoff.
    #[inline]
    pub(crate) fn is_well_known(&self) -> bool {
        self.normal_error < ROUNDOFF
    }

    /// The vertices for four edges at a time; the last edges may come again.
    pub(crate) fn four_edges(&self) -> &[FourEdges] {
        &self.four_edges
    }

    /// Triangles that add up to the polygon, in lengths times the second.
    pub(crate) fn fan(&self) -> (&[FanTriangle], f64) {
        (&self.fan, self.power)
    }

    /// Indices of three vertices in order that are not on one line.
    pub(crate) const fn plane_corners(&self) -> [usize; 3] {
        self.corners
    }

    /// Three vertices in order that are not on one line: the plane, exactly.
    pub(crate) fn plane_vertices(&self) -> [DVec3; 3] {
        self.corners.map(|i| self.vertices[i])
    }

    pub(crate) const fn precise_normal(&self) -> Vec3<DoubleDouble> {
        self.precise_normal
    }

    /// Unit normal `n2` to the digits of the scalar.
    #[inline]
    pub(crate) fn unit_normal<T: Real>(&self) -> Vec3<T> {
        if T::Number::BEYOND_DOUBLE_DOUBLE {
            let offsets: Vec<Vec3<T>> = self.vertices.iter().map(|&v| offset(v, self.vertices[0], self.power)).collect();
            return twice_area(&offsets).unit();
        }
        self.precise_normal.map(|c| T::from_double_double(c, self.normal_error))
    }

    /// Whether no corner turns inward, as far as [`Self::projected`] tells.
    pub(crate) const fn is_convex(&self) -> bool {
        self.is_convex
    }

    /// The vertices on the coordinate plane that shows the polygon largest, normalised, counter-clockwise.
    pub(crate) fn projected(&self) -> Vec<robust::Coord<f64>> {
        projected(&self.vertices, self.normal)
    }
}

/// Coordinates x, y, z of the five vertices that four edges join, the first of them the edge that ends in vertex 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FourEdges([[f64; 5]; 3]);

impl FourEdges {
    fn in_order(vertices: &[DVec3]) -> Vec<Self> {
        let count = vertices.len();
        let coordinate = |axis: usize, i: usize| vertices[(i + count - 1) % count].to_array()[axis];
        (0..count)
            .step_by(4)
            .map(|first| Self([0, 1, 2].map(|axis| [0, 1, 2, 3, 4].map(|i| coordinate(axis, first + i)))))
            .collect()
    }

    /// Where the edges start.
    #[inline(always)]
    pub(crate) fn starts<S: Simd>(&self, simd: S) -> Vec3<f64x4<S>> {
        let [x, y, z] = &self.0;
        Vec3::new(f64x4::from_slice(simd, &x[..4]), f64x4::from_slice(simd, &y[..4]), f64x4::from_slice(simd, &z[..4]))
    }

    /// Where they end.
    #[inline(always)]
    pub(crate) fn ends<S: Simd>(&self, simd: S) -> Vec3<f64x4<S>> {
        let [x, y, z] = &self.0;
        Vec3::new(f64x4::from_slice(simd, &x[1..]), f64x4::from_slice(simd, &y[1..]), f64x4::from_slice(simd, &z[1..]))
    }
}

fn projected(vertices: &[DVec3], normal: DVec3) -> Vec<robust::Coord<f64>> {
    let power = normalising_power(vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max));
    let [x, y, z] = normal.abs().to_array();
    let (along, across, up) = if z >= x && z >= y {
        (DVec3::X, DVec3::Y, normal.z)
    } else if y >= x {
        (DVec3::Z, DVec3::X, normal.y)
    } else {
        (DVec3::Y, DVec3::Z, normal.x)
    };
    let (along, across) = if up > 0.0 { (along, across) } else { (across, along) };
    vertices.iter().map(|v| robust::Coord { x: v.dot(along) * power, y: v.dot(across) * power }).collect()
}

/// Two edges that meet, by exact predicates.
fn meeting_edges(points: &[robust::Coord<f64>]) -> Option<[usize; 2]> {
    let count = points.len();
    for first in 0..count {
        let (a, b) = (points[first], points[(first + 1) % count]);
        for second in first + 1..count {
            let (c, d) = (points[second], points[(second + 1) % count]);
            let meet = if second == first + 1 {
                folds_back(a, b, d)
            } else if (second + 1) % count == first {
                folds_back(c, d, b)
            } else {
                segments_meet([a, b], [c, d])
            };
            if meet {
                return Some([first, second]);
            }
        }
    }
    None
}

/// Why a polygon's area vanishes: its lobes cancel, or all is on one line.
fn without_area(vertices: &[DVec3], offsets: &[Vec3<DoubleDouble>], precision: f64) -> Error {
    // A vertex farthest from vertex 0, and one farthest from the line through both. If no vertex is off that line by more than h, no
    // two span more than 3 h times its length, so that this finds a plane wherever there is one.
    let length = |offset: &Vec3<DoubleDouble>| offset.dot(*offset).to_f64();
    let farthest = offsets.iter().max_by(|a, b| length(a).total_cmp(&length(b)));
    let corners = farthest.into_iter().flat_map(|a| offsets.iter().map(|b| unit_vector(a.cross(*b))));
    let widest = corners.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, norm)| *norm > DEGENERATE);
    let crossing = widest.and_then(|(normal, _)| meeting_edges(&projected(vertices, normal.map(DoubleDouble::to_f64).into())));
    crossing.map_or(Error::ZeroArea { count: vertices.len() }, |[first, second]| Error::NotSimple { first, second, precision })
}

/// Puts the ends of an edge in order along the way from the vertex before to the one after it, where it is the shortest of two edges that
/// meet and the one between them, and so short that rounding may have exchanged its ends, or made them one: whether it is.
fn unfold(vertices: &mut [DVec3], [first, second]: [usize; 2], precision: f64) -> bool {
    let count = vertices.len();
    let next = |i: usize| (i + 1) % count;
    let half = |i: usize| 0.5 * (vertices[next(i)] - vertices[i]).abs().max_element();
    let between = [(first, second), (second, first)].into_iter().filter(|&(a, b)| next(next(a)) == b).map(|(a, _)| next(a));
    let shortest = [first, second].into_iter().chain(between).min_by(|&a, &b| half(a).total_cmp(&half(b))).unwrap_or(first);
    let way = vertices[next(next(shortest))] - vertices[(shortest + count - 1) % count];
    let (left, size) = (precision - half(shortest), way.abs().max_element());
    if !(left > 0.0 && size > 0.0) {
        return false;
    }
    let step = way * (left / size).min(0.25);
    let middle = vertices[shortest].midpoint(vertices[next(shortest)]);
    vertices[shortest] = middle - step;
    vertices[next(shortest)] = middle + step;
    true
}

/// A planarity defect in normalised coordinates, on its way to an error message.
struct Defect {
    index: usize,
    distance: f64,
    allowed: f64,
}

impl Defect {
    fn in_unit(self, power: f64, size: f64) -> Error {
        Error::NotPlanar { index: self.index, distance: self.distance / power, allowed: self.allowed / power, size }
    }
}

/// Heights of the vertices over the plane through vertex 0, normalised, and the offsets and the normal that they are computed from.
struct Heights<'a> {
    /// The vertices from the first.
    offsets: &'a [Vec3<DoubleDouble>],
    normal: Vec3<f64>,
    twice_area: f64,
    heights: Vec<f64>,
}

impl<'a> Heights<'a> {
    fn new(offsets: &'a [Vec3<DoubleDouble>], normal: Vec3<DoubleDouble>, twice_area: f64) -> Self {
        let heights = offsets.iter().map(|r| normal.dot(*r).to_f64()).collect();
        Self { offsets, normal: normal.map(DoubleDouble::to_f64), twice_area, heights }
    }

    /// The largest; an error where the best-fitting parallel plane is farther off a vertex than is allowed, and its height not
    /// [`Self::explained`].
    fn defect(&self, allowed: f64, precision: f64) -> Result<f64, Defect> {
        let middle = self.heights.iter().sum::<f64>() / self.heights.len() as f64;
        let deviation = |h: &f64| (h - middle).abs();
        let worst = |indices: &mut dyn Iterator<Item = usize>| {
            indices.max_by(|&i, &j| deviation(&self.heights[i]).total_cmp(&deviation(&self.heights[j])))
        };
        let mut farther = (0..self.heights.len()).filter(|&i| deviation(&self.heights[i]) > allowed);
        let refused = if precision > 0.0 {
            worst(&mut farther.filter(|&i| self.heights[i].abs() > allowed + self.explained(i, precision)))
        } else {
            worst(&mut farther)
        };
        if let Some(index) = refused {
            return Err(Defect {
                index,
                distance: deviation(&self.heights[index]),
                allowed: allowed + self.explained(index, precision),
            });
        }
        Ok(self.heights.iter().fold(0.0, |worst, h| worst.max(h.abs())))
    }

    /// The largest height that vertices have which were exactly in one plane before each coordinate moved by at most p.
    ///
    /// Twice the area moves by `sum d_i x D_i`, `d_i` the motion of vertex i and `D_i` the mean, before and after, of the offset
    /// between its neighbours. Before, the height was 0; so it is `n.(d_j - d_0)`, and as much as the motion turns the normal:
    /// `sum d_i.(D_i x r_j)` over twice the area, `r_j` from before.
    fn explained(&self, j: usize, p: f64) -> f64 {
        let (count, vertex) = (self.offsets.len(), |i: usize| self.offsets[i].map(|c| c.hi));
        let sum = |v: Vec3<f64>| v.x.abs() + v.y.abs() + v.z.abs();
        let r = vertex(j);
        let turned = (0..count).map(|i| {
            let across = vertex((i + 1) % count) - vertex((i + count - 1) % count);
            // `D` and `r` differ from these by at most p and 2p in each coordinate.
            sum(across.cross(r)) + 6.0 * p * sum(across) + 3.0 * p * sum(r) + 18.0 * p * p
        });
        p * (2.0 * sum(self.normal) + turned.sum::<f64>() / self.twice_area) * (1.0 + 1e-12)
    }
}

/// Twice the area as a vector along the normal, from the offsets of the vertices from the first.
fn twice_area<T>(offsets: &[Vec3<T>]) -> Vec3<T>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    offsets[2..].windows(2).fold(offsets[1].cross(offsets[2]), |sum, pair| sum + pair[0].cross(pair[1]))
}

/// Whether all vertices are exactly in the plane through three of them.
fn is_flat(vertices: &[DVec3], corners: [usize; 3]) -> bool {
    let [a, b, c] = corners.map(|i| vertices[i]);
    (0..vertices.len()).filter(|i| !corners.contains(i)).all(|i| orientation([a, b, c, vertices[i]]) == 0.0)
}

/// Whether edge `a b` and its successor `b d` run back over each other.
fn folds_back(a: robust::Coord<f64>, b: robust::Coord<f64>, d: robust::Coord<f64>) -> bool {
    robust::orient2d(a, b, d) == 0.0 && (b.x - a.x) * (d.x - b.x) + (b.y - a.y) * (d.y - b.y) < 0.0
}

/// Whether two closed segments have a point in common.
fn segments_meet([a, b]: [robust::Coord<f64>; 2], [c, d]: [robust::Coord<f64>; 2]) -> bool {
    let boxes_meet = a.x.min(b.x) <= c.x.max(d.x)
        && c.x.min(d.x) <= a.x.max(b.x)
        && a.y.min(b.y) <= c.y.max(d.y)
        && c.y.min(d.y) <= a.y.max(b.y);
    // With overlapping boxes, two collinear segments overlap too.
    boxes_meet
        && robust::orient2d(a, b, c) * robust::orient2d(a, b, d) <= 0.0
        && robust::orient2d(c, d, a) * robust::orient2d(c, d, b) <= 0.0
}
