/* {{title}}
 *
 * Model:        {{model_file}}, SHA-256 {{sha256}}
 * Made by:      sma {{version}}: {{command}}
 *
 * Drive:        {{drive_text}}
 * Output:       displacement, {{output_unit}}; temperatures in degrees Celsius
 * Sample time:  {{dt_s}} s, fixed: coefficients of this length are in the constants. Export again for another
 *               (--sample-time-s).
 * Samples:      {{p}}_plant_output reads sample k; {{p}}_plant_step then moves on to sample k + 1 under the drive of
 *               sample k. Inputs must be finite: a NaN spoils the temperature, and with it all later outputs.
 * Start:        {{p}}_plant_rest: cold and still. {{p}}_plant_start: any temperature and any place between the limiting
 *               curves of the loop. {{start_text}}
 * Offset:       {{offset_text}}
 * Memory rule:  {{rule_text}}
 * Effects:      {{effects_text}}
 * Left out:     {{left_out_text}}
//@if pid
 * Controller:   {{pid_text}}
//@else
 * Controller:   none; give --tuned or --gains to the export.
//@end
 *
//@if float
 * Numbers are float. {{tolerance_text}}
//@else
 * Numbers are double. {{tolerance_text}}
//@end
 * C99, no allocation, no global state. Compile with -ffp-contract=off, without -ffast-math and -ffinite-math-only: a fused or
 * reordered sum has other last bits. Link with -lm.
 *
 * Example:
 *
//@if pid
 *   {{p}}_plant plant;
 *   {{p}}_pid pid;
 *   {{p}}_plant_rest(&plant, {{ambient_degc}});
 *   {{p}}_pid_rest(&pid, {{p}}_plant_output(&plant));
 *   for (;;) {
 *       {{p}}_real y = {{p}}_plant_output(&plant);             or what the sensor reads
 *       {{p}}_real u = {{p}}_pid_step(&pid, set_point, y, 0);  once every {{dt_s}} s
 *       {{p}}_plant_step(&plant, u, {{ambient_degc}});                       or set the supply to u
 *   }
//@else
 *   {{p}}_plant plant;
 *   {{p}}_plant_rest(&plant, {{ambient_degc}});
 *   for (k = 0; k < n; ++k) {
 *       y[k] = {{p}}_plant_output(&plant);
 *       {{p}}_plant_step(&plant, drive[k], {{ambient_degc}});
 *   }
//@end
 */
#ifndef {{P}}_SMA_MODEL_H
#define {{P}}_SMA_MODEL_H

#include <math.h>
//@if own_expm1
#include <stdint.h>
#include <string.h>
//@end

#ifdef __FAST_MATH__
#error "compile without -ffast-math"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0
#error "compile without -ffinite-math-only: numbers that are none would no longer be noticed"
#endif

//@if float
typedef float {{p}}_real;
#define {{P}}_R(x) x##f
#define {{P}}_FABS fabsf
#define {{P}}_COPYSIGN copysignf
//@if supply_limit|supply_lag
#define {{P}}_SQRT sqrtf
//@end
//@if supply_lag
#define {{P}}_EXP expf
#define {{P}}_LOG logf
#define {{P}}_EXPM1 expm1f
//@end
//@else
typedef double {{p}}_real;
#define {{P}}_R(x) x
#define {{P}}_FABS fabs
#define {{P}}_COPYSIGN copysign
//@if supply_limit|supply_lag
#define {{P}}_SQRT sqrt
//@end
//@if supply_lag
#define {{P}}_EXP exp
#define {{P}}_LOG log
#define {{P}}_EXPM1 expm1
//@end
//@end

/* Sample time, s. */
#define {{P}}_DT_S {{P}}_R({{dt_s_hex}}) /* {{dt_s_hex_decimal}} s */
/* Where the first training recording starts: temperature above the surroundings, K, and place between the limiting
 * curves, 0 (heating) to 1 (cooling). */
#define {{P}}_START_RISE_K {{P}}_R({{start_rise_k}}) /* {{start_rise_k_decimal}} K */
#define {{P}}_START_SHARE {{P}}_R({{start_share}}) /* {{start_share_decimal}} */

/* Constants of the model. */
//@if is_duty|is_voltage
#define {{P}}_POWER_NUMERATOR {{P}}_R({{power_numerator}}) /* {{power_numerator_decimal}} */
#define {{P}}_POWER_DIVISOR {{P}}_R({{power_divisor}}) /* {{power_divisor_decimal}} */
//@end
//@if is_power
#define {{P}}_LENGTH_M {{P}}_R({{length_m}}) /* {{length_m_decimal}} m */
//@end
//@if is_current
#define {{P}}_RESISTANCE_OHM_PER_M {{P}}_R({{resistance_ohm_per_m}}) /* {{resistance_ohm_per_m_decimal}} Ohm/m */
//@end
//@if drive_limit
#define {{P}}_DRIVE_LIMIT {{P}}_R({{drive_limit}}) /* {{drive_limit_decimal}} in the unit of the drive */
//@end
#define {{P}}_RISE_K_M_PER_W {{P}}_R({{rise_k_m_per_w}}) /* {{rise_k_m_per_w_decimal}} K m/W */
#define {{P}}_RETAINED {{P}}_R({{retained}}) /* {{retained_decimal}} of a difference of temperatures, after a sub-step */
#define {{P}}_CENTER_DEGC {{P}}_R({{loop_center_degc}}) /* {{loop_center_degc_decimal}} deg C */
#define {{P}}_HALF_WIDTH_K {{P}}_R({{loop_half_width_k}}) /* {{loop_half_width_k_decimal}} K */
#define {{P}}_SPREAD_K {{P}}_R({{loop_spread_k}}) /* {{loop_spread_k_decimal}} K */
#define {{P}}_FRACTION_CENTER {{P}}_R({{fraction_center}}) /* {{fraction_center_decimal}} */
#define {{P}}_FRACTION_PER_RADIAN {{P}}_R({{fraction_per_radian}}) /* {{fraction_per_radian_decimal}} */
#define {{P}}_ZETA {{P}}_R({{zeta}}) /* {{zeta_decimal}} */
#define {{P}}_GAIN {{P}}_R({{gain}}) /* {{gain_decimal}} {{output_unit}} */
#define {{P}}_OFFSET {{P}}_R({{offset}}) /* {{offset_decimal}} {{output_unit}} */
//@if loop_asymmetry
#define {{P}}_WIDENING_HEATING {{P}}_R({{widening_heating}}) /* {{widening_heating_decimal}} */
#define {{P}}_WIDENING_COOLING {{P}}_R({{widening_cooling}}) /* {{widening_cooling_decimal}} */
//@end

/* ---- elementary functions, as polynomials ---- */

/* Even and odd powers by Horner's rule apart. */
static inline {{p}}_real {{p}}_polynomial(const {{p}}_real *coefficients, int count, {{p}}_real x) {
    const {{p}}_real square = x * x;
    {{p}}_real sums[2] = {0, 0};
    int k;
    for (k = count - 1; k >= 0; --k) {
        sums[k % 2] = k + 2 < count ? sums[k % 2] * square + coefficients[k] : coefficients[k];
    }
    return sums[0] + x * sums[1];
}

/* sin x for x from 0 to pi/2. */
static inline {{p}}_real {{p}}_sin_quarter({{p}}_real x) {
    static const {{p}}_real coefficients[{{n_sin}}] = {
{{sin_coefficients}}
    };
    const {{p}}_real square = x * x;
    return x + x * square * {{p}}_polynomial(coefficients, {{n_sin}}, square);
}

/* atan(a/b) for b > 0. */
static inline {{p}}_real {{p}}_atan_quotient({{p}}_real a, {{p}}_real b) {
    static const {{p}}_real coefficients[{{n_atan}}] = {
{{atan_coefficients}}
    };
    const {{p}}_real flat = {{P}}_R({{flat}});
    const {{p}}_real magnitude = {{P}}_FABS(a);
    const {{p}}_real size = magnitude > flat ? flat : magnitude;
    const {{p}}_real p = size < b ? size : b;
    const {{p}}_real q = size < b ? b : size;
    const {{p}}_real z = (p - {{P}}_R({{tan_pi_8}}) * q) / (q + {{P}}_R({{tan_pi_8}}) * p);
    const {{p}}_real square = z * z;
    const {{p}}_real octant =
        {{P}}_R({{pi_8}}) + (z + z * square * {{p}}_polynomial(coefficients, {{n_atan}}, square));
    return {{P}}_COPYSIGN(size > b ? {{P}}_R({{pi_2}}) - octant : octant, a);
}

//@if own_expm1
/* e^y - 1 for |y| <= 700. */
static inline {{p}}_real {{p}}_own_expm1({{p}}_real y) {
    static const {{p}}_real coefficients[{{n_exp}}] = {
{{exp_coefficients}}
    };
    const {{p}}_real rounding = {{P}}_R(6755399441055744.0);
    const {{p}}_real rounded = y * {{P}}_R({{log2_e}}) + rounding;
    const {{p}}_real k = rounded - rounding;
    const {{p}}_real r = (y - k * {{P}}_R({{ln_2_high}})) - k * {{P}}_R({{ln_2_low}});
    const {{p}}_real sum = {{p}}_polynomial(coefficients, {{n_exp}}, r);
    {{p}}_real power;
    uint64_t bits;
    memcpy(&bits, &rounded, sizeof bits);
    bits = (bits << 52) + (UINT64_C(1023) << 52);
    memcpy(&power, &bits, sizeof power);
    return power * (r * sum) + (power - {{P}}_R(1.0));
}

//@end
//@if supply_lag
/* (e^x - 1)/x. */
static inline {{p}}_real {{p}}_mean_exponential({{p}}_real x) {
    return {{P}}_FABS(x) < {{P}}_R(1e-9) ? {{P}}_R(1.0) + {{P}}_R(0.5) * x : {{P}}_EXPM1(x) / x;
}

//@end
//@if parts|middle
/* x within 0 and 1. */
static inline {{p}}_real {{p}}_unit({{p}}_real x) {
    x = x > 0 ? x : 0;
    return x < 1 ? x : 1;
}

/* Share of what a whole sample would do that is done after a share s of it, for a = dt/tau. */
static inline {{p}}_real {{p}}_progress({{p}}_real s, {{p}}_real a) {
    const {{p}}_real product = s * ({{P}}_R(1.0) - s);
    return s + product * a * ({{P}}_R(0.5) + a * (({{P}}_R(1.0) - {{P}}_R(2.0) * s) / {{P}}_R(12.0)
        - product * a / {{P}}_R(24.0)));
}

//@end
//@if r_phase|backlash
/* Where the driven side of a play stands: share 0 as after rising for long, 1 as after falling. */
static inline {{p}}_real {{p}}_play_at({{p}}_real driver, {{p}}_real half_width, {{p}}_real share) {
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    return driver + half_width * ({{P}}_R(2.0) * share - {{P}}_R(1.0));
}

//@end
//@if r_phase
/* A play of a half width: where its driven side stands once the driving side is at `driver`. */
static inline {{p}}_real {{p}}_play({{p}}_real before, {{p}}_real driver, {{p}}_real half_width) {
    const {{p}}_real upper = driver + half_width;
    const {{p}}_real lower = driver - half_width;
    const {{p}}_real below = before < upper ? before : upper;
    return below > lower ? below : lower;
}

//@end
/* ---- hysteresis: limiting-loop proximity ---- */

/* Reversals that are held. */
#define {{P}}_NESTING {{nesting}}
/* Smallest movement against the direction that is a reversal, K. */
#define {{P}}_DEAD_BAND_K {{P}}_R({{dead_band_k}})
/* Proximity below which a point lies on the limiting curve, K. */
#define {{P}}_SMALLEST_PROXIMITY_K {{P}}_R(1e-9)
/* Where what is remembered ends, K from the middle of the loop. */
#define {{P}}_FARTHEST_K {{P}}_R(1e6)
/* No return point. */
#define {{P}}_NOWHERE_K {{P}}_R(1e30)

/* A point of the loop: temperature above its middle, K, and anhysteretic temperature, K. */
typedef struct {
    {{p}}_real temperature_k;
    {{p}}_real level_k;
} {{p}}_turn;

/* A branch. */
typedef struct {
    {{p}}_turn start;
    {{p}}_real rise;
    {{p}}_real proximity_k;
    {{p}}_real inverse_proximity_per_k;
} {{p}}_path;

/* All that the hysteresis remembers. */
typedef struct {
    {{p}}_real sign;       /* of the branch: 1 heating, -1 cooling */
    {{p}}_path path;
    {{p}}_real return_k;   /* sign times the temperature of the point returned to */
    {{p}}_real furthest_k; /* sign times the furthest temperature */
    {{p}}_turn base;
    {{p}}_turn turns[{{P}}_NESTING];
    int depth;
    unsigned long forgotten; /* pairs of reversals that found no room */
} {{p}}_memory;

static inline {{p}}_real {{p}}_widening({{p}}_real sign) {
//@if loop_asymmetry
    return sign > 0 ? {{P}}_WIDENING_HEATING : {{P}}_WIDENING_COOLING;
//@else
    (void)sign;
    return {{P}}_R(1.0);
//@end
}

/* Anhysteretic temperature on a branch, K. */
static inline {{p}}_real {{p}}_level_k(const {{p}}_path *path, {{p}}_real temperature_k) {
    const {{p}}_real travel_k = temperature_k - path->start.temperature_k;
    const {{p}}_real x = travel_k * path->inverse_proximity_per_k;
    {{p}}_real angle = {{P}}_ZETA * x;
    angle = angle < 0 ? 0 : angle;
    angle = angle > {{P}}_R({{pi_2}}) ? {{P}}_R({{pi_2}}) : angle;
    return path->start.level_k + path->rise * travel_k - path->proximity_k * {{p}}_sin_quarter(angle);
}

/* Fraction at an anhysteretic temperature. */
static inline {{p}}_real {{p}}_fraction_at({{p}}_real level_k) {
    return {{P}}_FRACTION_PER_RADIAN * {{p}}_atan_quotient(level_k, {{P}}_SPREAD_K) + {{P}}_FRACTION_CENTER;
}

/* A factor of rescaling, within 0 and 1. */
static inline {{p}}_real {{p}}_factor({{p}}_real quotient) {
    const {{p}}_real nearest = quotient < 0 ? 0 : 1;
    return quotient >= 0 && quotient <= 1 ? quotient : nearest;
}

/* The branch of a direction from a point, through another if there is one to return to. */
static inline {{p}}_path {{p}}_path_of({{p}}_real sign, {{p}}_turn start, const {{p}}_turn *end) {
    const {{p}}_real shift_k = sign * {{P}}_HALF_WIDTH_K;
    const {{p}}_real widening = {{p}}_widening(sign);
    const {{p}}_real distance_k = start.level_k * widening + shift_k - start.temperature_k;
    const {{p}}_real within_k = sign * distance_k;
    const int is_beyond = (widening < 1 || widening > 1) && within_k < -{{P}}_SMALLEST_PROXIMITY_K;
    const int is_limiting = within_k <= {{P}}_SMALLEST_PROXIMITY_K && !is_beyond;
    {{p}}_path path;
    path.start = start;
    path.rise = {{P}}_R(1.0) / widening;
    if (is_limiting) {
        path.proximity_k = 0;
        path.inverse_proximity_per_k = sign;
        return path;
    }
    path.proximity_k = distance_k / widening;
    path.inverse_proximity_per_k = sign / {{P}}_FABS(distance_k);
    if (end) {
        const {{p}}_real reached_k = {{p}}_level_k(&path, end->temperature_k);
        const {{p}}_real excess_k = sign * (reached_k - end->level_k);
        if (excess_k > 0) {
            const {{p}}_real shrunk =
                {{p}}_factor((end->level_k - start.level_k) / (reached_k - start.level_k));
            path.rise = shrunk * path.rise;
            path.proximity_k = shrunk * path.proximity_k;
        } else if (excess_k < 0) {
            const {{p}}_real limit_k = end->temperature_k - shift_k;
            const {{p}}_real left_k = end->level_k * widening - limit_k - distance_k;
            const {{p}}_real natural_k = reached_k * widening - limit_k - distance_k;
            path.proximity_k = {{p}}_factor(left_k / natural_k) * path.proximity_k;
        }
    }
    return path;
}

static inline {{p}}_real {{p}}_within_reach({{p}}_real temperature_k) {
    return temperature_k < -{{P}}_FARTHEST_K ? -{{P}}_FARTHEST_K
        : temperature_k > {{P}}_FARTHEST_K ? {{P}}_FARTHEST_K : temperature_k;
}

/* What asymmetry adds to a limiting curve, K; 0 without one. */
static inline {{p}}_real {{p}}_added_k({{p}}_real sign, {{p}}_real temperature_k) {
    const {{p}}_real plain_k = temperature_k - sign * {{P}}_HALF_WIDTH_K;
    return plain_k / {{p}}_widening(sign) - plain_k;
}

/* A memory that begins at a share of the way from the heating (0) to the cooling curve (1). */
static inline void {{p}}_memory_start({{p}}_memory *memory, {{p}}_real temperature_degc, {{p}}_real share) {
    const {{p}}_real temperature_k = {{p}}_within_reach(temperature_degc - {{P}}_CENTER_DEGC);
    int k;
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    memory->sign = share <= 0 ? 1 : -1;
    memory->base.temperature_k = temperature_k;
    memory->base.level_k = temperature_k + ({{P}}_R(2.0) * share - {{P}}_R(1.0)) * {{P}}_HALF_WIDTH_K
        + (({{P}}_R(1.0) - share) * {{p}}_added_k(1, temperature_k) + share * {{p}}_added_k(-1, temperature_k));
    memory->path = {{p}}_path_of(memory->sign, memory->base, 0);
    memory->return_k = {{P}}_NOWHERE_K;
    memory->furthest_k = memory->sign * temperature_k;
    for (k = 0; k < {{P}}_NESTING; ++k) {
        memory->turns[k].temperature_k = 0;
        memory->turns[k].level_k = 0;
    }
    memory->depth = 0;
    memory->forgotten = 0;
}

static inline int {{p}}_turns_back(const {{p}}_memory *memory, {{p}}_real temperature_k) {
    return memory->sign * temperature_k - memory->furthest_k < -{{P}}_DEAD_BAND_K;
}

static inline int {{p}}_leaves(const {{p}}_memory *memory, {{p}}_real temperature_k) {
    return {{p}}_turns_back(memory, temperature_k) || memory->sign * temperature_k > memory->return_k;
}

/* The reversal that a branch from the last one returns to; null if there is none. */
static inline const {{p}}_turn *{{p}}_return_point(const {{p}}_memory *memory, int kept, int is_added) {
    const int before = is_added ? kept : (kept > 1 ? kept : 1) - 1;
    return before > 0 ? &memory->turns[before - 1] : 0;
}

/* Takes a memory that leaves its branch to the one on which it comes to a temperature. `is_nested`: all reversals that
 * enclose the branch are remembered; else the last one. */
static inline void {{p}}_change_branch({{p}}_memory *memory, {{p}}_real temperature_k, int is_nested) {
    {{p}}_turn added = {0, 0};
    {{p}}_turn start;
    {{p}}_real sign = memory->sign;
    int kept = memory->depth;
    int is_added = 0;
    const {{p}}_turn *end;
    if ({{p}}_turns_back(memory, temperature_k)) {
        added.temperature_k = {{p}}_within_reach(memory->sign * memory->furthest_k);
        added.level_k = {{p}}_level_k(&memory->path, added.temperature_k);
        is_added = 1;
        sign = -sign;
        if (!is_nested) {
            kept = 0;
        } else if (kept == {{P}}_NESTING) {
            kept -= 2;
            ++memory->forgotten;
        }
    }
    while ((end = {{p}}_return_point(memory, kept, is_added)) != 0) {
        if (sign * (temperature_k - end->temperature_k) <= 0) {
            break;
        }
        kept -= is_added ? 1 : 2;
        is_added = 0;
    }
    start = is_added ? added : kept > 0 ? memory->turns[kept - 1] : memory->base;
    memory->path = {{p}}_path_of(sign, start, end);
    memory->return_k = end ? sign * end->temperature_k : {{P}}_NOWHERE_K;
    memory->depth = kept;
    if (is_added) {
        memory->turns[kept] = added;
        memory->depth = kept + 1;
    }
    memory->sign = sign;
    memory->furthest_k = sign * temperature_k;
}

/* Goes to a temperature; returns the fraction there. */
static inline {{p}}_real {{p}}_commit({{p}}_memory *memory, {{p}}_real temperature_degc, int is_nested) {
    const {{p}}_real temperature_k = temperature_degc - {{P}}_CENTER_DEGC;
    {{p}}_real level_k;
    if ({{p}}_leaves(memory, temperature_k)) {
        {{p}}_change_branch(memory, temperature_k, is_nested);
    }
    level_k = {{p}}_level_k(&memory->path, temperature_k);
    if (memory->sign * temperature_k > memory->furthest_k) {
        memory->furthest_k = memory->sign * temperature_k;
    }
    return {{p}}_fraction_at(level_k);
}

/* Fraction at a temperature, without going there. */
static inline {{p}}_real {{p}}_peek(const {{p}}_memory *memory, {{p}}_real temperature_degc, int is_nested) {
    const {{p}}_real temperature_k = temperature_degc - {{P}}_CENTER_DEGC;
    if ({{p}}_leaves(memory, temperature_k)) {
        {{p}}_memory towards = *memory;
        return {{p}}_commit(&towards, temperature_degc, is_nested);
    }
    return {{p}}_fraction_at({{p}}_level_k(&memory->path, temperature_k));
}

/* ---- the plant ---- */

//@if output_lag|thermocouple_lag
/* A first-order lag: what it follows, and where it is. */
typedef struct {
    {{p}}_real followed;
    {{p}}_real value;
} {{p}}_lag;

/* Follows a signal that has passed `middle` in the middle of the sample. */
static inline {{p}}_real {{p}}_follow({{p}}_lag *lag, {{p}}_real middle, {{p}}_real signal, {{p}}_real retained,
    {{p}}_real trailing, {{p}}_real bent) {
    const {{p}}_real behind = lag->value - lag->followed;
    const {{p}}_real change = signal - lag->followed;
    const {{p}}_real bend = middle - (lag->followed + {{P}}_R(0.5) * change);
    lag->followed = signal;
    lag->value = signal + (behind * retained - change * trailing + bend * bent);
    return lag->value;
}

//@end
//@if dead_time
/* What a pure delay lets through: the sample that many before the newest, and the age of its end, s. */
typedef struct {
    int behind;
    {{p}}_real age_s;
} {{p}}_late;

/* Goes on to the sample that began more than `age_s` before the end of the newest, and ended no later; returns its place. */
static inline int {{p}}_go_on({{p}}_late *late, {{p}}_real age_s, int newest) {
    const {{p}}_real part_s = {{P}}_R({{part_s}});
    while (late->behind > 0 && late->age_s - age_s > {{P}}_R(1e-9) * part_s) {
        late->behind -= 1;
        late->age_s -= part_s;
    }
    if (late->behind == 0) {
        late->age_s = 0;
    }
    return (newest + {{late_capacity}} - late->behind) % {{late_capacity}};
}

//@end
/* State of the plant between samples. */
typedef struct {
    {{p}}_real temperature_degc;
    {{p}}_real fraction;
    {{p}}_memory memory;
//@if return_point_memory
    {{p}}_memory other; /* by the other rule of memory */
//@end
//@if r_phase
    {{p}}_real r_phase_degc;
//@end
//@if supply_lag|dead_time
    int has_begun;
//@end
//@if supply_lag
    {{p}}_real supply_level;
    {{p}}_real supply_started;
    {{p}}_real supply_wanted;
//@end
//@if dead_time
    {{p}}_real sent_w_per_m[{{late_capacity}}];
    {{p}}_late arriving;
    int newest;
//@end
//@if delays_output
    {{p}}_real shown_middle[{{late_capacity}}];
    {{p}}_real shown_end[{{late_capacity}}];
    {{p}}_late showing;
    {{p}}_real shown;
//@end
//@if middle
    {{p}}_real middle_fraction;
    {{p}}_real middle_degc;
//@end
//@if backlash
    {{p}}_real driver;
    {{p}}_real driven;
//@end
//@if output_lag
    {{p}}_real middle_output;
    {{p}}_lag output_lag;
//@end
//@if thermocouple_lag
    {{p}}_lag thermocouple;
    {{p}}_real recorded_degc;
//@end
    {{p}}_real output;
} {{p}}_plant;

//@if scale
/* Transformed share: the fraction, 0 cold to 1 hot, whatever its own scale. */
static inline {{p}}_real {{p}}_transformed({{p}}_real fraction) {
    return (fraction - {{P}}_R({{fraction_cold}})) * {{P}}_R({{per_fraction_span}});
}

//@end
/* What effects make of a fraction. */
static inline {{p}}_real {{p}}_mapped(const {{p}}_plant *plant, {{p}}_real driving_degc, {{p}}_real fraction) {
//@if return_point_memory
    fraction += {{P}}_R({{return_point_share}})
        * ({{p}}_peek(&plant->other, driving_degc, {{other_is_nested}}) - fraction);
//@else
    (void)plant;
    (void)driving_degc;
//@end
//@if loop_shape
    {
        const {{p}}_real p = {{p}}_transformed(fraction);
        const {{p}}_real x = {{P}}_R(1.0) - {{P}}_R(2.0) * p;
        const {{p}}_real square = x * x;
        const {{p}}_real bulge = p * ({{P}}_R(1.0) - p);
        const {{p}}_real added = bulge * ({{P}}_R({{loop_shape_1}}) + {{P}}_R({{loop_shape_2}}) * x
            + {{P}}_R({{loop_shape_3}}) * ({{P}}_R(1.25) * square - {{P}}_R(0.25)));
        fraction += {{P}}_R({{fraction_span}}) * added;
    }
//@end
    return fraction;
}

//@if delays_output
/* What the displacement was some time before the end of the newest sample. */
static inline {{p}}_real {{p}}_moved_at({{p}}_plant *plant, {{p}}_real age_s) {
    const int here = {{p}}_go_on(&plant->showing, age_s, plant->newest);
    const int older = (here + {{late_capacity}} - 1) % {{late_capacity}};
    const {{p}}_real end = plant->shown_end[here];
    const {{p}}_real start = plant->shown_end[older];
    const {{p}}_real bend = plant->shown_middle[here] - {{P}}_R(0.5) * (start + end);
    const {{p}}_real share = (age_s - plant->showing.age_s) / {{P}}_R({{part_s}});
    return end + share * (start - end) + {{P}}_R(4.0) * bend * share * ({{P}}_R(1.0) - share);
}

//@end
/* Instants of a sample at which the displacement is computed. */
enum { {{P}}_AT_TURN, {{P}}_AT_MIDDLE, {{P}}_AT_END, {{P}}_AT_START };

/* Displacement at an instant; remembers what effects have to. `share` counts at the start alone. */
static inline {{p}}_real {{p}}_show({{p}}_plant *plant, int instant, {{p}}_real share) {
//@if middle
    const {{p}}_real mapped = instant == {{P}}_AT_MIDDLE ? plant->middle_fraction : plant->fraction;
//@else
    const {{p}}_real mapped = plant->fraction;
//@end
//@if r_phase|thermal_expansion
//@if middle
    const {{p}}_real temperature_degc =
        instant == {{P}}_AT_MIDDLE ? plant->middle_degc : plant->temperature_degc;
//@else
    const {{p}}_real temperature_degc = plant->temperature_degc;
//@end
    const {{p}}_real transformed = {{p}}_transformed(mapped);
//@end
    {{p}}_real fraction = mapped;
    {{p}}_real y;
    (void)instant;
    (void)share;
//@if r_phase
    {
        const {{p}}_real driven_degc = {{p}}_play(plant->r_phase_degc, temperature_degc, {{P}}_R({{r_phase_half_width_k}}));
        const {{p}}_real above = (driven_degc - {{P}}_R({{r_phase_middle_degc}})) / {{P}}_R({{r_phase_spread_k}});
        const {{p}}_real given_back = {{P}}_R(0.5) - {{p}}_atan_quotient(above, 1) * {{P}}_R({{per_pi}});
        fraction -= {{P}}_R({{r_phase_share}}) * ({{P}}_R({{fraction_span}}) * transformed * given_back);
    }
//@end
    y = {{P}}_GAIN * fraction + {{P}}_OFFSET;
//@if delays_output
    if (instant == {{P}}_AT_START) {
        int k;
        for (k = 0; k < {{late_capacity}}; ++k) {
            plant->shown_middle[k] = y;
            plant->shown_end[k] = y;
        }
        plant->showing.behind = 0;
        plant->showing.age_s = 0;
        plant->shown = y;
    } else if (instant == {{P}}_AT_TURN) {
        y = plant->shown;
    } else if (instant == {{P}}_AT_MIDDLE) {
        const {{p}}_real middle_s = {{P}}_R(0.5) * {{P}}_R({{part_s}});
        plant->shown_middle[plant->newest] = y;
        plant->shown_end[plant->newest] = y;
        plant->showing.behind += 1;
        plant->showing.age_s += {{P}}_R({{part_s}});
        if ({{P}}_R({{output_delay_s}}) < middle_s) {
            const int last = (plant->newest + {{late_capacity}} - 1) % {{late_capacity}};
            const {{p}}_real before = plant->shown_end[last];
            y = y + ({{P}}_R({{output_delay_s}}) / middle_s) * (before - y);
        } else {
            y = {{p}}_moved_at(plant, {{P}}_R({{output_delay_s}}) + middle_s);
        }
    } else {
        plant->shown_end[plant->newest] = y;
        y = {{p}}_moved_at(plant, {{P}}_R({{output_delay_s}}));
        plant->shown = y;
    }
//@end
//@if thermal_expansion
    {
        const {{p}}_real warmed_k = temperature_degc - {{P}}_R({{reference_degc}});
        y -= {{P}}_R({{expansion_per_k}})
            * (({{P}}_R({{of_martensite}}) + {{P}}_R({{of_austenite}}) * transformed) * warmed_k);
    }
//@end
//@if end_stop
    {
        {{p}}_real beyond = {{P}}_R({{end_stop_sign}}) * (y - {{P}}_OFFSET) - {{P}}_R({{end_stop}});
        beyond = beyond > 0 ? beyond : 0;
        y -= {{P}}_R({{end_stop_share}}) * ({{P}}_R({{end_stop_sign}}) * beyond);
    }
//@end
//@if backlash
    if (instant == {{P}}_AT_START) {
        const {{p}}_real fallen = {{fallen}};
        const {{p}}_real relaxed = fallen + {{P}}_R({{backlash_relaxed}}) * ({{P}}_R(0.5) - fallen);
        plant->driver = y;
        plant->driven = {{p}}_play_at(y, {{P}}_R({{backlash_half_width}}), relaxed);
    } else {
        {{p}}_real way = y - plant->driver;
        const {{p}}_real sign = way < 0 ? -1 : 1;
        {{p}}_real lag = sign * (plant->driver - plant->driven) * {{P}}_R({{per_backlash_half_width}});
        {{p}}_real waits = {{P}}_R(1.0) - {{P}}_R({{backlash_softness}}) - lag;
        {{p}}_real waited;
        {{p}}_real rest;
        way = {{P}}_FABS(way) * {{P}}_R({{per_backlash_half_width}});
        waits = waits > 0 ? waits : 0;
        waited = way < waits ? way : waits;
        rest = (way - waited) / {{P}}_R({{backlash_least_softness}});
        rest = rest < {{P}}_R(700.0) ? rest : {{P}}_R(700.0);
        lag = lag + waited;
//@if float
        lag = lag - ({{P}}_R(1.0) - lag) * expm1f(-rest);
//@else
        lag = lag - ({{P}}_R(1.0) - lag) * {{p}}_own_expm1(-rest);
//@end
        if (!({{P}}_R({{backlash_half_width}}) > 0 && way < waits)) {
            plant->driven = y - {{P}}_R({{backlash_half_width}}) * (sign * lag);
        }
        plant->driver = y;
    }
    y = plant->driven;
//@end
//@if output_lag
    if (instant == {{P}}_AT_START) {
        plant->output_lag.followed = y;
        plant->output_lag.value = y;
    } else if (instant == {{P}}_AT_MIDDLE) {
        plant->middle_output = y;
    } else if (instant == {{P}}_AT_END) {
        y = {{p}}_follow(&plant->output_lag, plant->middle_output, y, {{P}}_R({{output_retained}}),
            {{P}}_R({{output_trailing}}), {{P}}_R({{output_bent}}));
    }
//@end
//@if sensor_nonlinearity
    {
        const {{p}}_real u = (y - {{P}}_OFFSET) * {{P}}_R({{per_stroke}});
        y += u * ({{P}}_R(1.0) - u)
            * ({{P}}_R({{nonlinearity_quadratic}}) + {{P}}_R({{nonlinearity_cubic}}) * ({{P}}_R(1.0) - {{P}}_R(2.0) * u));
    }
//@end
    return y;
}

/* A rod of a temperature, deg C, at a share of the way from the heating (0) to the cooling curve (1); the drive was off
 * before, and all lags have settled. */
static inline void {{p}}_plant_start({{p}}_plant *plant, {{p}}_real temperature_degc, {{p}}_real share) {
    plant->temperature_degc = temperature_degc;
    {{p}}_memory_start(&plant->memory, temperature_degc, share);
//@if return_point_memory
    {{p}}_memory_start(&plant->other, temperature_degc, share);
//@end
    plant->fraction =
        {{p}}_mapped(plant, temperature_degc, {{p}}_peek(&plant->memory, temperature_degc, {{is_nested}}));
//@if r_phase
    plant->r_phase_degc = {{p}}_play_at(temperature_degc, {{P}}_R({{r_phase_half_width_k}}), share);
//@end
//@if supply_lag|dead_time
    plant->has_begun = 0;
//@end
//@if supply_lag
    plant->supply_level = 0;
    plant->supply_started = 0;
    plant->supply_wanted = 0;
//@end
//@if dead_time
    {
        int k;
        for (k = 0; k < {{late_capacity}}; ++k) {
            plant->sent_w_per_m[k] = 0;
        }
        plant->newest = 0;
        plant->arriving.behind = 0;
        plant->arriving.age_s = 0;
    }
//@end
//@if middle
    plant->middle_fraction = plant->fraction;
    plant->middle_degc = temperature_degc;
//@end
//@if output_lag
    plant->middle_output = 0;
//@end
//@if thermocouple_lag
    plant->thermocouple.followed = temperature_degc;
    plant->thermocouple.value = temperature_degc;
    plant->recorded_degc = temperature_degc;
//@end
    plant->output = {{p}}_show(plant, {{P}}_AT_START, share);
}

/* A rod that is cold and still: cooled to the temperature of the surroundings, deg C. */
static inline void {{p}}_plant_rest({{p}}_plant *plant, {{p}}_real ambient_degc) {
    {{p}}_plant_start(plant, ambient_degc, 1);
}

/* Displacement, {{output_unit}}, as the sensor reads it. */
static inline {{p}}_real {{p}}_plant_output(const {{p}}_plant *plant) {
    return plant->output;
}

/* Temperature of the rod, deg C, as a thermocouple on it would record it. */
static inline {{p}}_real {{p}}_plant_temperature_degc(const {{p}}_plant *plant) {
//@if thermocouple_lag
    return plant->recorded_degc;
//@else
    return plant->temperature_degc;
//@end
}

//@if supply_lag
/* Amplitude of a power, or the power itself, whichever lags. */
static inline {{p}}_real {{p}}_supply_level({{p}}_real power_w_per_m) {
//@if squares
    return {{P}}_SQRT(power_w_per_m);
//@else
    return power_w_per_m;
//@end
}

/* Power of a supply that is at a level, and behind it by so much, as it fades: by its weights over a part. */
static inline {{p}}_real {{p}}_fading({{p}}_real wanted, {{p}}_real behind, {{p}}_real weight, {{p}}_real double_weight) {
//@if squares
    return {{P}}_R(2.0) * wanted * behind * weight + behind * behind * double_weight;
//@else
    (void)wanted;
    (void)double_weight;
    return behind * weight;
//@end
}

/* Time at which the supply is at a level, s after the start of the sample. */
static inline {{p}}_real {{p}}_supply_at_s({{p}}_real level, {{p}}_real wanted, {{p}}_real behind) {
    return -{{P}}_R({{supply_lag_s}}) * {{P}}_LOG((level - wanted) / behind);
}

/* Mean power over a part of a sample, W/m. */
static inline {{p}}_real {{p}}_supply_part({{p}}_real wanted, {{p}}_real behind, {{p}}_real share) {
    const {{p}}_real faded = share * {{P}}_R({{part_s}}) / {{P}}_R({{supply_lag_s}});
    const {{p}}_real a = share * {{P}}_R({{part_s}}) / {{P}}_R({{tau_s}});
    const {{p}}_real once = {{p}}_mean_exponential(a - faded) / {{p}}_mean_exponential(a);
    const {{p}}_real twice = {{p}}_mean_exponential(a - {{P}}_R(2.0) * faded) / {{p}}_mean_exponential(a);
//@if squares
    return wanted * wanted + {{p}}_fading(wanted, behind, once, twice);
//@else
    return wanted + {{p}}_fading(wanted, behind, once, twice);
//@end
}

//@end
//@if supply_lag|dead_time
/* Heat that the rod loses, W/m. */
static inline {{p}}_real {{p}}_lost(const {{p}}_plant *plant, {{p}}_real ambient_degc) {
    const {{p}}_real above_k = plant->temperature_degc - ambient_degc;
    return {{P}}_R({{conductance_w_per_m_k}}) * (above_k > 0 ? above_k : 0);
}

/* Before the first sample the power is what the rod loses at its start, so that it holds: none at rest. */
static inline void {{p}}_hold({{p}}_plant *plant, {{p}}_real ambient_degc) {
    const {{p}}_real held = {{p}}_lost(plant, ambient_degc);
    if (plant->has_begun) {
        return;
    }
    plant->has_begun = 1;
//@if supply_lag
    plant->supply_level = {{p}}_supply_level(held);
//@end
//@if dead_time
    {
        int k;
        for (k = 0; k < {{late_capacity}}; ++k) {
            plant->sent_w_per_m[k] = held;
        }
    }
//@end
}

//@end
//@if parts
/* A sample in two parts of constant power. */
typedef struct {
    {{p}}_real share;          /* of the sample before the change */
    {{p}}_real earlier_w_per_m;
    {{p}}_real later_w_per_m;
} {{p}}_parted;

//@end
//@if dead_time
/* Power that arrives late. */
static inline {{p}}_parted {{p}}_arriving({{p}}_plant *plant, {{p}}_real power_w_per_m) {
    const int count = {{late_capacity}};
    const {{p}}_real part_s = {{P}}_R({{part_s}});
    {{p}}_parted parted = {0, 0, 0};
    {{p}}_real earlier_w_per_m;
    int first;
    int last;
    plant->newest = (plant->newest + 1) % count;
    plant->sent_w_per_m[plant->newest] = power_w_per_m;
    plant->arriving.behind += 1;
    plant->arriving.age_s += part_s;
    first = plant->arriving.behind;
    last = {{p}}_go_on(&plant->arriving, {{P}}_R({{drive_delay_s}}), plant->newest);
    parted.later_w_per_m = plant->sent_w_per_m[last];
    earlier_w_per_m = plant->sent_w_per_m[(last + count - 1) % count];
    if (plant->arriving.behind < first
        && (earlier_w_per_m < parted.later_w_per_m || earlier_w_per_m > parted.later_w_per_m)) {
        const {{p}}_real start_s = part_s + plant->arriving.age_s;
        parted.share = {{P}}_R(1.0) - {{p}}_unit((start_s - {{P}}_R({{drive_delay_s}})) / part_s);
        parted.earlier_w_per_m = earlier_w_per_m;
    }
    return parted;
}

//@end
/* Moves the rod on under a constant power: over the whole sample, or over a part of it (`part` 1 before, 2 after the
 * change). */
static inline void {{p}}_advance({{p}}_plant *plant, {{p}}_real power_w_per_m, {{p}}_real ambient_degc, int part,
    {{p}}_real earlier) {
    const {{p}}_real steady_rise_k = power_w_per_m * {{P}}_RISE_K_M_PER_W;
    const {{p}}_real balance_degc = ambient_degc + steady_rise_k;
    {{p}}_real end_degc = balance_degc + (plant->temperature_degc - balance_degc) * {{P}}_RETAINED;
//@if parts|middle
    const {{p}}_real share = part == 0 ? 1 : part == 1 ? earlier : {{P}}_R(1.0) - earlier;
    const {{p}}_real rate = {{P}}_R({{rate}});
//@end
//@if middle
    const {{p}}_real per_share = share > 0 ? {{P}}_R(1.0) / share : 0;
    const {{p}}_real middle =
        part == 0 ? {{P}}_R(0.5) : {{p}}_unit(({{P}}_R(0.5) - (part == 1 ? 0 : earlier)) * per_share);
    const int has_middle = part == 0 || (earlier > {{P}}_R(0.5)) == (part == 1);
    const {{p}}_real done_by_middle = {{p}}_progress(middle, rate * share);
//@end
//@if parts
    if (part != 0) {
        const {{p}}_real done = {{p}}_progress(share, rate);
        const {{p}}_real change_k = end_degc - plant->temperature_degc;
        end_degc = part == 1 ? plant->temperature_degc + change_k * done : end_degc - change_k * ({{P}}_R(1.0) - done);
    }
//@else
    (void)part;
    (void)earlier;
//@end
//@if middle
    if (has_middle) {
        const {{p}}_real change_k = end_degc - plant->temperature_degc;
        const {{p}}_real passed_degc = plant->temperature_degc + change_k * done_by_middle;
        plant->middle_fraction =
            {{p}}_mapped(plant, passed_degc, {{p}}_peek(&plant->memory, passed_degc, {{is_nested}}));
        plant->middle_degc = passed_degc;
    }
//@end
    plant->fraction = {{p}}_mapped(plant, end_degc, {{p}}_commit(&plant->memory, end_degc, {{is_nested}}));
//@if return_point_memory
    {{p}}_commit(&plant->other, end_degc, {{other_is_nested}});
//@end
//@if r_phase
    plant->r_phase_degc = {{p}}_play(plant->r_phase_degc, end_degc, {{P}}_R({{r_phase_half_width_k}}));
//@end
    plant->temperature_degc = end_degc;
}

/* One sub-step of a sample. */
static inline void {{p}}_sub_step({{p}}_plant *plant, {{p}}_real power_w_per_m, {{p}}_real ambient_degc) {
//@if supply_lag|dead_time
    {{p}}_hold(plant, ambient_degc);
//@end
//@if supply_limit
    {
//@if squares
        const {{p}}_real beyond = {{P}}_SQRT(power_w_per_m) - {{P}}_R({{supply_limit}});
        const {{p}}_real cut = {{P}}_R({{supply_limit_share}}) * (beyond > 0 ? beyond : 0);
        const {{p}}_real asked = {{P}}_SQRT(power_w_per_m);
        power_w_per_m -= (asked + asked - cut) * cut;
//@else
        const {{p}}_real beyond = power_w_per_m - {{P}}_R({{supply_limit}});
        power_w_per_m -= {{P}}_R({{supply_limit_share}}) * (beyond > 0 ? beyond : 0);
//@end
    }
//@end
//@if supply_lag
    {
        const {{p}}_real wanted = {{p}}_supply_level(power_w_per_m);
        const {{p}}_real behind = plant->supply_level - wanted;
        plant->supply_started = plant->supply_level;
        plant->supply_wanted = wanted;
        plant->supply_level = wanted + behind * {{P}}_R({{supply_retained}});
        power_w_per_m += {{p}}_fading(wanted, behind, {{P}}_R({{supply_weight}}), {{P}}_R({{supply_double_weight}}));
    }
//@end
//@if dead_time
    {
        const {{p}}_parted parted = {{p}}_arriving(plant, power_w_per_m);
        if (parted.share > 0) {
            {{p}}_advance(plant, parted.earlier_w_per_m, ambient_degc, 1, parted.share);
            (void){{p}}_show(plant, {{P}}_AT_TURN, 0);
            {{p}}_advance(plant, parted.later_w_per_m, ambient_degc, 2, parted.share);
        } else {
            {{p}}_advance(plant, parted.later_w_per_m, ambient_degc, 0, 0);
        }
    }
//@else
//@if supply_lag
    {
        const {{p}}_real lost = {{p}}_lost(plant, ambient_degc);
        const {{p}}_real level = {{p}}_supply_level(lost);
        if ((plant->supply_started - level) * (plant->supply_level - level) < 0) {
            const {{p}}_real wanted = plant->supply_wanted;
            const {{p}}_real behind = plant->supply_started - wanted;
            const {{p}}_real first_s = {{p}}_supply_at_s(level, wanted, behind);
//@if squares
            const {{p}}_real beyond = plant->supply_started * plant->supply_started - lost;
//@else
            const {{p}}_real beyond = plant->supply_started - lost;
//@end
            const {{p}}_real grown = lost + {{P}}_R(0.5) * beyond * first_s / {{P}}_R({{tau_s}});
            const {{p}}_real share = {{p}}_supply_at_s({{p}}_supply_level(grown), wanted, behind) / {{P}}_R({{part_s}});
            {{p}}_parted parted;
            parted.share = 0;
            parted.earlier_w_per_m = 0;
            parted.later_w_per_m = power_w_per_m;
            if (share > 0 && share < 1) {
                const {{p}}_real left = behind * {{P}}_EXP(-share * {{P}}_R({{part_s}}) / {{P}}_R({{supply_lag_s}}));
                parted.share = share;
                parted.earlier_w_per_m = {{p}}_supply_part(wanted, behind, share);
                parted.later_w_per_m = {{p}}_supply_part(wanted, left, {{P}}_R(1.0) - share);
            }
            {{p}}_advance(plant, parted.earlier_w_per_m, ambient_degc, 1, parted.share);
            (void){{p}}_show(plant, {{P}}_AT_TURN, 0);
            {{p}}_advance(plant, parted.later_w_per_m, ambient_degc, 2, parted.share);
        } else {
            {{p}}_advance(plant, power_w_per_m, ambient_degc, 0, 0);
        }
    }
//@else
    {{p}}_advance(plant, power_w_per_m, ambient_degc, 0, 0);
//@end
//@end
//@if middle
    (void){{p}}_show(plant, {{P}}_AT_MIDDLE, 0);
//@end
    plant->output = {{p}}_show(plant, {{P}}_AT_END, 0);
//@if thermocouple_lag
    {
        const {{p}}_real middle_degc =
            plant->middle_degc - {{P}}_R({{thermocouple_low}}) * (plant->middle_degc - ambient_degc);
        const {{p}}_real end_degc =
            plant->temperature_degc - {{P}}_R({{thermocouple_low}}) * (plant->temperature_degc - ambient_degc);
        plant->recorded_degc = {{p}}_follow(&plant->thermocouple, middle_degc, end_degc,
            {{P}}_R({{thermocouple_retained}}), {{P}}_R({{thermocouple_trailing}}), {{P}}_R({{thermocouple_bent}}));
    }
//@end
}

/* Moves the plant on by one sample of {{dt_s}} s under a drive ({{drive_text}}), in surroundings of a temperature, deg C. */
static inline void {{p}}_plant_step({{p}}_plant *plant, {{p}}_real drive, {{p}}_real ambient_degc) {
    {{p}}_real power_w_per_m;
//@if sub_steps
    int part;
//@end
//@if drive_limit
    if ({{P}}_FABS(drive) > {{P}}_DRIVE_LIMIT) {
        drive = {{P}}_COPYSIGN({{P}}_DRIVE_LIMIT, drive);
    }
//@end
//@if is_duty
    /* A bridge is never on for less than none of the time, nor for more than all of it. */
    drive = drive < 0 ? 0 : drive > 1 ? 1 : drive;
//@end
//@if is_current
    power_w_per_m = drive * drive * {{P}}_RESISTANCE_OHM_PER_M;
//@end
//@if is_duty
    power_w_per_m = {{P}}_POWER_NUMERATOR * drive / {{P}}_POWER_DIVISOR;
//@end
//@if is_voltage
    power_w_per_m = drive * drive / {{P}}_POWER_DIVISOR;
//@end
//@if is_power
    power_w_per_m = drive / {{P}}_LENGTH_M;
//@end
//@if sub_steps
    for (part = 0; part < {{n_sub_steps}}; ++part) {
        {{p}}_sub_step(plant, power_w_per_m, ambient_degc);
    }
//@else
    {{p}}_sub_step(plant, power_w_per_m, ambient_degc);
//@end
}
//@if pid

/* ---- the controller ---- */

/* Limits of the drive, in its unit, and gains: drive per error, error in {{output_unit}}. */
#define {{P}}_DRIVE_LOWER {{P}}_R({{pid_lower}}) /* {{pid_lower_decimal}} */
#define {{P}}_DRIVE_UPPER {{P}}_R({{pid_upper}}) /* {{pid_upper_decimal}} */
#define {{P}}_KP {{P}}_R({{pid_kp}}) /* {{pid_kp_decimal}} */
#define {{P}}_KI_DT {{P}}_R({{pid_ki_dt}}) /* {{pid_ki_dt_decimal}} ki times the sample time */
#define {{P}}_KD_NEW {{P}}_R({{pid_kd_new}}) /* {{pid_kd_new_decimal}} kd times the share of a new derivative */
#define {{P}}_DERIVATIVE_RETAINED {{P}}_R({{pid_retained}}) /* {{pid_retained_decimal}} */
#define {{P}}_PER_DT_S {{P}}_R({{pid_per_dt_s}}) /* {{pid_per_dt_s_decimal}} 1/s */
#define {{P}}_SETPOINT_WEIGHT {{P}}_R({{pid_setpoint_weight}}) /* {{pid_setpoint_weight_decimal}} */

/* State of the controller between samples. */
typedef struct {
    {{p}}_real integral;
    {{p}}_real derivative;
    {{p}}_real watched;
    {{p}}_real per_elapsed_s;
    {{p}}_real unsaturated;
    unsigned long missed; /* samples with an input that was no finite number */
//@if scheduled
    {{p}}_real middle; /* of the play that tells the branch */
//@end
} {{p}}_pid;

static inline {{p}}_real {{p}}_saturated({{p}}_real drive) {
    drive = drive > {{P}}_DRIVE_LOWER ? drive : {{P}}_DRIVE_LOWER;
    return drive < {{P}}_DRIVE_UPPER ? drive : {{P}}_DRIVE_UPPER;
}

//@if scheduled
/* Way of the output from one branch to the other after a turn, halved, and one over it; first level of the output, and one over
 * the distance of two levels. */
#define {{P}}_HALF_TURN {{P}}_R({{schedule_half_turn}}) /* {{schedule_half_turn_decimal}} {{output_unit}} */
#define {{P}}_PER_TURN {{P}}_R({{schedule_per_turn}}) /* {{schedule_per_turn_decimal}} */
#define {{P}}_FIRST_LEVEL {{P}}_R({{schedule_first}}) /* {{schedule_first_decimal}} {{output_unit}} */
#define {{P}}_PER_LEVEL {{P}}_R({{schedule_per_level}}) /* {{schedule_per_level_decimal}} */
#define {{P}}_LAST_LEVEL {{schedule_last}}

/* Middle of the play after a measurement. */
static inline {{p}}_real {{p}}_middle({{p}}_real middle, {{p}}_real measured) {
    const {{p}}_real lower = measured - {{P}}_HALF_TURN;
    const {{p}}_real upper = measured + {{P}}_HALF_TURN;
    middle = middle > lower ? middle : lower;
    return middle < upper ? middle : upper;
}

/* Factor on kp, ki and kd by the level of the output and the branch: 1 at the level where the rig is steepest. */
static inline {{p}}_real {{p}}_gain_factor({{p}}_real measured, {{p}}_real middle) {
    static const {{p}}_real heating[{{P}}_LAST_LEVEL + 1] = {
{{schedule_heating}}
    };
    static const {{p}}_real cooling[{{P}}_LAST_LEVEL + 1] = {
{{schedule_cooling}}
    };
    {{p}}_real branch = (measured - middle) * {{P}}_PER_TURN + {{P}}_R(0.5);
    {{p}}_real place = (measured - {{P}}_FIRST_LEVEL) * {{P}}_PER_LEVEL;
    {{p}}_real share;
    {{p}}_real on_heating;
    {{p}}_real on_cooling;
    int below;
    branch = branch > 0 ? branch : 0;
    branch = branch < 1 ? branch : 1;
    place = place > 0 ? place : 0;
    place = place < {{P}}_LAST_LEVEL ? place : {{P}}_LAST_LEVEL;
    below = (int)place;
    below = below < {{P}}_LAST_LEVEL ? below : {{P}}_LAST_LEVEL - 1;
    share = place - ({{p}}_real)below;
    on_heating = heating[below] + share * (heating[below + 1] - heating[below]);
    on_cooling = cooling[below] + share * (cooling[below + 1] - cooling[below]);
    return on_cooling + branch * (on_heating - on_cooling);
}

//@end
/* A controller that was idle: no integral, no error so far. */
static inline void {{p}}_pid_rest({{p}}_pid *pid, {{p}}_real measured) {
//@if turned
    measured = -measured;
//@end
    pid->integral = 0;
    pid->derivative = 0;
//@if derivative_of_error
    (void)measured;
    pid->watched = 0;
//@else
    pid->watched = -measured;
//@end
    pid->per_elapsed_s = {{P}}_PER_DT_S;
    pid->unsaturated = 0;
    pid->missed = 0;
//@if scheduled
    /* As if the output had come from below: a rod is cold at first. */
    pid->middle = -INFINITY;
//@end
}

/* A controller that takes over from a drive set by hand, without a bump. */
static inline void {{p}}_pid_start({{p}}_pid *pid, {{p}}_real setpoint, {{p}}_real measured, {{p}}_real feed_forward,
    {{p}}_real drive) {
    {{p}}_pid_rest(pid, measured);
//@if turned
    setpoint = -setpoint;
    measured = -measured;
//@end
    drive = {{p}}_saturated(drive);
//@if scheduled
    pid->integral = drive
        - {{P}}_KP
            * ({{P}}_SETPOINT_WEIGHT * setpoint - measured
                + ({{p}}_gain_factor(measured, {{p}}_middle(pid->middle, measured)) - {{P}}_R(1.0)) * (setpoint - measured))
        - feed_forward;
//@else
    pid->integral = drive - {{P}}_KP * ({{P}}_SETPOINT_WEIGHT * setpoint - measured) - feed_forward;
//@end
//@if derivative_of_error
    pid->watched = setpoint - measured;
//@end
    /* A measurement that is no number tells nothing: the drive set by hand is held until one comes. */
    if (!isfinite(pid->integral)) {
        pid->integral = drive;
    }
    pid->unsaturated = drive;
}

/* The drive for one sample, to be called once every {{dt_s}} s: set point and measurement in {{output_unit}} as the sensor
 * reads them, and a drive to be added, 0 for none. A sample with a NaN is missed: the last drive is held, and counted. */
static inline {{p}}_real {{p}}_pid_step({{p}}_pid *pid, {{p}}_real setpoint, {{p}}_real measured, {{p}}_real feed_forward) {
    {{p}}_real error;
    {{p}}_real watched;
    {{p}}_real derivative;
    {{p}}_real unsaturated;
    {{p}}_real integral;
//@if scheduled
    {{p}}_real middle;
    {{p}}_real factor;
//@end
//@if turned
    /* The output falls as the drive rises. */
    setpoint = -setpoint;
    measured = -measured;
//@end
    error = setpoint - measured;
//@if derivative_of_error
    watched = error;
//@else
    watched = -measured;
//@end
//@if scheduled
    middle = {{p}}_middle(pid->middle, measured);
    factor = {{p}}_gain_factor(measured, middle);
    derivative = {{P}}_DERIVATIVE_RETAINED * pid->derivative
        + {{P}}_KD_NEW * factor * (isfinite(pid->watched) ? (watched - pid->watched) * pid->per_elapsed_s : 0);
    unsaturated = {{P}}_KP * ({{P}}_SETPOINT_WEIGHT * setpoint - measured + (factor - {{P}}_R(1.0)) * error)
        + pid->integral + derivative + feed_forward;
    integral = pid->integral + {{P}}_KI_DT * factor * error;
//@else
    derivative = {{P}}_DERIVATIVE_RETAINED * pid->derivative
        + {{P}}_KD_NEW * (isfinite(pid->watched) ? (watched - pid->watched) * pid->per_elapsed_s : 0);
    unsaturated = {{P}}_KP * ({{P}}_SETPOINT_WEIGHT * setpoint - measured) + pid->integral + derivative + feed_forward;
    integral = pid->integral + {{P}}_KI_DT * error;
//@end
//@if clamping
    /* No summand that drives a saturated command further out. */
    if ((unsaturated - {{p}}_saturated(unsaturated)) * error > 0) {
        integral = pid->integral;
    }
//@end
//@if back_calculation
    /* The integral follows the saturated command. */
    integral += ({{p}}_saturated(unsaturated) - unsaturated) * {{P}}_R({{pid_tracking_share}});
//@end
    if (isfinite(unsaturated) && isfinite(integral)) {
        pid->integral = integral;
        pid->derivative = derivative;
        pid->watched = watched;
        pid->per_elapsed_s = {{P}}_PER_DT_S;
        pid->unsaturated = unsaturated;
//@if scheduled
        pid->middle = middle;
//@end
    } else {
        pid->per_elapsed_s = {{P}}_R(1.0) / ({{P}}_R(1.0) / pid->per_elapsed_s + {{P}}_DT_S);
        ++pid->missed;
    }
    return {{p}}_saturated(pid->unsaturated);
}
//@end

#endif
