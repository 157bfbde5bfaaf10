"""Times of a call of Pinocchio from Python, ns, as one line of JSON; `table.py` runs it. Needs the package `pin`.

python peer_pinocchio.py ROBOT.urdf
"""

import json
import sys

import numpy as np
import pinocchio as pin
from clock import least

model = pin.buildModelFromUrdf(sys.argv[1])
data = model.createData()
rng = np.random.default_rng(0)
q, v, a = pin.randomConfiguration(model), rng.normal(size=model.nv), rng.normal(size=model.nv)
calls = {
    "rnea": lambda: pin.rnea(model, data, q, v, a),
    "aba": lambda: pin.aba(model, data, q, v, a),
    "crba": lambda: pin.crba(model, data, q),
}
times = {name: least(call, 50) for name, call in calls.items()}
print(json.dumps({"version": pin.__version__, "nv": model.nv, **times}))
