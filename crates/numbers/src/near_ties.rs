//! Logarithms and arc tangents that lie nearest to a double or midway between two, from `data/reference/near_ties.txt`: few digits
//! do not tell on which side. The example `near_ties` finds them.

use astro_float::{BigFloat, Consts, RoundingMode};

use crate::arc_tangent;
use crate::ball::Ball;
use crate::big::enclosure::Enclosure;
use crate::big::{Big, within};
use crate::double_double::{DoubleDouble, ROUNDOFF_OF_DOUBLE_DOUBLE};
use crate::logarithm;
use crate::number::{Number, ROUNDOFF};
use crate::radius::Radius;
use crate::real::Real;

const BITS: usize = 320;
const NEAREST: RoundingMode = RoundingMode::ToEven;

/// A function, an argument, and how near its value is to a multiple of half a unit in the last place: 2^-nearness of one.
struct Tie {
    is_logarithm: bool,
    x: f64,
    nearness: f64,
}

fn ties() -> Vec<Tie> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/near_ties.txt");
    let text = std::fs::read_to_string(file).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let tie = |line: &str| {
        let [function, x, nearness] = line.split(' ').collect::<Vec<_>>().try_into().unwrap();
        assert!(["ln", "atan"].contains(&function), "{line}");
        let nearness = nearness.strip_prefix("2^-").unwrap().parse().unwrap();
        Tie { is_logarithm: function == "ln", x: x.parse().unwrap(), nearness }
    };
    lines.map(tie).collect()
}

impl Tie {
    fn truth(&self, consts: &mut Consts) -> BigFloat {
        let x = BigFloat::from_f64(self.x, BITS);
        if self.is_logarithm { x.ln(BITS, NEAREST, consts) } else { x.atan(BITS, NEAREST, consts) }
    }

    fn evaluate<T: Real>(&self) -> T {
        let x = T::exact(self.x);
        if self.is_logarithm { x.ln() } else { x.atan2(T::exact(1.0)) }
    }
}

fn minus(a: &BigFloat, b: &BigFloat) -> f64 {
    a.sub(b, BITS, NEAREST).to_string().parse().unwrap()
}

fn big(x: DoubleDouble) -> BigFloat {
    BigFloat::from_f64(x.hi, BITS).add(&BigFloat::from_f64(x.lo, BITS), BITS, NEAREST)
}

#[test]
fn near_ties_are_as_near_as_stated_and_every_precision_keeps_its_bound() {
    let (ties, mut consts) = (ties(), Consts::new().unwrap());
    assert!(ties.len() >= 40 && ties.iter().all(|tie| tie.nearness > 30.0));
    for tie in &ties {
        let (truth, x) = (tie.truth(&mut consts), tie.x);
        // The double below the value, and the nearest multiple of half its unit.
        let near: f64 = truth.to_string().parse().unwrap();
        let unit = near.abs().next_up() - near.abs();
        let halves = [-0.5, 0.0, 0.5].map(|half| big(DoubleDouble::from(near) + DoubleDouble::from(half * unit)));
        let nearest = halves.iter().min_by(|a, b| minus(a, &truth).abs().total_cmp(&minus(b, &truth).abs())).unwrap();
        let distance = minus(&truth, nearest);
        let nearness = (0.5 * unit / distance.abs()).log2();
        assert!((nearness - tie.nearness).abs() < 0.1, "{x:?}: 2^-{nearness}");
        let side = |value: &BigFloat| minus(value, nearest).signum();

        let value = if tie.is_logarithm { logarithm::ln(x) } else { arc_tangent::atan2(x, 1.0) };
        let units = if tie.is_logarithm { logarithm::UNITS } else { arc_tangent::UNITS };
        let error = |value: f64| minus(&BigFloat::from_f64(value, BITS), &truth);
        assert!((error(value) / value / ROUNDOFF).abs() <= units, "{x:?}");

        let wide = DoubleDouble::from(x);
        let value = if tie.is_logarithm { wide.ln() } else { wide.atan2(DoubleDouble::from(1.0)) };
        let wide_error = minus(&big(value), &truth);
        assert!((wide_error / value.hi).abs() <= <DoubleDouble as Number>::LIBRARY_UNITS * ROUNDOFF_OF_DOUBLE_DOUBLE, "{x:?}");
        // Roundings of 2^-103 tell the side but of the worst case.
        assert!(tie.nearness > 40.0 || side(&big(value)) == distance.signum(), "{x:?}");

        let ball = tie.evaluate::<Ball<f64>>();
        assert!(error(ball.middle()).abs() <= ball.error(), "{x:?}");
        let ball = tie.evaluate::<Ball<DoubleDouble>>();
        assert!(minus(&big(ball.middle()), &truth).abs() <= ball.error(), "{x:?}");
        // Its result for users is a double and a bound.
        assert!(error(ball.value()).abs() <= ball.value_error(), "{x:?}");

        for bits in [128, 256] {
            let (enclosure, _) = within(bits, u64::MAX, || Enclosure::from_ball(tie.evaluate::<Ball<Big>>()));
            let (double, bound) = enclosure.unwrap().to_double();
            let bound = bound.to_double();
            assert!(error(double).abs() <= bound && bound <= 1.001 * ROUNDOFF * near.abs(), "{x:?}: {bound:e}");
            // The nearest double, though it is nearly midway.
            assert_eq!(double, near, "{x:?}");
        }
    }
}
