//! Solutions of scenes, and queries to them.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use radgrad_certificate::{Certificate, Interval, Place, Request as Certifying, certify_points_until, certify_until};
use radgrad_core::DVec3;
use radgrad_scene::Scene;
use radgrad_solver::{
    Irradiance, Ledger, MAX_DEGREE, Marking, Options, Progress, Solution, SurfaceGradient, WeightedPoint, WeightedSum, solve,
};
use rayon::prelude::*;

use crate::arrays::{Shape, vectors};
use crate::detached::{Ended, Stop, detached, failed};
use crate::pool::{computed, entered};
use crate::refused;
use crate::scene::SceneCore;

/// A solution.
#[pyclass(frozen, module = "radgrad._radgrad")]
#[derive(Debug)]
pub(crate) struct SolutionCore {
    solution: Arc<Solution>,
    scene: Arc<Scene>,
    error: f64,
    seconds: f64,
    /// Of the mean: that which was made last.
    certificate: Mutex<Option<Certificate>>,
}

/// Half-width, probability of failure, seed and rays of a certificate; `None` takes the default of the program.
#[derive(Debug, FromPyObject)]
struct Wished(Option<f64>, Option<f64>, Option<u64>, Option<u64>);

/// A certificate as it is kept: ends of the mean and of the reflected light, the surfaces, probability, seed, walks and rays.
#[derive(Debug, FromPyObject, IntoPyObject)]
struct Certified(Vec<[f64; 2]>, Vec<[f64; 2]>, Vec<Vec<f64>>, f64, u64, usize, u64);

impl Certified {
    /// A certificate of a solution with as many channels.
    fn made(self, of: &Solution) -> PyResult<Certificate> {
        let Self(mean, reflected, surfaces, delta, seed, walks, rays) = self;
        let is_interval = |[lower, upper]: &[f64; 2]| lower <= upper;
        let is_whole = [&mean, &reflected].iter().all(|ends| ends.len() == of.channels().len() && ends.iter().all(is_interval));
        if !(is_whole && 0.0 < delta && delta < 1.0 && surfaces.iter().all(|surface| surface.len() == of.channels().len())) {
            return Err(refused("the certificate that was kept is none of this solution"));
        }
        let [mean, reflected] =
            [mean, reflected].map(|ends| ends.into_iter().map(|[lower, upper]| Interval { lower, upper }).collect());
        Ok(Certificate { mean, reflected, surfaces, delta, seed, walks, rays })
    }
}

/// Points, their normals, whether they are taken to be on faces (else those near one are), and the shape that both have together.
#[derive(Debug, FromPyObject)]
struct Asked<'py>(PyReadonlyArrayDyn<'py, f64>, PyReadonlyArrayDyn<'py, f64>, Option<bool>, Vec<usize>);

/// Options of a solve; `None` takes Rust's default.
#[derive(Debug, Clone, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Request {
    error: f64,
    degree: Option<usize>,
    seconds: Option<f64>,
    most_elements: Option<usize>,
    divide: String,
}

impl Request {
    fn options(&self) -> PyResult<Options> {
        let (rest, seconds) = (Options::default(), self.seconds.map(Duration::try_from_secs_f64).transpose());
        if let Some(degree) = self.degree.filter(|degree| *degree > MAX_DEGREE) {
            return Err(refused(format!("degree is {degree}: it must be at most {MAX_DEGREE}")));
        }
        let marking = match self.divide.as_str() {
            "residual" => Marking::Residual,
            "gradient" => Marking::Gradient,
            "shadows" => Marking::Shadows,
            other => return Err(refused(format!("divide is {other:?}: it must be \"residual\", \"gradient\" or \"shadows\""))),
        };
        Ok(Options {
            error: self.error,
            degree: self.degree,
            time: seconds.map_err(|error| refused(format!("seconds: {error}")))?,
            most_elements: self.most_elements.unwrap_or(rest.most_elements),
            marking,
            ..rest
        })
    }
}

/// A message from the thread that solves.
enum Seen {
    Round(Progress),
    End(Box<Result<Solution, String>>),
}

#[pymethods]
impl SolutionCore {
    /// Solves a scene. `watch` is called after each round with its number, elements, links and estimate. The first Ctrl-C lets the
    /// round end and gives the answer that was reached; the second one is raised.
    #[new]
    fn new(py: Python<'_>, scene: PyRef<'_, SceneCore>, request: Request, watch: Option<Py<PyAny>>) -> PyResult<Self> {
        let (options, scene, start) = (request.options()?, Arc::clone(&scene.scene), Instant::now());
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = channel();
        let run = {
            let (stop, scene) = (Arc::clone(&stop), Arc::clone(&scene));
            move || {
                let solved = run(&scene, &options, |progress| {
                    // Nobody listens to a run that was given up.
                    let heard = sender.send(Seen::Round(*progress)).is_ok();
                    heard && !stop.load(Ordering::Relaxed)
                });
                let _ = sender.send(Seen::End(Box::new(solved)));
            }
        };
        let inside = entered()?;
        std::thread::spawn(|| inside.install(run));
        let receiver = Mutex::new(receiver);
        loop {
            let seen = py.detach(|| match receiver.lock() {
                Ok(receiver) => receiver.recv_timeout(Duration::from_millis(50)),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            match seen {
                Ok(Seen::End(solution)) => {
                    let solution = Arc::new((*solution).map_err(refused)?);
                    let seconds = start.elapsed().as_secs_f64();
                    return Ok(Self { solution, scene, error: request.error, seconds, certificate: Mutex::new(None) });
                }
                Ok(Seen::Round(progress)) => {
                    let Some(watch) = &watch else { continue };
                    let Progress { round, elements, links, estimate, .. } = progress;
                    if let Err(error) = watch.call1(py, (round, elements, links, estimate)) {
                        stop.store(true, Ordering::Relaxed);
                        return Err(error);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => return Err(failed()),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals()
                        && stop.swap(true, Ordering::Relaxed)
                    {
                        return Err(signal);
                    }
                }
            }
        }
    }

    /// The solution as bytes, and how long it took.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = computed(py, || [&self.seconds.to_le_bytes()[..], &self.solution.to_bytes()].concat())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The solution of a scene that was made into bytes, without solving.
    #[staticmethod]
    fn from_bytes(
        py: Python<'_>,
        scene: PyRef<'_, SceneCore>,
        request: Request,
        bytes: &[u8],
        certificate: Option<Certified>,
    ) -> PyResult<Self> {
        let scene = Arc::clone(&scene.scene);
        let (seconds, rest) = bytes.split_first_chunk().ok_or_else(|| refused("there are no bytes of a solution"))?;
        let made = detached(py, false, |_| Ok(Solution::from_bytes(&scene, rest)?))?;
        let seconds = f64::from_le_bytes(*seconds);
        let certificate = certificate.map(|of| of.made(&made)).transpose()?;
        Ok(Self { solution: Arc::new(made), scene, error: request.error, seconds, certificate: Mutex::new(certificate) })
    }

    /// The certificate that was made last, of which [`Self::from_bytes`] makes it again.
    fn certificate(&self) -> Option<Certified> {
        let Certificate { mean, reflected, surfaces, delta, seed, walks, rays } = self.kept().clone()?;
        let [mean, reflected] = [mean, reflected].map(|of| of.iter().map(ends).collect());
        Some(Certified(mean, reflected, surfaces, delta, seed, walks, rays))
    }

    /// At points, row by row: radiosity and estimate, the same of the irradiance, and the faces that they are on: -1 in free space,
    /// where the radiosity is that of a white surface, the irradiance.
    fn gather<'py>(&self, py: Python<'py>, asked: Asked<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let solution = &*self.solution;
        let of = |point: DVec3, normal: DVec3, is_on_face: bool| {
            let answer = if is_on_face {
                let gather = solution.gather(point, normal)?;
                Found {
                    face: i64::try_from(gather.face).unwrap_or(i64::MAX),
                    radiosity: [gather.radiosity, totals(&gather.estimate)],
                    irradiance: of_irradiance(gather.irradiance),
                }
            } else {
                let irradiance = of_irradiance(solution.irradiance_at(point, normal)?);
                Found { face: -1, radiosity: irradiance.clone(), irradiance }
            };
            let out_of_range = answer.radiosity[0].iter().chain(&answer.irradiance[0]).find(|value| !value.is_finite()).copied();
            Ok((answer, out_of_range.map(|value| format!("the radiosity is {value}"))))
        };
        let answers = self.at_each(py, asked, of)?;
        let [radiosity, estimate] =
            [0, 1].map(|k| PyArray1::from_iter(py, answers.iter().flat_map(|of| of.radiosity[k].iter().copied())));
        let [irradiance, irradiance_estimate] =
            [0, 1].map(|k| PyArray1::from_iter(py, answers.iter().flat_map(|of| of.irradiance[k].iter().copied())));
        let face = PyArray1::from_iter(py, answers.iter().map(|of| of.face));
        (radiosity, estimate, irradiance, irradiance_estimate, face).into_pyobject(py)
    }

    /// Derivatives of a weighted sum, of surfaces or of points: its value and the relative estimate by channel; the derivatives by
    /// emission and by reflectance, face by face and channel by channel; and those by vertices with their estimates, if they are asked for.
    fn derivative<'py>(
        &self,
        py: Python<'py>,
        weights: Vec<Vec<f64>>,
        points: Option<(PyReadonlyArrayDyn<'py, f64>, PyReadonlyArrayDyn<'py, f64>)>,
        vertices: bool,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let sum = match points {
            None => WeightedSum { surfaces: weights, points: Vec::new() },
            Some((positions, normals)) => {
                let pairs = vectors(&positions)?.into_iter().zip(vectors(&normals)?).zip(weights);
                let point = |((position, normal), weights)| WeightedPoint { position, normal, weights };
                WeightedSum { surfaces: Vec::new(), points: pairs.map(point).collect() }
            }
        };
        let derivative = detached(py, false, |_| match vertices {
            true => Ok(self.solution.derivative_with_vertices(&self.scene, &sum)?),
            false => Ok(self.solution.derivative(&self.scene, &sum)?),
        })?;
        let by_face = |of: Vec<Vec<f64>>| PyArray1::from_iter(py, of.into_iter().flatten());
        let [value, estimate] = [derivative.value, derivative.relative_estimate].map(|of| PyArray1::from_vec(py, of));
        let by_vertex = derivative.vertices.iter().flatten().flatten().flat_map(DVec3::to_array);
        let estimates = derivative.vertices_estimate.into_iter().flatten().flatten();
        let by_vertex = (PyArray1::from_iter(py, by_vertex), PyArray1::from_iter(py, estimates));
        let by_face = [derivative.emission, derivative.reflectance].map(by_face);
        let ([emission, reflectance], (vertices, vertices_estimate)) = (by_face, by_vertex);
        (value, estimate, emission, reflectance, vertices, vertices_estimate).into_pyobject(py)
    }

    /// At points, row by row: gradients of the radiosity and estimates of their errors' lengths, and the same of the irradiance; in free
    /// space both are that.
    fn gradient<'py>(&self, py: Python<'py>, asked: Asked<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let solution = &*self.solution;
        let of = |point: DVec3, normal: DVec3, is_on_face: bool| {
            let gradients = if is_on_face {
                let SurfaceGradient { radiosity, irradiance } = solution.gradient(point, normal)?;
                [radiosity, irradiance]
            } else {
                let irradiance = solution.irradiance_gradient_at(point, normal)?;
                [irradiance.clone(), irradiance]
            };
            let out_of_range = gradients.iter().flat_map(|of| &of.gradient).find(|slope| !slope.is_finite()).copied();
            Ok((gradients, out_of_range.map(|slope| format!("the gradient is {slope}"))))
        };
        let answers = self.at_each(py, asked, of)?;
        let slopes = |k: usize| answers.iter().flat_map(move |of| of[k].gradient.iter().flat_map(DVec3::to_array));
        let estimates = |k: usize| answers.iter().flat_map(move |of| of[k].estimate.iter().copied());
        let [radiosity, irradiance] = [0, 1].map(|k| PyArray1::from_iter(py, slopes(k)));
        let [radiosity_estimate, irradiance_estimate] = [0, 1].map(|k| PyArray1::from_iter(py, estimates(k)));
        (radiosity, radiosity_estimate, irradiance, irradiance_estimate).into_pyobject(py)
    }

    /// Certifies the mean, and keeps that: lower and upper end in each channel, and the probability of failure, seed, walks and rays.
    fn certify<'py>(&self, py: Python<'py>, wished: Wished) -> PyResult<Bound<'py, PyTuple>> {
        let request = self.request(&wished);
        let made = detached(py, false, |stop| Ok(certify_until(&self.scene, &request, stop.flag())?))?;
        let ends = PyArray1::from_iter(py, made.mean.iter().flat_map(ends));
        let said = (ends, made.delta, made.seed, made.walks, made.rays);
        *self.kept() = Some(made);
        said.into_pyobject(py)
    }

    /// Certifies points: the ends of the radiosity, or of the irradiance in space, of the irradiance, in each channel; and the probability
    /// that any of them fails, and the seed.
    fn certify_points<'py>(&self, py: Python<'py>, asked: Asked<'_>, wished: Wished) -> PyResult<Bound<'py, PyTuple>> {
        let request = Certifying { rays: wished.3.unwrap_or(radgrad_cli::file::RAYS_A_POINT), ..self.request(&wished) };
        let shape = Shape(asked.3.clone());
        let places = self.at_each(py, asked, |position, normal, is_on_face| {
            let face = if is_on_face { Some(self.solution.gather(position, normal)?.face) } else { None };
            Ok((Place { position, normal, face }, None))
        })?;
        let certified = detached(py, false, |stop| {
            let refused =
                |index: usize, error: radgrad_certificate::Error| Ended::Refused(format!("{}{error}", shape.place(index)));
            let certificates = certify_points_until(&self.scene, &places, &request, stop.flag())?;
            let each = certificates.into_iter().enumerate().map(|(index, of)| of.map_err(|error| refused(index, error)));
            each.collect::<Result<Vec<_>, _>>()
        })?;
        let radiosity = certified.iter().flat_map(|of| of.radiosity.as_ref().unwrap_or(&of.irradiance).iter().flat_map(ends));
        let irradiance = certified.iter().flat_map(|of| of.irradiance.iter().flat_map(ends));
        let (radiosity, irradiance) = (PyArray1::from_iter(py, radiosity), PyArray1::from_iter(py, irradiance));
        (radiosity, irradiance, request.delta, request.seed).into_pyobject(py)
    }

    /// The object that `radgrad solve --summary` prints.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        let Self { solution, scene, error, seconds, .. } = self;
        let certificate = self.kept().clone();
        computed(py, || radgrad_cli::file::summary(solution, scene, certificate.as_ref(), *error, *seconds))?.map_err(refused)
    }

    /// Writes a solution to a `.vtu` or `.ply`.
    fn write(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        let certificate = self.kept().clone();
        computed(py, || radgrad_cli::file::solution(&self.solution, &self.scene, certificate.as_ref(), &file))?
            .map_err(pyo3::exceptions::PyOSError::new_err)
    }

    /// The picture that a camera sees, with the options of `radgrad solve --view` after it: radiosity and estimate of each pixel, row by
    /// row. Written to the file that the options name.
    fn picture<'py>(&self, py: Python<'py>, options: Vec<String>) -> PyResult<Bound<'py, PyTuple>> {
        let solution = &*self.solution;
        let work = |stop: &Stop| radgrad_cli::file::picture(solution, &options, stop.flag()).map_err(Ended::Refused);
        let picture = detached(py, false, work)?;
        (picture.size, PyArray1::from_vec(py, picture.radiosity), PyArray1::from_vec(py, picture.estimate)).into_pyobject(py)
    }

    /// The bits of the solution on every leaf, by which two runs are compared.
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let (solution, channels) = (&*self.solution, self.solution.channels().len());
        let at = |leaf: usize| (0..channels).map(move |channel| solution.value_on(leaf, channel, [0.25, 0.5]));
        PyArray1::from_iter(py, solution.mesh().leaves().flat_map(at))
    }
}

impl SolutionCore {
    fn request(&self, wished: &Wished) -> Certifying {
        let defaults = radgrad_cli::file::certifying(&self.solution, self.error, wished.0);
        let Wished(_, delta, seed, rays) = *wished;
        Certifying {
            delta: delta.unwrap_or(defaults.delta),
            seed: seed.unwrap_or(defaults.seed),
            rays: rays.unwrap_or(defaults.rays),
            ..defaults
        }
    }

    /// The certificate; who held it and panicked has not changed it by half.
    fn kept(&self) -> MutexGuard<'_, Option<Certificate>> {
        self.certificate.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks `of` for the answer at each point, by the point, its normal and whether it is on a face. Beside an answer that is beyond the range of
    /// a double `of` gives a sentence that says so.
    fn at_each<T: Send>(
        &self,
        py: Python<'_>,
        Asked(points, normals, on_face, shape): Asked<'_>,
        of: impl Fn(DVec3, DVec3, bool) -> Result<(T, Option<String>), radgrad_solver::Error> + Sync,
    ) -> PyResult<Vec<T>> {
        let (points, normals, shape) = (vectors(&points)?, vectors(&normals)?, Shape(shape));
        detached(py, false, |stop| {
            stop.expect(points.len());
            let one = |(index, point): (usize, &DVec3)| {
                if stop.is_set() {
                    return Err(Ended::Stopped);
                }
                stop.step(1);
                let normal = normals[if normals.len() == 1 { 0 } else { index }];
                let refused = |reason: String| Ended::Refused(format!("{}{reason}", shape.place(index)));
                let is_on_face = on_face.unwrap_or_else(|| self.solution.is_on_a_face(*point));
                match of(*point, normal, is_on_face) {
                    Ok((found, None)) => Ok(found),
                    Ok((_, Some(what))) => Err(refused(format!("{what}: it is beyond the range of a double"))),
                    Err(error) => Err(refused(error.to_string())),
                }
            };
            points.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()
        })
    }
}

/// Radiosity and irradiance at a point, each with its estimate, in each channel.
struct Found {
    face: i64,
    radiosity: [Vec<f64>; 2],
    irradiance: [Vec<f64>; 2],
}

fn ends(of: &Interval) -> [f64; 2] {
    [of.lower, of.upper]
}

fn totals(ledgers: &[Ledger]) -> Vec<f64> {
    ledgers.iter().map(Ledger::total).collect()
}

fn of_irradiance(found: Irradiance) -> [Vec<f64>; 2] {
    let estimate = totals(&found.estimate);
    [found.irradiance, estimate]
}

fn run(scene: &Scene, options: &Options, mut watch: impl FnMut(&Progress) -> bool) -> Result<Solution, String> {
    solve(scene, options, |solution| watch(solution.progress())).map_err(|error| error.to_string())
}
