"""Data of the pneumatic brake, in SI units and absolute pressures; who may write what: `data`.

One cell of the brake pipe lies at every vehicle, one face behind every vehicle but the last. Of the gas: R T, from
which follow density p/(R T) and speed of sound sqrt(R T), at one temperature everywhere. v vehicles, l locomotives.
"""

from __future__ import annotations

from typing import NamedTuple

from haul_ros.physics.kernel.data import Floats, record_type

# Kinds of control valve.
NO_VALVE, DIRECT_RELEASE, GRADUATED_RELEASE = 0.0, 1.0, 2.0

# Positions of a control valve.
RELEASED, APPLYING, LAPPED = 0.0, 1.0, 2.0

NEARLY_CHARGED = 5e3
"""Pipe below equalising reservoir [Pa] at which it counts as charged: a fall from there on is one that others made."""


class AirParameters(NamedTuple):
    """Brake pipe and control valve of every vehicle (v,); areas are effective ones, discharge coefficient included."""

    pipe_volume: Floats
    """Of the pipe and its branch [m^3]."""
    face_length: Floats
    """Of pipe between the middle of this vehicle and that of the next [m]."""
    kind: Floats
    """NO_VALVE, DIRECT_RELEASE or GRADUATED_RELEASE [-]."""
    reference_pressure: Floats
    """Gauge pressure of the cylinder at which the brake shoes have their full force [Pa]."""
    auxiliary_volume: Floats
    """Auxiliary reservoir [m^3]; of a locomotive whose cylinder is filled from its main reservoir, that one."""
    from_main_reservoir: Floats
    """1 if that is so, and the brake pipe does not charge it [-]."""
    accelerated_volume: Floats
    """Reservoir of the accelerated release [m^3]."""
    emergency_volume: Floats
    """Emergency reservoir, joined to auxiliary reservoir and cylinder in emergency [m^3]."""
    cylinder_clearance: Floats
    """Volume of the brake cylinder and its piping, piston in [m^3]."""
    cylinder_displaced: Floats
    """What the piston adds when it is out [m^3]."""
    cylinder_spring: Floats
    """Gauge pressure at which the piston is out [Pa]."""
    cylinder_limit: Floats
    """Gauge pressure beyond which the load device lets nothing in [Pa]."""
    bulb_volume: Floats
    """Chamber of the first quick service, or accelerating chamber [m^3]."""
    charge_area: Floats
    """Charging groove between pipe and reservoirs [m^2]."""
    service_area: Floats
    """Auxiliary reservoir to cylinder [m^2]."""
    exhaust_area: Floats
    """Cylinder to atmosphere [m^2]."""
    fast_area: Floats
    """Emergency: reservoir to cylinder up to ``fast_end`` [m^2]."""
    slow_area: Floats
    """Emergency: the same after that [m^2]."""
    bulb_fill_area: Floats
    """Pipe to bulb [m^2]."""
    bulb_vent_area: Floats
    """Bulb to atmosphere [m^2]."""
    quick_service_area: Floats
    """Second quick service: pipe to cylinder [m^2]."""
    accelerated_area: Floats
    """Reservoir of the accelerated release to pipe [m^2]."""
    vent_area: Floats
    """Emergency vent of the pipe [m^2]."""
    apply_difference: Floats
    """Reservoir (graduated: control reservoir) over pipe at which an application begins [Pa]."""
    lap_difference: Floats
    """The same at which the service port closes [Pa]."""
    reapply_difference: Floats
    """The same at which it opens again [Pa]."""
    release_difference: Floats
    """Pipe over reservoir that releases; graduated: control reservoir over pipe below which all is released [Pa]."""
    quick_service_difference: Floats
    """Reservoir over pipe at which the first quick service begins [Pa]."""
    quick_service_end: Floats
    """Gauge pressure of the cylinder that ends the second quick service [Pa]."""
    opening_difference: Floats
    """Over the lap difference, at which the service port is fully open; graduated: of cylinder and its target [Pa]."""
    emergency_difference: Floats
    """Emergency chamber over pipe that trips an emergency; infinite: never [Pa]."""
    emergency_lag: Floats
    """Of the emergency chamber behind the pipe [s]."""
    vent_time: Floats
    """For which an emergency vents the pipe [s]."""
    fast_end: Floats
    """Gauge pressure of the cylinder up to which an emergency fills fast [Pa]."""
    accelerated_end: Floats
    """Gauge pressure of the cylinder below which there is no accelerated release [Pa]."""
    cylinder_ratio: Floats
    """Graduated: gauge pressure of the cylinder per control reservoir over pipe [-]."""
    cylinder_most: Floats
    """Graduated: largest gauge pressure of the cylinder [Pa]."""
    inshot: Floats
    """Graduated: least gauge pressure of the cylinder while applied [Pa]."""
    control_lag: Floats
    """Graduated: of the control reservoir behind the pipe while released [s]."""


class AirState(NamedTuple):
    """Brake pipe and control valve of every vehicle (v,) after the last air step."""

    pipe: Floats
    """Brake pipe pressure [Pa]."""
    flow: Floats
    """Through the face behind the vehicle, rearward positive [kg/s]."""
    momentum: Floats
    """Of the flow through the cell, per time [N]; scratch."""
    inflow: Floats
    """Into the cell from all but the pipe, in this air step [kg]; scratch."""
    auxiliary: Floats
    """Auxiliary reservoir, or the main reservoir that takes its place [Pa]."""
    accelerated: Floats
    """Reservoir of the accelerated release [Pa]."""
    emergency_reservoir: Floats
    """[Pa]"""
    cylinder: Floats
    """Brake cylinder [Pa]."""
    cylinder_before: Floats
    """The same an air step before [Pa]."""
    cylinder_air: Floats
    """In the brake cylinder [kg]."""
    bulb: Floats
    """[Pa]"""
    chamber: Floats
    """Emergency chamber [Pa]."""
    control: Floats
    """Control reservoir of a graduated valve [Pa]."""
    position: Floats
    """RELEASED, APPLYING or LAPPED [-]."""
    quick_service: Floats
    """1 while the pipe is joined to the bulb [-]."""
    boosting: Floats
    """1 while the reservoir of the accelerated release feeds the pipe [-]."""
    emergency: Floats
    """1 from the trip of an emergency to the release [-]."""
    vent_left: Floats
    """Time for which the pipe is still vented [s]."""
    held_off: Floats
    """1 while an electric brake keeps the cylinder empty [-]."""
    cock: Floats
    """Of the face behind the vehicle: 1 open, 0 closed [-]."""
    hole: Floats
    """Effective area of the pipe's opening to the atmosphere: leak, hole, parted hose [m^2]."""
    cut_out: Floats
    """1: the control valve is cut out from the pipe, and its cylinder open to the atmosphere [-]."""


class DriverValveParameters(NamedTuple):
    """Brake valve of every locomotive (l,)."""

    vehicle: Floats
    """Index of the vehicle [-]."""
    reservoir_volume: Floats
    """Main reservoir [m^3]."""


class DriverValveState(NamedTuple):
    """Brake valve of every locomotive (l,) after the last air step."""

    target: Floats
    """To which the equalising reservoir is taken [Pa]."""
    equalising: Floats
    """Equalising reservoir [Pa]."""
    main_reservoir: Floats
    """[Pa]"""
    compressing: Floats
    """1 while the compressor runs [-]."""
    emergency: Floats
    """1 while the driver has emergency [-]."""
    tripped: Floats
    """1 from an emergency that the valve felt to the next command [-]."""
    vent_left: Floats
    """Time for which the felt emergency still vents the pipe [s]."""
    chamber: Floats
    """Pressure behind which the pipe falls in an emergency [Pa]."""
    charged: Floats
    """1 once the pipe has come up to the equalising reservoir since the last command [-]."""
    feed_cut: Floats
    """1 while a fall of the pipe that nobody has commanded here keeps the feed closed [-]."""


AIR = record_type("""
    #present #every #substeps step
    gas root_gas atmosphere pipe_area pipe_bore pipe_friction viscosity
    charge_pressure equalising_down equalising_up dead_band relay_span exhaust_area feed_area emergency_area
    emergency_difference emergency_lag vent_time feed_cut_difference #maintaining
    compressor_flow compressor_on compressor_off
""")
"""present: 1 if the train has a pneumatic brake; an air step of ``step`` [s] is done every so many time steps, or so
many substeps in a time step; gas: R T [J/kg], root_gas: its root [m/s]; pipe_friction: factor of turbulent flow [-];
viscosity: dynamic [Pa s]; the rest of the locomotives' brake valves: areas are effective [m^2], rates [Pa/s],
pressures [Pa], compressor_flow [kg/s]; maintaining: 1 if the feed stays open in an application."""

AIR_ACCOUNT = record_type("vented fed compressed vented_rest compressed_rest")
"""Air that has left to the atmosphere, come from main reservoirs into the pipe, and from compressors into these, since
the start [kg]; a rest is what rounding has added to that sum beyond what was to be added."""
