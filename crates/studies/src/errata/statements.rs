//! Statements of the text that do not hold as they stand, each with a command and what it prints.

use crate::errata::evidence::Evidence;

pub(super) const HEADING: &str = "
## Statements

Each command prints more than is quoted.
";

const RADIUS: &[&str] = &["spectral radius"];

pub(super) const STATEMENTS: &[Evidence] = &[
    Evidence {
        title: "\"φ = π/ω by orthogonality\" (conservative, double-sided)",
        prose: "Unique only if every mode lies below ω. Otherwise χ₃(φ) = 0 may have more roots. At the paper's parameters they \
                are not physical; on short rings at low frequency some are, and stable.",
        commands: &[
            "orbit --family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .42 --asymmetry .4",
            "orbit --family double-sided --sites 3 --gamma1 .14 --gamma2 .25 --omega .55 --asymmetry 0",
        ],
        quoted: &["solutions,", "phi", "physical"],
    },
    Evidence {
        title: "\"Stability of conservative breathers is lost by Neimark–Sacker\"",
        prose: "Also through +1 and −1.",
        commands: &[
            "orbit --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .80 --asymmetry .4",
            "orbit --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .93 --asymmetry .4",
        ],
        quoted: RADIUS,
    },
    Evidence {
        title: "\"Period doubling belongs to single-sided breathers\"",
        prose: "Forced double-sided ones have it, too.",
        commands: &[
            "orbit --family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .5 --restitution .9",
        ],
        quoted: RADIUS,
    },
    Evidence {
        title: "The forced breathers that the map calls stable",
        prose: "They are mostly weakly unstable: they radiate into the ring's modes, and the longer the ring the slower \
                the growth. At the paper's defaults, N = 10, 20 and 100 (first solution each). `studies validate` sets such rates \
                against simulations; counting growth below 1 % a period as stable gives a map of the paper's shape \
                ([figures.md](figures.md), figure 10).",
        commands: &[
            "orbit --family double-sided --sites 11 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
            "orbit --family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
            "orbit --family double-sided --sites 101 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
        ],
        quoted: RADIUS,
    },
    Evidence {
        title: "\"Stable forced breathers are hyperbolic attractors\"",
        prose: "The modes that are odd about the breather have a node at it and never feel an impact: on a ring of M masses \
                their ⌊(M−1)/2⌋ pairs of multipliers stay on the unit circle, and perturbations along them neither grow nor \
                decay. Below, a stable breather, pushed at random by 1e-4 and simulated for 20 000 periods, keeps a \
                distance of that order.",
        commands: &[
            "simulate --family single-sided --sites 21 --gamma1 .2 --gamma2 .08 --omega .92 --asymmetry .7 --amplitude .05 --restitution .9 --perturb 1e-4 --periods 20000",
        ],
        quoted: &["largest distance", "periods,"],
    },
    Evidence {
        title: "\"The doubled orbit needs a frequency in the attenuation zone\"",
        prose: "A finite ring only asks that no harmonic of ω/2 meets a mode. In figure 13 half the force's frequency, 0.535, \
                lies inside the band from √0.2 to √0.6 of the ring; one of the orbits listed is physical, and stable.",
        commands: &[
            "orbit --family period-doubled --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .1582 --restitution .25",
        ],
        quoted: &["physical", "spectral radius"],
    },
    Evidence {
        title: "\"φ = π/ω at grazing\" (forced, single-sided)",
        prose: "Only for e = 1. With losses the peak is late, see the first of the points above. The double-sided breather \
                starts at the same point, with a multiplier that tends to −∞: just beyond, both barriers are met, the upper \
                one at a small velocity.",
        commands: &[
            "orbit --family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .9305 --asymmetry .4 --amplitude .1 --restitution .9",
        ],
        quoted: &["solution 1:", "upper barrier", "spectral radius"],
    },
    Evidence {
        title: "Figure 9 without a restitution",
        prose: "Four solutions exist above the pitchfork listed above, two below.",
        commands: &[
            "orbit --family double-sided --sites 21 --gamma1 .1 --gamma2 .05 --omega 1.33 --asymmetry 0 --amplitude 1.5 --restitution .6",
            "orbit --family double-sided --sites 21 --gamma1 .1 --gamma2 .05 --omega 1.33 --asymmetry 0 --amplitude 1.5 --restitution .5",
        ],
        quoted: &["solutions,", "spectral radius"],
    },
];
