/* Functions of runs, written with the operations of the including header: of `lanes.h` for a run in
   each SIMD lane, of `work_item.h` for one run in each work item of an accelerator.

   Largest errors against the exact value, over all arguments in the tests, in units in the last
   place: exp 1, expm1 2, tanh 3, log 1, log1p 2, sin and cos 1 (below 8e5; above it, those of the
   C library), atan2, asin and acos 3. For erf_inv: 1e-15 relative. */

FUNCTION real real_of_mask(mask m) { return select_real(m, all_real(1.0), all_real(0.0)); }
FUNCTION integer integer_of_mask(mask m) { return select_integer(m, all_integer(1), all_integer(0)); }
FUNCTION mask mask_of_integer(integer x) { return ne_integer(x, all_integer(0)); }
FUNCTION mask lt_mask(mask a, mask b) { return and_mask(not_mask(a), b); }
FUNCTION mask le_mask(mask a, mask b) { return or_mask(not_mask(a), b); }
FUNCTION mask gt_mask(mask a, mask b) { return lt_mask(b, a); }
FUNCTION mask ge_mask(mask a, mask b) { return le_mask(b, a); }
FUNCTION mask eq_mask(mask a, mask b) { return not_mask(xor_mask(a, b)); }
FUNCTION mask ne_mask(mask a, mask b) { return xor_mask(a, b); }
FUNCTION mask select_mask(mask m, mask yes, mask no)
{
    return or_mask(and_mask(m, yes), and_mask(not_mask(m), no));
}

/* comparisons with a constant, and the test for NaN */
#define BELOW(x, number) lt_real(x, all_real(number))
#define ABOVE(x, number) gt_real(x, all_real(number))
#define IS(x, number) eq_real(x, all_real(number))
FUNCTION mask is_none(real x) { return ne_real(x, x); }


/* minimum and maximum that propagate NaN */
FUNCTION real max_real(real a, real b) { return select_real(or_mask(ge_real(a, b), is_none(a)), a, b); }
FUNCTION real min_real(real a, real b) { return select_real(or_mask(le_real(a, b), is_none(a)), a, b); }

LANE_BY_LANE(round)
LANE_BY_LANE(exp2)
LANE_BY_LANE(tan)
LANE_BY_LANE(atan)
LANE_BY_LANE(sinh)
LANE_BY_LANE(cosh)
LANE_BY_LANE(asinh)
LANE_BY_LANE(acosh)
LANE_BY_LANE(atanh)
LANE_BY_LANE(erf)
LANE_BY_LANE(erfc)
LANE_BY_LANE(cbrt)
LANE_BY_LANE_2(pow)
LANE_BY_LANE_2(fmod)

/* an integer-valued real below 2^51 as an integer: in 1.5 * 2^52 + number, it is the last bits */
FUNCTION integer integer_near(real number)
{
    return as_integer(number + 0x1.8p52) - as_integer(all_real(0x1.8p52));
}

/* 1 / n! from n = 2 on */
SHARES shares[] = {
    ALL(1.0 / 2.0), ALL(1.0 / 6.0), ALL(1.0 / 24.0), ALL(1.0 / 120.0), ALL(1.0 / 720.0),
    ALL(1.0 / 5040.0), ALL(1.0 / 40320.0), ALL(1.0 / 362880.0), ALL(1.0 / 3628800.0),
    ALL(1.0 / 39916800.0), ALL(1.0 / 479001600.0), ALL(1.0 / 6227020800.0),
};

/* exp(r) - 1 for |r| <= ln(2)/2, by the Taylor series up to r^13 / 13!, with terms in pairs to
   shorten the chain of dependent operations */
FUNCTION real expm1_near_zero(real r)
{
    const real r2 = r * r, r4 = r2 * r2;
    const real low = (shares[0] + r * shares[1]) + r2 * (shares[2] + r * shares[3]);
    const real middle = (shares[4] + r * shares[5]) + r2 * (shares[6] + r * shares[7]);
    const real high = (shares[8] + r * shares[9]) + r2 * (shares[10] + r * shares[11]);
    return r + r2 * (low + r4 * (middle + r4 * high));
}

/* x - number ln(2); ln(2) is split in two parts, the first of 32 bits so that its product with
   number is exact */
FUNCTION real rest_of_ln2(real x, real number)
{
    return (x - number * 0.6931471803691238) - number * 1.9082149292705877e-10;
}

FUNCTION real power_of_two(integer k) { return as_real((k + 1023) << 52); }

/* In lanes short enough to be inlined: a call would spill the registers to memory. */
MIDDLE_FUNCTION real exp_real(real x)
{
    x = at_least(-760.0, at_most(720.0, x));
    const real number = rint_real(x * 1.4426950408889634);
    const real p = 1.0 + expm1_near_zero(rest_of_ln2(x, number));
#if LANES == 8
    return (real)_mm512_scalef_pd((__m512d)p, (__m512d)number);
#else
    /* two factors: a subnormal result is rounded once, and overflow gives infinity */
    const integer k = integer_near(number), k_2 = k >> 1;
    return p * power_of_two(k_2) * power_of_two(k - k_2);
#endif
}

LONG_FUNCTION real expm1_real(real x)
{
    const mask far = ABOVE(abs_real(x), 40.0);
    const real near = select_real(far, all_real(0.0), x);
    const real number = rint_real(near * 1.4426950408889634);
    const real p = expm1_near_zero(rest_of_ln2(near, number));
    const real scale = power_of_two(integer_near(number));
    const real made = scale * p + (scale - 1.0);
    real result = select_real(IS(number, 0.0), p, made);
    if (any(far)) { result = select_real(far, exp_real(x) - 1.0, result); }
    return result;
}

LONG_FUNCTION real tanh_real(real x)
{
    const real size = abs_real(x);
    const real e = expm1_real(2.0 * select_real(ABOVE(size, 20.0), all_real(20.0), size));
    const real made = e / (e + 2.0);
    return as_real(as_integer(made) | (as_integer(x) & INT64_MIN));
}

/* m 2^k with m between sqrt(1/2) and sqrt(2); ln(m) = 2 artanh(s), s = (m - 1)/(m + 1) */
LONG_FUNCTION real log_real(real x)
{
    const mask small = BELOW(x, 0x1p-1022);
    const real scaled = select_real(small, x * 0x1p54, x);
    const integer offset = as_integer(scaled) - 0x3fe6a09e667f3bcd;
    const integer k = offset >> 52;
    const real m = as_real(as_integer(scaled) - (k << 52));
    const real number = real_of_integer(k) - select_real(small, all_real(54.0), all_real(0.0));
    const real f = m - 1.0;
    const real s = f / (m + 1.0);
    const real z = s * s;
    real p = z * (2.0 / 23.0) + 2.0 / 21.0;
    p = p * z + 2.0 / 19.0;
    p = p * z + 2.0 / 17.0;
    p = p * z + 2.0 / 15.0;
    p = p * z + 2.0 / 13.0;
    p = p * z + 2.0 / 11.0;
    p = p * z + 2.0 / 9.0;
    p = p * z + 2.0 / 7.0;
    p = p * z + 2.0 / 5.0;
    p = p * z + 2.0 / 3.0;
    /* 2 s = f - s f, which reduces the effect of the rounding of s */
    const real rest = s * (z * p - f);
    real made = number * 0.6931471803691238 + (f + (rest + number * 1.9082149292705877e-10));
    made = select_real(IS(x, INFINITY), x, made);
    made = select_real(IS(x, 0.0), all_real(-INFINITY), made);
    return select_real(or_mask(BELOW(x, 0.0), is_none(x)), all_real(NAN), made);
}

LONG_FUNCTION real log1p_real(real x)
{
    const real u = 1.0 + x;
    const real lost = (x - (u - 1.0)) / u;
    const real made = log_real(u) + lost;
    const real ends = select_real(IS(u, 0.0), all_real(-INFINITY), select_real(IS(u, INFINITY), u, made));
    return select_real(BELOW(abs_real(x), 0x1p-54), x, ends);
}

/* x = n pi/2 + r; pi/2 in three parts, the first two of 33 bits */
FUNCTION real quartered(real x, integer *n)
{
    const real number = rint_real(x * 0.6366197723675814);
    *n = integer_near(number);
    return ((x - number * 1.5707963267341256) - number * 6.077100506303966e-11)
        - number * 2.0222662487959506e-21;
}

/* Taylor series for |r| <= pi/4, up to r^17 and r^18 */
FUNCTION real sin_near_zero(real r)
{
    const real z = r * r;
    real p = z * (1.0 / 355687428096000.0) - 1.0 / 1307674368000.0;
    p = p * z + 1.0 / 6227020800.0;
    p = p * z - 1.0 / 39916800.0;
    p = p * z + 1.0 / 362880.0;
    p = p * z - 1.0 / 5040.0;
    p = p * z + 1.0 / 120.0;
    p = p * z - 1.0 / 6.0;
    return r + r * z * p;
}

FUNCTION real cos_near_zero(real r)
{
    const real z = r * r;
    real p = z * (-1.0 / 6402373705728000.0) + 1.0 / 20922789888000.0;
    p = p * z - 1.0 / 87178291200.0;
    p = p * z + 1.0 / 479001600.0;
    p = p * z - 1.0 / 3628800.0;
    p = p * z + 1.0 / 40320.0;
    p = p * z - 1.0 / 720.0;
    p = p * z + 1.0 / 24.0;
    /* 1 - z/2, compensated for its rounding error */
    const real z_2 = 0.5 * z, near = 1.0 - z_2;
    return near + (((1.0 - near) - z_2) + z * z * p);
}

#define LARGEST_ANGLE 8e5

LONG_FUNCTION real sin_real(real x)
{
    integer n;
    const real r = quartered(x, &n);
    const real made = select_real(mask_of_integer(n & 1), cos_near_zero(r), sin_near_zero(r));
    real result = as_real(as_integer(made) ^ ((n & 2) << 62));
    const mask far = not_mask(BELOW(abs_real(x), LARGEST_ANGLE));
    WHERE(far, result, sin, x)
    return select_real(IS(x, 0.0), x, result);
}

LONG_FUNCTION real cos_real(real x)
{
    integer n;
    const real r = quartered(x, &n);
    const real made = select_real(mask_of_integer(n & 1), sin_near_zero(r), cos_near_zero(r));
    real result = as_real(as_integer(made) ^ (((n + 1) & 2) << 62));
    const mask far = not_mask(BELOW(abs_real(x), LARGEST_ANGLE));
    WHERE(far, result, cos, x)
    return result;
}

/* (atan(q)/q - 1)/q^2 for |q| <= tan(pi/8), interpolated at Chebyshev points; error 5e-18 */
FUNCTION real atan_near_zero(real q)
{
    const real z = q * q;
    real p = z * -0.019176887119048774 + 0.039231658295576184;
    p = p * z - 0.05085449737939879;
    p = p * z + 0.05858148912802137;
    p = p * z - 0.06664511447381939;
    p = p * z + 0.07692183190826087;
    p = p * z - 0.09090904578123901;
    p = p * z + 0.11111111015256361;
    p = p * z - 0.14285714284666542;
    p = p * z + 0.1999999999999552;
    p = p * z - 0.3333333333333333;
    return q + q * z * p;
}

LONG_FUNCTION real atan2_real(real y, real x)
{
    const integer sign_bit = all_integer(INT64_MIN);
    real a = abs_real(y), b = abs_real(x);
    const mask steep = gt_real(a, b);
    real low = select_real(steep, b, a), high = select_real(steep, a, b);
    const mask endless = IS(high, INFINITY), both = and_mask(endless, IS(low, INFINITY));
    low = select_real(both, all_real(1.0), select_real(endless, all_real(0.0), low));
    high = select_real(endless, all_real(1.0), high);
    /* scale to avoid overflow and underflow */
    const real smaller = select_real(ABOVE(high, 0x1p500), all_real(0x1p-500), all_real(1.0));
    const real scale = select_real(BELOW(high, 0x1p-500), all_real(0x1p500), smaller);
    low *= scale;
    high *= scale;
    const mask wide = gt_real(low, 0.41421356237309503 * high);
    const real top = select_real(wide, low - high, low);
    const real bottom = select_real(wide, low + high, high);
    const real q = select_real(IS(bottom, 0.0), all_real(0.0), top / bottom);
    real angle = atan_near_zero(q);
    angle = select_real(wide, 0x1.921fb54442d18p-1 + (angle + 0x1.1a62633145c07p-55), angle);
    angle = select_real(steep, 0x1.921fb54442d18p0 - (angle - 0x1.1a62633145c07p-54), angle);
    const mask left = mask_of_integer(as_integer(x) & sign_bit);
    angle = select_real(left, 0x1.921fb54442d18p1 - (angle - 0x1.1a62633145c07p-53), angle);
    angle = as_real(as_integer(angle) | (as_integer(y) & sign_bit));
    return select_real(or_mask(is_none(x), is_none(y)), x + y, angle);
}

FUNCTION real asin_real(real x) { return atan2_real(x, sqrt_real((1.0 - x) * (1.0 + x))); }
FUNCTION real acos_real(real x) { return atan2_real(sqrt_real((1.0 - x) * (1.0 + x)), x); }

FUNCTION real horner(TABLE_OF(double) table, int count, real w)
{
    real sum = all_real(table[0]);
    for (int term = 1; term < count; ++term) { sum = sum * w + table[term]; }
    return sum;
}

/* M. Giles, "Approximating the erfinv function", GPU Computing Gems, Jade ed., 2011, table 10.4 */
TABLE double giles_near[] = {
    -3.6444120640178196996e-21, -1.685059138182016589e-19, 1.2858480715256400167e-18,
    1.115787767802518096e-17, -1.333171662854620906e-16, 2.0972767875968561637e-17,
    6.6376381343583238325e-15, -4.0545662729752068639e-14, -8.1519341976054721522e-14,
    2.6335093153082322977e-12, -1.2975133253453532498e-11, -5.4154120542946279317e-11,
    1.051212273321532285e-09, -4.1126339803469836976e-09, -2.9070369957882005086e-08,
    4.2347877827932403518e-07, -1.3654692000834678645e-06, -1.3882523362786468719e-05,
    0.0001867342080340571352, -0.00074070253416626697512, -0.0060336708714301490533,
    0.24015818242558961693, 1.6536545626831027356,
};
TABLE double giles_middle[] = {
    2.2137376921775787049e-09, 9.0756561938885390979e-08, -2.7517406297064545428e-07,
    1.8239629214389227755e-08, 1.5027403968909827627e-06, -4.013867526981545969e-06,
    2.9234449089955446044e-06, 1.2475304481671778723e-05, -4.7318229009055733981e-05,
    6.8284851459573175448e-05, 2.4031110387097893999e-05, -0.0003550375203628474796,
    0.00095328937973738049703, -0.0016882755560235047313, 0.0024914420961078508066,
    -0.0037512085075692412107, 0.005370914553590063617, 1.0052589676941592334,
    3.0838856104922207635,
};
TABLE double giles_far[] = {
    -2.7109920616438573243e-11, -2.5556418169965252055e-10, 1.5076572693500548083e-09,
    -3.7894654401267369937e-09, 7.6157012080783393804e-09, -1.4960026627149240478e-08,
    2.9147953450901080826e-08, -6.7711997758452339498e-08, 2.2900482026654717e-07,
    -9.9298272942317002539e-07, 4.5260625972231537039e-06, -1.9681778105531670567e-05,
    7.5995277030017761139e-05, -0.00021503011930044477347, -0.00013871931833623122026,
    1.0103004648645343977, 4.8499064014085844221,
};

LONG_FUNCTION real erf_inv_real(real x)
{
    const real w = -log1p_real(-(x * x));
    const real near = w - 3.125;
    real p = horner(giles_near, 23, near);
    const mask beyond = ge_real(w, all_real(6.25));
    if (any(beyond)) {
        const real root = sqrt_real(w);
        const real middle = root - 3.25, far = root - 5.0;
        const real near_one = horner(giles_far, 17, far);
        const real made = select_real(BELOW(w, 16.0), horner(giles_middle, 19, middle), near_one);
        p = select_real(beyond, made, p);
    }
    return select_real(IS(abs_real(x), 1.0), x * INFINITY, p * x);
}

/* Threefry-2x32 with 20 rounds: J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3",
   2011. Both key and counter are two words, the first in the upper half. */
#define ROTATED(x, r) (((x) << (r)) | ((x) >> (32 - (r))))
#define FOUR_ROUNDS(a, b, c, d)                                                                   \
    x0 += x1; x1 = ROTATED(x1, a) ^ x0; x0 += x1; x1 = ROTATED(x1, b) ^ x0;                       \
    x0 += x1; x1 = ROTATED(x1, c) ^ x0; x0 += x1; x1 = ROTATED(x1, d) ^ x0;

LONG_FUNCTION bits threefry_bits(bits key, bits counter)
{
    const words k0 = words_of_bits(key >> 32), k1 = words_of_bits(key);
    const words k2 = k0 ^ k1 ^ 0x1bd11bdau;
    words x0 = words_of_bits(counter >> 32) + k0, x1 = words_of_bits(counter) + k1;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k1; x1 += k2 + 1u;
    FOUR_ROUNDS(17, 29, 16, 24) x0 += k2; x1 += k0 + 2u;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k0; x1 += k1 + 3u;
    FOUR_ROUNDS(17, 29, 16, 24) x0 += k1; x1 += k2 + 4u;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k2; x1 += k0 + 5u;
    return (bits_of_words(x0) << 32) | bits_of_words(x1);
}
