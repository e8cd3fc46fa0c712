static void SetNotANumber(@real@* values, FwSizeType count) {
    for (FwSizeType k = 0; k < count; ++k) {
        values[k] = NAN;
    }
}

