//! Randomised cases in named families, each around one way of losing digits or one thing to get right.
//!
//! A case is named `family:seed:index` and drawn from a random stream of its own, so it depends on nothing but its name: a
//! shard, a replay and a test see the same case, bit for bit, on every machine. Lengths are about 1, emission about 1 unless
//! the family says otherwise; parameters that cover decades are spread logarithmically. All comes from ring operations,
//! division and square root, which IEEE 754 rounds in one way.

mod degenerate;
mod description;
mod emission;
mod extreme;
mod frame;
mod horizon;
mod many_sided;
mod mixed;
mod near;
mod occluded;
mod scene;
mod spread;
mod world;

use std::fmt;
use std::str::FromStr;

use radgrad_scene::case::Case;

use crate::cases::name::{Families, UnknownFamily};
use crate::cases::sampler::Sampler;
use scene::Scene;

/// One way of being difficult.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// A fat triangle, wholly above the horizon, at 1/4 to 8 sizes.
    Generic,
    /// The same at 10 to 10^8 sizes.
    Far,
    /// The horizon cuts the triangle.
    Clipped,
    /// The receiver is 1e-12 to 1e-1 sizes above the inside of the emitter.
    Contact,
    /// The receiver is 1e-12 to 1e-1 sizes from the inside of an edge.
    NearEdge,
    /// The receiver is 1e-12 to 1e-1 sizes from a vertex.
    NearVertex,
    /// The receiver is 1e-12 to 1e-1 sizes from the line of an edge, beyond its ends.
    NearExtension,
    /// The receiver is beside the emitter, 1e-12 to 1e-1 sizes above its plane.
    Grazing,
    /// A corner or an edge of the emitter looks over the horizon by 1e-12 to 1e-1 of its distance.
    HorizonSliver,
    /// A triangle 1e-8 to 1e-1 times as wide as long.
    Needle,
    /// Generic, scaled by 2^-300 to 2^300, the receiver's normal by another such power.
    Scale,
    /// Generic, up to 2^40 sizes from the origin of the coordinates.
    FarOrigin,
    /// Star-shaped and rectilinear polygons with reflex vertices, exactly planar.
    Concave,
    /// Convex polygons with 3 to 24 vertices, some of them on a straight edge; exactly planar.
    NGon,
    /// A needle at 10 to 10^8 sizes.
    FarNeedle,
    /// The horizon cuts the triangle at 10 to 10^8 sizes.
    FarClipped,
    /// A polygon at 10 to 10^8 sizes, one vertex hidden by an occluder that stands on it.
    FarScreen,
    /// Almost touching, and only a vertex or an edge looks over the horizon, by little.
    ContactSliver,
    /// Almost touching, at a scale of 2^600 to 2^900 or the inverse.
    ContactScale,
    /// Just above the plane, at a scale of 2^600 to 2^900 or the inverse.
    GrazingScale,
    /// A polygon behind an occluder that stands on it, at a scale of 2^600 to 2^900 or the inverse.
    ScreenScale,
    /// By the line of an edge, the emission linear and steep: up to 2^40 between vertices.
    SteepExtension,
    /// A polynomial emission of degree 2 to 6 at 10 to 10^8 sizes.
    PolynomialFar,
    /// The same cut by the horizon.
    PolynomialClipped,
    /// The receiver is exactly in the emitter's plane, inside, on an edge or at a vertex: 0.
    InPlaneInside,
    /// The receiver is exactly in the emitter's plane, outside: 0.
    InPlaneOutside,
    /// The receiver is behind the emitter, at any distance: 0.
    BackFacing,
    /// The emitter is wholly below the receiver's horizon, at any distance: 0.
    BelowHorizon,
    /// The receiver is a point of the inside or of an edge as far as rounding allows.
    OnSurface,
    /// Generic, the receiver's normal 2^-1040 to 2^-100 long.
    ShortNormal,
    /// Generic at a size of 2^-1040 to 2^-1010: the coordinates are subnormal.
    Subnormal,
    /// Generic, some coordinates 2^-1000 to 2^-200, the emission 2^-900 to 2^900.
    MixedExponents,
    /// Emission of both signs that cancels but for 2^-50 to 2^-3 of it.
    CancellingValues,
    /// Two vertices are 2^-48 to 2^-20 of an edge from each other.
    NearCoincidentVertices,
    /// A star with a hundred vertices.
    HundredVertices,
    /// Occluders in the emitter's plane, in the horizon and seen edge-on hide nothing.
    OccludersInPlane,
    /// Repeated vertices or no area: to be refused.
    EqualVertices,
    /// A triangle between receiver and emitter hides a part.
    OneScreen,
    /// Ten triangles between, overlapping.
    TenScreens,
    /// An occluder's edge is seen along an edge of the emitter, off it by 2^-40 to 2^-3 of its size.
    SilhouetteScreen,
    /// An occluder stands on an edge of the emitter.
    EdgeScreen,
    /// An occluder has a corner in the emitter's plane, but for rounding or a little more.
    DippingScreen,
    /// An occluder at 2^-24 to 2^-8 of the way, almost touching the receiver.
    NearScreen,
    /// Components of the receiver's normal are 2^60 to 2^240 apart, and the small one decides the visible part.
    SteepNormal,
    /// An occluder 2^-160 to 2^160 times as far or as large as the emitter.
    OtherScale,
    /// A wall stands on the receiver's floor, exactly.
    Standing,
    /// Vertices are rounded to single precision, up to 2^8 sizes from the origin, as a renderer's are; half the emitters are behind a quadrilateral.
    Single,
    /// Occluders behind the receiver, behind the emitter and in its plane hide nothing.
    IdleScreens,
    /// In a closed box, another box in the way.
    Boxes,
    /// Two dozen small triangles between.
    Thicket,
    /// A thousand smaller ones.
    ThousandTriangles,
}

impl Family {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 51] = [
        Self::Generic,
        Self::Far,
        Self::Clipped,
        Self::Contact,
        Self::NearEdge,
        Self::NearVertex,
        Self::NearExtension,
        Self::Grazing,
        Self::HorizonSliver,
        Self::Needle,
        Self::Scale,
        Self::FarOrigin,
        Self::Concave,
        Self::NGon,
        Self::FarNeedle,
        Self::FarClipped,
        Self::FarScreen,
        Self::ContactSliver,
        Self::ContactScale,
        Self::GrazingScale,
        Self::ScreenScale,
        Self::SteepExtension,
        Self::PolynomialFar,
        Self::PolynomialClipped,
        Self::InPlaneInside,
        Self::InPlaneOutside,
        Self::BackFacing,
        Self::BelowHorizon,
        Self::OnSurface,
        Self::ShortNormal,
        Self::Subnormal,
        Self::MixedExponents,
        Self::CancellingValues,
        Self::NearCoincidentVertices,
        Self::HundredVertices,
        Self::OccludersInPlane,
        Self::EqualVertices,
        Self::OneScreen,
        Self::TenScreens,
        Self::SilhouetteScreen,
        Self::EdgeScreen,
        Self::DippingScreen,
        Self::NearScreen,
        Self::SteepNormal,
        Self::OtherScale,
        Self::Standing,
        Self::Single,
        Self::IdleScreens,
        Self::Boxes,
        Self::Thicket,
        Self::ThousandTriangles,
    ];

    /// Name in tables and ids.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Generic => "generic",
            Self::Far => "far",
            Self::Clipped => "clipped",
            Self::Contact => "contact",
            Self::NearEdge => "near-edge",
            Self::NearVertex => "near-vertex",
            Self::NearExtension => "near-extension",
            Self::Grazing => "grazing",
            Self::HorizonSliver => "horizon-sliver",
            Self::Needle => "needle",
            Self::Scale => "scale",
            Self::FarOrigin => "far-origin",
            Self::Concave => "concave",
            Self::NGon => "n-gon",
            Self::FarNeedle => "far-needle",
            Self::FarClipped => "far-clipped",
            Self::FarScreen => "far-screen",
            Self::ContactSliver => "contact-sliver",
            Self::ContactScale => "contact-scale",
            Self::GrazingScale => "grazing-scale",
            Self::ScreenScale => "screen-scale",
            Self::SteepExtension => "steep-extension",
            Self::PolynomialFar => "polynomial-far",
            Self::PolynomialClipped => "polynomial-clipped",
            Self::InPlaneInside => "in-plane-inside",
            Self::InPlaneOutside => "in-plane-outside",
            Self::BackFacing => "back-facing",
            Self::BelowHorizon => "below-horizon",
            Self::OnSurface => "on-surface",
            Self::ShortNormal => "short-normal",
            Self::Subnormal => "subnormal",
            Self::MixedExponents => "mixed-exponents",
            Self::CancellingValues => "cancelling-values",
            Self::NearCoincidentVertices => "near-coincident-vertices",
            Self::HundredVertices => "hundred-vertices",
            Self::OccludersInPlane => "occluders-in-plane",
            Self::EqualVertices => "equal-vertices",
            Self::OneScreen => "one-screen",
            Self::TenScreens => "ten-screens",
            Self::SilhouetteScreen => "silhouette-screen",
            Self::EdgeScreen => "edge-screen",
            Self::DippingScreen => "dipping-screen",
            Self::NearScreen => "near-screen",
            Self::SteepNormal => "steep-normal",
            Self::OtherScale => "other-scale",
            Self::Standing => "standing",
            Self::Single => "single",
            Self::IdleScreens => "idle-screens",
            Self::Boxes => "boxes",
            Self::Thicket => "thicket",
            Self::ThousandTriangles => "thousand-triangles",
        }
    }

    /// Whether the exact answer is 0 in every case.
    #[must_use]
    pub const fn is_dark(self) -> bool {
        matches!(self, Self::InPlaneInside | Self::InPlaneOutside | Self::BackFacing | Self::BelowHorizon)
    }

    /// Whether every case must be refused: an answer is then wrong, whatever it is.
    #[must_use]
    pub const fn is_refused(self) -> bool {
        matches!(self, Self::EqualVertices)
    }

    /// Whether emitters and occluders are flat only up to a rounding that the case states: no tolerance below the effect of that
    /// rounding is met.
    #[must_use]
    pub const fn is_rounded(self) -> bool {
        matches!(self, Self::Single)
    }

    /// Whether as many digits as are asked for can be found of every case: none is left open by its input.
    #[must_use]
    pub const fn has_digits(self) -> bool {
        matches!(
            self,
            Self::Generic
                | Self::Clipped
                | Self::Far
                | Self::NGon
                | Self::SteepNormal
                | Self::OneScreen
                | Self::OtherScale
                | Self::Standing
        )
    }

    /// Of how many cases of other families one is enough here, as each takes so much longer.
    #[must_use]
    pub(crate) const fn dearness(self) -> u64 {
        match self {
            Self::TenScreens | Self::Boxes => 4,
            Self::Thicket => 8,
            Self::HundredVertices => 40,
            Self::ThousandTriangles => 800,
            _ => 1,
        }
    }

    /// Case `index` under `seed`.
    #[must_use]
    pub fn case(self, seed: u64, index: u64) -> Case {
        let sampler = &mut Sampler::new(seed, self.name(), index);
        let scene = self.scene(sampler);
        scene.into_case(Name { family: self, seed, index }.to_string(), sampler)
    }

    fn scene(self, sampler: &mut Sampler) -> Scene {
        match self {
            Self::Generic => spread::generic(sampler),
            Self::Far => spread::far(sampler),
            Self::Clipped => horizon::clipped(sampler),
            Self::Contact => near::contact(sampler),
            Self::NearEdge => near::edge(sampler),
            Self::NearVertex => near::vertex(sampler),
            Self::NearExtension => near::extension(sampler),
            Self::Grazing => near::grazing(sampler),
            Self::HorizonSliver => horizon::sliver(sampler),
            Self::Needle => spread::needle(sampler),
            Self::Scale => spread::scale(sampler),
            Self::FarOrigin => spread::far_origin(sampler),
            Self::Concave => many_sided::concave(sampler),
            Self::NGon => many_sided::convex(sampler),
            Self::FarNeedle => mixed::far_needle(sampler),
            Self::FarClipped => mixed::far_clipped(sampler),
            Self::FarScreen => mixed::far_screen(sampler),
            Self::ContactSliver => mixed::contact_sliver(sampler),
            Self::ContactScale => mixed::contact_scale(sampler),
            Self::GrazingScale => mixed::grazing_scale(sampler),
            Self::ScreenScale => mixed::screen_scale(sampler),
            Self::SteepExtension => mixed::steep_extension(sampler),
            Self::PolynomialFar => mixed::polynomial_far(sampler),
            Self::PolynomialClipped => mixed::polynomial_clipped(sampler),
            Self::InPlaneInside => many_sided::in_plane_inside(sampler),
            Self::InPlaneOutside => many_sided::in_plane_outside(sampler),
            Self::BackFacing => degenerate::back_facing(sampler),
            Self::BelowHorizon => degenerate::below_horizon(sampler),
            Self::OnSurface => extreme::on_surface(sampler),
            Self::ShortNormal => extreme::short_normal(sampler),
            Self::Subnormal => extreme::subnormal(sampler),
            Self::MixedExponents => extreme::mixed_exponents(sampler),
            Self::CancellingValues => extreme::cancelling_values(sampler),
            Self::NearCoincidentVertices => extreme::near_coincident_vertices(sampler),
            Self::HundredVertices => extreme::hundred_vertices(sampler),
            Self::OccludersInPlane => extreme::occluders_in_plane(sampler),
            Self::EqualVertices => degenerate::equal_vertices(sampler),
            Self::OneScreen => occluded::one_screen(sampler),
            Self::TenScreens => occluded::ten_screens(sampler),
            Self::SilhouetteScreen => occluded::silhouette_screen(sampler),
            Self::EdgeScreen => occluded::edge_screen(sampler),
            Self::DippingScreen => occluded::dipping_screen(sampler),
            Self::NearScreen => occluded::near_screen(sampler),
            Self::SteepNormal => world::steep_normal(sampler),
            Self::OtherScale => world::other_scale(sampler),
            Self::Standing => world::standing(sampler),
            Self::Single => world::single(sampler),
            Self::IdleScreens => occluded::idle_screens(sampler),
            Self::Boxes => occluded::boxes(sampler),
            Self::Thicket => occluded::thicket(sampler),
            Self::ThousandTriangles => occluded::thousand_triangles(sampler),
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Family {
    type Err = UnknownFamily<Self>;

    fn from_str(text: &str) -> Result<Self, UnknownFamily<Self>> {
        Self::find(text)
    }
}

impl Families for Family {
    const EVERY: &'static [Self] = &Self::ALL;
    const KIND: &'static str = "family";
    const MEMBER: [&'static str; 2] = ["case", "contact:1:17"];

    fn id(self) -> &'static str {
        self.name()
    }
}

/// The name of a case: `contact:1:17` is case 17 of family `contact` under seed 1.
///
/// ```
/// use radgrad_audit::cases::family::{Family, Name};
/// let name: Name = "contact:1:17".parse()?;
/// assert_eq!((name.family, name.index), (Family::Contact, 17));
/// assert_eq!(name.case(), Family::Contact.case(1, 17), "the same bits on every machine");
/// # Ok::<(), radgrad_audit::cases::name::BadName<Family>>(())
/// ```
pub type Name = crate::cases::name::Name<Family>;

impl Name {
    /// The case of this name.
    #[must_use]
    pub fn case(self) -> Case {
        self.family.case(self.seed, self.index)
    }
}

#[cfg(test)]
mod tests;
