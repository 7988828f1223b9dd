# Breathers of a ring from Julia: `mapgen` computes, its answers are JSON.
#
#     julia --project=examples/julia -e 'import Pkg; Pkg.instantiate()'
#     julia --project=examples/julia examples/julia/breather.jl
#
# The program is the first `mapgen` on PATH, or what the variable MAPGEN names.
using JSON

const MAPGEN = get(ENV, "MAPGEN", "mapgen")

"""The answer of a command of `mapgen`; what it refuses is an error in its own words."""
function ask(command, arguments...)
    out, told = IOBuffer(), IOBuffer()
    words = string.([command, "--json", arguments...])
    process = run(pipeline(ignorestatus(`$MAPGEN $words`); stdout = out, stderr = told))
    success(process) || error(String(take!(told)))
    return JSON.parse(String(take!(out)))
end

chain = ["--sites", 21, "--gamma1", 0.2, "--gamma2", 0.1, "--asymmetry", 0.4, "--amplitude", 0.1, "--restitution", 0.9]
answer = ask("orbit", "--family", "double-sided", "--omega", 1.5, chain...)
for orbit in answer["solutions"]
    impulses = [round(impact["impulse"]; digits = 6) for impact in orbit["impacts"]]
    multipliers = [complex(pair...) for pair in orbit["stability"]["multipliers"]]
    println("impulses ", impulses, ", largest |μ| ", maximum(abs, multipliers))
end

# How fast perturbations of the first breather grow, as the frequency varies.
for omega in 1.4:0.1:1.8
    orbit = ask("orbit", "--family", "double-sided", "--omega", omega, chain...)["solutions"][1]
    println("ω = ", omega, ": ", orbit["stability"]["spectral_radius"])
end

@assert length(answer["solutions"]) == 2
@assert round(answer["solutions"][1]["stability"]["spectral_radius"]; digits = 6) == 1.001629
