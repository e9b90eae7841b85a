//! The surface integrals that the paper leaves to Gaussian quadrature: `X1 = int dA/r^2` and `X2 = int dA/r^4` over the emitter.
//!
//! With h the height of `x` over the emitter plane and q its in-plane part of r, the radial integral from the foot of `x` is
//! elementary, and the rest is an integral along the contour (`c_i = n2.w_i`, twice the signed area of foot and edge):
//!
//! ```text
//! X1 = sum c_i/2 int_0^1 ln(1 + q^2/h^2) / q^2 dt        X2 = sum c_i/(2 h^2) int_0^1 dt/r^2
//! ```
//!
//! Both integrands are analytic but where r^2 = 0, at `t* +- i S/|e|`, S the distance of the edge's line. An edge is halved
//! until each panel is as long as its middle is far from `x` at most: the nearest singularity is then 2 half-lengths from the
//! middle, in units of which 16 Gauss nodes leave `(2 + sqrt 3)^-32 = 5e-19`. The remaining error is rounding: 1e-15 where the foot
//! is in or near the emitter; far outside the signed triangles cancel, by the ratio of distance to size.

use radgrad_core::DVec3;

use crate::appendix::edge::AppendixEdge;

/// Nodes and weights of the 16-point Gauss-Legendre rule on [-1, 1], the positive half.
const GAUSS: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_8, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_88),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_894),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_096),
];

/// X1 and X2 of the polygon with these edges and normal `n2`.
pub(super) fn x1_x2(edges: &[AppendixEdge], n2: DVec3) -> (f64, f64) {
    let h = n2.dot(edges[0].r);
    edges.iter().fold((0.0, 0.0), |(x1, x2), edge| {
        let c = n2.dot(edge.w);
        let q = edge.r - n2.dot(edge.r) * n2;
        let (first, second) = contour_integrals(q, edge.e, h * h);
        (x1 + 0.5 * c * first, x2 + 0.5 * c * second / (h * h))
    })
}

/// `int ln(1 + q^2/h^2)/q^2 dt` and `int dt/(h^2 + q^2)` along `q(t) = q + t e`, by halving.
fn contour_integrals(q: DVec3, e: DVec3, hh: f64) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    let mut panels = vec![(0.0, 1.0)];
    while let Some((start, length)) = panels.pop() {
        let (middle, half) = (start + 0.5 * length, 0.5 * length);
        if length * length * e.length_squared() > hh + (q + middle * e).length_squared() {
            panels.extend([(start, half), (middle, half)]);
            continue;
        }
        for (node, weight) in GAUSS {
            for t in [middle - half * node, middle + half * node] {
                let qq = (q + t * e).length_squared();
                let u = qq / hh;
                // ln(1 + u)/u has the limit 1 at the foot itself.
                let ratio = if u == 0.0 { 1.0 } else { libm::log1p(u) / u };
                sum.0 += half * weight * ratio / hh;
                sum.1 += half * weight / (hh + qq);
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appendix::misprint::Misprints;

    fn edges(vertices: &[DVec3]) -> Vec<AppendixEdge> {
        let vertex = |i: usize| vertices[i % vertices.len()];
        (0..vertices.len())
            .map(|i| AppendixEdge::new(i, [vertex(i), vertex(i + 1), vertex(i + 2)], Misprints(&[])).unwrap())
            .collect()
    }

    #[test]
    fn the_rule_is_exact_to_degree_31() {
        for degree in (0..32).step_by(2) {
            let sum: f64 = GAUSS.iter().map(|(x, w)| 2.0 * w * x.powi(degree)).sum();
            let exact = 2.0 / f64::from(degree + 1);
            assert!((sum / exact - 1.0).abs() < 1e-15 * 4.0, "degree {degree}: {sum} for {exact}");
        }
    }

    #[test]
    fn x2_equals_its_closed_form_by_i1() {
        // X2 = sum c_i I1(i) / (2 h^2), the atan of the edge integral instead of the quadrature.
        let triangle = [DVec3::new(-0.3, -0.2, 0.7), DVec3::new(0.1, 0.9, 0.7), DVec3::new(0.8, -0.4, 0.7)];
        for height in [1.0, 0.1, 1e-3, 1e-6] {
            let edges = edges(&triangle.map(|v| DVec3::new(v.x, v.y, height)));
            let (_, x2) = x1_x2(&edges, -DVec3::Z);
            let exact: f64 = edges.iter().map(|e| 0.5 * -e.w.z * e.i1).sum::<f64>() / (height * height);
            assert!((x2 / exact - 1.0).abs() < 2e-15, "at height {height}: {x2} for {exact}");
        }
    }

    #[test]
    fn x1_of_a_quarter_square_tends_to_its_series() {
        // Over the square [0, s]^2 at height 1, 1/r^2 = 1 - q^2 + q^4 - ...: X1 = s^2 - 2 s^4/3 + 28 s^6/45 - 24 s^8/35 +
        // O(s^10).
        let s = 1.0 / 1024.0;
        let square = [DVec3::Z, DVec3::new(0.0, s, 1.0), DVec3::new(s, s, 1.0), DVec3::new(s, 0.0, 1.0)];
        let (x1, _) = x1_x2(&edges(&square), -DVec3::Z);
        let exact = s * s * (1.0 - s * s * (2.0 / 3.0 - s * s * 28.0 / 45.0));
        assert!((x1 / exact - 1.0).abs() < 1e-15, "{x1} for {exact}");
    }
}
