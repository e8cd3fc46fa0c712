/* Three orthogonal wheels with dry friction that point a body: the loop of three_wheels.py as one
   would write it by hand in C, to measure against. Several runs go side by side in the elements of
   GCC's vectors, blocks of them on all cores:

       cc -std=gnu11 -O3 -march=native -fopenmp -shared -fPIC three_wheels.c -o three_wheels.so -lm

   The state, the fourth-order step in frozen modes of motion and the events are those of
   gyrostat.spacecraft.Gyrostat. What it leaves out is what never binds at a step of 0.01 s: the search for
   the longest step that resolves friction and body, and failures, limits and axes in general. */

#include <stdbool.h>

#if defined(__AVX512F__)
#define LANES 8
#elif defined(__AVX2__)
#define LANES 4
#else
#define LANES 2
#endif
#define INLINE static inline __attribute__((always_inline))
#ifndef EVERYTHING
#define EVERYTHING 0 /* 1: friction's bend and held wheels are always reckoned with, as in gyrostat */
#endif
#define EACH(i) for (int i = 0; i < 3; ++i)
#define NARROWINGS 8 /* of a bracket, by secants: what is nearly a straight line needs fewer */
#define BAND 6.1     /* Stribeck speeds, beyond which the exponential is below 1e-16 */
#define NEAR 1e-6    /* share of the breakaway torque, below which a held wheel is looked at */

typedef double Reals __attribute__((vector_size(8 * LANES)));
typedef long long Truths __attribute__((vector_size(8 * LANES)));

static const bool ALL[3] = {true, true, true};

/* SI; matrices by rows. */
typedef struct {
    double locked[9];         /* inertia with rotors locked */
    double locked_inverse[9]; /* of it */
    double inverse[9];        /* of the inertia without that of the rotors about their axes */
    double rotor, rotor_inverse, viscous, coulomb, stiction, stribeck_speed, stribeck_inverse;
    double torque[3]; /* of disturbance, body axes */
    double proportional, derivative, period, settled;
} Case;

typedef struct {
    Reals attitude[4], momentum[3], speed[3];
} State;

typedef struct {
    Reals coulomb[3], excess[3]; /* static less Coulomb */
} Friction;

typedef struct {
    Reals sense[3], holding[9]; /* see gyrostat.wheel.contacts.Modes */
} Modes;

INLINE Reals all(double x) { return x - (Reals){0.0}; }
INLINE Reals chosen(Truths is, Reals a, Reals b)
{
    return (Reals)((is & (Truths)a) | (~is & (Truths)b));
}
INLINE bool any(Truths is)
{
    long long found = 0;
    for (int lane = 0; lane < LANES; ++lane) { found |= is[lane]; }
    return found != 0;
}
INLINE Reals size(Reals x) { return chosen(x < 0.0, -x, x); }
INLINE Reals sign(Reals x) { return chosen(x > 0.0, all(1.0), chosen(x < 0.0, all(-1.0), all(0.0))); }

INLINE void cross(const Reals a[3], const Reals b[3], Reals out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

INLINE void times(const double m[9], const Reals v[3], Reals out[3])
{
    EACH(i) { out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2]; }
}

/* To inertial axes with way 1, to body axes with way -1. */
INLINE void turned(const Reals q[4], double way, const Reals v[3], Reals out[3])
{
    Reals twice[3], again[3];
    cross(q + 1, v, twice);
    EACH(i) { twice[i] = 2.0 * twice[i]; }
    cross(q + 1, twice, again);
    EACH(i) { out[i] = v[i] + way * q[0] * twice[i] + again[i]; }
}

/* exp(x) of x <= 0: x = n ln 2 + r, and the series of exp(r). */
INLINE Reals exponential(Reals x)
{
    x = chosen(x < -700.0, all(-700.0), x);
    const Truths n = __builtin_convertvector(x * 1.4426950408889634 - 0.5, Truths);
    const Reals count = __builtin_convertvector(n, Reals);
    const Reals r = (x - count * 0x1.62e42feep-1) - count * 0x1.a39ef35793c76p-33;
    Reals sum = all(1.0 / 479001600.0);
    sum = sum * r + 1.0 / 39916800.0;
    sum = sum * r + 1.0 / 3628800.0;
    sum = sum * r + 1.0 / 362880.0;
    sum = sum * r + 1.0 / 40320.0;
    sum = sum * r + 1.0 / 5040.0;
    sum = sum * r + 1.0 / 720.0;
    sum = sum * r + 1.0 / 120.0;
    sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0;
    sum = sum * r + 0.5;
    sum = sum * r + 1.0;
    sum = sum * r + 1.0;
    return sum * (Reals)((n + 1023) << 52);
}

/* Momentum in body axes and rate of the body. */
INLINE void body_of(const Case *c, const State *y, Reals momentum[3], Reals rate[3])
{
    Reals rest[3];
    turned(y->attitude, -1.0, y->momentum, momentum);
    EACH(i) { rest[i] = momentum[i] - c->rotor * y->speed[i]; }
    times(c->locked_inverse, rest, rate);
}

/* Derivative of the state in frozen modes, and the friction torques. Which wheels are in the bend of
   their curves, and whether some wheel is held, is known beforehand for all lanes. */
INLINE void rate_of(const Case *c, const Friction *f, const State *y, const Reals motor[3],
    const Modes *modes, const bool bends[3], bool holds, State *rate, Reals friction[3])
{
    const Reals *q = y->attitude;
    Reals momentum[3], w[3], gyroscopic[3], push[3], torque[3], change[3];
    body_of(c, y, momentum, w);
    cross(w, momentum, gyroscopic);
    EACH(i) {
        Reals dry = f->coulomb[i];
        if (bends[i]) {
            const Reals share = c->stribeck_inverse * y->speed[i];
            dry += f->excess[i] * exponential(-share * share);
        }
        friction[i] = c->viscous * y->speed[i] + modes->sense[i] * dry;
        torque[i] = c->torque[i] - gyroscopic[i];
    }
    if (holds) { /* torques that leave the held wheels where they are */
        Reals net[3], surplus[3];
        EACH(i) {
            surplus[i] = chosen(modes->sense[i] == 0.0, all(0.0), motor[i] - friction[i]);
            net[i] = torque[i] - surplus[i];
        }
        times(c->inverse, net, change);
        EACH(i) { change[i] = c->rotor_inverse * surplus[i] - change[i]; }
        EACH(i) {
            const Reals *h = modes->holding + 3 * i;
            const Reals held = motor[i] + h[0] * change[0] + h[1] * change[1] + h[2] * change[2];
            friction[i] = chosen(modes->sense[i] == 0.0, held, friction[i]);
        }
    }
    EACH(i) {
        push[i] = motor[i] - friction[i];
        torque[i] -= push[i];
    }
    times(c->inverse, torque, change);
    EACH(i) {
        rate->speed[i] = c->rotor_inverse * push[i] - change[i];
        if (holds) {
            rate->speed[i] = chosen(modes->sense[i] == 0.0, all(0.0), rate->speed[i]);
        }
        torque[i] = all(c->torque[i]);
    }
    turned(q, 1.0, torque, rate->momentum);
    rate->attitude[0] = -0.5 * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2]);
    rate->attitude[1] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
    rate->attitude[2] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
    rate->attitude[3] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
}

INLINE void moved(const State *y, Reals by, const State *rate, State *out)
{
    for (int i = 0; i < 4; ++i) { out->attitude[i] = y->attitude[i] + by * rate->attitude[i]; }
    EACH(i) { out->momentum[i] = y->momentum[i] + by * rate->momentum[i]; }
    EACH(i) { out->speed[i] = y->speed[i] + by * rate->speed[i]; }
}

/* A classical fourth-order step; the rate at its start, and friction torques near its end. */
INLINE void step(const Case *c, const Friction *f, const State *y, const Reals motor[3],
    const Modes *modes, Reals duration, const bool bends[3], bool holds, State *end, State *first,
    Reals friction[3])
{
    State there, rate;
    rate_of(c, f, y, motor, modes, bends, holds, first, friction);
    moved(y, duration * (1.0 / 6.0), first, end);
    moved(y, 0.5 * duration, first, &there);
    rate_of(c, f, &there, motor, modes, bends, holds, &rate, friction);
    moved(end, duration * (1.0 / 3.0), &rate, end);
    moved(y, 0.5 * duration, &rate, &there);
    rate_of(c, f, &there, motor, modes, bends, holds, &rate, friction);
    moved(end, duration * (1.0 / 3.0), &rate, end);
    moved(y, duration, &rate, &there);
    rate_of(c, f, &there, motor, modes, bends, holds, &rate, friction);
    moved(end, duration * (1.0 / 6.0), &rate, end);
}

/* The inverse of the mobility of the held wheels, zero for the others: by cofactors. */
static void hold(const Case *c, Modes *modes)
{
    Reals m[9];
    Truths held[3];
    EACH(i) { held[i] = modes->sense[i] == 0.0; }
    EACH(i) EACH(k) {
        const double unit = (i == k) ? 1.0 : 0.0;
        const Reals mobility = all(c->inverse[3 * i + k] + unit * c->rotor_inverse);
        m[3 * i + k] = chosen(held[i] & held[k], mobility, all(unit));
    }
    EACH(i) EACH(k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3, d = (i + 1) % 3, e = (i + 2) % 3;
        modes->holding[3 * i + k] = m[3 * a + d] * m[3 * b + e] - m[3 * a + e] * m[3 * b + d];
    }
    const Reals *cofactors = modes->holding;
    const Reals determinant = m[0] * cofactors[0] + m[1] * cofactors[3] + m[2] * cofactors[6];
    EACH(i) EACH(k) {
        const Reals inverse = modes->holding[3 * i + k] / determinant;
        modes->holding[3 * i + k] = chosen(held[i] & held[k], inverse, all(0.0));
    }
}

/* Turning wheels keep their sense, resting ones hold if they can; the worst is released first. */
static void modes_of(const Case *c, const Friction *f, const State *y, const Reals motor[3],
    const Reals released[3], Modes *modes)
{
    EACH(i) { modes->sense[i] = chosen(y->speed[i] == 0.0, released[i], sign(y->speed[i])); }
    for (;;) {
        State rate;
        Reals friction[3], excess[3], worst = all(0.0);
        hold(c, modes);
        rate_of(c, f, y, motor, modes, ALL, true, &rate, friction);
        EACH(i) {
            excess[i] = size(friction[i]) - (f->coulomb[i] + f->excess[i]);
            excess[i] = chosen(modes->sense[i] == 0.0, excess[i], all(0.0));
            worst = chosen(excess[i] > worst, excess[i], worst);
        }
        if (!any(worst > 0.0)) { return; }
        EACH(i) {
            const Truths goes = (excess[i] == worst) & (worst > 0.0);
            modes->sense[i] = chosen(goes, sign(friction[i]), modes->sense[i]);
        }
    }
}

/* What is left before the mode of wheel i ends: speed in its sense, or torque to the breakaway. */
INLINE Reals height(const Friction *f, const Modes *modes, const Reals rising[3], int i,
    const State *y, const Reals friction[3])
{
    const Reals lacks = f->coulomb[i] + f->excess[i] - rising[i] * friction[i];
    return chosen(modes->sense[i] == 0.0, lacks, modes->sense[i] * y->speed[i]);
}

/* A period in pieces between events, in the lanes where one may happen. */
static void pass_events(const Case *c, const Friction *f, State *y, const Reals motor[3],
    Truths lanes)
{
    Reals left = chosen(lanes, all(c->period), all(0.0));
    Reals released[3] = {{0.0}, {0.0}, {0.0}};
    while (any(left > 0.0)) {
        const Truths active = left > 0.0;
        Modes modes;
        State end, first, last, there, unused;
        Reals at_first[3], at_last[3], rising[3], near_end[3], duration = left;
        Truths hit[3];
        modes_of(c, f, y, motor, released, &modes);
        step(c, f, y, motor, &modes, left, ALL, true, &end, &first, near_end);
        rate_of(c, f, y, motor, &modes, ALL, true, &first, at_first);
        rate_of(c, f, &end, motor, &modes, ALL, true, &last, at_last);
        EACH(i) { rising[i] = sign(at_last[i] - at_first[i]); }
        EACH(i) {
            const Truths held = modes.sense[i] == 0.0;
            const Reals begin_rate = modes.sense[i] * first.speed[i];
            const Reals end_rate = modes.sense[i] * last.speed[i];
            const Truths turns = begin_rate * end_rate < 0.0;
            const Reals turning = left * begin_rate / chosen(turns, begin_rate - end_rate, all(1.0));
            const Reals begin = height(f, &modes, rising, i, y, at_first);
            const Reals final = height(f, &modes, rising, i, &end, at_last);
            const Truths from_zero = ~held & (begin == 0.0);
            const Truths rises = turns & (begin_rate > 0.0);
            const Truths past = (final <= 0.0) & (~from_zero | rises);
            const Truths dips = turns & (begin_rate < 0.0) & ~from_zero & ~past &
                (begin + 0.5 * begin_rate * turning <= 0.0);
            const Truths late = from_zero & rises;
            Reals low = chosen(late, turning, all(0.0)), high = chosen(past, left, turning);
            hit[i] = (Truths){0};
            if (any(active & (past | dips))) {
                Reals above, below, try = high, found = all(0.0);
                Reals torque[3];
                step(c, f, y, motor, &modes, low, ALL, true, &there, &unused, torque);
                rate_of(c, f, &there, motor, &modes, ALL, true, &unused, torque);
                above = height(f, &modes, rising, i, &there, torque);
                below = final;
                for (int k = 0; k <= NARROWINGS; ++k) {
                    step(c, f, y, motor, &modes, try, ALL, true, &there, &unused, torque);
                    rate_of(c, f, &there, motor, &modes, ALL, true, &unused, torque);
                    found = height(f, &modes, rising, i, &there, torque);
                    if (k == 0) { hit[i] = active & (past | dips) & (found <= 0.0); }
                    low = chosen(found > 0.0, try, low);
                    above = chosen(found > 0.0, found, above);
                    high = chosen(found > 0.0, high, try);
                    below = chosen(found > 0.0, below, found);
                    const Reals drop = above - below;
                    const Reals way = above / chosen(drop > 0.0, drop, all(1.0));
                    try = low + chosen(drop > 0.0, way, all(0.0)) * (high - low);
                }
                hit[i] &= try <= duration;
                duration = chosen(hit[i], try, duration);
                for (int k = 0; k < i; ++k) { hit[k] &= ~hit[i]; }
            } else {
                const Truths back = active & from_zero & ~rises & (final < 0.0);
                end.speed[i] = chosen(back, all(0.0), end.speed[i]);
            }
        }
        const Truths whole = ~(hit[0] | hit[1] | hit[2]);
        step(c, f, y, motor, &modes, duration, ALL, true, &there, &unused, near_end);
        for (int i = 0; i < 4; ++i) {
            const Reals to = chosen(whole, end.attitude[i], there.attitude[i]);
            y->attitude[i] = chosen(active, to, y->attitude[i]);
        }
        EACH(i) {
            Reals to = chosen(whole, end.momentum[i], there.momentum[i]);
            y->momentum[i] = chosen(active, to, y->momentum[i]);
            to = chosen(whole, end.speed[i], chosen(hit[i], all(0.0), there.speed[i]));
            y->speed[i] = chosen(active, to, y->speed[i]);
            released[i] = chosen(hit[i] & (modes.sense[i] == 0.0), rising[i], all(0.0));
        }
        left = chosen(active & ~whole, left - duration, all(0.0));
    }
}

/* One control period of held motor torques. */
INLINE void period(const Case *c, const Friction *f, State *y, const Reals motor[3], const bool bends[3])
{
    const Reals whole = all(c->period);
    const Truths rest = (y->speed[0] == 0.0) | (y->speed[1] == 0.0) | (y->speed[2] == 0.0);
    State end, first;
    Reals friction[3];
    Truths event = {0};
    Modes modes;
    if (EVERYTHING || any(rest)) {
        const Reals none[3] = {{0.0}, {0.0}, {0.0}};
        modes_of(c, f, y, motor, none, &modes);
        step(c, f, y, motor, &modes, whole, ALL, true, &end, &first, friction);
        EACH(i) {
            const Reals limit = (1.0 - NEAR) * (f->coulomb[i] + f->excess[i]);
            event |= (modes.sense[i] == 0.0) & (size(friction[i]) >= limit);
        }
    } else {
        EACH(i) { modes.sense[i] = chosen(y->speed[i] > 0.0, all(1.0), all(-1.0)); }
        step(c, f, y, motor, &modes, whole, bends, false, &end, &first, friction);
    }
    EACH(i) { /* a wheel that dips through zero first heads for it */
        const Reals straight = y->speed[i] + c->period * first.speed[i];
        const Truths turns = modes.sense[i] != 0.0;
        event |= turns & ((modes.sense[i] * end.speed[i] <= 0.0) | (modes.sense[i] * straight <= 0.0));
    }
    if (any(event)) {
        pass_events(c, f, y, motor, event);
        for (int i = 0; i < 4; ++i) {
            y->attitude[i] = chosen(event, y->attitude[i], end.attitude[i]);
        }
        EACH(i) { y->momentum[i] = chosen(event, y->momentum[i], end.momentum[i]); }
        EACH(i) { y->speed[i] = chosen(event, y->speed[i], end.speed[i]); }
    } else {
        *y = end;
    }
}

INLINE Reals root(Reals x)
{
    for (int lane = 0; lane < LANES; ++lane) { x[lane] = __builtin_sqrt(x[lane]); }
    return x;
}

/* Fly the lanes of one block: sum and largest value of the squared vector part of the quaternion. */
static void fly_block(const Case *c, const Friction *f, State *state, long count, Reals *sum,
    Reals *largest)
{
    State here = *state, *y = &here; /* of which no pointer leaves, but for events */
    for (long k = 0;; ++k) {
        const Reals *q = y->attitude;
        const Reals sine = q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        *sum += sine;
        if ((double)k * c->period >= c->settled) {
            *largest = chosen(sine > *largest, sine, *largest);
        }
        if (k == count) { break; }
        Reals momentum[3], rate[3], motor[3];
        body_of(c, y, momentum, rate);
        const Reals scale = sign(q[0]) * c->proportional / (1.0 + size(q[0]));
        bool bends[3];
        EACH(i) {
            motor[i] = scale * q[i + 1] + c->derivative * rate[i];
            bends[i] = EVERYTHING || any(size(y->speed[i]) < BAND * c->stribeck_speed);
        }
        period(c, f, y, motor, bends);
        const Reals unit = 1.0 / root(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int i = 0; i < 4; ++i) { y->attitude[i] *= unit; }
    }
    *state = here;
}

/* Fly runs for count control periods.

   drawn: for each run attitude (4), rate (3), wheel speeds (3), factors on dry friction (3).
   flown: for each run the sum and the largest, then attitude (4), momentum (3), wheel speeds (3). */
void fly(const Case *c, long runs, long count, const double (*drawn)[13], double (*flown)[12])
{
#pragma omp parallel for schedule(dynamic)
    for (long first = 0; first < runs; first += LANES) {
        State y;
        Friction friction;
        Reals rate[3], momentum[3], sum = {0.0}, largest = {0.0};
        for (int lane = 0; lane < LANES; ++lane) {
            const long run = (first + lane < runs) ? first + lane : first;
            for (int i = 0; i < 4; ++i) { y.attitude[i][lane] = drawn[run][i]; }
            EACH(i) {
                rate[i][lane] = drawn[run][4 + i];
                y.speed[i][lane] = drawn[run][7 + i];
                friction.coulomb[i][lane] = c->coulomb * drawn[run][10 + i];
                friction.excess[i][lane] = (c->stiction - c->coulomb) * drawn[run][10 + i];
            }
        }
        times(c->locked, rate, momentum);
        EACH(i) { momentum[i] += c->rotor * y.speed[i]; }
        turned(y.attitude, 1.0, momentum, y.momentum);
        fly_block(c, &friction, &y, count, &sum, &largest);
        for (int lane = 0; lane < LANES && first + lane < runs; ++lane) {
            double *out = flown[first + lane];
            out[0] = sum[lane];
            out[1] = largest[lane];
            for (int i = 0; i < 4; ++i) { out[2 + i] = y.attitude[i][lane]; }
            EACH(i) { out[6 + i] = y.momentum[i][lane]; }
            EACH(i) { out[9 + i] = y.speed[i][lane]; }
        }
    }
}
