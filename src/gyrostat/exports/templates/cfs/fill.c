
static void SetNotANumber(@real@ *Values, size_t Count)
{
    size_t k;

    for (k = 0U; k < Count; ++k)
    {
        Values[k] = NAN;
    }
}
