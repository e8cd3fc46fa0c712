/* Checks of parameters. A function is written if it is used. */

/* The same for integers. */
static const char *WithinIntegers(const char *Fault, const char *Name, const int64_t *Values, size_t Count,
                                  int64_t Lower, int64_t Upper)
{
    const char *Result = Fault;
    size_t      k;

    for (k = 0U; k < Count; ++k)
    {
        if ((Result == NULL) && !((Values[k] >= Lower) && (Values[k] <= Upper)))
        {
            Result = Name;
        }
    }
    return Result;
}

/* The same for logical values, whose bytes are read: another value than 0 and 1 is no bool. */
static const char *Logical(const char *Fault, const char *Name, const bool *Values, size_t Count)
{
    const char *Result = Fault;
    uint8       Byte   = 0U;
    size_t      k;

    for (k = 0U; k < Count; ++k)
    {
        (void)memcpy(&Byte, &Values[k], sizeof(Byte));
        if ((Result == NULL) && (Byte > 1U))
        {
            Result = Name;
        }
    }
    return Result;
}

/* The same for a range: each upper limit is above its lower limit. */
static const char *Ordered(const char *Fault, const char *Name, const @real@ *Upper, size_t Uppers,
                           const @real@ *Lower, size_t Lowers)
{
    const char  *Result = Fault;
    const size_t Count  = (Uppers > Lowers) ? Uppers : Lowers;
    size_t       k;

    for (k = 0U; k < Count; ++k)
    {
        if ((Result == NULL) && !(Lower[(Lowers > 1U) ? k : 0U] < Upper[(Uppers > 1U) ? k : 0U]))
        {
            Result = Name;
        }
    }
    return Result;
}
