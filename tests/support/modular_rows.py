"""The conditions of the product modulo a prime as one array, for tests and the judge."""

import numpy as np

from balance.space.exact.modular_series import Momenta, chain_modulo


def conditions(chain, rays, order, p):
    """Conditions of the orders 0 … order along rays (rays, w), modulo p.

    Returns:
        Remainders (order + 1, rays, w, rows, bodies × parameters), and the number of orders
        at which all loops close; or None if p will not do.
    """
    remainders = chain_modulo(chain, p)
    if remainders is None:
        return None
    momenta = [Momenta(remainders, ray) for ray in np.asarray(rays, dtype=np.int64)]
    X = np.array([[one.rows(k) for one in momenta] for k in range(order + 1)])
    closed = min(one.twists.closed for one in momenta)
    return X.reshape(*X.shape[:2], chain.width, len(chain.rows), X.shape[-1]), closed
