"""One model of a wheel from its records at several dates and temperatures."""
