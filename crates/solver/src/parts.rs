//! The pieces of a solution, each asked by itself, for those who hold it to a truth of its own. No part of the interface.

use radgrad_core::{DVec3, Receiver};
use radgrad_scene::{Scene, largest};

use crate::clock::Clock;
use crate::error::Error;
use crate::estimate::unsampled::{self, Edges, Outlined};
use crate::estimate::visible_sources::VisibleSources;
use crate::estimate::{point, sources};
use crate::field::Field;
use crate::links::cell::Rules;
use crate::links::cluster::sampled::Draw;
use crate::links::rays::centres;
use crate::links::station::Station;
use crate::links::transfer::{Optics, Row};
use crate::mesh::basis::{Basis, MAX_DEGREE};
use crate::mesh::clusters::{self, Cluster};
use crate::mesh::glow::ClusterEmission;
use crate::mesh::partition::{self, Known, Sample};
use crate::mesh::shadow::{Scenery, lines};
use crate::mesh::shape::Shape;
use crate::mesh::surfaces::Surfaces;
use crate::mesh::texture::{Pattern, patterns};
use crate::mesh::{Mesh, Sight};

/// The light of an element on a point.
#[derive(Debug, Clone)]
pub struct Transfer {
    /// The element.
    pub source: usize,
    /// The light of each function of the element's basis.
    pub values: Vec<f64>,
    /// Bounds on the error of the first of these, and on that of each other one.
    pub errors: [f64; 2],
    /// Estimate of the error of the first one, by rays.
    pub likely: Option<f64>,
    /// The least and the largest of the kernel over the element, times the area.
    pub kernel: [f64; 2],
    /// Bounds on its derivatives along any direction of the plane, over the factorial of the order; none if it is not smooth.
    pub derivatives: Option<[f64; MAX_DEGREE + 2]>,
    /// Bounds on the mean square of the visible kernel, and on the root mean square of its part beyond the values.
    pub beyond: Option<[f64; 2]>,
}

/// The light of each of the coarsest elements on a point in space, with this error; by rays to so many cells a side where many faces are between.
///
/// # Errors
/// If the light cannot be represented.
pub fn transfers(mesh: &Mesh, receiver: &Receiver, error: f64, cells: usize) -> Result<Vec<Transfer>, Error> {
    let (rules, station) = (Rules::new(), Station::in_space(receiver));
    let optics = optics(mesh, &rules, error, cells);
    let of = |&source: &usize| {
        let sight = station.sight(mesh, source, None)?;
        let row = optics.receive(&station, source, &sight, usize::MAX)?;
        let beyond = row.sampled.map(|sampled| [sampled.square, row.truncation()]);
        let derivatives = (row.kernel.smooth && row.kernel.peak > 0.0).then(|| row.kernel.derivatives());
        let (errors, kernel) = ([row.error, row.other_errors], [row.kernel.least, row.kernel.peak]);
        Ok(Transfer { source, values: row.values, errors, likely: row.likely, kernel, derivatives, beyond })
    };
    mesh.roots().iter().map(of).collect()
}

fn optics<'a>(mesh: &'a Mesh, rules: &'a Rules, error: f64, cells: usize) -> Optics<'a> {
    Optics { mesh, rules, absolute: error, past: error, cells, brightness: 1.0, clock: Clock::started() }
}

/// Centres of the cells of a shape, so many a side, in reference coordinates.
#[must_use]
pub fn cells(shape: Shape, side: usize) -> Vec<[f64; 2]> {
    centres(shape, side)
}

/// A point's gathers of an element.
#[derive(Debug, Clone, Copy)]
pub struct Gathering {
    /// Bound on the form factor.
    pub factor: f64,
    /// Bound on the root mean square of the visible kernel, times the area, beyond polynomials.
    pub truncation: f64,
    /// Bound on the gather of a quantity.
    pub gathered: f64,
}

/// A point's gathers of a divided element by a link to it, and by links to its quarters; the quantity has this largest value and this mean, in the
/// first channel, and is distributed as the reflectance is.
///
/// # Errors
/// If the light cannot be represented.
pub fn gathers(
    scene: &Scene,
    mesh: &Mesh,
    receiver: &Receiver,
    source: usize,
    error: f64,
    [largest, mean]: [f64; 2],
) -> Result<[Gathering; 2], Error> {
    let (rules, station, mut surfaces) = (Rules::new(), Station::in_space(receiver), Surfaces::from_scene(scene));
    surfaces.grow(mesh);
    let optics = optics(mesh, &rules, error, 0);
    let receives: Vec<bool> = (0..mesh.elements().len()).map(|element| element == source).collect();
    let by_links = |linked: Vec<usize>| -> Result<Gathering, Error> {
        let row = |&element: &usize| {
            let sight = station.sight(mesh, element, None)?;
            Ok((element, [optics.receive(&station, element, &sight, usize::MAX)?]))
        };
        let rows: Vec<(usize, [Row; 1])> = linked.iter().map(row).collect::<Result<_, Error>>()?;
        let links = rows.iter().map(|(element, rows)| (*element, &rows[..]));
        let visible = VisibleSources::gather(mesh, &surfaces, &[station], &receives, links);
        let on_source = |value: f64| receives.iter().map(|is_source| if *is_source { value } else { 0.0 }).collect::<Vec<_>>();
        let gathered = visible.gathered((0, 1), &on_source(largest), &on_source(mean))[0];
        Ok(Gathering { factor: visible.factors[0], truncation: visible.truncation[0], gathered })
    };
    let quarters = mesh.elements()[source].children().map_or_else(Vec::new, |first| (first..first + 4).collect());
    Ok([by_links(vec![source])?, by_links(quarters)?])
}

/// The polynomial of an element over the light of its leaves.
#[derive(Debug, Clone)]
pub struct Projection {
    /// In the element's basis.
    pub coefficients: Vec<f64>,
    /// Bounds on the light beyond the polynomial: on its magnitude, and on its root mean square.
    pub beyond: [f64; 2],
}

/// The projections of this light on the leaves, in the order of [`Mesh::leaves`], on all elements.
#[must_use]
pub fn projections(mesh: &Mesh, light: &[Vec<f64>]) -> Vec<Projection> {
    let mut field = Field::dark(mesh, 1);
    mesh.leaves().zip(light).for_each(|(leaf, light)| field.add(mesh, leaf, 0, light));
    field.pull(mesh);
    let projection = |element: usize| Projection {
        coefficients: field.coefficients(element, 0).to_vec(),
        beyond: [field.left_out(element, 0), field.left_out_rms(element, 0)],
    };
    (0..mesh.elements().len()).map(projection).collect()
}

/// The receivers that an element is, or that are below it.
#[must_use]
pub fn receivers_below(mesh: &Mesh, receives: &[bool], element: usize) -> Vec<usize> {
    let mut visited = Vec::new();
    point::below(mesh, receives, element, &mut |receiver| visited.push(receiver));
    visited
}

/// Values of all elements, of which those of receivers are given: of the elements above them the mean, and the largest.
#[must_use]
pub fn pulled(mesh: &Mesh, receives: &[bool], values: &[f64]) -> [Vec<f64>; 2] {
    let joins: [fn([f64; 4]) -> f64; 2] = [|four| 0.25 * four.iter().sum::<f64>(), |four| four.into_iter().fold(0.0, largest)];
    joins.map(|join| {
        let mut values = values.to_vec();
        sources::pull(mesh, 1, receives, &mut values, join);
        values
    })
}

/// A point's view of a cluster.
#[derive(Debug, Clone)]
pub struct View {
    /// The elements that are in it.
    pub elements: Vec<usize>,
    /// Bounds on its form factor, and on the kernel times its area.
    pub bounds: [f64; 2],
    /// Its form factor by rays, and the deviation of that.
    pub sampled: [f64; 2],
}

/// Views of all clusters of a scene's faces, from each of some points by so many rays.
///
/// # Errors
/// If the scene has no mesh.
pub fn views(scene: &Scene, receivers: &[Receiver], rays: usize) -> Result<Vec<Vec<View>>, Error> {
    let mut mesh = Mesh::new(scene, 0)?;
    mesh.cluster();
    let (rules, tree) = (Rules::new(), mesh.clusters());
    let optics = optics(&mesh, &rules, 1e-9, 0);
    let from = |receiver: &Receiver| {
        let station = Station::in_space(receiver);
        let drawn = optics.rays(&station, rays, Draw::Second);
        let of = |(index, cluster): (usize, &Cluster)| {
            let seen = optics.look(&station, &drawn, index);
            let within = tree.within(index);
            let elements = mesh.roots().iter().copied().filter(|&root| within.contains(&tree.single(root)));
            let [factor, off] = [seen.weight, seen.noise(&ClusterEmission { power: 1.0, ..ClusterEmission::default() })]
                .map(|of| of * cluster.area());
            View {
                elements: elements.collect(),
                bounds: [seen.view.factor, seen.view.peak * cluster.area()],
                sampled: [factor, off],
            }
        };
        tree.clusters().iter().enumerate().map(of).collect()
    };
    Ok(receivers.iter().map(from).collect())
}

/// The largest `-n.y` for normals n in a box and points y in another.
#[must_use]
pub fn most_toward(normals: [DVec3; 2], [low, high]: [DVec3; 2]) -> f64 {
    clusters::most_toward(normals, low, high)
}

/// The most light of sources with these form factors, at most, and these radiosities, where they fill no more than the hemisphere.
#[must_use]
pub fn filled(sources: Vec<(f64, f64)>) -> f64 {
    unsampled::fill(sources)
}

/// Segments of a face's plane where the light of another face, a lamp, changes suddenly if any face may be between.
#[must_use]
pub fn shadow_lines(mesh: &Mesh, face: usize, lamp: usize) -> Vec<[DVec3; 2]> {
    let between = (0..mesh.polygons().len()).filter(|other| ![face, lamp].contains(other)).collect();
    let scenery = Scenery { polygons: mesh.polygons(), index: mesh.index(), lamps: &[lamp] };
    lines(&scenery, face, mesh.convex_parts(face), &[between])
}

/// The light at places.
pub type Light<'a> = dyn Fn(&[DVec3]) -> Vec<f64> + Sync + 'a;

/// A triangle or a parallelogram cut where polynomials of a degree then fit some light best, along these lines too: into so many parts at most,
/// until the root mean square that they leave is this. A tenth of all samples are for it, as if the rest were for another face.
///
/// # Errors
/// None: the light is given.
pub fn partition(
    part: &[DVec3],
    lines: &[[DVec3; 2]],
    degree: usize,
    (most, error): (usize, f64),
    light: &Light<'_>,
) -> Result<Vec<Vec<DVec3>>, Error> {
    let normal = (part[1] - part[0]).cross(part[2] - part[0]).normalize_or_zero();
    let face = Known { normal, parts: vec![part.to_vec()], lines: lines.to_vec(), stays: false };
    let other = Known { normal, parts: vec![part.iter().map(|p| *p * 3.0).collect()], lines: Vec::new(), stays: true };
    let bases = [Shape::Parallelogram, Shape::Triangle].map(|shape| Basis::new(shape, degree));
    let light = |_, places: &[DVec3]| {
        let samples = places.iter().zip(light(places)).map(|(&point, light)| Sample { point, light: vec![light] });
        Ok(Some(samples.collect()))
    };
    let parts = partition::partition(&[face, other], &bases, (most + 1, error / 10.0_f64.sqrt()), &light)?;
    Ok(parts.into_iter().next().unwrap_or_default())
}

/// Bounds on the form factor of each of the coarsest elements of a face from any place of another, and on its mean over that, if no node of that
/// sees any of it; none where nothing is between or all is behind.
#[must_use]
pub fn unseen(mesh: &Mesh, of: usize) -> Vec<(usize, Option<[f64; 2]>)> {
    let edges = Edges::find(mesh);
    let outlined = Outlined { mesh, edges: &edges };
    let sources = || mesh.roots().iter().copied().filter(|&root| mesh.elements()[root].face() == of);
    let bound = |element: usize, source: usize| match mesh.sight(element, source, None) {
        Sight::Past(faces) => Some(outlined.unseen(element, std::iter::once((source, &faces[..], 1.0)))),
        Sight::Nothing(_) => Some([0.0; 2]),
        Sight::Clear => None,
    };
    mesh.roots()
        .iter()
        .flat_map(|&element| sources().map(move |source| (element, source)))
        .filter(|(element, source)| element != source)
        .map(|(element, source)| (element, bound(element, source)))
        .collect()
}

/// The segments in which faces stand on others or cross them: the face below, that on it, and the ends.
#[must_use]
pub fn feet(mesh: &Mesh) -> Vec<(usize, usize, [DVec3; 2])> {
    let edges = Edges::find(mesh);
    (0..mesh.polygons().len()).flat_map(|face| edges.feet(face).iter().map(move |&(other, foot)| (face, other, foot))).collect()
}

/// The effect of textures on an element, in a channel.
#[derive(Debug, Clone)]
pub struct Texture {
    /// Projections of the emission and of the reflectance times some irradiance.
    pub emitted: Vec<f64>,
    /// That of the reflectance times some irradiance.
    pub reflected: Vec<f64>,
    /// Bounds on the residual of their projection: its largest magnitude, and its mean magnitude.
    pub detail: [f64; 2],
    /// Root mean squares of the reflectance, of its difference from its mean, and of that from its projection.
    pub spread: [f64; 3],
}

/// The effect of textures on an element with an irradiance of these coefficients, in each channel; none without textures.
#[must_use]
pub fn textures(scene: &Scene, mesh: &Mesh, element: usize, irradiance: &[f64]) -> Vec<Texture> {
    let basis = mesh.basis(element);
    let patterns = patterns(scene, &mesh.elements()[element], basis).unwrap_or_default();
    let of = |pattern: &Pattern| {
        let detail = pattern.detail(basis, irradiance, true);
        Texture {
            emitted: pattern.emitted().to_vec(),
            reflected: pattern.reflected(irradiance),
            detail: [detail.largest, detail.mean],
            spread: pattern.spread_of_reflectance(),
        }
    };
    patterns.iter().map(of).collect()
}
