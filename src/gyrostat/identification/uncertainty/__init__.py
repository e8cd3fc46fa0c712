"""Standard deviations, effects outside the model, posterior."""
