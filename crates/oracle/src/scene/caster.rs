//! The first face that a ray meets. Of faces that it meets at one place, up to rounding, that is one that it meets from the front: two faces
//! in one plane, back to back, are the two sides of a plate, and a ray meets the side that it comes to.

use glam::DVec3;

use super::Face;

/// Units of rounding of the coordinates within which a face is in another's plane: a few sums and products.
const LEVEL: f64 = 16.0 * f64::EPSILON;

/// Faces prepared for rays.
#[derive(Debug)]
pub(super) struct Caster {
    plates: Vec<Plate>,
    /// For each face, whether each other one is in its plane.
    level: Vec<Vec<bool>>,
    slack: f64,
}

#[derive(Debug)]
struct Plate {
    vertices: Vec<DVec3>,
    normal: DVec3,
    /// Area over perimeter: so far from the vertices the plane is off by about as much as they are.
    width: f64,
}

impl Plate {
    fn new(face: &Face) -> Self {
        let vertices = face.polygon.vertices().to_vec();
        let perimeter: f64 = (0..vertices.len()).map(|i| (vertices[(i + 1) % vertices.len()] - vertices[i]).length()).sum();
        Self { normal: face.polygon.normal(), width: face.polygon.area() / perimeter, vertices }
    }

    /// Height of a point over the plane.
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.vertices[0])
    }

    /// Whether a point is in the plane, where the vertices are off by so much.
    fn holds(&self, point: DVec3, slack: f64) -> bool {
        self.height(point).abs() <= slack * (1.0 + (point - self.vertices[0]).length() / self.width)
    }
}

/// The face that a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    pub(super) face: usize,
    /// Distance in lengths of the direction.
    pub(super) parameter: f64,
    /// Whether the side that gives and takes light was met.
    pub(super) front: bool,
}

impl Caster {
    pub(super) fn new(faces: &[Face]) -> Self {
        let plates: Vec<Plate> = faces.iter().map(Plate::new).collect();
        let largest = plates.iter().flat_map(|plate| &plate.vertices).map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let slack = LEVEL * largest;
        let is_level =
            |a: &Plate, b: &Plate| b.vertices.iter().all(|v| a.holds(*v, slack)) && a.vertices.iter().all(|v| b.holds(*v, slack));
        let level = plates.iter().map(|a| plates.iter().map(|b| is_level(a, b)).collect()).collect();
        Self { plates, level, slack }
    }

    /// The most that rounding may move a point of a plane.
    pub(super) const fn slack(&self) -> f64 {
        self.slack
    }

    /// Whether neither of two faces hides anything from the other, for they are in one plane.
    pub(super) fn is_level(&self, a: usize, b: usize) -> bool {
        self.level[a][b]
    }

    /// The first face along `direction` from a point of face `from`: none in the plane of which that point is.
    pub(super) fn first(&self, from: usize, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let shear = Shear::new(direction);
        let [mut front, mut back]: [Option<Hit>; 2] = [None, None];
        for (face, plate) in self.plates.iter().enumerate() {
            if self.level[from][face] {
                continue;
            }
            let advance = plate.normal.dot(direction);
            let parameter = -plate.height(origin) / advance;
            let best = if advance < 0.0 { &mut front } else { &mut back };
            // Also false where the ray is in the plane and the quotient is not a number.
            let nearer = parameter > 0.0 && best.is_none_or(|hit| parameter < hit.parameter);
            if nearer && !plate.holds(origin, self.slack) && shear.meets(origin, &plate.vertices) {
                *best = Some(Hit { face, parameter, front: advance < 0.0 });
            }
        }
        let (Some(hit), Some(behind)) = (front, back) else { return front.or(back) };
        let is_there = || self.plates[behind.face].holds(origin + direction * hit.parameter, self.slack);
        if hit.parameter <= behind.parameter || is_there() { front } else { back }
    }

    /// Whether nothing is between a point of face `from` and a point of face `to`.
    pub(super) fn is_clear(&self, [from, to]: [usize; 2], origin: DVec3, end: DVec3) -> bool {
        let direction = end - origin;
        let shear = Shear::new(direction);
        let blocks = |(face, plate): (usize, &Plate)| {
            if face == from || face == to || self.level[from][face] || self.level[to][face] {
                return false;
            }
            let parameter = -plate.height(origin) / plate.normal.dot(direction);
            let is_between =
                parameter > 0.0 && parameter < 1.0 && ![origin, end].iter().any(|point| plate.holds(*point, self.slack));
            is_between && shear.meets(origin, &plate.vertices)
        };
        !self.plates.iter().enumerate().any(blocks)
    }
}

/// Coordinates in which a ray is the third axis: the largest component of its direction, and the other two less their part of it.
struct Shear {
    axes: [usize; 3],
    slopes: [f64; 2],
}

impl Shear {
    fn new(direction: DVec3) -> Self {
        let d = direction.to_array();
        let along = direction.abs().max_position();
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        Self { axes, slopes: [d[axes[0]] / d[along], d[axes[1]] / d[along]] }
    }

    fn project(&self, v: DVec3) -> [f64; 2] {
        let v = v.to_array();
        let along = v[self.axes[2]];
        [v[self.axes[0]] - self.slopes[0] * along, v[self.axes[1]] - self.slopes[1] * along]
    }

    /// Whether the line of the ray passes through a polygon: the crossings of the first axis by its outline, each decided by the
    /// signs of two ends and one determinant, which is exactly the opposite for the edge in the other direction.
    fn meets(&self, origin: DVec3, vertices: &[DVec3]) -> bool {
        let mut winding = 0;
        let mut a = self.project(vertices[vertices.len() - 1] - origin);
        for vertex in vertices {
            let b = self.project(*vertex - origin);
            if (a[1] <= 0.0) != (b[1] <= 0.0) {
                let side = a[0] * b[1] - a[1] * b[0];
                if a[1] <= 0.0 && side > 0.0 {
                    winding += 1;
                } else if b[1] <= 0.0 && side < 0.0 {
                    winding -= 1;
                }
            }
            a = b;
        }
        winding != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use radgrad_core::Polygon;

    fn face(vertices: &[[f64; 3]]) -> Face {
        let polygon = Polygon::new(vertices.iter().map(|&v| v.into()).collect()).unwrap();
        Face { polygon, reflectance: 0.5, emitted: 0.0, exchanges: true, pattern: None }
    }

    fn square(z: f64, up: bool) -> Face {
        let mut corners = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        if !up {
            corners.reverse();
        }
        face(&corners)
    }

    #[test]
    fn the_nearest_face_counts_and_backs_are_told_from_fronts() {
        let caster = Caster::new(&[square(0.0, true), square(1.0, true), square(2.0, false)]);
        let first = |from, z, up: f64| caster.first(from, DVec3::new(0.3, 0.6, z), DVec3::Z * up);
        assert_eq!(first(0, 0.0, 1.0), Some(Hit { face: 1, parameter: 1.0, front: false }));
        assert_eq!(first(1, 1.0, 2.0), Some(Hit { face: 2, parameter: 0.5, front: true }));
        assert_eq!(first(2, 2.0, 1.0), None);
        assert!(!caster.is_clear([0, 2], DVec3::new(0.3, 0.3, 0.0), DVec3::new(0.4, 0.4, 2.0)));
        assert!(caster.is_clear([0, 1], DVec3::new(0.3, 0.3, 0.0), DVec3::new(0.4, 0.4, 1.0)));
    }

    #[test]
    fn a_plate_of_two_faces_is_met_on_the_side_that_faces_the_ray() {
        for order in [[true, false], [false, true]] {
            let caster = Caster::new(&[square(0.0, true), square(1.0, order[0]), square(1.0, order[1]), square(2.0, false)]);
            for (from, z, up) in [(0, 0.0, 1.0), (3, 2.0, -1.0)] {
                let hit = caster.first(from, DVec3::new(0.3, 0.6, z), DVec3::new(0.1, 0.05, up)).unwrap();
                assert!(hit.front && (hit.face == 1 || hit.face == 2), "{hit:?}");
            }
        }
    }

    #[test]
    fn a_plate_of_many_faces_turned_anyhow_has_two_sides() {
        let mut random = 1_u64;
        let mut uniform = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            2.0 * (random >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
        };
        for _ in 0..6 {
            let turn = glam::DQuat::from_xyzw(uniform(), uniform(), uniform(), uniform()).normalize();
            let shift = DVec3::new(uniform(), uniform(), uniform()) * 9.0;
            let place = |x: f64, y: f64, z: f64| turn * DVec3::new(x, y, z) + shift;
            // The upper side in squares, the lower one in others.
            let side = |count: u32, up: bool| {
                let coordinate = move |k: u32| 2.0 * f64::from(k) / f64::from(count) - 1.0;
                (0..count * count).map(move |k| {
                    let (i, j) = (k / count, k % count);
                    let mut corners =
                        [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| place(coordinate(i), coordinate(j), 0.0));
                    if !up {
                        corners.reverse();
                    }
                    face(&corners.map(|corner| corner.to_array()))
                })
            };
            let wall =
                |z: f64| face(&[(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| place(x, y, z).to_array()));
            let faces: Vec<Face> = side(23, true).chain(side(22, false)).chain([wall(3.0), wall(-3.0)]).collect();
            let (caster, upper, count) = (Caster::new(&faces), 23 * 23, faces.len());
            assert!(count > 1000);
            for _ in 0..300 {
                let [x, y] = [uniform(), uniform()];
                for up in [true, false] {
                    let (from, z) = if up { (count - 2, 3.0) } else { (count - 1, -3.0) };
                    let origin = place(1.9 * uniform(), 1.9 * uniform(), z);
                    let end = place(x, y, 0.0);
                    let hit = caster.first(from, origin, end - origin).unwrap();
                    assert!(hit.front && (hit.face < upper) == up && (hit.parameter - 1.0).abs() < 1e-12, "{hit:?}");
                    assert!(caster.is_clear([from, hit.face], origin, end));
                    // And from there the wall, past all faces of either side.
                    let hit = caster.first(hit.face, end, origin - end).unwrap();
                    assert_eq!(hit.face, from);
                }
            }
        }
    }

    #[test]
    fn no_ray_passes_between_neighbours() {
        // A square of two triangles whose seam, and the seams with the walls around, every ray aims at.
        let (a, b, c, d) = ([0.1, 0.2, 1.0], [1.3, 0.1, 1.1], [1.2, 1.4, 0.9], [0.0, 1.1, 1.05]);
        let caster = Caster::new(&[square(-1.0, true), face(&[a, c, b]), face(&[a, d, c])]);
        for i in 0..20_000 {
            let t = 0.01 + 0.98 * f64::from(i) / 20_000.0;
            let on_seam = DVec3::from(a) * (1.0 - t) + DVec3::from(c) * t;
            let origin = DVec3::new(0.37, 0.41 + 1e-3 * t, -1.0);
            assert!(caster.first(0, origin, on_seam - origin).is_some(), "{t}");
        }
    }
}
