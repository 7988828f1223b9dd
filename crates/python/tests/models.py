"""Random models, the same in every run."""

import random

import vibrochain as vc


def random_models(count, seed=20240717):
    """So many models: rings, rows with ends and layers; with and without force, of one harmonic or several."""
    random_ = random.Random(seed)
    for i in range(count):
        layout = {}
        if i % 5 == 3:
            layout["ends"] = random_.choice(["free", "fixed"])
        if i % 7 == 5:
            layout.update(layers=random_.randint(2, 3), gamma3=random_.uniform(0.0, 0.1))
        chain = vc.Chain(random_.randint(1, 30), random_.uniform(0.05, 0.5), random_.uniform(0.0, 0.3), **layout)
        omega, asymmetry = random_.uniform(0.6, 3.0), random_.uniform(0.0, 0.9)
        forced = {}
        if i % 3:
            forced["restitution"] = random_.uniform(0.3, 1.0)
            if i % 11 == 4:
                forced["force"] = vc.Force(
                    [(1, random_.uniform(0.05, 0.5)), (3, random_.uniform(-0.1, 0.1), random_.uniform(-3, 3))]
                )
            else:
                forced["amplitude"] = random_.uniform(0.01, 1.0)
        yield vc.Model(chain, omega, asymmetry, **forced)
