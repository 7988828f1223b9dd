//! From a model to its orbits. A [`Finder`] keeps what a sweep can reuse: the spectrum as long as the chain stays the
//! same, the impulse response as long as chain and frequency do, and all scratch space.

use std::sync::Arc;

use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum, Stop};

use crate::admissible::answer::Admissibility;
use crate::admissible::check::Watch;
use crate::admissible::conservative_modes::ConservativeModes;
use crate::admissible::gap::Depth;
use crate::error::BreatherError;
use crate::motion::Motion;
use crate::orbit::delicate::delicate;
use crate::orbit::{Family, LatticeOrbit, Orbit};
use crate::roots::interval::Zeros;
use crate::search::orbit_list::OrbitList;
use crate::search::screens::kernel_grid::KernelGrid;
use crate::search::screens::radiation::Radiation;
use crate::structures::condition::Condition;
use crate::structures::map_orbit::modes::Modes;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::response::FixedPart;

/// Which orbits are asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Scope {
    /// All, physical or not.
    #[default]
    All,
    /// Without conservative ones of two instants with φ ≠ T/2.
    Symmetric,
    /// Those that could be physical, for less work where none is: not those one of whose impacts has the wrong sign, nor
    /// those that would make masses of the ring swing beyond their barriers.
    Candidates,
    /// Candidates without conservative ones of two instants with φ ≠ T/2; [`Asked`](crate::Completeness::Asked) tells where there could be any.
    SymmetricCandidates,
}

impl Scope {
    pub(crate) fn candidates(self) -> bool {
        matches!(self, Self::Candidates | Self::SymmetricCandidates)
    }
}

/// Reusable work space for finding and checking orbits.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_lattice::{Chain, Model};
/// let mut finder = Finder::new(21);
/// let mut found = OrbitList::default();
/// for omega in [1.4, 1.5, 1.6] {
///     let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, omega, 0.4)?;
///     finder.find(&model, Family::DoubleSided, &mut found)?;
///     assert!(finder.admissibility(&found.orbits[0])?.is_physical());
/// }
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Finder {
    spectrum: Option<Spectrum>,
    pub(crate) response: ImpulseResponse,
    current: Option<(f64, usize)>,
    /// Boxed: the last two change places.
    pub(crate) motion: Box<Motion>,
    /// That of the orbit found before the last one: of two that a search finds neither is worked out again to be checked.
    pub(super) earlier: Box<Motion>,
    pub(crate) zeros: Zeros,
    pub(crate) kernel_grid: KernelGrid,
    /// Of the impulse response, once it has been asked for.
    pub(crate) radiation: Option<Option<Radiation>>,
    pub(crate) watch: Watch,
    pub(crate) conservative_modes: ConservativeModes,
    /// That of the orbit last asked for it: verdicts and answers both want it.
    condition: Option<Box<(Orbit, Condition)>>,
    /// The lattice as a structure with contacts at the masses that hit in the orbits last asked for.
    pub(crate) contact: Option<Box<LoadedStructure>>,
    /// Modes of a structure half a period after an impact, of the contact and the period last asked for.
    pub(crate) half_period: Option<Box<(Arc<FixedPart>, f64, Modes)>>,
    pub(crate) stop: Stop,
}

impl Default for Finder {
    /// For rings of one mass, and structures.
    fn default() -> Self {
        Self::new(1)
    }
}

impl Finder {
    /// A finder for rings of `sites` masses (other lattices work too, at the price of new scratch space).
    pub fn new(sites: usize) -> Self {
        let chain = Chain::alone(sites);
        let response = ImpulseResponse::vacant(&chain);
        let motion = Box::new(Motion::vacant(&chain, response.shapes().clone()));
        Self {
            spectrum: None,
            response,
            current: None,
            earlier: motion.clone(),
            motion,
            zeros: Zeros::default(),
            kernel_grid: KernelGrid::default(),
            radiation: None,
            watch: Watch::default(),
            conservative_modes: ConservativeModes::default(),
            condition: None,
            contact: None,
            half_period: None,
            stop: Stop::default(),
        }
    }

    /// The same finder, all of whose work ends with [`BreatherError::Stopped`] soon after `stop` is raised.
    #[must_use]
    pub fn until(mut self, stop: &Stop) -> Self {
        self.stop = stop.clone();
        self.contact = None;
        for copy in [&mut self.zeros.stop, &mut self.watch.stop] {
            *copy = stop.clone();
        }
        self
    }

    /// What ends its work early. Whoever works for long on its orbits looks at it, too.
    pub fn stop(&self) -> &Stop {
        &self.stop
    }

    /// Spectrum and impulse response of the model's chain for impulses of frequency `omega`.
    pub(crate) fn prepare(&mut self, model: &Model, omega: f64) -> Result<(), BreatherError> {
        self.prepare_at(model, omega, 0)
    }

    /// The same, from the view of another site.
    pub(super) fn prepare_at(&mut self, model: &Model, omega: f64, home: usize) -> Result<(), BreatherError> {
        self.stop.heard()?;
        let chain = model.chain();
        match &mut self.spectrum {
            Some(spectrum) if spectrum.chain() == chain => {}
            Some(spectrum) => {
                spectrum.reset(*chain);
                self.current = None;
            }
            None => self.spectrum = Some(Spectrum::new(*chain)),
        }
        if let Some(spectrum) = &self.spectrum
            && self.current != Some((omega, home))
        {
            (self.current, self.radiation) = (None, None);
            self.response.reset_at(spectrum, omega, home)?;
            self.current = Some((omega, home));
        }
        Ok(())
    }

    /// All orbits of `family` at a point, into `found`.
    ///
    /// # Errors
    /// [`BreatherError::Resonance`].
    pub fn find(&mut self, model: &Model, family: Family, found: &mut OrbitList) -> Result<(), BreatherError> {
        self.search(model, family, Scope::All, found)
    }

    /// As [`Finder::find`], without the conservative double-sided orbits with φ ≠ T/2.
    ///
    /// # Errors
    /// As [`Finder::find`].
    pub fn find_symmetric(
        &mut self,
        model: &Model,
        family: Family,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        self.search(model, family, Scope::Symmetric, found)
    }

    /// The orbits of `family` at a point that are `wanted`, into `found`.
    ///
    /// # Errors
    /// As [`Finder::find`].
    pub fn search(
        &mut self,
        model: &Model,
        family: Family,
        wanted: Scope,
        found: &mut OrbitList,
    ) -> Result<(), BreatherError> {
        self.search_at(model, family.into(), 0, wanted, found)
    }

    /// Whether an orbit is physical, see [`Admissibility`]; if not, with the worst obstruction.
    ///
    /// # Errors
    /// [`BreatherError::TooStiff`]; [`BreatherError::Resonance`], which an orbit that exists has already passed.
    pub fn admissibility(&mut self, orbit: &Orbit) -> Result<Admissibility, BreatherError> {
        self.check(orbit, Depth::Worst)
    }

    /// As [`Finder::admissibility`], but stops at the first obstruction found: the same for a physical orbit, sooner done
    /// with one that is not.
    ///
    /// # Errors
    /// As [`Finder::admissibility`].
    pub fn quick_admissibility(&mut self, orbit: &Orbit) -> Result<Admissibility, BreatherError> {
        self.check(orbit, Depth::First)
    }

    fn check(&mut self, orbit: &Orbit, depth: Depth) -> Result<Admissibility, BreatherError> {
        if let Some(contacts) = orbit.contacts() {
            return contacts.checked(depth);
        }
        let orbit = orbit.lattice()?;
        self.load(orbit)?;
        if orbit.model().chain().is_kept() {
            return self.watch.check(orbit, &mut self.motion, depth);
        }
        // All modes and all masses of a large lattice are not held together.
        self.give_back_response();
        let mut watch = Watch::default();
        watch.stop = self.stop.clone();
        let checked = watch.check(orbit, &mut self.motion, depth);
        self.motion.give_back();
        checked
    }

    /// The motion of an orbit, and the impulse response.
    fn load(&mut self, orbit: LatticeOrbit<'_>) -> Result<(), BreatherError> {
        let response = if orbit.model().is_damped() {
            self.stop.heard()?;
            None
        } else {
            self.prepare(orbit.model(), orbit.frequency())?;
            Some(&self.response)
        };
        if self.earlier.is_of(orbit, response) {
            std::mem::swap(&mut self.motion, &mut self.earlier);
        }
        self.motion.load(orbit, response);
        Ok(())
    }

    fn give_back_response(&mut self) {
        (self.spectrum, self.current, self.radiation) = (None, None, None);
        self.response.give_back();
    }

    /// Gives back what the modes of a large lattice take, to whoever needs the room: what this finder is asked for next it works out
    /// again. Of lattices that sweeps go through everything is kept.
    pub fn give_back(&mut self) {
        if !self.response.chain().is_kept() {
            self.give_back_response();
            self.motion.give_back();
            self.earlier.give_back();
        }
    }

    /// The motion of an orbit, in this finder's scratch space.
    ///
    /// # Errors
    /// As [`Finder::admissibility`].
    pub fn motion(&mut self, orbit: &Orbit) -> Result<&mut Motion, BreatherError> {
        self.load(orbit.lattice()?)?;
        Ok(&mut self.motion)
    }

    /// The orbit near one that was given by its impacts roughly ([`Orbit::from_impulses`]), by Newton's method; it must be so near
    /// that every step improves it. Impulses and, where symmetry in time does not hold them, all times but the first and the phase are
    /// free; times count from the first one. [`Orbit::residual`] tells how well the conditions at the impacts are met.
    ///
    /// # Errors
    /// [`BreatherError::NotConverged`]; as [`Finder::admissibility`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, Hit, Orbit};
    /// use vibrochain_lattice::{Barrier, Chain, Model};
    /// // Two neighbours in phase, roughly.
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.05)?, 1.5, 0.2)?;
    /// let half = 0.5 * model.period();
    /// let both = |barrier, time, impulse| [0, 1].map(|site| Hit::new(site, barrier, time, impulse));
    /// let hits = [both(Barrier::Upper, 0.0, -1.9), both(Barrier::Lower, half, 1.9)].concat();
    /// let orbit = Finder::new(21).polish(&Orbit::from_impulses(&model, 1, 0.0, &hits)?)?;
    /// assert!(orbit.residual() < 1e-14);
    /// # Ok::<(), vibrochain_breather::BreatherError>(())
    /// ```
    pub fn polish(&mut self, orbit: &Orbit) -> Result<Orbit, BreatherError> {
        orbit.refined(&self.stop)
    }

    /// How far an orbit can be trusted. Not part of a sweep's inner loop: it makes the modes of the masses that are hit.
    ///
    /// # Errors
    /// As [`Finder::admissibility`].
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, OrbitList};
    /// use vibrochain_lattice::{Chain, Model, Point};
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
    /// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    /// finder.find(&model, Family::DoubleSided, &mut found)?;
    /// let condition = finder.condition(&found.orbits[0])?;
    /// assert!(condition.impulse_error() < 1e-13);
    /// # Ok::<(), vibrochain_breather::BreatherError>(())
    /// ```
    pub fn condition(&mut self, orbit: &Orbit) -> Result<Condition, BreatherError> {
        if let Some((known, condition)) = self.condition.as_deref()
            && known == orbit
        {
            return Ok(condition.clone());
        }
        let condition = Condition::of(orbit, self.at_contacts(orbit))?;
        self.condition = Some(Box::new((orbit.clone(), condition.clone())));
        Ok(condition)
    }

    /// Whether errors of an orbit could matter to its verdict: next to a resonance, to grazing or to a fold. Cheap enough
    /// for a sweep, which asks for [`Finder::condition`] only then.
    ///
    /// # Errors
    /// As [`Finder::admissibility`].
    pub fn is_delicate(&mut self, orbit: &Orbit) -> Result<bool, BreatherError> {
        if let Some(contacts) = orbit.contacts() {
            return Ok(contacts.is_delicate());
        }
        let orbit = orbit.lattice()?;
        if orbit.model().is_damped() {
            return Ok(self.at_contacts(&orbit)?.is_delicate());
        }
        self.prepare(orbit.model(), orbit.frequency())?;
        let slowest = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(f64::INFINITY, f64::min);
        if delicate(&self.response, orbit.model().omega(), (slowest, orbit.velocity_scale())) {
            return Ok(true);
        }
        if orbit.is_reversible() {
            return Ok(false);
        }
        match self.at_contacts(&orbit) {
            Err(stopped @ BreatherError::Stopped(_)) => Err(stopped),
            // Where nothing is known of them they could.
            known => Ok(known.map_or(true, |known| known.is_delicate())),
        }
    }

    /// An orbit as contacts at the masses that hit know it.
    ///
    /// # Errors
    /// As [`Orbit::at_contacts`].
    pub fn at_contacts(&mut self, orbit: &Orbit) -> Result<Arc<ContactOrbit>, BreatherError> {
        orbit.at_contacts_from(&mut self.contact, &self.stop)
    }

    /// An orbit with the impulse response of its chain and frequency, which this finder keeps.
    ///
    /// # Errors
    /// [`BreatherError::Dashpots`]; as [`Finder::admissibility`].
    pub fn prepared<'a>(&'a mut self, orbit: &'a Orbit) -> Result<Prepared<'a>, BreatherError> {
        let orbit = orbit.lattice()?;
        if orbit.model().is_damped() {
            return Err(BreatherError::Dashpots);
        }
        self.prepare(orbit.model(), orbit.frequency())?;
        Ok(Prepared { orbit, response: &self.response })
    }
}

/// An orbit that is being analysed, with the impulse response that belongs to it.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let prepared = finder.prepared(&found.orbits[0])?;
/// assert_eq!(prepared.response().omega(), prepared.orbit().frequency());
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[must_use]
pub struct Prepared<'a> {
    orbit: LatticeOrbit<'a>,
    response: &'a ImpulseResponse,
}

impl<'a> Prepared<'a> {
    /// The orbit.
    pub fn orbit(&self) -> LatticeOrbit<'a> {
        self.orbit
    }

    /// The impulse response of its chain and frequency.
    pub fn response(&self) -> &'a ImpulseResponse {
        self.response
    }
}

/// All orbits of a family at a point: the one-shot form of [`Finder::find`].
///
/// # Errors
/// [`BreatherError::Resonance`].
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_lattice::{Chain, Model, Point};
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// let found = breathers(&model, Family::DoubleSided)?;
/// assert!((found.orbits[0].phi().unwrap() - 2.0771604154348533).abs() < 1e-12);
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
pub fn breathers(model: &Model, family: Family) -> Result<OrbitList, BreatherError> {
    let mut found = OrbitList::default();
    Finder::new(model.chain().sites()).find(model, family, &mut found)?;
    Ok(found)
}

/// How far an orbit can be trusted: the one-shot form of [`Finder::condition`].
///
/// # Errors
/// As [`Finder::condition`].
pub fn condition(orbit: &Orbit) -> Result<Condition, BreatherError> {
    Finder::default().condition(orbit)
}
