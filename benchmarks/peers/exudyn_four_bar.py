"""exudyn: the four-bar with a flexible coupler hinged at its ends, by ANCF cable elements.

The coupler stretches there; its axial stiffness is so large that results no longer change by
more than 0.2 %. Wheels are the rotary inertia that they add to the links they are geared to.
"""

from __future__ import annotations

import numpy as np

from benchmarks.peers import library

AXIAL, WHEEL, SHARE, MASS = 1e6, 0.6875, 0.1, 5.0
CRANK, COUPLER, PIVOT = np.array([0.0, 0.5]), np.array([1.0, 0.5]), np.array([1.5, -0.5])


def peak_force(profile, duration: float, elements: int, steps: int) -> float:
    """Simulate, and return the largest force on the mount.

    Args:
        profile: angle of the crank over time, its rate and acceleration.
        duration: in units of time.
        elements: of the coupler.
        steps: of the integrator.
    """
    exu = library("exudyn")
    items = library("exudyn.itemInterface")
    from exudyn.beams import GenerateStraightLineANCFCable2D

    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(items.ObjectGround())

    def body(inertia, centre):
        node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*centre, 0.0]))
        rigid = items.ObjectRigidBody2D(mass=MASS, inertia=inertia, nodeNumber=node)
        return node, mbs.AddObject(rigid)

    def on(number, point):
        return mbs.AddMarker(
            items.MarkerBodyPosition(bodyNumber=number, localPosition=[*point, 0.0])
        )

    def pin(first, second):
        return mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[first, second]))

    low, high = -SHARE * CRANK, PIVOT - SHARE * (COUPLER - PIVOT)
    node, crank = body(1e-9, low)
    _, rocker = body(WHEEL, high)
    cable = items.ObjectANCFCable2D(
        physicsMassPerLength=1.0, physicsBendingStiffness=1.0, physicsAxialStiffness=AXIAL
    )
    ends = GenerateStraightLineANCFCable2D(
        mbs, [*CRANK, 0.0], [*COUPLER, 0.0], elements, cable, [0, 0, 0], None, None
    )[0]
    tips = [mbs.AddMarker(items.MarkerNodePosition(nodeNumber=n)) for n in (ends[0], ends[-1])]
    mounts = [
        pin(on(ground, (0.0, 0.0)), on(crank, -low)),
        pin(on(ground, PIVOT), on(rocker, PIVOT - high)),
    ]
    pin(on(crank, CRANK - low), tips[0])
    pin(on(rocker, COUPLER - high), tips[1])
    fixed = mbs.AddNode(items.NodePointGround())
    both = [
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=n, coordinate=c))
        for n, c in ((fixed, 0), (node, 2))
    ]
    mbs.AddObject(
        items.ObjectConnectorCoordinate(
            markerNumbers=both, offsetUserFunction=lambda mbs, t, *_: profile(t)[0]
        )
    )
    force = exu.OutputVariableType.Force
    sensors = [
        mbs.AddSensor(
            items.SensorObject(objectNumber=mount, storeInternal=True, outputVariableType=force)
        )
        for mount in mounts
    ]
    mbs.Assemble()
    mbs.SolveDynamic(_settings(exu, duration, steps))
    total = sum(mbs.GetSensorStoredData(sensor)[:, 1:3] for sensor in sensors)
    return float(np.hypot(*np.transpose(total)).max())


def _settings(exu, duration, steps):
    """Generalised α with little damping, full Newton steps."""
    found = exu.SimulationSettings()
    integration = found.timeIntegration
    integration.numberOfSteps, integration.endTime = steps, duration
    integration.generalizedAlpha.spectralRadius = 0.98
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-7
    integration.verboseMode = 0
    found.solutionSettings.writeSolutionToFile = False
    found.solutionSettings.sensorsWritePeriod = 2.0 * duration / steps
    return found
