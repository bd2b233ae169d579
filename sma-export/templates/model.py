"""{{title}}

Model:        {{model_file}}, SHA-256 {{sha256}}
Made by:      sma {{version}}: {{command}}

Drive:        {{drive_text}}
Output:       displacement, {{output_unit}}; temperatures in degrees Celsius
Sample time:  {{dt_s}} s, fixed: coefficients of this length are in the constants. Export again for another (--sample-time-s).
Samples:      Plant.output is that of sample k; Plant.step then moves on to sample k + 1 under the drive of sample k.
              Inputs must be finite: a NaN spoils the temperature, and with it all later outputs.
Start:        Plant.rest: cold and still. Plant: any temperature and any place between the limiting curves of the loop.
              {{start_text}}
Offset:       {{offset_text}}
Memory rule:  {{rule_text}}
Effects:      {{effects_text}}
Left out:     {{left_out_text}}
#@if pid
Controller:   {{pid_text}}
#@else
Controller:   none; give --tuned or --gains to the export.
#@end

Needs Python 3 alone. Outputs have the bits of the program; with backlash or supply-lag they agree to 1e-12 of the stroke,
since exponentials are those of Python.

Example:

    plant = Plant.rest({{ambient_degc}})
    outputs = []
    for drive in drives:
        outputs.append(plant.output)
        plant.step(drive, {{ambient_degc}})
#@if pid

    pid = Pid(plant.output)
    drive = pid.step(set_point, plant.output)  # once every {{dt_s}} s
#@end
"""

import copy
import math

# Sample time, s.
DT_S = {{dt_s_hex}}
# Where the first training recording starts: temperature above the surroundings, K, and place between the limiting curves, 0
# (heating) to 1 (cooling).
START_RISE_K = {{start_rise_k}}
START_SHARE = {{start_share}}
# Zero of the sensor.
OFFSET = {{offset}}
GAIN = {{gain}}

_SIN = (
{{sin_coefficients}}
)
_ATAN = (
{{atan_coefficients}}
)


def _polynomial(coefficients, x):
    """Even and odd powers by Horner's rule apart."""
    square = x * x
    sums = [0.0, 0.0]
    count = len(coefficients)
    for k in range(count - 1, -1, -1):
        sums[k % 2] = sums[k % 2] * square + coefficients[k] if k + 2 < count else coefficients[k]
    return sums[0] + x * sums[1]


def _sin_quarter(x):
    """sin x for x from 0 to pi/2."""
    square = x * x
    return x + x * square * _polynomial(_SIN, square)


def _atan_quotient(a, b):
    """atan(a/b) for b > 0."""
    size = min(abs(a), 1e300)
    p = size if size < b else b
    q = b if size < b else size
    z = (p - {{tan_pi_8}} * q) / (q + {{tan_pi_8}} * p)
    square = z * z
    octant = {{pi_8}} + (z + z * square * _polynomial(_ATAN, square))
    return math.copysign({{pi_2}} - octant if size > b else octant, a)


def _unit(x):
    """x within 0 and 1."""
    x = x if x > 0.0 else 0.0
    return x if x < 1.0 else 1.0


#@if parts|middle
def _progress(s, a):
    """Share of what a whole sample would do that is done after a share s of it, for a = dt/tau."""
    product = s * (1.0 - s)
    return s + product * a * (0.5 + a * ((1.0 - 2.0 * s) / 12.0 - product * a / 24.0))


#@end
#@if supply_lag
def _mean_exponential(x):
    """(e^x - 1)/x."""
    return 1.0 + 0.5 * x if abs(x) < 1e-9 else math.expm1(x) / x


#@end
#@if r_phase|backlash
def _play_at(driver, half_width, share):
    """Where the driven side of a play stands: share 0 as after rising for long, 1 as after falling."""
    return driver + half_width * (2.0 * _unit(share) - 1.0)


#@end
#@if r_phase
def _play(before, driver, half_width):
    """Where the driven side of a play stands once the driving side is at `driver`."""
    below = before if before < driver + half_width else driver + half_width
    return below if below > driver - half_width else driver - half_width


#@end
class _Branch:
    """A branch of the loop: from a point (temperature above the middle, K, anhysteretic temperature, K), through another
    if there is one to return to."""

    __slots__ = ("start", "rise", "proximity_k", "inverse_proximity_per_k")

    def __init__(self, sign, start, end):
        shift_k = sign * {{loop_half_width_k}}
        widening = _widening(sign)
        distance_k = start[1] * widening + shift_k - start[0]
        within_k = sign * distance_k
        is_beyond = widening != 1.0 and within_k < -1e-9
        self.start = start
        self.rise = 1.0 / widening
        if within_k <= 1e-9 and not is_beyond:
            self.proximity_k = 0.0
            self.inverse_proximity_per_k = sign
            return
        self.proximity_k = distance_k / widening
        self.inverse_proximity_per_k = sign / abs(distance_k)
        if end is None:
            return
        reached_k = self.level_k(end[0])
        excess_k = sign * (reached_k - end[1])
        if excess_k > 0.0:
            shrunk = _factor(end[1] - start[1], reached_k - start[1])
            self.rise = shrunk * self.rise
            self.proximity_k = shrunk * self.proximity_k
        elif excess_k < 0.0:
            limit_k = end[0] - shift_k
            left_k = end[1] * widening - limit_k - distance_k
            natural_k = reached_k * widening - limit_k - distance_k
            self.proximity_k = _factor(left_k, natural_k) * self.proximity_k

    def level_k(self, temperature_k):
        """Anhysteretic temperature, K."""
        travel_k = temperature_k - self.start[0]
        angle = {{zeta}} * (travel_k * self.inverse_proximity_per_k)
        angle = 0.0 if angle < 0.0 else angle
        angle = {{pi_2}} if angle > {{pi_2}} else angle
        return self.start[1] + self.rise * travel_k - self.proximity_k * _sin_quarter(angle)


def _widening(sign):
#@if loop_asymmetry
    return {{widening_heating}} if sign > 0.0 else {{widening_cooling}}
#@else
    return 1.0
#@end


def _factor(part, whole):
    """A factor of rescaling, within 0 and 1."""
    if whole == 0.0:
        return 0.0 if part * math.copysign(1.0, whole) < 0.0 else 1.0
    quotient = part / whole
    nearest = 0.0 if quotient < 0.0 else 1.0
    return quotient if 0.0 <= quotient <= 1.0 else nearest


def _within_reach(temperature_k):
    return -1e6 if temperature_k < -1e6 else 1e6 if temperature_k > 1e6 else temperature_k


def _added_k(sign, temperature_k):
    """What asymmetry adds to a limiting curve, K; 0 without one."""
    plain_k = temperature_k - sign * {{loop_half_width_k}}
    return plain_k / _widening(sign) - plain_k


class _Memory:
    """All that the hysteresis remembers, from a share of the way between the heating (0) and the cooling curve (1) on.
    `is_nested`: all reversals that enclose the branch; else the last one."""

    def __init__(self, temperature_degc, share, is_nested):
        temperature_k = _within_reach(temperature_degc - {{loop_center_degc}})
        share = _unit(share)
        level_k = temperature_k + (2.0 * share - 1.0) * {{loop_half_width_k}} + (
            (1.0 - share) * _added_k(1.0, temperature_k) + share * _added_k(-1.0, temperature_k)
        )
        self.is_nested = is_nested
        self.sign = 1.0 if share <= 0.0 else -1.0
        self.base = (temperature_k, level_k)
        self.branch = _Branch(self.sign, self.base, None)
        self.return_k = math.inf
        self.furthest_k = self.sign * temperature_k
        self.turns = []
        # Pairs of reversals that found no room.
        self.forgotten = 0

    def commit(self, temperature_degc):
        """Goes to a temperature; returns the fraction there."""
        temperature_k = temperature_degc - {{loop_center_degc}}
        if self._leaves(temperature_k):
            self._change_branch(temperature_k)
        level_k = self.branch.level_k(temperature_k)
        if self.sign * temperature_k > self.furthest_k:
            self.furthest_k = self.sign * temperature_k
        return _fraction_at(level_k)

    def peek(self, temperature_degc):
        """Fraction at a temperature, without going there."""
        temperature_k = temperature_degc - {{loop_center_degc}}
        if self._leaves(temperature_k):
            # What changes in the copy is replaced, so that the two may share the rest.
            towards = copy.copy(self)
            return towards.commit(temperature_degc)
        return _fraction_at(self.branch.level_k(temperature_k))

    def _turns_back(self, temperature_k):
        return self.sign * temperature_k - self.furthest_k < -{{dead_band_k}}

    def _leaves(self, temperature_k):
        return self._turns_back(temperature_k) or self.sign * temperature_k > self.return_k

    def _change_branch(self, temperature_k):
        turns, sign = self.turns, self.sign
        if self._turns_back(temperature_k):
            at_k = _within_reach(sign * self.furthest_k)
            added = (at_k, self.branch.level_k(at_k))
            sign = -sign
            if not self.is_nested:
                turns = []
            elif len(turns) == {{nesting_capacity}}:
                turns = turns[:-2]
                self.forgotten += 1
            turns = turns + [added]
        # The reversal before the last is the one that a branch returns to.
        while len(turns) > 1 and sign * (temperature_k - turns[-2][0]) > 0.0:
            turns = turns[:-2]
        end = turns[-2] if len(turns) > 1 else None
        self.branch = _Branch(sign, turns[-1] if turns else self.base, end)
        self.return_k = math.inf if end is None else sign * end[0]
        self.turns = turns
        self.sign = sign
        # The extreme of the direction left behind must not hold back the new one.
        self.furthest_k = sign * temperature_k


def _fraction_at(level_k):
    return {{fraction_per_radian}} * _atan_quotient(level_k, {{loop_spread_k}}) + {{fraction_center}}


#@if scale
def _transformed(fraction):
    """Transformed share: the fraction, 0 cold to 1 hot, whatever its own scale."""
    return (fraction - {{fraction_cold}}) * {{per_fraction_span}}


#@end
#@if output_lag|thermocouple_lag
class _Lag:
    """A first-order lag of something whose middle in a sample is known."""

    def __init__(self, signal, retained, trailing, bent):
        self.followed = signal
        self.value = signal
        self.retained, self.trailing, self.bent = retained, trailing, bent

    def follow(self, middle, signal):
        behind = self.value - self.followed
        change = signal - self.followed
        bend = middle - (self.followed + 0.5 * change)
        self.followed = signal
        self.value = signal + (behind * self.retained - change * self.trailing + bend * self.bent)
        return self.value


#@end
#@if dead_time
class _Late:
    """What a pure delay lets through: the sample that many before the newest, and the age of its end, s."""

    def __init__(self):
        self.behind = 0
        self.age_s = 0.0

    def add(self):
        self.behind += 1
        self.age_s += {{part_s}}

    def go_on(self, age_s):
        """To the sample that began more than `age_s` before the end of the newest, and ended no later."""
        while self.behind > 0 and self.age_s - age_s > 1e-9 * {{part_s}}:
            self.behind -= 1
            self.age_s -= {{part_s}}
        if self.behind == 0:
            self.age_s = 0.0
        return self.behind


#@end
class Plant:
    """A rod of a temperature, deg C, at a share of the way from the heating (0) to the cooling curve (1); the drive was off
    before, and all lags have settled."""

    def __init__(self, temperature_degc, share):
        self._rod_degc = temperature_degc
        self._memory = _Memory(temperature_degc, share, {{is_nested}} == 1)
#@if return_point_memory
        self._other = _Memory(temperature_degc, share, {{other_is_nested}} == 1)
#@end
        self._fraction = self._mapped(temperature_degc, self._memory.peek(temperature_degc))
#@if r_phase
        self._r_phase_degc = _play_at(temperature_degc, {{r_phase_half_width_k}}, share)
#@end
#@if supply_lag|dead_time
        self._has_begun = False
#@end
#@if supply_lag
        self._supply_level = self._supply_started = self._supply_wanted = 0.0
#@end
#@if dead_time
        self._sent_w_per_m = [0.0] * {{late_capacity}}
        self._newest = 0
        self._arriving = _Late()
#@end
#@if middle
        self._middle_fraction = self._fraction
        self._middle_degc = temperature_degc
#@end
#@if thermocouple_lag
        self._thermocouple = _Lag(
            temperature_degc, {{thermocouple_retained}}, {{thermocouple_trailing}}, {{thermocouple_bent}}
        )
        self._recorded_degc = temperature_degc
#@end
        # Displacement, {{output_unit}}, as the sensor reads it.
        self.output = self._show("start", share)

    @classmethod
    def rest(cls, ambient_degc):
        """A rod that is cold and still: cooled to the temperature of the surroundings, deg C."""
        return cls(ambient_degc, 1.0)

    @property
    def temperature_degc(self):
        """Temperature of the rod, deg C, as a thermocouple on it would record it."""
#@if thermocouple_lag
        return self._recorded_degc
#@else
        return self._rod_degc
#@end

    def step(self, drive, ambient_degc):
        """Moves on by one sample of {{dt_s}} s under a drive ({{drive_text}}), in surroundings of a temperature, deg C."""
#@if drive_limit
        if abs(drive) > {{drive_limit}}:
            drive = math.copysign({{drive_limit}}, drive)
#@end
#@if is_duty
        # A bridge is never on for less than none of the time, nor for more than all of it.
        drive = 0.0 if drive < 0.0 else 1.0 if drive > 1.0 else drive
#@end
#@if is_current
        power_w_per_m = drive * drive * {{resistance_ohm_per_m}}
#@end
#@if is_duty
        power_w_per_m = {{power_numerator}} * drive / {{power_divisor}}
#@end
#@if is_voltage
        power_w_per_m = drive * drive / {{power_divisor}}
#@end
#@if is_power
        power_w_per_m = drive / {{length_m}}
#@end
        for _ in range({{n_sub_steps}}):
            self._sub_step(power_w_per_m, ambient_degc)

    def _mapped(self, driving_degc, fraction):
        """What effects make of a fraction."""
#@if return_point_memory
        fraction += {{return_point_share}} * (self._other.peek(driving_degc) - fraction)
#@end
#@if loop_shape
        p = _transformed(fraction)
        x = 1.0 - 2.0 * p
        square = x * x
        bulge = p * (1.0 - p)
        added = bulge * ({{loop_shape_1}} + {{loop_shape_2}} * x + {{loop_shape_3}} * (1.25 * square - 0.25))
        fraction += {{fraction_span}} * added
#@end
        return fraction

#@if delays_output
    def _moved_at(self, age_s):
        """Displacement some time before the end of the newest sample."""
        here = self._newest - self._showing.go_on(age_s)
        end = self._shown_end[here]
        start = self._shown_end[here - 1]
        bend = self._shown_middle[here] - 0.5 * (start + end)
        share = (age_s - self._showing.age_s) / {{part_s}}
        return end + share * (start - end) + 4.0 * bend * share * (1.0 - share)

#@end
    def _show(self, instant, share=0.0):
        """Displacement at an instant of the sample; remembers what effects have to."""
#@if middle
        is_middle = instant == "middle"
        fraction = self._middle_fraction if is_middle else self._fraction
        temperature_degc = self._middle_degc if is_middle else self._rod_degc
#@else
        fraction = self._fraction
        temperature_degc = self._rod_degc
#@end
#@if r_phase|thermal_expansion
        transformed = _transformed(fraction)
#@end
#@if r_phase
        driven_degc = _play(self._r_phase_degc, temperature_degc, {{r_phase_half_width_k}})
        above = (driven_degc - {{r_phase_middle_degc}}) / {{r_phase_spread_k}}
        given_back = 0.5 - _atan_quotient(above, 1.0) * {{per_pi}}
        fraction -= {{r_phase_share}} * ({{fraction_span}} * transformed * given_back)
#@end
        y = GAIN * fraction + OFFSET
#@if delays_output
        if instant == "start":
            self._shown_middle = [y] * {{late_capacity}}
            self._shown_end = [y] * {{late_capacity}}
            self._showing = _Late()
            self._shown = y
        elif instant == "turn":
            y = self._shown
        elif instant == "middle":
            middle_s = 0.5 * {{part_s}}
            self._shown_middle[self._newest] = self._shown_end[self._newest] = y
            self._showing.add()
            if {{output_delay_s}} < middle_s:
                before = self._shown_end[self._newest - 1]
                y = y + ({{output_delay_s}} / middle_s) * (before - y)
            else:
                y = self._moved_at({{output_delay_s}} + middle_s)
        else:
            self._shown_end[self._newest] = y
            y = self._moved_at({{output_delay_s}})
            self._shown = y
#@end
#@if thermal_expansion
        warmed_k = temperature_degc - {{reference_degc}}
        y -= {{expansion_per_k}} * (({{of_martensite}} + {{of_austenite}} * transformed) * warmed_k)
#@end
#@if end_stop
        beyond = {{end_stop_sign}} * (y - OFFSET) - {{end_stop}}
        y -= {{end_stop_share}} * ({{end_stop_sign}} * (beyond if beyond > 0.0 else 0.0))
#@end
#@if backlash
        if instant == "start":
            fallen = {{fallen}}
            relaxed = fallen + {{backlash_relaxed}} * (0.5 - fallen)
            self._driver = y
            self._driven = _play_at(y, {{backlash_half_width}}, relaxed)
        else:
            way = y - self._driver
            sign = -1.0 if way < 0.0 else 1.0
            way = abs(way) * {{per_backlash_half_width}}
            lag = sign * (self._driver - self._driven) * {{per_backlash_half_width}}
            waits = 1.0 - {{backlash_softness}} - lag
            waits = waits if waits > 0.0 else 0.0
            waited = way if way < waits else waits
            rest = (way - waited) / {{backlash_least_softness}}
            rest = rest if rest < 700.0 else 700.0
            lag = lag + waited
            lag = lag - (1.0 - lag) * math.expm1(-rest)
            if not ({{backlash_half_width}} > 0.0 and way < waits):
                self._driven = y - {{backlash_half_width}} * (sign * lag)
            self._driver = y
        y = self._driven
#@end
#@if output_lag
        if instant == "start":
            self._output_lag = _Lag(y, {{output_retained}}, {{output_trailing}}, {{output_bent}})
        elif instant == "middle":
            self._middle_output = y
        elif instant == "end":
            y = self._output_lag.follow(self._middle_output, y)
#@end
#@if sensor_nonlinearity
        u = (y - OFFSET) * {{per_stroke}}
        y += u * (1.0 - u) * ({{nonlinearity_quadratic}} + {{nonlinearity_cubic}} * (1.0 - 2.0 * u))
#@end
        return y

#@if dead_time
    def _arrives(self, power_w_per_m):
        """Power that arrives late, and, if it changes in the sample, its share before, and the powers before and after."""
        self._newest = (self._newest + 1) % {{late_capacity}}
        self._sent_w_per_m[self._newest] = power_w_per_m
        self._arriving.add()
        first = self._arriving.behind
        last = self._arriving.go_on({{drive_delay_s}})
        later_w_per_m = self._sent_w_per_m[self._newest - last]
        earlier_w_per_m = self._sent_w_per_m[self._newest - last - 1]
        share = 0.0
        if last < first and earlier_w_per_m != later_w_per_m:
            start_s = {{part_s}} + self._arriving.age_s
            share = 1.0 - _unit((start_s - {{drive_delay_s}}) / {{part_s}})
        return later_w_per_m, (share, earlier_w_per_m, later_w_per_m) if share > 0.0 else None

#@end
#@if supply_lag
    @staticmethod
    def _level(power_w_per_m):
        """Amplitude of a power, or the power itself, whichever lags."""
#@if squares
        return math.sqrt(power_w_per_m)
#@else
        return power_w_per_m
#@end

    @staticmethod
    def _fading(wanted, behind, weight, double_weight):
        """Power of a supply beyond the wanted one, by its weights over a part."""
#@if squares
        return 2.0 * wanted * behind * weight + behind * behind * double_weight
#@else
        return behind * weight
#@end

    @staticmethod
    def _at_s(level, wanted, behind):
        """Time at which the supply is at a level, s after the start of the sample; NaN if it never is."""
        share = (level - wanted) / behind
        return -{{supply_lag_s}} * math.log(share) if share > 0.0 else math.nan

    def _part(self, wanted, behind, share):
        """Mean power over a part of a sample, W/m."""
        faded = share * {{part_s}} / {{supply_lag_s}}
        a = share * {{part_s}} / {{tau_s}}
        once = _mean_exponential(a - faded) / _mean_exponential(a)
        twice = _mean_exponential(a - 2.0 * faded) / _mean_exponential(a)
#@if squares
        return wanted * wanted + self._fading(wanted, behind, once, twice)
#@else
        return wanted + self._fading(wanted, behind, once, twice)
#@end

    def _turn(self, power_w_per_m, ambient_degc):
        """Where the rod turns while the supply falls: share of the sample before, power before, power after; or None."""
        lost = self._lost(ambient_degc)
        level = self._level(lost)
        started, wanted = self._supply_started, self._supply_wanted
        if not (started - level) * (self._supply_level - level) < 0.0:
            return None
        behind = started - wanted
        first_s = self._at_s(level, wanted, behind)
#@if squares
        beyond = started * started - lost
#@else
        beyond = started - lost
#@end
        grown = lost + 0.5 * beyond * first_s / {{tau_s}}
        share = self._at_s(self._level(grown), wanted, behind) / {{part_s}} if grown >= 0.0 else math.nan
        if not 0.0 < share < 1.0:
            return 0.0, 0.0, power_w_per_m
        left = behind * math.exp(-share * {{part_s}} / {{supply_lag_s}})
        return share, self._part(wanted, behind, share), self._part(wanted, left, 1.0 - share)

#@end
    def _advance(self, power_w_per_m, ambient_degc, part=0, earlier=0.0):
        """Moves the rod on under a constant power: over the whole sample, or over a part of it (`part` 1 before, 2 after
        the change)."""
        balance_degc = ambient_degc + power_w_per_m * {{rise_k_m_per_w}}
        end_degc = balance_degc + (self._rod_degc - balance_degc) * {{retained}}
#@if parts|middle
        share = 1.0 if part == 0 else earlier if part == 1 else 1.0 - earlier
        rate = {{rate}}
#@end
#@if parts
        if part != 0:
            done = _progress(share, rate)
            change_k = end_degc - self._rod_degc
            end_degc = self._rod_degc + change_k * done if part == 1 else end_degc - change_k * (1.0 - done)
#@end
#@if middle
        if part == 0 or (earlier > 0.5) == (part == 1):
            per_share = 1.0 / share if share > 0.0 else 0.0
            middle = 0.5 if part == 0 else _unit((0.5 - (0.0 if part == 1 else earlier)) * per_share)
            change_k = end_degc - self._rod_degc
            passed_degc = self._rod_degc + change_k * _progress(middle, rate * share)
            self._middle_fraction = self._mapped(passed_degc, self._memory.peek(passed_degc))
            self._middle_degc = passed_degc
#@end
        self._fraction = self._mapped(end_degc, self._memory.commit(end_degc))
#@if return_point_memory
        self._other.commit(end_degc)
#@end
#@if r_phase
        self._r_phase_degc = _play(self._r_phase_degc, end_degc, {{r_phase_half_width_k}})
#@end
        self._rod_degc = end_degc

#@if supply_lag|dead_time
    def _lost(self, ambient_degc):
        """Heat that the rod loses, W/m."""
        above_k = self._rod_degc - ambient_degc
        return {{conductance_w_per_m_k}} * (above_k if above_k > 0.0 else 0.0)

    def _hold(self, ambient_degc):
        """Before the first sample the power is what the rod loses at its start, so that it holds: none at rest."""
        if self._has_begun:
            return
        self._has_begun = True
#@if supply_lag
        self._supply_level = self._level(self._lost(ambient_degc))
#@end
#@if dead_time
        self._sent_w_per_m = [self._lost(ambient_degc)] * {{late_capacity}}
#@end

#@end
    def _sub_step(self, power_w_per_m, ambient_degc):
#@if supply_lag|dead_time
        self._hold(ambient_degc)
#@end
#@if supply_limit
#@if squares
        asked = math.sqrt(power_w_per_m)
        beyond = asked - {{supply_limit}}
        cut = {{supply_limit_share}} * (beyond if beyond > 0.0 else 0.0)
        power_w_per_m -= (asked + asked - cut) * cut
#@else
        beyond = power_w_per_m - {{supply_limit}}
        power_w_per_m -= {{supply_limit_share}} * (beyond if beyond > 0.0 else 0.0)
#@end
#@end
        turn = None
#@if supply_lag
        wanted = self._level(power_w_per_m)
        behind = self._supply_level - wanted
        self._supply_started, self._supply_wanted = self._supply_level, wanted
        self._supply_level = wanted + behind * {{supply_retained}}
        power_w_per_m += self._fading(wanted, behind, {{supply_weight}}, {{supply_double_weight}})
#@if dead_time
#@else
        turn = self._turn(power_w_per_m, ambient_degc)
#@end
#@end
#@if dead_time
        power_w_per_m, turn = self._arrives(power_w_per_m)
#@end
        if turn is None:
            self._advance(power_w_per_m, ambient_degc)
        else:
            share, earlier_w_per_m, later_w_per_m = turn
            self._advance(earlier_w_per_m, ambient_degc, 1, share)
            self._show("turn")
            self._advance(later_w_per_m, ambient_degc, 2, share)
#@if middle
        self._show("middle")
#@end
        self.output = self._show("end")
#@if thermocouple_lag
        middle_degc = self._middle_degc - {{thermocouple_low}} * (self._middle_degc - ambient_degc)
        end_degc = self._rod_degc - {{thermocouple_low}} * (self._rod_degc - ambient_degc)
        self._recorded_degc = self._thermocouple.follow(middle_degc, end_degc)
#@end
#@if pid
#@if scheduled


# Factors on kp, ki and kd, from level to level of the output: 1 at the level where the rig is steepest.
_HEATING = (
{{schedule_heating}}
)
_COOLING = (
{{schedule_cooling}}
)
#@end


class Pid:
    """The controller, idle until now: no integral, no error so far. Set point and measurement in {{output_unit}} as the
    sensor reads them."""

    DRIVE_LOWER = {{pid_lower}}
    DRIVE_UPPER = {{pid_upper}}

    def __init__(self, measured):
#@if turned
        measured = -measured
#@end
        self.integral = 0.0
        self.derivative = 0.0
#@if derivative_of_error
        self.watched = 0.0
#@else
        self.watched = -measured
#@end
        self.per_elapsed_s = {{pid_per_dt_s}}
        self.unsaturated = 0.0
        # Samples with an input that was no finite number.
        self.missed = 0
#@if scheduled
        # Middle of the play that tells the branch: as if the output had come from below, since a rod is cold at first.
        self.middle = -math.inf

    @staticmethod
    def _factor(measured, middle):
        branch = (measured - middle) * {{schedule_per_turn}} + 0.5
        branch = branch if branch > 0.0 else 0.0
        branch = branch if branch < 1.0 else 1.0
        place = (measured - {{schedule_first}}) * {{schedule_per_level}}
        place = place if place > 0.0 else 0.0
        place = place if place < {{schedule_last}} else {{schedule_last}}
        below = min(int(place), {{schedule_last}} - 1)
        share = place - below
        on_heating, on_cooling = (
            factors[below] + share * (factors[below + 1] - factors[below]) for factors in (_HEATING, _COOLING)
        )
        return on_cooling + branch * (on_heating - on_cooling)
#@end

    def _saturated(self, drive):
        drive = drive if drive > self.DRIVE_LOWER else self.DRIVE_LOWER
        return drive if drive < self.DRIVE_UPPER else self.DRIVE_UPPER

    def step(self, setpoint, measured, feed_forward=0.0):
        """The drive for one sample, to be called once every {{dt_s}} s, with a drive to be added. A sample with a NaN is
        missed: the last drive is held, and counted."""
#@if turned
        # The output falls as the drive rises.
        setpoint, measured = -setpoint, -measured
#@end
        error = setpoint - measured
#@if derivative_of_error
        watched = error
#@else
        watched = -measured
#@end
#@if scheduled
        rate = (watched - self.watched) * self.per_elapsed_s if math.isfinite(self.watched) else 0.0
        lower, upper = measured - {{schedule_half_turn}}, measured + {{schedule_half_turn}}
        middle = self.middle if self.middle > lower else lower
        middle = middle if middle < upper else upper
        factor = self._factor(measured, middle)
        derivative = {{pid_retained}} * self.derivative + {{pid_kd_new}} * factor * rate
        unsaturated = (
            {{pid_kp}} * ({{pid_setpoint_weight}} * setpoint - measured + (factor - 1.0) * error)
            + self.integral
            + derivative
            + feed_forward
        )
        integral = self.integral + {{pid_ki_dt}} * factor * error
#@else
        derivative = {{pid_retained}} * self.derivative + {{pid_kd_new}} * (
            (watched - self.watched) * self.per_elapsed_s if math.isfinite(self.watched) else 0.0
        )
        unsaturated = (
            {{pid_kp}} * ({{pid_setpoint_weight}} * setpoint - measured) + self.integral + derivative + feed_forward
        )
        integral = self.integral + {{pid_ki_dt}} * error
#@end
#@if clamping
        # No summand that drives a saturated command further out.
        if (unsaturated - self._saturated(unsaturated)) * error > 0.0:
            integral = self.integral
#@end
#@if back_calculation
        # The integral follows the saturated command.
        integral += (self._saturated(unsaturated) - unsaturated) * {{pid_tracking_share}}
#@end
        if math.isfinite(unsaturated) and math.isfinite(integral):
            self.integral, self.derivative, self.watched = integral, derivative, watched
            self.per_elapsed_s = {{pid_per_dt_s}}
            self.unsaturated = unsaturated
#@if scheduled
            self.middle = middle
#@end
        else:
            self.per_elapsed_s = 1.0 / (1.0 / self.per_elapsed_s + DT_S)
            self.missed += 1
        return self._saturated(self.unsaturated)
#@end
