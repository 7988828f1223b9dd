//! Points where orbits change: the commands that find them, with an error each.

use crate::errata::evidence::Evidence;

pub(super) const HEADING: &str = "
## Points of change

21 masses (N = 20). `mapgen locate` follows the branch through a breather and solves for the points on it, each with the
error that rounding may have left; it prints more than is quoted.
";

pub(super) const POINTS: &[Evidence] = &[
    Evidence {
        title: "Grazing, single-sided (figures 8 and 10)",
        prose: "The mass touches the farther barrier later than half a period after its impact.",
        commands: &[
            "locate --event grazing --free omega --from .92 --to .94 --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega .925 --asymmetry .4 --amplitude .1 --restitution .9",
        ],
        quoted: &[" ± ", "touches", "period"],
    },
    Evidence {
        title: "Pitchfork, double-sided (figure 9)",
        prose: "Where the symmetric breather loses stability and the asymmetric pair is born.",
        commands: &[
            "locate --event pitchfork --free restitution --family double-sided --sites 21 --gamma1 .1 --gamma2 .05 --omega 1.33 --asymmetry 0 --amplitude 1.5 --restitution .6",
        ],
        quoted: &[" ± ", "asymmetric pair"],
    },
    Evidence {
        title: "Neimark–Sacker, single-sided (figure 11)",
        prose: "Stable below, unstable above.",
        commands: &[
            "locate --event neimark-sacker --free gamma2 --from .08 --to .09 --family single-sided --sites 21 --gamma1 .2 --gamma2 .085 --omega .92 --asymmetry .7 --amplitude .05 --restitution .9",
        ],
        quoted: &[" ± ", "multiplier", "stable"],
    },
    Evidence {
        title: "Period doubling, single-sided (figure 13)",
        prose: "The doubled orbit starts here.",
        commands: &[
            "locate --event period-doubling --free amplitude --to .17 --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25",
        ],
        quoted: &[" ± ", "doubled orbit"],
    },
    Evidence {
        title: "Fold, single-sided",
        prose: "Below it no single-sided orbit exists.",
        commands: &[
            "locate --event fold --free amplitude --to .17 --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25",
        ],
        quoted: &[" ± "],
    },
];
