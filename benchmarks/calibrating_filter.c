/* The filter of calibrating_filter.py, written by hand with loops: Jacobians in closed form, and no
   products with the parts of the matrices that are zero or one. The header is the emitted one. */
#include "filter.h"

#include <math.h>

enum { STATES = 15, SENSORS = 6 };

static const double period = 0.25;
static const double walk[5] = {2e-5, 1e-7, 1e-7, 1e-8, 1e-10}; /* of each three states */
static const double sigma[2] = {5e-5, 2e-7};                   /* of each three sensors */

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* p q, or the inverse of p times q with sign -1 */
static void multiply(const double p[4], double sign, const double q[4], double r[4])
{
    double turned[3];
    cross(p + 1, q + 1, turned);
    r[0] = p[0] * q[0] - sign * dot(p + 1, q + 1);
    for (int i = 0; i < 3; ++i) {
        r[i + 1] = p[0] * q[i + 1] + sign * (q[0] * p[i + 1] + turned[i]);
    }
}

/* R' v of a quaternion that need not have unit length */
static void to_body(const double q[4], const double v[3], double r[3])
{
    double turned[3];
    const double along = 2.0 * dot(q + 1, v), scale = q[0] * q[0] - dot(q + 1, q + 1);
    cross(q + 1, v, turned);
    for (int i = 0; i < 3; ++i) {
        r[i] = scale * v[i] + along * q[i + 1] - 2.0 * q[0] * turned[i];
    }
}

static void rotation(const double v[3], double q[4])
{
    const double half = 0.5 * sqrt(dot(v, v) + 1e-30), scale = 0.5 * sin(half) / half;
    q[0] = cos(half);
    for (int i = 0; i < 3; ++i) {
        q[i + 1] = scale * v[i];
    }
}

/* turn of a period, and its derivative with respect to the rotation vector */
static void jacobian(const double v[3], double matrix[3][3])
{
    const double squared = dot(v, v) + 1e-30, angle = sqrt(squared), small = sin(0.5 * angle);
    const double first = 2.0 * small * small / squared;
    const double second = angle < 1e-2 ? 1.0 / 6.0 - squared / 120.0 + squared * squared / 5040.0
                                       : (angle - sin(angle)) / (squared * angle);
    for (int j = 0; j < 3; ++j) {
        double unit[3] = {0.0, 0.0, 0.0}, once[3], twice[3];
        unit[j] = 1.0;
        cross(v, unit, once);
        cross(v, once, twice);
        for (int i = 0; i < 3; ++i) {
            matrix[i][j] = unit[i] - first * once[i] + second * twice[i];
        }
    }
}

static void predict(Estimate *estimate, const double rate[3])
{
    double turn[3], step[4], attitude[4], by_turn[3][3], forward[3][9];
    for (int i = 0; i < 3; ++i) {
        turn[i] = period * (rate[i] * (1.0 - estimate->scale[i]) - estimate->bias[i]);
    }
    rotation(turn, step);
    multiply(estimate->attitude, 1.0, step, attitude);
    jacobian(turn, by_turn);
    for (int j = 0; j < 3; ++j) {
        double unit[3] = {0.0, 0.0, 0.0}, turned[3];
        estimate->attitude[j] = attitude[j];
        unit[j] = 1.0;
        to_body(step, unit, turned);
        for (int i = 0; i < 3; ++i) {
            forward[i][j] = turned[i];
            forward[i][3 + j] = -period * by_turn[i][j];
            forward[i][6 + j] = forward[i][3 + j] * rate[j];
        }
    }
    estimate->attitude[3] = attitude[3];
    /* only the first three rows of the matrix are not those of a unit matrix */
    double rows[3][STATES], block[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < STATES; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 9; ++k) {
                sum += forward[i][k] * estimate->covariance[k][j];
            }
            rows[i][j] = sum;
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 9; ++k) {
                sum += rows[i][k] * forward[j][k];
            }
            block[i][j] = sum;
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < STATES; ++j) {
            estimate->covariance[i][j] = j < 3 ? block[i][j] : rows[i][j];
            estimate->covariance[j][i] = j < 3 ? block[j][i] : rows[i][j];
        }
    }
    for (int i = 0; i < STATES; ++i) {
        estimate->covariance[i][i] += period * walk[i / 3] * walk[i / 3];
    }
}

/* derivative of the measurements: [turned 0 0 misaligned 0; crossed 0 0 0 1] */
typedef struct {
    double turned[3][3];
    double misaligned[3][3];
    double crossed[3][3];
} Seen;

/* column of the derivative times a matrix with 15 rows */
static void times(const Seen *seen, const double *column, int step, double result[SENSORS])
{
    for (int i = 0; i < 3; ++i) {
        double angle = 0.0, field = column[(12 + i) * step];
        for (int k = 0; k < 3; ++k) {
            angle += seen->turned[i][k] * column[k * step];
            angle += seen->misaligned[i][k] * column[(9 + k) * step];
            field += seen->crossed[i][k] * column[k * step];
        }
        result[i] = angle;
        result[3 + i] = field;
    }
}

static void see(const Estimate *estimate, const Sensors *sensors, Seen *seen, double innovation[6])
{
    double misalignment[4] = {1.0}, predicted[4], difference[4], field[3];
    for (int i = 0; i < 3; ++i) {
        misalignment[i + 1] = 0.5 * estimate->misalignment[i];
    }
    multiply(estimate->attitude, 1.0, misalignment, predicted);
    multiply(predicted, -1.0, sensors->attitude, difference);
    to_body(estimate->attitude, sensors->model_field, field);
    for (int i = 0; i < 3; ++i) {
        innovation[i] = (difference[0] < 0.0 ? -2.0 : 2.0) * difference[i + 1];
        innovation[3 + i] = sensors->field[i] - field[i] - estimate->offset[i];
    }
    for (int j = 0; j < 3; ++j) {
        double unit[3] = {0.0, 0.0, 0.0}, turned[3], half[3], crossed[3];
        unit[j] = 1.0;
        to_body(misalignment, unit, turned);
        cross(misalignment + 1, unit, half);
        cross(field, unit, crossed);
        for (int i = 0; i < 3; ++i) {
            seen->turned[i][j] = turned[i];
            seen->misaligned[i][j] = unit[i] - half[i];
            seen->crossed[i][j] = crossed[i];
        }
    }
}

/* S = L L'; each row of the gain is then S^-1 times a column of H P */
static void decompose(double s[SENSORS][SENSORS])
{
    for (int j = 0; j < SENSORS; ++j) {
        for (int i = j; i < SENSORS; ++i) {
            double sum = s[i][j];
            for (int k = 0; k < j; ++k) {
                sum -= s[i][k] * s[j][k];
            }
            s[i][j] = i == j ? sqrt(sum) : sum / s[j][j];
        }
    }
}

static void solve(double lower[SENSORS][SENSORS], double x[SENSORS])
{
    for (int i = 0; i < SENSORS; ++i) {
        for (int k = 0; k < i; ++k) {
            x[i] -= lower[i][k] * x[k];
        }
        x[i] /= lower[i][i];
    }
    for (int i = SENSORS - 1; i >= 0; --i) {
        for (int k = i + 1; k < SENSORS; ++k) {
            x[i] -= lower[k][i] * x[k];
        }
        x[i] /= lower[i][i];
    }
}

static void update(Estimate *estimate, const Sensors *sensors)
{
    Seen seen;
    double innovation[SENSORS], across[STATES][SENSORS], scatter[SENSORS][SENSORS];
    double gain[STATES][SENSORS], change[STATES], rest[STATES][STATES];
    see(estimate, sensors, &seen, innovation);
    for (int j = 0; j < STATES; ++j) {
        times(&seen, &estimate->covariance[0][j], STATES, across[j]);
    }
    for (int j = 0; j < SENSORS; ++j) {
        times(&seen, &across[0][j], SENSORS, scatter[j]);
        scatter[j][j] += sigma[j / 3] * sigma[j / 3];
    }
    decompose(scatter);
    for (int i = 0; i < STATES; ++i) {
        double sum = 0.0;
        for (int k = 0; k < SENSORS; ++k) {
            gain[i][k] = across[i][k];
        }
        solve(scatter, gain[i]);
        for (int k = 0; k < SENSORS; ++k) {
            sum += gain[i][k] * innovation[k];
        }
        change[i] = sum;
    }
    /* Joseph form: X = P - K H P, then X - X H' K' + K R K' */
    for (int i = 0; i < STATES; ++i) {
        double row[SENSORS];
        for (int j = 0; j < STATES; ++j) {
            double sum = estimate->covariance[i][j];
            for (int k = 0; k < SENSORS; ++k) {
                sum -= gain[i][k] * across[j][k];
            }
            rest[i][j] = sum;
        }
        times(&seen, rest[i], 1, row);
        for (int k = 0; k < SENSORS; ++k) {
            row[k] -= sigma[k / 3] * sigma[k / 3] * gain[i][k];
        }
        for (int j = 0; j < STATES; ++j) {
            for (int k = 0; k < SENSORS; ++k) {
                rest[i][j] -= row[k] * gain[j][k];
            }
        }
    }
    for (int i = 0; i < STATES; ++i) {
        for (int j = 0; j < STATES; ++j) {
            estimate->covariance[i][j] = 0.5 * (rest[i][j] + rest[j][i]);
        }
    }
    double step[4], attitude[4], squared = 0.0;
    rotation(change, step);
    multiply(estimate->attitude, 1.0, step, attitude);
    for (int i = 0; i < 4; ++i) {
        squared += attitude[i] * attitude[i];
    }
    for (int i = 0; i < 4; ++i) {
        estimate->attitude[i] = attitude[i] / sqrt(squared);
    }
    for (int i = 0; i < 3; ++i) {
        estimate->bias[i] += change[3 + i];
        estimate->scale[i] += change[6 + i];
        estimate->misalignment[i] += change[9 + i];
        estimate->offset[i] += change[12 + i];
    }
}

int filter_step(Estimate *estimate, const Sensors *sensors)
{
    predict(estimate, sensors->rate);
    update(estimate, sensors);
    return 0;
}
