//! What the paper says of each figure, and what to make of it, in words. Numbers that have to be computed stand in the
//! findings, which the figures compute.

/// The words of one figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Caption {
    id: &'static str,
    /// What the paper says of it, and what it leaves out.
    pub(super) paper: &'static str,
    /// What is found here, and the difference if there is one.
    pub(super) here: &'static str,
}

/// The caption of a figure; scenes of a user's own have none.
pub(super) fn caption(id: &str) -> Option<&'static Caption> {
    CAPTIONS.iter().find(|caption| caption.id == id)
}

const CAPTIONS: &[Caption] = &[
    Caption {
        id: "1",
        paper: "The profile does not change with the length of the ring: the breather is strongly localized.",
        here: "The same for the profile; the last line has the difference of the two rings. The longer ring has \
               more modes, and the breather on it sits on a stripe of (weak) instability.",
    },
    Caption {
        id: "2",
        paper: "The asymmetry changes the shape of the profile; it is said to act mainly on the value that displacements \
                tend to away from the breather.",
        here: "Displacements tend to 0 whatever the asymmetry (last column: the farthest mass at the first \
               impact). What is shifted are the few masses next to the breather.",
    },
    Caption {
        id: "3",
        paper: "Over a period the impacting mass differs by a slight change of curvature alone.",
        here: "The same. Both impacts stay half a period apart at every asymmetry (last column).",
    },
    Caption {
        id: "4",
        paper: "With one impact a period the mass does not reach the farther barrier. No frequency is given.",
        here: "The same, at the frequency of figure 8.",
    },
    Caption {
        id: "5",
        paper: "With a force, too, the length of the ring makes no visible difference.",
        here: "The same for the profile, not for stability: the excess |μ| − 1 of the weak instability depends \
               on the ring, whose modes carry the radiation.",
    },
    Caption {
        id: "6",
        paper: "Away from the breather all masses follow the force together; asymmetry mainly shifts the centre of the \
                oscillation.",
        here: "The common motion is the uniform response to the force (last column), which knows no asymmetry. \
               What is shifted is the breather and its neighbours. All three are unstable by Neimark–Sacker, by \
               some per cent a period.",
    },
    Caption {
        id: "7",
        paper: "With a force the second impact is not at half a period; the deviation is typically very small.",
        here: "The same; the last column is the deviation. At a = 0 there is none.",
    },
    Caption {
        id: "8",
        paper: "A forced single-sided breather exists at ω = 0.92. Elsewhere the second impact is said to be at \
                φ = π/ω where the orbit grazes the upper barrier.",
        here: "It exists and is weakly unstable. Grazing is not at half a period: with losses the orbit has no \
               mirror symmetry in time, its peak is late ([errata.md](errata.md)).",
    },
    Caption {
        id: "9",
        paper: "Several solutions, very different from each other, exist at one point, some of them stable; even with \
                a = 0 there are asymmetric ones, which become stable where the symmetric one loses stability by a \
                pitchfork. The restitution is not given.",
        here: "At e = 0.6 there are four: two symmetric ones and a stable asymmetric pair, born in the pitchfork \
               of the right-hand panel. Below it only the symmetric ones are left, one of them stable. The curve \
               a(φ) in the middle meets a = 0 in all of them.",
    },
    Caption {
        id: "10",
        paper: "Double-sided breathers are stable in one large region, single-sided ones in strips on the other side of \
                the grazing line, along which lies a band of unstable double-sided ones. Stability is lost by \
                Neimark–Sacker bifurcations.",
        here: "With excess below 1 % a period counted as stable the map has the paper's shape. Nearly all of the \
               cells that count as stable have multipliers outside the circle all the same (last lines; the \
               strict map follows). Neimark–Sacker is the most frequent way to lose stability, not the only one \
               (table and textures).",
    },
    Caption {
        id: "10-strict",
        paper: "(Not in the paper.)",
        here: "Strictly speaking nearly all forced double-sided breathers are unstable: they radiate into the \
               modes of the ring, and simulations show the rates that the multipliers say \
               ([validation.md](validation.md)). A simulation of some hundred periods would not see it. What is \
               left of stability lies at zero coupling and in a thin line of single-sided breathers along the \
               grazing line.",
    },
    Caption {
        id: "11",
        paper: "An unstable single-sided breather: the simulation leaves the analytic orbit, which confirms the analysis. \
                No parameters are given.",
        here: "The same; moreover the distance grows at the rate of the multiplier for as long as it is small (right), \
               until other masses meet their barriers, too.",
    },
    Caption {
        id: "12",
        paper: "The same for a double-sided breather. No parameters are given.",
        here: "The same; again at the rate of the multiplier. Localization is lost in the end: all masses come \
               to move alike (last line). The second window shows the change, not the end.",
    },
    Caption {
        id: "13",
        paper: "Beyond a period doubling two consecutive peaks of different heights make up one period. No parameters are \
                given; such orbits are said to need a frequency in the ring's attenuation zone.",
        here: "Started off the orbit the ring returns to it at the rate of the multiplier. The difference of the \
               peaks is small: doubling is supercritical, and the doubled orbit soon loses stability. A finite \
               ring needs no attenuation zone, only that no harmonic of ω/2 meets a mode.",
    },
    Caption {
        id: "15a",
        paper: "The map resembles that of forced breathers. Stripes of instability depend on the length of the ring, as they \
                come from its modes; apart from them length matters little. Stability is lost by Neimark–Sacker bifurcations.",
        here: "The shortest ring: few modes, few stripes.",
    },
    Caption { id: "15b", paper: "The same.", here: "More modes, more stripes; the regions stay where they are." },
    Caption {
        id: "15c",
        paper: "The same.",
        here: "The regions and stripes are as described. Stability is lost in all three ways (table and \
               textures): the stripes are mostly Neimark–Sacker; bands of real multipliers above +1 accompany \
               the grazing line and bound the single-sided region at low frequency; single-sided breathers near \
               grazing also lose it through −1.",
    },
    Caption {
        id: "15d",
        paper: "The same.",
        here: "Stripes become more and closer together, as modes do: their cells are the ones that the table has more of.",
    },
];
