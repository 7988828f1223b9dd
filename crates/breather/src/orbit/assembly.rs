//! Orbits from their impulses: velocities, accelerations and what the defining equations leave, by superposition.

use vibrochain_lattice::{ImpulseResponse, Model, Shapes, Spectrum};

use crate::error::BreatherError;
use crate::motion::Motion;
use crate::orbit::{Draft, Family, Hit, Impact, LatticePart, Of, Orbit, sources};
use crate::worse;

impl Orbit {
    /// Works out velocities, accelerations and the residual; `motion` holds the orbit afterwards. `response` is the impulse response of the lattice,
    /// `None` of one with dashpots.
    pub(crate) fn assemble(
        model: &Model,
        response: Option<&ImpulseResponse>,
        motion: &mut Motion,
        draft: Draft,
    ) -> Result<Self, BreatherError> {
        let e = model.restitution();
        let impact = |&Hit { site, barrier, time, impulse }: &Hit| Impact {
            site,
            barrier,
            time,
            impulse,
            velocity_before: -impulse / (1.0 + e),
            velocity_after: e * impulse / (1.0 + e),
            acceleration: 0.0,
        };
        let half = 0.5 * (model.period() * f64::from(draft.force_periods));
        let fixed = |hit: &Hit| hit.time == 0.0 || hit.time == half;
        let part = LatticePart {
            model: *model,
            steady: model.steady()?,
            sources: draft.sources,
            uniform_offset: draft.uniform_offset,
            fixed_times: model.is_conservative() && draft.impacts.iter().all(fixed),
            at_contacts: draft.at_contacts.into(),
        };
        let mut orbit = Self {
            family: draft.family,
            force_periods: draft.force_periods,
            psi: draft.psi,
            impacts: draft.impacts.iter().map(impact).collect(),
            residual: 0.0,
            of: Of::Lattice(part),
        };
        let known = orbit.lattice()?;
        motion.load(known, response);
        let (length, velocity, loss) = (known.length_scale(), known.velocity_scale(), model.loss());
        for (i, impact) in orbit.impacts.iter_mut().enumerate() {
            let after;
            (after, impact.acceleration) = motion.just_after(i, impact.site);
            // v(t_i) − (a±1) and w_i + qP_i/2, over the largest terms.
            let position = (after.displacement - model.barrier(impact.barrier)) / length;
            let mean = after.velocity - 0.5 * impact.impulse;
            let newton = (mean + 0.5 * loss * impact.impulse) / velocity;
            orbit.residual = [position, newton].into_iter().fold(orbit.residual, |worst, x| worse(worst, x.abs()));
        }
        Ok(orbit)
    }

    /// An orbit from any list of impacts at any sites, times within the orbit's
    /// period of `force_periods` periods of the force, rising. Whether the impacts meet their barriers and obey
    /// Newton's law is told by [`Orbit::residual`].
    ///
    /// # Errors
    /// [`BreatherError::Impact`] for a site that does not exist, a time outside the period or out of order, or an
    /// impulse that is not finite; for a net impulse with γ₁ = 0 (with none, the ring is put where its first impact
    /// meets the barrier). [`BreatherError::Resonance`] where the linear
    /// ring has no periodic response.
    ///
    /// ```
    /// use vibrochain_breather::{Hit, Orbit};
    /// use vibrochain_lattice::{Barrier, Chain, Model};
    /// // A free-flying mass between its barriers: |velocity| 2/(T/2), impulses ±8/T. γ₁ is negligible.
    /// let model = Model::conservative(Chain::new(1, 1e-20, 0.0)?, 1.0, 0.0)?;
    /// let period = model.period();
    /// let first = Hit::new(0, Barrier::Upper, 0.0, -8.0 / period);
    /// let hits = [first, Hit::new(0, Barrier::Lower, period / 2.0, 8.0 / period)];
    /// let orbit = Orbit::from_impulses(&model, 1, 0.0, &hits)?;
    /// assert!(orbit.residual() < 1e-14);
    /// # Ok::<(), vibrochain_breather::BreatherError>(())
    /// ```
    pub fn from_impulses(model: &Model, force_periods: u32, psi: f64, impacts: &[Hit]) -> Result<Self, BreatherError> {
        Self::from_impulses_in(None, model, force_periods, psi, impacts)
    }

    /// The same in the room of a motion, which is left holding this orbit.
    pub(crate) fn from_impulses_in(
        room: Option<&mut Motion>,
        model: &Model,
        force_periods: u32,
        psi: f64,
        impacts: &[Hit],
    ) -> Result<Self, BreatherError> {
        let chain = model.chain();
        let bad = |index, what| Err(BreatherError::Impact { index, what });
        if force_periods == 0 || impacts.is_empty() {
            return bad(0, "give at least one impact and one period");
        }
        let omega = model.omega() / f64::from(force_periods);
        let spectrum = (!model.is_damped()).then(|| Spectrum::new(*chain));
        let response = spectrum.as_ref().map(|spectrum| ImpulseResponse::new(spectrum, omega)).transpose()?;
        let (response, period) = (response.as_ref(), model.period() * f64::from(force_periods));
        let mut previous = 0.0;
        for (index, &Hit { site, time, impulse, .. }) in impacts.iter().enumerate() {
            if site >= chain.sites() {
                return bad(index, "the site does not exist on this lattice");
            }
            if !(previous..period).contains(&time) {
                return bad(index, "the times must rise from 0 and stay below the period");
            }
            if !impulse.is_finite() {
                return bad(index, "the impulse is not finite");
            }
            previous = time;
        }
        let sources = sources(impacts);
        let net: f64 = sources.iter().map(|source| source.net_impulse).sum();
        let uniform_offset = match response.map(ImpulseResponse::uniform_static) {
            Some(Some(uniform)) => net * uniform,
            // Where all modes die, or are held, impulses say where they are.
            None if !chain.is_adrift() => 0.0,
            _ => {
                let scale: f64 = impacts.iter().map(|impact| impact.impulse.abs()).sum();
                if net.abs() > 4.0 * f64::EPSILON * scale {
                    return bad(0, "gamma1 = 0 without walls needs a net impulse of zero");
                }
                0.0
            }
        };
        let mut draft = Draft {
            family: Family::Word,
            force_periods,
            psi,
            impacts: impacts.into(),
            sources,
            uniform_offset,
            at_contacts: None,
        };
        let shapes = || response.map_or_else(|| Shapes::new(chain), |response| response.shapes().clone());
        let mut own = None;
        let motion = match room {
            Some(motion) => motion,
            None => own.insert(Motion::vacant(chain, shapes())),
        };
        if chain.is_adrift() {
            // A lattice that nothing holds may stand anywhere: where its first impact meets the barrier.
            Self::assemble(model, response, motion, draft.clone())?;
            let Hit { site, barrier, .. } = impacts[0];
            draft.uniform_offset = model.barrier(barrier) - motion.just_after(0, site).0.displacement;
        }
        Self::assemble(model, response, motion, draft)
    }
}
