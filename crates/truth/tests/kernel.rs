//! The impulse response against another library's digits, closed forms by hand, and the problem it solves.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, OrbitList, Scope};
use vibrochain_lattice::{Chain, Ends, Force, Harmonic};
use vibrochain_truth::{DEFAULT_BITS, Kernel, Real, TrueOrbit, TruthError};

fn kernel(sites: usize, gamma1: f64, gamma2: f64, omega: f64) -> Kernel {
    Kernel::new(&Chain::new(sites, gamma1, gamma2).unwrap(), omega, 1, DEFAULT_BITS).unwrap()
}

/// |a − b| < 10^−digits · scale
#[track_caller]
fn assert_close(a: &Real, b: &Real, scale: &Real, digits: f64) {
    let error = (a - b).log10_abs() - scale.log10_abs();
    assert!(error < -digits, "{a} {b}: 1e{error}");
}

/// (sites, γ₁, γ₂, ω, site, t/T) and K_n, K_n′, K_n″, K_n‴ by the full modal sum in 120 digits (mpmath).
type Case = ((usize, f64, f64, f64, usize, f64), [&'static str; 4]);
const CASES: [Case; 5] = [
    (
        (21, 0.2, 0.1, 1.5, 0, 0.25),
        [
            "0.7351502718667860955573755055003464941676352810624444707225874743569255",
            "0.3193041723334126914418937364154452459766246895733179846679551003805298",
            "-0.2572508437146768181421963771346302951530792546507703310952638383261664",
            "-0.1318520836231321679583703097756271611613177005639678830744043819233886",
        ],
    ),
    (
        (21, 0.2, 0.1, 1.5, 10, 0.25),
        [
            "0.000001667044310947393256411803281103192856255503081843563327740887768703664",
            "0.00000000000008076723341556605500789195104946451838374937902985796291840888959722993",
            "-0.00000000000000000002235245466027077440125584394038386665656223126564945723760473064452366",
            "-0.0000000000001817262751646074323795771801122122103372035501300891439204800156702736",
        ],
    ),
    (
        (5, 1e-30, 3.0, 0.4, 1, 0.375),
        [
            "12732395447351626507228367941.41386928440751325021398814692249379034056",
            "0.1475212437810980199842242075422104712917812822763666924493058638244128",
            "0.4676606188513335357400831826551053748066921751505752781818295226530863",
            "-0.2116705041291772336880805197227371585663549695866597575007807133462426",
        ],
    ),
    (
        (8, 1000.0, 2.5, 0.01, 3, 0.8125),
        [
            "-0.006689860594004368517400746398990226145359509748608850274146919557090555",
            "0.2536852363980211260850836634838377257510198174020383391955484489172081",
            "6.745035382805880230044176606825308165477014278949515200477271076065106",
            "-257.2404660995580339924872660562214419471350409441163709161705243851831",
        ],
    ),
    (
        (21, 0.2, 0.1, 0.6324555320336759, 2, 0.125),
        [
            "0.7326791573912396563473725353764000825674117889245385178875503978779085",
            "-0.4485680211127617173644562636605153418015940995381172188974838459231459",
            "-0.2849304782736707312207196784204906442093390370729110115487535807124117",
            "0.1774332075239210433765500209467643344422293444422438129096914974288496",
        ],
    ),
];

#[test]
fn all_digits_agree_with_another_library() {
    for ((sites, gamma1, gamma2, omega, site, fraction), expected) in CASES {
        let kernel = kernel(sites, gamma1, gamma2, omega);
        let t = kernel.period() * fraction;
        let jet = kernel.jet(site, 0, &t);
        let largest = kernel.jet(0, 0, &t);
        let pairs = [
            (&jet.value, &largest.value),
            (&jet.slope, &largest.slope),
            (&jet.curvature, &largest.curvature),
            (&jet.third, &largest.third),
        ];
        for ((found, scale), text) in pairs.into_iter().zip(expected) {
            assert_close(found, &Real::parse(text, 320).unwrap(), scale, 56.0);
        }
        assert_eq!(jet.slope, kernel.slope(site, 0, &t));
        assert_eq!(jet.curvature, kernel.curvature(site, 0, &t));
        assert_eq!(jet.third, kernel.third(site, 0, &t));
    }
}

#[test]
fn one_mass_by_hand() {
    // γ₁ = 1, ω = 3: K = cos(t − π/3)/(2 sin π/3) = cos(t − π/3)/√3; K(0) = 1/(2√3).
    let kernel = kernel(1, 1.0, 0.0, 3.0);
    let root = Real::new(3.0, 256).sqrt();
    assert_close(&kernel.chi2(), &(Real::new(-1.0, 256) / &root), &root, 58.0);
    let third = kernel.period() / 2.0;
    assert_close(&kernel.value(0, 0, &third), &(Real::one(256) / &root), &root, 58.0);
    // Half-way to the middle x = −π/6: K′ = −sin x/(2 sin π/3) = 1/(2√3).
    let quarter = kernel.period() / 4.0;
    assert_close(&(kernel.chi3(&quarter) * &root), &Real::one(256), &root, 58.0);
    // A free mass: K̂ = T/24 − (t−T/2)²/(2T), K′ = ½ − t/T.
    let free = Kernel::new(&Chain::new(1, 0.0, 1.0).unwrap(), 1.0, 2, 128).unwrap();
    let period = Real::pi(192) * 4.0;
    assert_close(&free.value(0, 0, &Real::zero(192)), &(-&period / 12.0), &period, 37.0);
    assert_close(&free.slope(0, 0, &(&period / 4.0)), &Real::new(0.25, 128), &period, 37.0);
    assert!(free.uniform_static().is_none() && free.static_part(0, 0).is_zero());
}

/// What the springs do to mass n of a lattice with the displacements `u`: neighbours by the plain rule, all in many digits.
fn springs(chain: &Chain, u: &[Real], n: usize) -> Real {
    let (length, layers) = (chain.length(), chain.layers());
    let (site, layer, own) = (n % length, n / length, &u[n]);
    let stretch = |ends: Ends, place: usize, count: usize, at: &dyn Fn(usize) -> usize| {
        let side = |inside: bool, next: usize, far: usize| match (inside, ends) {
            (true, _) => own - &u[at(next)],
            (false, Ends::Closed) => own - &u[at(far)],
            (false, Ends::Free) => Real::zero(64),
            (false, Ends::Fixed) => own.clone(),
        };
        side(place > 0, place.wrapping_sub(1), count - 1) + side(place + 1 < count, place + 1, 0)
    };
    let along = stretch(chain.ends(), site, length, &|site| site + layer * length);
    let across = stretch(chain.layer_ends(), layer, layers, &|layer| site + layer * length);
    -(own * chain.gamma1()) - along * chain.gamma2() - across * chain.gamma3()
}

/// Equation of motion, periodicity and a unit jump of velocity: nothing but K_nm has them all.
#[test]
fn it_solves_the_problem_it_is_the_solution_of() {
    let row = |sites, gamma1, gamma2, ends| Chain::new(sites, gamma1, gamma2).unwrap().with_ends(ends);
    let layered = |chain: Chain, layers, gamma3, ends| chain.with_layers(layers, gamma3, ends).unwrap();
    let cases = [
        (row(2, 0.2, 0.1, Ends::Closed), 0.83, 1),
        (row(3, 1e-40, 0.7, Ends::Closed), 1.3, 1),
        (row(8, 0.2, 0.1, Ends::Closed), 0.31, 2),
        (row(9, 0.0, 0.1, Ends::Closed), 0.9, 1),
        (row(21, 3.0, 2.0, Ends::Closed), 0.05, 1),
        (row(1, 0.2, 0.1, Ends::Free), 0.83, 1),
        (row(6, 0.2, 0.1, Ends::Free), 0.83, 2),
        (row(5, 0.0, 0.1, Ends::Free), 0.83, 1),
        (row(1, 0.0, 0.1, Ends::Fixed), 0.83, 1),
        (row(6, 0.0, 0.1, Ends::Fixed), 0.83, 1),
        (layered(row(1, 0.2, 0.1, Ends::Closed), 2, 0.03, Ends::Free), 1.5, 1),
        (layered(row(4, 0.2, 0.1, Ends::Closed), 3, 0.03, Ends::Closed), 1.5, 1),
        (layered(row(3, 0.0, 0.1, Ends::Free), 3, 0.1, Ends::Free), 1.5, 2),
        (layered(row(4, 0.2, 0.1, Ends::Fixed), 2, 0.3, Ends::Closed), 0.7, 1),
        (layered(row(2, 0.0, 0.1, Ends::Free), 3, 0.3, Ends::Fixed), 0.7, 1),
    ];
    for (chain, omega, periods) in cases {
        let kernel = Kernel::new(&chain, omega, periods, DEFAULT_BITS).unwrap();
        let (t, sites) = (kernel.period() * 0.3125, chain.sites());
        for from in [0, sites / 2, sites - 1] {
            let all = |of: &dyn Fn(usize) -> Real| (0..sites).map(of).collect::<Vec<Real>>();
            let (moving, fixed) = (all(&|n| kernel.dynamic(n, from, &t)), all(&|n| kernel.static_part(n, from)));
            let scale = moving[from].abs() + 1.0;
            for n in 0..sites {
                // The dynamic part answers the impulse less its mean: the rest of the mean force is that of the static part.
                let mut force = springs(&chain, &moving, n) + springs(&chain, &fixed, n);
                if chain.is_adrift() {
                    // A rigid mode is pulled back evenly by the mean of the impulses.
                    force -= Real::one(256) / kernel.period() / sites as f64;
                }
                assert_close(&kernel.curvature(n, from, &t), &force, &scale, 54.0);
                let after = kernel.slope(n, from, &(Real::new(1e-70, 512)));
                let before = kernel.slope(n, from, &(-Real::new(1e-70, 512)));
                let jump = Real::new(if n == from { 1.0 } else { 0.0 }, 256);
                assert_close(&(after - before), &jump, &scale, 55.0);
                let later = &t + kernel.period();
                assert_close(&kernel.value(n, from, &later), &kernel.value(n, from, &t), &scale, 55.0);
            }
        }
        assert!(kernel.slope(0, 0, &Real::zero(64)).is_zero() && kernel.third(0, 0, &Real::zero(64)).is_zero());
        let profile = kernel.profile(&t);
        let last = profile.len() - 1;
        assert_eq!(profile[last], kernel.value(last, 0, &t));
    }
}

#[test]
fn derivatives_are_derivatives() {
    let kernel = Kernel::new(&Chain::new(7, 0.2, 0.1).unwrap(), 0.4, 1, 512).unwrap();
    let t = kernel.period() * 0.21;
    let h = Real::one(512).times_power_of_two(-130);
    let (plus, minus, here) = (kernel.jet(2, 0, &(&t + &h)), kernel.jet(2, 0, &(&t - &h)), kernel.jet(2, 0, &t));
    let pairs = [
        ((&plus.value, &minus.value), &here.slope),
        ((&plus.slope, &minus.slope), &here.curvature),
        ((&plus.curvature, &minus.curvature), &here.third),
    ];
    for ((plus, minus), derivative) in pairs {
        // Error h²/6·|K⁗| ~ 2^−260 ~ 1e−78.
        assert_close(&((plus - minus) / (&h * 2.0)), derivative, &Real::one(64), 75.0);
    }
}

#[test]
fn far_sites_need_more_digits_and_get_them() {
    // 150 masses away the answer is 1e-300 and below. Of all harmonics the constant one reaches farthest: neighbours'
    // ratios approach its decay factor.
    let kernel = Kernel::new(&Chain::new(400, 0.2, 0.001).unwrap(), 1.5, 1, 1200).unwrap();
    let profile = kernel.profile(&(kernel.period() * 0.5));
    assert!(profile[150].log10_abs() < -300.0);
    // γ₂(v_{n+1} + v_{n−1}) = (γ₁ + 2γ₂)v_n
    let b = 0.202 / 0.001;
    let decay = (b - (b * b - 4.0_f64).sqrt()) / 2.0;
    let ratio = (&profile[151] / &profile[150]).to_f64();
    assert!((ratio / decay - 1.0).abs() < 1e-9, "{ratio} {decay}");
}

#[test]
fn resonances_and_bad_requests_are_errors() {
    let chain = Chain::new(3, 0.25, 0.1).unwrap();
    let error = Kernel::new(&chain, 0.125, 1, DEFAULT_BITS).unwrap_err();
    assert!(matches!(error, TruthError::Resonance { mode: 0, .. }), "{error}");
    // One unit in the last place away it exists, with all digits: against more of them.
    let omega = 0.125 * (1.0 + f64::EPSILON);
    let near = Kernel::new(&chain, omega, 1, DEFAULT_BITS).unwrap();
    let nearer = Kernel::new(&chain, omega, 1, 2 * DEFAULT_BITS).unwrap();
    assert_close(&near.chi2(), &nearer.chi2(), &nearer.chi2(), 57.0);
    assert!(near.chi2().log10_abs() > 14.0);
    for (omega, periods) in [(0.0, 1), (f64::NAN, 1), (f64::INFINITY, 1), (1.0, 0)] {
        assert!(matches!(Kernel::new(&chain, omega, periods, 64), Err(TruthError::Parameter { .. })));
    }
}

#[test]
fn extremes_keep_their_digits() {
    for (sites, gamma1, gamma2, omega) in [(5, 1e-300, 1.0, 1.0), (6, 1e60, 1e-60, 1.0), (4, 0.2, 5e-324, 1e-60)] {
        let (few, many) = (
            kernel(sites, gamma1, gamma2, omega),
            Kernel::new(&Chain::new(sites, gamma1, gamma2).unwrap(), omega, 1, 700).unwrap(),
        );
        let t = many.period() * 0.375;
        for n in 0..2 {
            let (a, b) = (few.dynamic(0, 0, &t), many.dynamic(0, 0, &t));
            assert_close(&a, &b, &b, 55.0);
            assert_close(&few.slope(n, 0, &t), &many.slope(n, 0, &t), &Real::one(64), 55.0);
        }
    }
}

/// Under a force the masses next to walls move less: all of the motion together obeys the equations of motion.
#[test]
fn forced_motions_of_all_lattices_obey_the_equations_of_motion() {
    let row = |sites, ends| Chain::new(sites, 0.2, 0.01).unwrap().with_ends(ends);
    let (mut checked, mut walls) = (0, 0);
    for (chain, word) in [
        (row(5, Ends::Fixed), "1-"),
        (row(4, Ends::Free), "0-"),
        (row(3, Ends::Fixed).with_layers(2, 0.02, Ends::Free).unwrap(), "0:1-"),
        (row(3, Ends::Closed).with_layers(2, 0.02, Ends::Free).unwrap(), "2-"),
    ] {
        let terms = [(1, 0.3), (3, -0.03)].map(|(number, amplitude)| Harmonic { number, amplitude, phase: 0.1 });
        let point = chain.point().omega(1.07).asymmetry(0.7);
        let model = point.under(&Force::new(&terms).unwrap()).restitution(0.6).model().unwrap();
        let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        for orbit in &found.orbits {
            let orbit = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
            let t = orbit.period() * 0.37;
            let displacements: Vec<Real> = (0..chain.sites()).map(|n| orbit.displacement(n, &t)).collect();
            let mut push = Real::zero(256);
            for harmonic in model.force().harmonics() {
                let rate = Real::new(model.omega(), 256) * f64::from(harmonic.number);
                let (_, cos) = (rate * (&t + orbit.psi().unwrap()) + harmonic.phase).sin_cos();
                push += cos * harmonic.amplitude;
            }
            for n in 0..chain.sites() {
                let force = springs(&chain, &displacements, n) + &push;
                assert_close(&orbit.acceleration(n, &t), &force, &Real::one(64), 54.0);
            }
            checked += 1;
            walls += usize::from(chain.has_walls());
        }
    }
    assert!(checked >= 4 && walls >= 2, "{checked} {walls}");
}
