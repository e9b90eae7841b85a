//! Families in plain words, for tables that people read.

use super::Family;

impl Family {
    /// The cases of the family, in one line.
    #[must_use]
    pub const fn description(self) -> &'static str {
        match self {
            Self::Generic => "a fat triangle above the horizon, at 1/4 to 8 of its sizes",
            Self::Far => "the same at 10 to 1e8 sizes",
            Self::Clipped => "the receiver's horizon cuts the triangle",
            Self::Contact => "1e-12 to 0.1 sizes above the inside of the emitter",
            Self::NearEdge => "1e-12 to 0.1 sizes from the inside of an edge",
            Self::NearVertex => "1e-12 to 0.1 sizes from a vertex",
            Self::NearExtension => "1e-12 to 0.1 sizes from the line of an edge, beyond its ends",
            Self::Grazing => "beside the emitter, 1e-12 to 0.1 sizes above its plane",
            Self::HorizonSliver => "a corner or an edge looks over the horizon by 1e-12 to 0.1",
            Self::Needle => "a triangle 1e-8 to 0.1 times as wide as long",
            Self::Scale => "scaled by 2^-300 to 2^300",
            Self::FarOrigin => "up to 2^40 sizes from the origin of the coordinates",
            Self::Concave => "polygons with reflex vertices",
            Self::NGon => "convex polygons with 3 to 24 vertices, some on a straight edge",
            Self::FarNeedle => "a needle at 10 to 1e8 sizes",
            Self::FarClipped => "cut by the horizon at 10 to 1e8 sizes",
            Self::FarScreen => "a vertex hidden by an occluder, at 10 to 1e8 sizes",
            Self::ContactSliver => "almost touching, and little of the emitter above the horizon",
            Self::ContactScale => "almost touching, scaled by 2^600 to 2^900 or the inverse",
            Self::GrazingScale => "just above the plane, scaled by 2^600 to 2^900 or the inverse",
            Self::ScreenScale => "a vertex hidden by an occluder, scaled by 2^600 to 2^900 or the inverse",
            Self::SteepExtension => "by the line of an edge, the emission up to 2^40 times steeper",
            Self::PolynomialFar => "a polynomial emission of degree 2 to 6, at 10 to 1e8 sizes",
            Self::PolynomialClipped => "the same cut by the horizon",
            Self::InPlaneInside => "exactly in the emitter's plane, inside or on its boundary: dark",
            Self::InPlaneOutside => "exactly in the emitter's plane, outside: dark",
            Self::BackFacing => "behind the emitter: dark",
            Self::BelowHorizon => "the emitter wholly below the horizon: dark",
            Self::OneScreen => "a polygon before the emitter",
            Self::TenScreens => "ten polygons between receiver and emitter, overlapping",
            Self::SilhouetteScreen => "a screen whose edge passes by the emitter's border",
            Self::EdgeScreen => "a screen that shares an edge with the emitter",
            Self::DippingScreen => "a screen with a corner in the emitter's plane, or 2^-52 to 2^-30 off it",
            Self::NearScreen => "a screen almost touching the receiver",
            Self::SteepNormal => "components of the receiver's normal are 2^60 to 2^240 apart",
            Self::OtherScale => "an occluder is 2^-160 to 2^160 times as far or as large as the emitter",
            Self::Standing => "a wall stands on the receiver's floor, exactly",
            Self::Single => "vertices rounded to single precision, up to 2^8 sizes from the origin",
            Self::IdleScreens => "screens that hide nothing: behind the receiver, behind the emitter or in its plane",
            Self::Boxes => "a room with a box in it",
            Self::Thicket => "two dozen triangles at random",
            Self::ThousandTriangles => "a thousand triangles at random",
            Self::OnSurface => "a point of the emitter as far as rounding allows, inside or on an edge",
            Self::ShortNormal => "the receiver's normal is 2^-1040 to 2^-100 long",
            Self::Subnormal => "at a size of 2^-1040 to 2^-1010, where coordinates are subnormal",
            Self::MixedExponents => "coordinates of 1 beside 1e-300, emission of 1e-270 beside 1e270",
            Self::CancellingValues => "emission of both signs that cancels but for 1e-15 to 0.1 of it",
            Self::NearCoincidentVertices => "two vertices 1e-14 to 1e-6 of an edge from each other",
            Self::HundredVertices => "a star with a hundred vertices",
            Self::OccludersInPlane => "occluders in the emitter's plane, in the horizon and seen edge-on",
            Self::EqualVertices => "repeated vertices or no area: to be refused",
        }
    }
}
