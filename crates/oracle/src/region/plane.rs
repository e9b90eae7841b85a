//! Points, edges and triangles of the emitter's plane in doubles, in the coordinates of `region`, for the rules.
//!
//! Halving keeps the corners' numbers exact: `p, q, s, b` of a middle are means, areas and moments are halved exactly, so a small
//! piece next to a corner is as accurate, relatively, as the corner.

/// A point of the emitter's plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Vertex {
    pub(crate) p: f64,
    pub(crate) q: f64,
    pub(crate) s: f64,
    pub(crate) b: f64,
}

/// A triangle of the emitter's plane, with its area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triangle {
    pub(crate) corners: [Vertex; 3],
    pub(crate) area: f64,
}

/// A directed segment of the emitter's plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edge {
    pub(crate) ends: [Vertex; 2],
    /// Vector from the first end to the second.
    pub(crate) along: [f64; 2],
    /// `p dq - q dp`: twice the area of the triangle with the foot of the receiver.
    pub(crate) moment: f64,
}

impl Edge {
    /// The point at `t` in `[0, 1]`.
    #[inline]
    pub(crate) fn point(&self, t: f64) -> Vertex {
        self.between([1.0 - t, t])
    }

    /// The point with these weights of the two ends, of sum 1.
    #[inline]
    pub(crate) fn between(&self, [from, to]: [f64; 2]) -> Vertex {
        let [a, b] = &self.ends;
        let mean = |a: f64, b: f64| from * a + to * b;
        Vertex { p: mean(a.p, b.p), q: mean(a.q, b.q), s: mean(a.s, b.s), b: mean(a.b, b.b) }
    }

    pub(crate) fn halves(&self) -> [Self; 2] {
        let middle = self.point(0.5);
        let half = |from, to| Self { ends: [from, to], along: self.along.map(|c| 0.5 * c), moment: 0.5 * self.moment };
        [half(self.ends[0], middle), half(middle, self.ends[1])]
    }

    pub(crate) fn squared_length(&self) -> f64 {
        self.along[0] * self.along[0] + self.along[1] * self.along[1]
    }

    /// Square of the distance from the foot of the receiver.
    pub(crate) fn squared_distance_to_foot(&self) -> f64 {
        squared_distance_to_edge(&self.ends[0], &self.ends[1])
    }
}

impl Triangle {
    /// The point with barycentric coordinates `l`.
    #[inline]
    pub(crate) fn point(&self, l: [f64; 3]) -> Vertex {
        let [a, b, c] = &self.corners;
        Vertex {
            p: l[0] * a.p + l[1] * b.p + l[2] * c.p,
            q: l[0] * a.q + l[1] * b.q + l[2] * c.q,
            s: l[0] * a.s + l[1] * b.s + l[2] * c.s,
            b: l[0] * a.b + l[1] * b.b + l[2] * c.b,
        }
    }

    /// The point at in-plane coordinates `(p, q)`, if it is inside or on the border.
    pub(crate) fn vertex(&self, p: f64, q: f64) -> Option<Vertex> {
        let [a, b, c] = &self.corners;
        let opposite = |from: &Vertex, to: &Vertex| (to.p - from.p) * (q - from.q) - (to.q - from.q) * (p - from.p);
        let parts = [opposite(b, c), opposite(c, a), opposite(a, b)];
        let sum = parts[0] + parts[1] + parts[2];
        (sum > 0.0 && parts.iter().all(|part| *part >= 0.0)).then(|| self.point(parts.map(|part| part / sum)))
    }

    /// Halves, by the middle of the longest edge.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let [a, b, c] = self.corners;
        let squared = [(b, c), (c, a), (a, b)].map(|(from, to)| squared_distance(&from, &to));
        let (apex, from, to) = if squared[0] >= squared[1] && squared[0] >= squared[2] {
            (a, b, c)
        } else if squared[1] >= squared[2] {
            (b, c, a)
        } else {
            (c, a, b)
        };
        let half = |x: f64, y: f64| 0.5 * (x + y);
        let middle = Vertex { p: half(from.p, to.p), q: half(from.q, to.q), s: half(from.s, to.s), b: half(from.b, to.b) };
        let area = 0.5 * self.area;
        [Self { corners: [apex, from, middle], area }, Self { corners: [apex, middle, to], area }]
    }

    /// Square of the longest edge.
    pub(crate) fn squared_diameter(&self) -> f64 {
        let [a, b, c] = &self.corners;
        squared_distance(a, b).max(squared_distance(b, c)).max(squared_distance(c, a))
    }

    /// Square of the distance from the foot of the receiver; 0 if it is inside.
    pub(crate) fn squared_distance_to_foot(&self) -> f64 {
        let [a, b, c] = &self.corners;
        let edges = [(a, b), (b, c), (c, a)];
        if edges.iter().all(|(from, to)| from.p * to.q - from.q * to.p >= 0.0) {
            return 0.0;
        }
        edges.iter().map(|(from, to)| squared_distance_to_edge(from, to)).fold(f64::INFINITY, f64::min)
    }
}

fn squared_distance(a: &Vertex, b: &Vertex) -> f64 {
    (b.p - a.p) * (b.p - a.p) + (b.q - a.q) * (b.q - a.q)
}

/// Square of the distance of the foot from a segment.
fn squared_distance_to_edge(from: &Vertex, to: &Vertex) -> f64 {
    let (ep, eq) = (to.p - from.p, to.q - from.q);
    let along = -(from.p * ep + from.q * eq);
    let squared_length = ep * ep + eq * eq;
    if along <= 0.0 {
        from.p * from.p + from.q * from.q
    } else if along >= squared_length {
        to.p * to.p + to.q * to.q
    } else {
        let across = from.p * eq - from.q * ep;
        across * across / squared_length
    }
}
